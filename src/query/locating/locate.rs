//! The triangle that contains a point, and the z of the triangulation there.

use std::sync::Arc;

use super::location::Location;
use super::walk::{Locate, WalkStep};
use crate::geometry::{Point, VertexIndex};
use crate::query::request::Contradiction;
use crate::store::{ReadError, Tile, TileReader, VertexId};
use crate::terrain::facet;

/// Point location.
impl TileReader {
    /// Returns the location of a point. Reads the tile of its cell, and the other tiles that the
    /// walk to the point enters. A coordinate closer to 0 than [`Point::MIN_MAGNITUDE`] counts as
    /// 0. The [example of the library](crate#examples) locates a point.
    ///
    /// # Errors
    /// If a tile cannot be read, or tiles contradict each other. A point that is not finite is
    /// outside.
    pub async fn locate(&self, x: f64, y: f64) -> Result<Location, ReadError> {
        let found = self.locate_in_tile(x, y).await?;
        Ok(found.map_or(Location::Outside, |(_, location)| location))
    }

    /// Returns the location of a point, with a tile that has the triangle or the vertex. Returns
    /// `None` if the point is outside the box around all vertices.
    async fn locate_in_tile(&self, x: f64, y: f64) -> Result<Option<(Arc<Tile>, Location)>, ReadError> {
        let target = Point::new(x, y).representable();
        if !self.metadata().bounds.contains(target) {
            return Ok(None);
        }
        let Some(mut id) = self.tile_at(target).await? else {
            return Ok(None);
        };
        let mut walk = Locate::new(target, self.metadata().triangles);
        loop {
            let tile = self.tile(id).await?;
            let step = walk.step(&tile);
            match step.map_err(|contradiction| self.damaged(id, contradiction.to_string()))? {
                WalkStep::Need(other) => id = other,
                WalkStep::Done(walked) => return Ok(Some((tile, walked.location))),
            }
        }
    }

    /// Returns the z of the triangulation at a point, on the plane through the corners of its
    /// triangle. Returns `None` if the point is outside or the file has no z. The result is the
    /// same to the last bit, whatever the tiles.
    ///
    /// Reads the tiles that [`locate`](Self::locate) reads, and no others: a tile has the z of all
    /// corners of its triangles.
    ///
    /// # Errors
    /// As [`locate`](Self::locate).
    ///
    /// # Examples
    ///
    /// ```
    /// # use delaunay_tiles::{BuildOptions, Builder, OpenOptions, Point, TileReader, input::PointBatch};
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("slope.tiles");
    /// # tokio::runtime::Runtime::new()?.block_on(async {
    /// # let points: Vec<Point> = (0..2500).map(|i| Point::new(f64::from(i % 50), f64::from(i / 50))).collect();
    /// # let z = points.iter().map(|p| p.x + 2.0 * p.y).collect();
    /// # let options = BuildOptions::default().tile_vertices(100);
    /// # let mut builder = Builder::new(&path, options)?;
    /// # builder.push(&PointBatch { records: (0..2500).collect(), points, z }).await?;
    /// # builder.finish().await?;
    /// let slope = TileReader::open(&path, OpenOptions::default()).await?;
    /// for x in 0..490 {
    ///     let x = f64::from(x) / 10.0;
    ///     let z = slope.z_at(x, 20.25).await?.expect("it lies inside");
    ///     assert!((z - (x + 40.5)).abs() < 1e-9);
    /// }
    /// assert_eq!(slope.z_at(-1.0, 20.0).await?, None);
    /// # Ok(())
    /// # })
    /// # }
    /// ```
    pub async fn z_at(&self, x: f64, y: f64) -> Result<Option<f64>, ReadError> {
        let Some((tile, location)) = self.locate_in_tile(x, y).await? else {
            return Ok(None);
        };
        let triangle = match location {
            Location::InTriangle(triangle) | Location::OnEdge { triangle, .. } => triangle.triangle,
            Location::OnVertex(vertex) => return Ok(z_in(&tile, vertex.id)),
            Location::Outside => return Ok(None),
        };
        let point = Point::new(x, y).representable();
        Ok(facet(&tile, triangle).and_then(|facet| Some(facet.z_at(point, facet.place(point)?))))
    }

    /// Returns the z of a vertex, read from the tile that owns it. Returns `None` if the file has
    /// no z. [`z_at`](Self::z_at) has an example.
    ///
    /// # Errors
    /// If the tile cannot be read, or has no such vertex.
    pub async fn z_of(&self, vertex: VertexId) -> Result<Option<f64>, ReadError> {
        let tile = self.tile(vertex.tile).await?;
        if !tile.has_vertex(vertex.index) {
            let contradiction = Contradiction::NoVertex(vertex.index);
            return Err(self.damaged(vertex.tile, contradiction.to_string()));
        }
        Ok(tile.z(vertex.index))
    }
}

/// Returns the z of a vertex of a tile, or of a corner that another tile owns.
fn z_in(tile: &Tile, vertex: VertexId) -> Option<f64> {
    if vertex.tile == tile.id() {
        return tile.z(vertex.index);
    }
    let mut foreign = (tile.vertex_count()..tile.corner_count() as u32).map(VertexIndex);
    tile.z(foreign.find(|&corner| tile.vertex(corner).id == vertex)?)
}
