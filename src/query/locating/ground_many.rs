//! What is at many points: free ground, a hole, or nothing.

use std::sync::Arc;

use super::batch::{At, BulkOptions, Outcome, Question, ask};
use super::locate::triangles_at;
use super::walk::Spot;
use crate::geometry::{Point, TriangleId, VertexIndex};
use crate::mesh::Twin;
use crate::query::request::{Contradiction, half_edge_towards};
use crate::store::{ReadError, Tile, TileId, TileReader, VertexId};

/// What is at a point of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ground {
    /// Nothing: the point is outside the hull.
    Outside,
    /// A triangle in no hole. Its edges and corners count too.
    Free,
    /// Only triangles in holes.
    Hole,
}

impl TileReader {
    /// Returns what is at points, in their order. It depends on the triangulation alone, and not on
    /// its tiles. Points are located as by [`locate_many`](Self::locate_many).
    ///
    /// # Errors
    /// As [`locate_many`](Self::locate_many).
    ///
    /// # Panics
    /// If there are more than 2³² points.
    pub(crate) async fn ground_many(
        &self,
        points: Arc<[Point]>,
        options: BulkOptions,
    ) -> Result<Vec<Ground>, ReadError> {
        ask(self, points, options, WhatIsThere, Ground::Outside).await
    }
}

struct WhatIsThere;

/// What is asked in another tile, because all triangles at the point that the first tile has are in
/// holes.
enum Asked {
    /// An edge between a vertex that the tile owns and another one.
    Edge(VertexIndex, VertexId),
    /// A vertex that the tile owns.
    Vertex(VertexIndex),
}

impl Question for WhatIsThere {
    type Answer = Ground;
    type Errand = Asked;
    type InTile = ();

    fn in_tile(&self, _: &Tile) {}

    fn answer(&self, at: &At<'_, ()>, spot: Spot, _: TileId) -> Result<Outcome<Self>, Contradiction> {
        let tile = at.tile;
        let ground = match spot {
            Spot::Outside(_) => Ground::Outside,
            Spot::Triangle(triangle) => of(tile, [triangle]),
            Spot::Edge(half_edge) => {
                let twin = tile.twin(half_edge);
                let other = twin.half_edge().map(|twin| twin.triangle());
                let ground = of(tile, [half_edge.triangle()].into_iter().chain(other));
                if ground == Ground::Hole && twin == Twin::Elsewhere {
                    let [a, b] = tile.ends(half_edge).map(|end| end.id);
                    return Ok(Outcome::Ask(a.tile, Asked::Edge(a.index, b)));
                }
                ground
            }
            Spot::Vertex(corner) => {
                let vertex = tile.vertex(corner).id;
                let ground = of(tile, triangles_at(tile, vertex));
                if ground == Ground::Hole && vertex.tile != tile.id() {
                    return Ok(Outcome::Ask(vertex.tile, Asked::Vertex(vertex.index)));
                }
                ground
            }
        };
        Ok(Outcome::Answer(ground))
    }

    fn finish(&self, at: &At<'_, ()>, asked: Asked) -> Result<Ground, Contradiction> {
        let tile = at.tile;
        let (Asked::Vertex(index) | Asked::Edge(index, _)) = asked;
        if !tile.has_vertex(index) {
            return Err(Contradiction::NoVertex(index));
        }
        Ok(match asked {
            Asked::Edge(a, b) => {
                // The other side of the edge, if it has one. The first tile had a hole on this
                // side.
                let other = half_edge_towards(tile, a, b)?;
                other.map_or(Ground::Hole, |other| of(tile, [other.triangle()]))
            }
            Asked::Vertex(index) => of(tile, triangles_at(tile, VertexId { tile: tile.id(), index })),
        })
    }
}

/// Returns what is where these triangles meet. Without triangles, there are only vertices, which
/// are free.
fn of(tile: &Tile, triangles: impl IntoIterator<Item = TriangleId>) -> Ground {
    let mut triangles = triangles.into_iter().peekable();
    match triangles.peek().is_some() && triangles.all(|triangle| tile.is_hole(triangle)) {
        true => Ground::Hole,
        false => Ground::Free,
    }
}
