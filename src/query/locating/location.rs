//! Where points lie.

use crate::geometry::{Point, TriangleId};
use crate::store::{Tile, TileId, Vertex};

/// A triangle, by a tile that holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct TriangleRef {
    /// The tile.
    pub tile: TileId,
    /// Its number there.
    pub triangle: TriangleId,
    /// Its corners, counter-clockwise.
    pub vertices: [Vertex; 3],
    /// The z of each corner. `None` if the file has no z, or if another tile owns the corner:
    /// [`TileReader::z_at`](crate::store::TileReader::z_at) reads it there.
    pub z: [Option<f64>; 3],
}

impl TriangleRef {
    /// A triangle of a tile.
    pub(crate) fn of(tile: &Tile, triangle: TriangleId) -> Self {
        let corners = tile.corners(triangle);
        let is_own = |corner| tile.has_vertex(corner);
        Self {
            tile: tile.id(),
            triangle,
            vertices: corners.map(|corner| tile.vertex(corner)),
            z: corners.map(|corner| is_own(corner).then(|| tile.z(corner)).flatten()),
        }
    }

    /// The z at a point of the plane through the corners. `None` if the z of a corner is not known.
    ///
    /// # Examples
    ///
    /// ```
    /// # use delaunay_tiles::{BuildOptions, Builder, Location, OpenOptions, Point, TileReader, input::PointBatch};
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("slope.tiles");
    /// # tokio::runtime::Runtime::new()?.block_on(async {
    /// # let points = vec![Point::new(0.0, 0.0), Point::new(8.0, 0.0), Point::new(0.0, 8.0)];
    /// # let mut builder = Builder::new(&path, BuildOptions::default())?;
    /// # builder.push(&PointBatch { records: vec![0, 1, 2], points, z: vec![1.0, 5.0, 1.0] }).await?;
    /// # builder.finish().await?;
    /// let slope = TileReader::open(&path, OpenOptions::default()).await?;
    /// let Location::InTriangle(triangle) = slope.locate(2.0, 3.0).await? else { panic!("it lies inside") };
    /// assert_eq!(triangle.z_at(Point::new(2.0, 3.0)), Some(2.0));
    /// # Ok(())
    /// # })
    /// # }
    /// ```
    #[must_use]
    pub fn z_at(&self, point: Point) -> Option<f64> {
        let [Some(za), Some(zb), Some(zc)] = self.z else {
            return None;
        };
        let [a, b, c] = self.vertices.map(|vertex| vertex.point);
        let doubled = |p: Point, q: Point, r: Point| (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
        let whole = doubled(a, b, c);
        let [of_b, of_c] = [doubled(a, point, c) / whole, doubled(a, b, point) / whole];
        Some(za + of_b * (zb - za) + of_c * (zc - za))
    }
}

/// Where a point lies in a triangulation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Location {
    /// On a vertex.
    OnVertex(Vertex),
    /// Within the edge between two vertices.
    OnEdge {
        /// The ends of the edge: corners `i` and `i + 1` of the triangle.
        ends: [Vertex; 2],
        /// A triangle that the edge is a side of.
        triangle: TriangleRef,
    },
    /// Within a triangle.
    InTriangle(TriangleRef),
    /// Outside the hull. A file without triangles has nothing inside but its vertices.
    Outside,
}
