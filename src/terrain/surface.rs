//! The triangles of a file that count as its surface.
//!
//! In: a [`Surface`], which users choose. Out: a [`FileSurface`], which knows what it has to know of the
//! whole file, and of that a [`TileSurface`] for each tile.

use std::sync::Arc;

use crate::geometry::TriangleId;
use crate::store::{Metadata, Needs, PassReader, ReadError, Tile, TileReader};
use crate::terrain::facet::{Corner, Facet};
use crate::terrain::peel::{Bits, Peeled, is_long};

/// The triangles that count as the surface: by default those that are in no hole.
///
/// ```
/// use delaunay_tiles::terrain::Surface;
///
/// let surface = Surface::default().max_edge(Some(50.0));
/// // A lake with few points stays; a bay that the hull spans does not.
/// let with_lakes = surface.from_hull(true);
/// # let _ = with_lakes;
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surface {
    holes: bool,
    max_edge: Option<f64>,
    from_hull: bool,
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

    /// Sets whether, of the triangles with an edge longer than [`max_edge`](Self::max_edge), only those
    /// are left out that are peeled off from the hull inwards; false by default. A triangle is peeled if
    /// it has an edge that is too long, and an edge on the hull or of another triangle that is peeled.
    /// Constraints and holes do not stop it. Without `max_edge`, this has no effect.
    ///
    /// Which triangles these are follows from the whole triangulation, so each question reads all tiles
    /// first.
    #[must_use]
    pub fn from_hull(mut self, from_hull: bool) -> Self {
        self.from_hull = from_hull;
        self
    }

    /// Returns the length if triangles of a file may be peeled off because of it.
    pub(crate) fn peels(&self, metadata: &Metadata) -> Option<f64> {
        self.max_edge.filter(|_| self.from_hull && metadata.triangles > 0)
    }
}

/// The surface of a file.
#[derive(Clone, Debug)]
pub(crate) struct FileSurface {
    holes: bool,
    limit: Limit<Arc<Peeled>>,
}

/// The triangles that are left out because they are long.
#[derive(Clone, Debug)]
enum Limit<P> {
    None,
    /// Those with a longer edge.
    Longer(f64),
    Peeled(P),
}

impl FileSurface {
    /// Returns the surface of a file. If triangles are peeled off, this reads all tiles, and calls
    /// `advance` after each.
    ///
    /// # Errors
    /// Fails if triangles are peeled off and a tile cannot be read, if tiles contradict each other, or if
    /// the memory that the reader may use does not suffice.
    pub(crate) async fn of(
        reader: &PassReader,
        surface: Surface,
        advance: impl FnMut() + Send,
    ) -> Result<Self, ReadError> {
        let metadata = reader.metadata();
        let Some(most) = surface.peels(metadata) else {
            return Ok(Self::without_peeling(surface, metadata));
        };
        let peeled = Peeled::of(reader, most, advance).await?;
        Ok(Self {
            limit: Limit::Peeled(Arc::new(peeled)),
            ..Self::without_peeling(surface, metadata)
        })
    }

    /// Returns the surface of a file for a few of its tiles, like [`of`](Self::of).
    ///
    /// # Errors
    /// As [`of`](Self::of), and if the directory cannot be read.
    pub(crate) async fn for_few_tiles(reader: &TileReader, surface: Surface) -> Result<Self, ReadError> {
        match surface.peels(reader.metadata()) {
            Some(_) => Self::of(&reader.for_passes().await?, surface, || {}).await,
            None => Ok(Self::without_peeling(surface, reader.metadata())),
        }
    }

    /// Returns the surface of a file from which all long triangles are left out, whether they are peeled
    /// or not. Without holes in the file, no triangle is asked whether it is in one, which takes a lookup.
    pub(crate) fn without_peeling(surface: Surface, metadata: &Metadata) -> Self {
        Self {
            holes: surface.holes || metadata.hole_triangles == 0,
            limit: surface.max_edge.map_or(Limit::None, Limit::Longer),
        }
    }

    /// Returns whether triangles in holes count.
    pub(crate) fn has_holes(&self) -> bool {
        self.holes
    }

    /// Returns whether triangles are left out for the length of an edge.
    pub(crate) fn is_limited(&self) -> bool {
        !matches!(self.limit, Limit::None)
    }

    /// Returns the memory that a pass needs for it.
    pub(crate) fn needs(&self) -> Needs {
        match &self.limit {
            Limit::None | Limit::Longer(_) => Needs::default(),
            Limit::Peeled(peeled) => peeled.needs(),
        }
    }

    /// Returns the part of it in a tile. If triangles are peeled off, this looks at all of the tile's.
    pub(crate) fn in_tile(&self, tile: &Tile) -> TileSurface {
        TileSurface {
            holes: self.holes,
            limit: match &self.limit {
                Limit::None => Limit::None,
                Limit::Longer(most) => Limit::Longer(*most),
                Limit::Peeled(peeled) => peeled.in_tile(tile).map_or(Limit::None, Limit::Peeled),
            },
        }
    }
}

/// The surface in a tile. It must be asked about that tile only.
#[derive(Debug)]
pub(crate) struct TileSurface {
    holes: bool,
    limit: Limit<Bits>,
}

impl TileSurface {
    /// Returns whether a triangle of the tile counts.
    pub(crate) fn has(&self, tile: &Tile, triangle: TriangleId) -> bool {
        (self.holes || !tile.is_hole(triangle))
            && match &self.limit {
                Limit::None => true,
                Limit::Longer(most) => !is_long(tile, triangle, *most),
                Limit::Peeled(peeled) => !peeled.has(triangle.index()),
            }
    }

    /// Returns the facet of a triangle of the tile; `None` if it does not count, or the file has no z.
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
