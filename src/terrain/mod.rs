//! The triangulation as a surface: heights, rasters, contours, profiles and volumes.
//!
//! In: an open tile file whose vertices have z. Out: what people ask of terrain. The surface is the
//! plane of each triangle; nothing is resampled or smoothed.
//!
//! All of it is made of pure functions of tiles, which need no other tile: a tile has the z of all
//! corners of its triangles. Only to peel triangles off the hull, all tiles are read before. What they
//! compute is the same to the last bit, whatever the tiles, the threads and the memory.
//!
//! | module | contents |
//! |---|---|
//! | `facet` | the plane of a triangle, exact places on it |
//! | `surface`, `clip` | the triangles that count; polygons to which results are limited |
//! | `peel` | triangles that are left out from the hull inwards |
//! | `outline` | z outside, from the nearest point of the hull |
//! | `ponds` | the lowest z of shores, for all vertices in them |
//! | `grid`, `scan`, `measure` | cells, the cells in a triangle, what they show |
//! | `cells`, `raster` | blocks of a raster, filled by threads |
//! | `chord`, `profile` | the part of a segment in a triangle; heights along a line |
//! | `overlap`, `exact_sum`, `volume` | the part of a triangle in polygons; sums without rounding; cut and fill |
//! | [`shading`] | colours of heights, and the light on slopes |
//! | `strips` | segments, found by their place |
//! | `levels`, `contours`, `chain`, `strands` | contours in a tile, and how those of several tiles join |
//! | `cut` | the parts of a line in polygons |

mod cells;
mod chain;
mod chord;
mod clip;
mod contours;
mod cut;
mod error;
mod exact_sum;
mod facet;
mod grid;
mod levels;
mod measure;
mod outline;
mod overlap;
mod peel;
mod ponds;
mod profile;
mod raster;
mod scan;
pub mod shading;
mod strands;
mod strips;
mod surface;
mod volume;

pub(crate) use chain::{complete, push};
pub use clip::Clip;
pub(crate) use clip::Side;
pub use contours::ContourOptions;
pub(crate) use contours::{Ends, TileChains, Traced, level_ranges, trace};
pub(crate) use cut::{CUT_PER_EDGE, Cut, Piece};
pub use error::TerrainError;
pub(crate) use exact_sum::ExactSum;
pub(crate) use facet::{Corner, Facet, Place};
pub use grid::{Grid, GridError};
pub use levels::{Levels, LevelsError};
pub use measure::{Light, Measure, UnknownMeasure};
pub(crate) use outline::{Outline, OutlineParts};
pub(crate) use ponds::ShoreLevels;
pub use ponds::{Ponds, Shores};
pub use profile::{Profile, ProfilePart, ProfilePoint};
pub use raster::RasterOptions;
pub(crate) use raster::{Block, BlockSize, Raster};
pub(crate) use strands::{Run, Strand, Strands};
pub use surface::Surface;
pub(crate) use surface::{FileSurface, TileSurface, facet};
pub use volume::Volume;
