//! The triangulation as a surface: heights, rasters, contours, profiles and volumes.
//!
//! In: an open tile file whose vertices have z. Out: what people ask of terrain. The surface is the
//! plane of each triangle; nothing is resampled or smoothed.
//!
//! All of it is made of pure functions of tiles, which need no other tile: a tile has the z of all
//! corners of its triangles. What they compute is the same to the last bit, whatever the tiles, the
//! threads and the memory.
//!
//! | module | contents |
//! |---|---|
//! | `facet` | the plane of a triangle, exact places on it |
//! | `surface`, `clip` | the triangles that count; polygons to which results are limited |
//! | `outline` | z outside, from the nearest point of the hull |
//! | `grid`, `scan`, `measure` | cells, the cells in a triangle, what they show |
//! | `cells`, `raster` | blocks of a raster, filled by threads |

mod cells;
mod clip;
mod error;
mod facet;
mod grid;
mod measure;
mod outline;
mod raster;
mod scan;
mod surface;

pub use clip::Clip;
pub use error::TerrainError;
pub use grid::{Grid, GridError};
pub use measure::{Light, Measure, UnknownMeasure};
pub(crate) use outline::{Outline, OutlineParts};
pub use raster::RasterOptions;
pub(crate) use raster::{Block, BlockSize, Raster};
pub use surface::Surface;
pub(crate) use surface::facet;
