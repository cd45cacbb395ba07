//! The places of many points.

use std::sync::Arc;

use futures::future::{BoxFuture, FutureExt};

use super::batch::{At, BulkOptions, Outcome, Question, ask};
use super::locate::triangles_at;
use super::place::Place;
use super::walk::Spot;
use crate::geometry::{HalfEdge, Point, TriangleId, VertexIndex};
use crate::mesh::Twin;
use crate::query::request::Contradiction;
use crate::store::{ReadError, Tile, TileId, TileReader, VertexId};

/// Location of many points.
impl TileReader {
    /// Returns the places of points, in their order: what [`locate`](Self::locate) returns for each, but
    /// the vertices. Must be awaited within a tokio runtime.
    ///
    /// This takes a fraction of the time of as many calls of `locate`: tiles are read ahead, each once
    /// for all points in its cell, several threads compute, and they walk from each point to the next
    /// one. It takes about 50 bytes of memory per point, and a few tiles besides those in the cache. If
    /// the future is dropped, the threads stop soon.
    ///
    /// Places are exact. Which triangle they name at an edge or at a vertex, and by which tile, depends
    /// on the point and the file alone. A point that is not finite is outside, and a coordinate closer to
    /// 0 than [`Point::MIN_MAGNITUDE`] counts as 0.
    ///
    /// # Errors
    /// If a tile cannot be read, or tiles contradict each other.
    ///
    /// # Panics
    /// If there are more than 2³² points.
    ///
    /// # Examples
    ///
    /// ```
    /// # use delaunay_tiles::{BuildOptions, Builder, OpenOptions, Point, TileReader, input::PointBatch};
    /// use delaunay_tiles::query::{BulkOptions, Location, Place};
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("town.tiles");
    /// # tokio::runtime::Runtime::new()?.block_on(async {
    /// # let points: Vec<Point> = (0..2500).map(|i| Point::new(f64::from(i % 50), f64::from(i / 50))).collect();
    /// # let mut builder = Builder::new(&path, BuildOptions::default().tile_vertices(100))?;
    /// # builder.push(&PointBatch { records: (0..2500).collect(), points, z: vec![] }).await?;
    /// # builder.finish().await?;
    /// // A grid of 50 by 50 vertices at whole numbers.
    /// let town = TileReader::open(&path, OpenOptions::default()).await?;
    /// let points: Vec<Point> = (0..100).map(|i| Point::new(f64::from(i) / 2.0, 7.25)).collect();
    /// let places = town.locate_many(points, BulkOptions::default()).await?;
    /// assert!(matches!(places[8], Place::OnEdge { .. }));
    /// assert!(matches!(places[99], Place::Outside));
    ///
    /// // The vertices are in the tile.
    /// let tile = town.tile(places[9].tile().expect("it is inside")).await?;
    /// let Location::InTriangle(triangle) = places[9].location(&tile) else { panic!("on an edge") };
    /// assert!(triangle.vertices.iter().all(|v| (v.point.x - 4.5).abs() < 1.0));
    /// # Ok(())
    /// # })
    /// # }
    /// ```
    pub async fn locate_many(
        &self,
        points: impl Into<Arc<[Point]>>,
        options: BulkOptions,
    ) -> Result<Vec<Place>, ReadError> {
        self.locate_all(points.into(), options).await
    }

    fn locate_all(&self, points: Arc<[Point]>, options: BulkOptions) -> BoxFuture<'_, Result<Vec<Place>, ReadError>> {
        ask(self, points, options, Where, Place::Outside).boxed()
    }
}

/// The question where a point is.
///
/// Of the triangles at the point, the answer names the first one of the tile of the point's cell. If that
/// has none, it names what a [walk](super::walk::Locate) finds that begins in this tile. Which tile a
/// walk from another point ends in does not matter then.
struct Where;

/// What is asked in another tile.
enum Naming {
    /// The place on a vertex that the tile owns.
    Vertex(VertexIndex),
    /// The first triangle of the tile with these corners, if it has one.
    Triangle { corners: [VertexId; 3], otherwise: Place },
    /// The edge of the first triangle of the tile with these ends, if it has one.
    Edge { ends: [VertexId; 2], otherwise: Place },
}

impl Question for Where {
    type Answer = Place;
    type Errand = Naming;
    type InTile = ();

    fn in_tile(&self, _: &Tile) {}

    fn answer(&self, at: &At<'_, ()>, spot: Spot, home: TileId) -> Result<Outcome<Self>, Contradiction> {
        let tile = at.tile;
        let is_home = tile.id() == home;
        Ok(match spot {
            Spot::Outside(_) => Outcome::Answer(Place::Outside),
            Spot::Triangle(triangle) => {
                let tile_id = tile.id();
                let place = Place::InTriangle {
                    tile: tile_id,
                    triangle,
                };
                if is_home {
                    return Ok(Outcome::Answer(place));
                }
                let mut corners = tile.vertices(triangle).map(|corner| corner.id);
                match corners.iter().position(|corner| corner.tile == home) {
                    None => Outcome::Answer(place),
                    Some(own) => {
                        corners.swap(0, own);
                        let otherwise = place;
                        Outcome::Ask(home, Naming::Triangle { corners, otherwise })
                    }
                }
            }
            Spot::Edge(half_edge) => {
                let first = match tile.twin(half_edge) {
                    Twin::HalfEdge(twin) => twin.min(half_edge),
                    Twin::Hull | Twin::Elsewhere => half_edge,
                };
                let place = Place::on_edge(tile, first);
                if is_home {
                    return Ok(Outcome::Answer(place));
                }
                let mut ends = tile.ends(half_edge).map(|end| end.id);
                if ends[1].tile == home {
                    ends.swap(0, 1);
                }
                let otherwise = place;
                Outcome::Ask(home, Naming::Edge { ends, otherwise })
            }
            Spot::Vertex(corner) if tile.has_vertex(corner) => Outcome::Answer(on_vertex(tile, corner)),
            Spot::Vertex(corner) => {
                let VertexId { tile, index } = tile.vertex(corner).id;
                Outcome::Ask(tile, Naming::Vertex(index))
            }
        })
    }

    fn finish(&self, at: &At<'_, ()>, naming: Naming) -> Result<Place, Contradiction> {
        let tile = at.tile;
        match naming {
            Naming::Vertex(vertex) if tile.has_vertex(vertex) => Ok(on_vertex(tile, vertex)),
            Naming::Vertex(vertex) => Err(Contradiction::NoVertex(vertex)),
            Naming::Triangle { corners, otherwise } => Ok(match first_with(tile, &corners)? {
                None => otherwise,
                Some(triangle) => Place::InTriangle {
                    tile: tile.id(),
                    triangle,
                },
            }),
            Naming::Edge { ends, otherwise } => {
                let Some(triangle) = first_with(tile, &ends)? else {
                    return Ok(otherwise);
                };
                let is_edge = |half_edge: &HalfEdge| tile.ends(*half_edge).iter().all(|end| ends.contains(&end.id));
                let edge = HalfEdge::of_triangle(triangle).into_iter().find(is_edge);
                Ok(edge.map_or(otherwise, |edge| Place::on_edge(tile, edge)))
            }
        }
    }
}

/// Returns the place on a vertex that a tile owns.
fn on_vertex(tile: &Tile, index: VertexIndex) -> Place {
    let tile_id = tile.id();
    Place::OnVertex {
        vertex: VertexId { tile: tile_id, index },
        triangle: tile.leaving(index).map(HalfEdge::triangle),
    }
}

/// Returns the first triangle of a tile that has all of these vertices as corners.
fn first_with(tile: &Tile, vertices: &[VertexId]) -> Result<Option<TriangleId>, Contradiction> {
    let missing = vertices
        .iter()
        .find(|v| v.tile == tile.id() && !tile.has_vertex(v.index));
    if let Some(missing) = missing {
        return Err(Contradiction::NoVertex(missing.index));
    }
    let has_all = |&triangle: &TriangleId| {
        let corners = tile.vertices(triangle).map(|corner| corner.id);
        vertices.iter().all(|vertex| corners.contains(vertex))
    };
    let Some(&first) = vertices.first() else {
        return Ok(None);
    };
    Ok(triangles_at(tile, first).filter(has_all).min())
}
