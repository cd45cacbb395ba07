//! The z of the surface at many points.

use std::sync::Arc;

use futures::future::FutureExt;

use super::at_spot::{Found, Rest, find, find_rest};
use super::batch::{At, BulkOptions, Outcome, Question, ask};
use super::walk::Spot;
use crate::geometry::{Point, TriangleId};
use crate::query::request::Contradiction;
use crate::store::{ReadError, Tile, TileId, TileReader};
use crate::terrain::{FileSurface, Surface, TileSurface, facet};

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
        self.surface_z_of_all(points.into(), surface, options).await
    }

    fn surface_z_of_all(
        &self,
        points: Arc<[Point]>,
        surface: Surface,
        options: BulkOptions,
    ) -> impl Future<Output = Result<Vec<f64>, ReadError>> + Send {
        async move {
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
        .boxed()
    }
}

/// The question how high the surface is at a point; NaN if the point is not on it.
struct Height {
    surface: FileSurface,
    /// Whether all vertices are on the surface, because there are no triangles.
    all_count: bool,
}

impl Question for Height {
    type Answer = f64;
    type Errand = Rest;
    type InTile = TileSurface;

    fn in_tile(&self, tile: &Tile) -> TileSurface {
        self.surface.in_tile(tile)
    }

    fn answer(&self, at: &At<'_, TileSurface>, spot: Spot, _: TileId) -> Result<Outcome<Self>, Contradiction> {
        let z = match (spot, find(at.tile, spot, |triangle| at.in_tile.has(at.tile, triangle))) {
            (_, Found::Ask(tile, rest)) if !self.all_count => return Ok(Outcome::Ask(tile, rest)),
            (Spot::Triangle(_), Found::In(triangle)) => facet(at.tile, triangle).map(|facet| facet.z_inside(at.point)),
            (Spot::Edge(_), Found::In(triangle)) => on_edge(at, triangle),
            (Spot::Vertex(corner), Found::In(_)) => at.tile.z(corner),
            (Spot::Vertex(corner), _) if self.all_count => at.tile.z(corner),
            _ => None,
        };
        Ok(Outcome::Answer(z.unwrap_or(f64::NAN)))
    }

    fn finish(&self, at: &At<'_, TileSurface>, rest: Rest) -> Result<f64, Contradiction> {
        let found = find_rest(at.tile, &rest, |triangle| at.in_tile.has(at.tile, triangle))?;
        let z = found.and_then(|triangle| match rest {
            Rest::Edge(..) => on_edge(at, triangle),
            Rest::Vertex(vertex) => at.tile.z(vertex),
        });
        Ok(z.unwrap_or(f64::NAN))
    }
}

/// Returns the z at a point on an edge of a triangle.
fn on_edge(at: &At<'_, TileSurface>, triangle: TriangleId) -> Option<f64> {
    let facet = facet(at.tile, triangle)?;
    Some(facet.z_at(at.point, facet.place(at.point)?))
}
