//! The z of the surface at many points.

use std::sync::Arc;

use super::batch::{At, BulkOptions, Outcome, Question, ask};
use super::locate::triangles_at;
use super::walk::Spot;
use crate::geometry::{Point, TriangleId, VertexIndex};
use crate::mesh::Twin;
use crate::query::request::{Contradiction, half_edge_towards};
use crate::store::{ReadError, Tile, TileId, TileReader, VertexId};
use crate::terrain::{FileSurface, Surface, TileSurface};

/// Heights at many points.
impl TileReader {
    /// Returns the z of the surface at points, in their order: what [`surface_z`](Self::surface_z)
    /// returns for each, to the last bit, with NaN for `None`. Must be awaited within a tokio runtime.
    ///
    /// Points are located as by [`locate_many`](Self::locate_many). If triangles are left out [from the
    /// hull](Surface::from_hull), and a point is in one that is long, this reads all tiles once for all
    /// points.
    ///
    /// # Errors
    /// As [`locate_many`](Self::locate_many), and if triangles are left out from the hull and the memory
    /// that the reader may use does not suffice.
    ///
    /// # Panics
    /// If there are more than 2³² points.
    ///
    /// # Examples
    ///
    /// ```
    /// # use delaunay_tiles::{BuildOptions, Builder, OpenOptions, Point, TileReader, input::PointBatch};
    /// use delaunay_tiles::query::BulkOptions;
    /// use delaunay_tiles::terrain::Surface;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("slope.tiles");
    /// # tokio::runtime::Runtime::new()?.block_on(async {
    /// # let points: Vec<Point> = (0..2500).map(|i| Point::new(f64::from(i % 50), f64::from(i / 50))).collect();
    /// # let z = points.iter().map(|p| p.x).collect();
    /// # let mut builder = Builder::new(&path, BuildOptions::default().tile_vertices(100))?;
    /// # builder.push(&PointBatch { records: (0..2500).collect(), points, z }).await?;
    /// # builder.finish().await?;
    /// // A square of 49 by 49 that rises from 0 in the west to 49 in the east.
    /// let slope = TileReader::open(&path, OpenOptions::default()).await?;
    /// let points: Vec<Point> = (0..100).map(|i| Point::new(f64::from(i), 7.25)).collect();
    /// let z = slope.surface_z_many(points, Surface::default(), BulkOptions::default()).await?;
    /// assert!(z[12] == 12.0 && z[99].is_nan());
    /// # Ok(())
    /// # })
    /// # }
    /// ```
    pub async fn surface_z_many(
        &self,
        points: impl Into<Arc<[Point]>>,
        surface: Surface,
        options: BulkOptions,
    ) -> Result<Vec<f64>, ReadError> {
        let points: Arc<[Point]> = points.into();
        let metadata = self.metadata();
        if !metadata.has_z {
            return Ok(vec![f64::NAN; points.len()]);
        }
        let on = |surface: FileSurface, points: Arc<[Point]>| {
            let all_count = metadata.triangles == 0;
            ask(self, points, options, Height { surface, all_count }, f64::NAN)
        };
        let least = FileSurface::without_peeling(surface, metadata);
        let mut z = on(least, Arc::clone(&points)).await?;
        if surface.peels(metadata).is_none() {
            return Ok(z);
        }
        // The points that are in a triangle that is too long, which may not be peeled.
        let mut open: Vec<usize> = (0..z.len()).filter(|&i| z[i].is_nan()).collect();
        let of = |open: &[usize]| open.iter().map(|&i| points[i]).collect::<Arc<[Point]>>();
        let most = FileSurface::without_peeling(surface.max_edge(None), metadata);
        let inside = on(most, of(&open)).await?;
        let mut inside = inside.iter().map(|z| !z.is_nan());
        open.retain(|_| inside.next().unwrap_or(false));
        if !open.is_empty() {
            let surface = FileSurface::for_few_tiles(self, surface).await?;
            let found = on(surface, of(&open)).await?;
            for (i, found) in open.into_iter().zip(found) {
                z[i] = found;
            }
        }
        Ok(z)
    }
}

/// The question how high the surface is at a point; NaN if the point is not on it.
struct Height {
    surface: FileSurface,
    /// Whether all vertices are on the surface, because there are no triangles.
    all_count: bool,
}

/// What is asked in another tile, because no triangle at the point counts of those that the first tile
/// has.
enum Asked {
    /// An edge between a vertex that the tile owns and another one.
    Edge(VertexIndex, VertexId),
    /// A vertex that the tile owns.
    Vertex(VertexIndex),
}

impl Question for Height {
    type Answer = f64;
    type Errand = Asked;
    type InTile = TileSurface;

    fn in_tile(&self, tile: &Tile) -> TileSurface {
        self.surface.in_tile(tile)
    }

    fn answer(&self, at: &At<'_, TileSurface>, spot: Spot, _: TileId) -> Result<Outcome<Self>, Contradiction> {
        let tile = at.tile;
        let z = match spot {
            Spot::Outside(_) => None,
            Spot::Triangle(triangle) => inside(at, triangle),
            Spot::Edge(half_edge) => {
                let other = || match tile.twin(half_edge) {
                    Twin::HalfEdge(twin) => on_triangle(at, twin.triangle()),
                    Twin::Hull | Twin::Elsewhere => None,
                };
                let z = on_triangle(at, half_edge.triangle()).or_else(other);
                if z.is_none() && tile.twin(half_edge) == Twin::Elsewhere {
                    let [a, b] = tile.ends(half_edge).map(|end| end.id);
                    return Ok(Outcome::Ask(a.tile, Asked::Edge(a.index, b)));
                }
                z
            }
            Spot::Vertex(corner) => {
                let vertex = tile.vertex(corner).id;
                let z = self.on_vertex(at, vertex, corner);
                if z.is_none() && vertex.tile != tile.id() {
                    return Ok(Outcome::Ask(vertex.tile, Asked::Vertex(vertex.index)));
                }
                z
            }
        };
        Ok(Outcome::Answer(z.unwrap_or(f64::NAN)))
    }

    fn finish(&self, at: &At<'_, TileSurface>, asked: Asked) -> Result<f64, Contradiction> {
        let tile = at.tile;
        let (Asked::Vertex(index) | Asked::Edge(index, _)) = asked;
        if !tile.has_vertex(index) {
            return Err(Contradiction::NoVertex(index));
        }
        let z = match asked {
            Asked::Edge(a, b) => {
                let other = half_edge_towards(tile, a, b)?;
                other.and_then(|half_edge| on_triangle(at, half_edge.triangle()))
            }
            Asked::Vertex(index) => self.on_vertex(at, VertexId { tile: tile.id(), index }, index),
        };
        Ok(z.unwrap_or(f64::NAN))
    }
}

impl Height {
    /// Returns the z of a vertex, if a triangle of the tile there counts.
    fn on_vertex(&self, at: &At<'_, TileSurface>, vertex: VertexId, corner: VertexIndex) -> Option<f64> {
        let counts = |triangle| at.in_tile.has(at.tile, triangle);
        let is_on_surface = self.all_count || triangles_at(at.tile, vertex).any(counts);
        is_on_surface.then(|| at.tile.z(corner))?
    }
}

/// Returns the z at a point inside a triangle, if that counts.
fn inside(at: &At<'_, TileSurface>, triangle: TriangleId) -> Option<f64> {
    let facet = at.in_tile.facet(at.tile, triangle)?;
    Some(facet.z_inside(at.point))
}

/// Returns the z at a point on a triangle, if that counts.
fn on_triangle(at: &At<'_, TileSurface>, triangle: TriangleId) -> Option<f64> {
    let facet = at.in_tile.facet(at.tile, triangle)?;
    Some(facet.z_at(at.point, facet.place(at.point)?))
}
