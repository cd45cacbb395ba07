//! Where a query begins or ends: on which vertex, edge or triangle, whether that is free, and where the nearest free point is if not.

use super::ground::Ground;
use super::nearest_free::nearest_free;
use super::spot::Spot;
use super::wedges::Wedge;
use crate::geometry::{Point, TriangleId};
use crate::query::locating::{Location, TriangleRef, Walked};
use crate::query::request::{QueryError, Tiles, target};
use crate::store::{TileId, Vertex, VertexId};

/// A point, and where it lies.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) point: Point,
    pub(crate) spot: Spot,
    /// Whether one may be there.
    pub(crate) is_free: bool,
    /// Whether it lies outside the hull or on its edge, and the outside is free.
    pub(crate) is_outside: bool,
    /// The corners of the free triangles that it lies in or on the edge of; none for a vertex.
    pub(crate) triangles: Vec<[Point; 3]>,
    /// The free triangles at the vertex or the edge that it is on, as far as they are known.
    pub(crate) around: Vec<(TileId, TriangleId)>,
}

impl Place {
    /// Finds out where a point lies. A coordinate closer to 0 than any of a triangulation can be counts as 0.
    pub(crate) async fn find(tiles: &mut Tiles, point: Point) -> Result<Self, QueryError> {
        let point = target(point);
        if !point.is_valid() {
            return Err(QueryError::NotAPoint { point });
        }
        let Walked { location, exit } = tiles.walk(point).await?;
        let spot = match (location, exit) {
            (Location::InTriangle(triangle), _) => Spot::Triangle(triangle),
            (Location::OnEdge { ends, .. }, _) => Spot::Edge { ends },
            (Location::OnVertex(vertex), _) => Spot::Vertex(vertex),
            (Location::Outside, Some(edge)) => Spot::Outside(edge),
            (Location::Outside, None) => return Err(tiles.no_triangles()),
        };
        let mut this = Self {
            point,
            spot,
            is_free: false,
            is_outside: false,
            triangles: Vec::new(),
            around: Vec::new(),
        };
        this.look_round(tiles).await?;
        Ok(this)
    }

    /// The same for a point where one must be free.
    pub(crate) async fn find_free(tiles: &mut Tiles, point: Point) -> Result<Self, QueryError> {
        let place = Self::find(tiles, point).await?;
        if place.is_free {
            return Ok(place);
        }
        let nearest_free = place.nearest_free(tiles).await?;
        Err(QueryError::InsideObstacle { point, nearest_free })
    }

    /// The nearest point where one may be, of a place where one may not. None if there is no such point.
    pub(crate) async fn nearest_free(&self, tiles: &mut Tiles) -> Result<Option<Point>, QueryError> {
        nearest_free(tiles, self.point, self.spot).await
    }

    /// A vertex that is known to be free.
    pub(crate) fn at(vertex: Vertex) -> Self {
        Self {
            point: vertex.point,
            spot: Spot::Vertex(vertex),
            is_free: true,
            is_outside: false,
            triangles: Vec::new(),
            around: Vec::new(),
        }
    }

    /// The vertex that it is, if it is one.
    pub(crate) fn vertex(&self) -> Option<VertexId> {
        match self.spot {
            Spot::Vertex(vertex) => Some(vertex.id),
            _ => None,
        }
    }

    /// A tile that a search from here needs first.
    pub(crate) fn tile(&self) -> TileId {
        match self.spot {
            Spot::Triangle(triangle) => triangle.tile,
            Spot::Edge { ends: [_, end] } => end.id.tile,
            Spot::Vertex(vertex) => vertex.id.tile,
            Spot::Outside([from, _]) => from.tile,
        }
    }

    /// Finds out whether the place is free.
    async fn look_round(&mut self, tiles: &mut Tiles) -> Result<(), QueryError> {
        let outside_is_free = tiles.outside_is_free();
        match self.spot {
            Spot::Outside(_) => self.is_outside = outside_is_free,
            Spot::Triangle(TriangleRef { tile, triangle, .. }) => {
                let tile = tiles.get(tile).await?;
                if !tile.is_hole(triangle) {
                    self.triangles.push(tile.triangle_points(triangle));
                }
            }
            Spot::Vertex(vertex) => {
                let tile = tiles.get(vertex.id.tile).await?;
                if tile.leaving(vertex.id.index).is_none() {
                    return Err(tiles.no_triangles());
                }
                let wedges = Ground::of(tiles, &tile).free_wedges(vertex.id.index);
                let wedges = tiles.checked(tile.id(), wedges)?;
                self.is_free = !wedges.is_empty();
                for wedge in wedges {
                    if let Wedge::Triangle(side) = wedge {
                        self.around.push((tile.id(), side.triangle()));
                    }
                }
            }
            Spot::Edge { ends: [a, b] } => {
                for [from, to] in [[a, b], [b, a]] {
                    match tiles.side_between(from.id, to.id).await? {
                        Some((tile, side)) if tile.is_hole(side.triangle()) => {}
                        Some((tile, side)) => {
                            self.triangles.push(tile.triangle_points(side.triangle()));
                            self.around.push((tile.id(), side.triangle()));
                        }
                        None => self.is_outside |= outside_is_free,
                    }
                }
            }
        }
        self.is_free |= self.is_outside || !self.triangles.is_empty();
        Ok(())
    }
}
