//! The triangle that contains a point, and the z of the triangulation there.

use std::sync::Arc;

use super::location::{Location, TriangleRef};
use super::walk::{Locate, WalkStep};
use crate::geometry::{HalfEdge, Point, TriangleId, VertexIndex};
use crate::mesh::Topology;
use crate::query::request::{Contradiction, half_edge_towards};
use crate::store::{ReadError, Tile, TileReader, VertexId};
use crate::terrain::{FileSurface, Surface};

/// Point location.
impl TileReader {
    /// Returns the location of a point. Reads the tile of its cell, and the other tiles that the
    /// walk to the point enters. A coordinate closer to 0 than [`Point::MIN_MAGNITUDE`] counts as
    /// 0. For many points, [`locate_many`](Self::locate_many) is faster. The [example of the
    /// library](crate#examples) locates a point.
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

    /// Returns the z of the surface at a point: that of the plane of its triangle. Returns `None` if the
    /// point is outside or in a hole, or the file has no z. This is
    /// [`surface_z`](Self::surface_z) with [`Surface::default`].
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
        self.surface_z(x, y, Surface::default()).await
    }

    /// Returns the z of the surface at a point: that of the plane of its triangle, if that counts. A point
    /// on an edge or on a vertex is on the surface if any triangle there counts. Returns `None` if the
    /// point is not on the surface, or the file has no z.
    ///
    /// A z on an edge is computed from the ends of the edge alone, and at a vertex it is that of the
    /// vertex. So the result is the same to the last bit for all triangles at the point, whatever the
    /// tiles, and [rasters](Self::raster) have it too. In a file without triangles, the surface is the
    /// vertices.
    ///
    /// Reads the tiles that [`locate`](Self::locate) reads, and no others: a tile has the z of all
    /// corners of its triangles. Only if the point is on an edge or on a vertex, and no triangle there
    /// counts that one of these tiles has, it reads the tile of a vertex there. If triangles are left out
    /// [from the hull](Surface::from_hull), and the point is in one that is long, it reads all tiles; for
    /// many such points, [`surface_z_many`](Self::surface_z_many) is faster, which reads them once.
    ///
    /// # Errors
    /// As [`locate`](Self::locate).
    pub async fn surface_z(&self, x: f64, y: f64, surface: Surface) -> Result<Option<f64>, ReadError> {
        Ok(self.locate_with_z(x, y, surface).await?.1)
    }

    /// Returns what [`locate`](Self::locate) and [`surface_z`](Self::surface_z) return, from one walk to
    /// the point.
    ///
    /// # Errors
    /// As [`locate`](Self::locate).
    ///
    /// # Examples
    ///
    /// ```
    /// # use delaunay_tiles::{BuildOptions, Builder, OpenOptions, Point, TileReader, input::PointBatch};
    /// use delaunay_tiles::query::Location;
    /// use delaunay_tiles::terrain::Surface;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("slope.tiles");
    /// # tokio::runtime::Runtime::new()?.block_on(async {
    /// # let points: Vec<Point> = (0..441).map(|i| Point::new(f64::from(i % 21), f64::from(i / 21))).collect();
    /// # let z = points.iter().map(|p| p.x).collect();
    /// # let mut builder = Builder::new(&path, BuildOptions::default())?;
    /// # builder.push(&PointBatch { records: (0..441).collect(), points, z }).await?;
    /// # builder.finish().await?;
    /// // A square of 20 by 20 that rises from 0 in the west to 20 in the east.
    /// let slope = TileReader::open(&path, OpenOptions::default()).await?;
    /// let (location, z) = slope.locate_with_z(7.0, 3.5, Surface::default()).await?;
    /// assert!(matches!(location, Location::OnEdge { .. }) && z == Some(7.0));
    /// # Ok(())
    /// # })
    /// # }
    /// ```
    pub async fn locate_with_z(&self, x: f64, y: f64, surface: Surface) -> Result<(Location, Option<f64>), ReadError> {
        let Some((tile, location)) = self.locate_in_tile(x, y).await? else {
            return Ok((Location::Outside, None));
        };
        let point = Point::new(x, y).representable();
        let z = self.z_in_place(&tile, point, &location, surface).await?;
        Ok((location, z))
    }

    /// Returns the z of the surface at a point, given its location and the tile that has it.
    async fn z_in_place(
        &self,
        tile: &Tile,
        point: Point,
        location: &Location,
        surface: Surface,
    ) -> Result<Option<f64>, ReadError> {
        let metadata = self.metadata();
        let at = (point, location);
        let peels = surface.peels(metadata).is_some();
        let least = FileSurface::without_peeling(surface, metadata);
        let found = self.z_on(tile, at, &least).await?;
        if found.is_some() || !peels {
            return Ok(found);
        }
        // Not all long triangles may be peeled.
        let most = FileSurface::without_peeling(surface.max_edge(None), metadata);
        if self.z_on(tile, at, &most).await?.is_none() {
            return Ok(None);
        }
        let surface = FileSurface::for_few_tiles(self, surface).await?;
        self.z_on(tile, at, &surface).await
    }

    /// Returns the same, of a surface of which all is known that it needs.
    async fn z_on(
        &self,
        tile: &Tile,
        (point, location): (Point, &Location),
        surface: &FileSurface,
    ) -> Result<Option<f64>, ReadError> {
        let z = |tile: &Tile, triangle: TriangleId| {
            let facet = surface.in_tile(tile).facet(tile, triangle)?;
            Some(facet.z_at(point, facet.place(point)?))
        };
        match location {
            Location::Outside => Ok(None),
            Location::InTriangle(triangle) => Ok(z(tile, triangle.triangle)),
            Location::OnEdge { ends: [a, b], triangle } => {
                let here = z(tile, triangle.triangle);
                if here.is_some() || !tile.has_z() {
                    return Ok(here);
                }
                let tile = self.tile_of(a.id).await?;
                let other = half_edge_towards(&tile, a.id.index, b.id);
                let other = other.map_err(|contradiction| self.damaged(tile.id(), contradiction.to_string()))?;
                Ok(other.and_then(|half_edge| z(&tile, half_edge.triangle())))
            }
            Location::OnVertex(vertex) => {
                let has = |tile: &Tile| {
                    let surface = surface.in_tile(tile);
                    triangles_at(tile, vertex.id).any(|triangle| surface.has(tile, triangle))
                };
                let is_on_surface = self.metadata().triangles == 0
                    || has(tile)
                    || (vertex.id.tile != tile.id() && has(&*self.tile_of(vertex.id).await?));
                Ok(if is_on_surface { z_in(tile, vertex.id) } else { None })
            }
        }
    }

    /// Returns the z of a vertex, read from the tile that owns it. Returns `None` if the file has
    /// no z. [`z_at`](Self::z_at) has an example.
    ///
    /// # Errors
    /// If the tile cannot be read, or has no such vertex.
    pub async fn z_of(&self, vertex: VertexId) -> Result<Option<f64>, ReadError> {
        Ok(self.tile_of(vertex).await?.z(vertex.index))
    }

    /// Returns the z of the corners of a triangle, in their order; `None` if the file has no z. Reads one
    /// tile, which [`locate`](Self::locate) has read.
    ///
    /// # Errors
    /// If the tile cannot be read, or has no such triangle.
    pub async fn z_of_corners(&self, triangle: &TriangleRef) -> Result<Option<[f64; 3]>, ReadError> {
        let tile = self.tile(triangle.tile).await?;
        if triangle.triangle.0 >= tile.triangle_count() {
            return Err(self.damaged(triangle.tile, format!("it has no triangle {}", triangle.triangle.0)));
        }
        let [a, b, c] = tile.corners(triangle.triangle).map(|corner| tile.z(corner));
        Ok(a.zip(b).zip(c).map(|((a, b), c)| [a, b, c]))
    }

    /// Returns the tile that owns a vertex, which has all triangles around it.
    ///
    /// # Errors
    /// If the tile cannot be read, or has no such vertex.
    async fn tile_of(&self, vertex: VertexId) -> Result<Arc<Tile>, ReadError> {
        let tile = self.tile(vertex.tile).await?;
        if tile.has_vertex(vertex.index) {
            return Ok(tile);
        }
        let contradiction = Contradiction::NoVertex(vertex.index);
        Err(self.damaged(vertex.tile, contradiction.to_string()))
    }
}

/// Returns the triangles of a tile that have a vertex as a corner. If the tile owns the vertex, these are
/// all of them.
pub(super) fn triangles_at(tile: &Tile, vertex: VertexId) -> impl Iterator<Item = TriangleId> {
    let is_own = vertex.tile == tile.id();
    let first = is_own.then(|| tile.leaving(vertex.index)).flatten();
    let around = first.map(|first| tile.star(tile.rewind(first).0));
    let border = (!is_own).then(|| tile.border_triangle_ids());
    let has_corner = move |&triangle: &TriangleId| {
        let corners = tile.corners(triangle).into_iter();
        corners.map(|corner| tile.vertex(corner).id).any(|id| id == vertex)
    };
    let around = around.into_iter().flatten().map(HalfEdge::triangle);
    around.chain(border.into_iter().flatten().filter(has_corner))
}

/// Returns the z of a vertex of a tile, or of a corner that another tile owns.
fn z_in(tile: &Tile, vertex: VertexId) -> Option<f64> {
    if vertex.tile == tile.id() {
        return tile.z(vertex.index);
    }
    let mut foreign = (tile.vertex_count()..tile.corner_count() as u32).map(VertexIndex);
    tile.z(foreign.find(|&corner| tile.vertex(corner).id == vertex)?)
}
