//! The triangles of a file that count as its surface.

use crate::geometry::{Point, TriangleId};
use crate::store::{Metadata, Tile};
use crate::terrain::facet::{Corner, Facet};

/// The triangles that count as the surface: by default those that are in no hole.
///
/// ```
/// use delaunay_tiles::terrain::Surface;
///
/// let surface = Surface::default().max_edge(Some(50.0));
/// # let _ = surface;
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surface {
    holes: bool,
    max_edge: Option<f64>,
}

impl Surface {
    /// Sets whether triangles in holes count too; false by default.
    #[must_use]
    pub fn holes(mut self, holes: bool) -> Self {
        self.holes = holes;
        self
    }

    /// Leaves out triangles with an edge longer than this, in units of the coordinates. `None`, the
    /// default, leaves out none.
    #[must_use]
    pub fn max_edge(mut self, length: Option<f64>) -> Self {
        self.max_edge = length;
        self
    }

    /// Returns the surface of a file. Without holes in the file, no triangle is asked whether it is in
    /// one, which takes a lookup.
    pub(crate) fn of(self, metadata: &Metadata) -> Self {
        let holes = self.holes || metadata.hole_triangles == 0;
        Self { holes, ..self }
    }

    /// Returns whether triangles in holes count.
    pub(crate) fn has_holes(&self) -> bool {
        self.holes
    }

    /// Returns whether triangles are left out for the length of an edge.
    pub(crate) fn is_limited(&self) -> bool {
        self.max_edge.is_some()
    }

    /// Returns whether a triangle of a tile counts.
    pub(crate) fn has(&self, tile: &Tile, triangle: TriangleId) -> bool {
        (self.holes || !tile.is_hole(triangle))
            && self.max_edge.is_none_or(|most| {
                let [a, b, c] = tile.triangle_points(triangle);
                [(a, b), (b, c), (c, a)].into_iter().all(|(p, q)| length(p, q) <= most)
            })
    }

    /// Returns the facet of a triangle of a tile; `None` if it does not count, or the file has no z.
    pub(crate) fn facet(&self, tile: &Tile, triangle: TriangleId) -> Option<Facet> {
        self.has(tile, triangle).then(|| facet(tile, triangle))?
    }

    /// Returns the same as [`facet`](Self::facet).
    ///
    /// # Errors
    /// Fails if the triangle is not counter-clockwise, which valid files do not have.
    pub(crate) fn checked_facet(&self, tile: &Tile, triangle: TriangleId) -> Result<Option<Facet>, String> {
        match self.facet(tile, triangle) {
            Some(facet) if facet.doubled_area() > 0.0 => Ok(Some(facet)),
            Some(_) => Err(format!("triangle {} is not counter-clockwise", triangle.0)),
            None => Ok(None),
        }
    }
}

/// Returns the facet of a triangle of a tile; `None` if the file has no z.
pub(crate) fn facet(tile: &Tile, triangle: TriangleId) -> Option<Facet> {
    let [a, b, c] = tile.corners(triangle).map(|corner| {
        Some(Corner {
            point: tile.point(corner),
            z: tile.z(corner)?,
        })
    });
    Some(Facet::new([a?, b?, c?]))
}

/// Returns the length of an edge; the same for both directions.
fn length(a: Point, b: Point) -> f64 {
    (a.x - b.x).hypot(a.y - b.y)
}
