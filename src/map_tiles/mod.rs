//! Map tiles: the triangulation as pictures, heights, vector tiles and terrain meshes.
//!
//! In: an open tile file and the number of a map tile. Out: the bytes of the map tile. Drawing is a pure
//! function of the file, the grid, the number and the limits: the same bytes on every machine of a
//! kind, whatever the threads, the cache and the tiles of the file.
//!
//! ```text
//!  coord ─▶ grid ─▶ which points of the file ─▶ samples ─▶ heights, ground ─┐
//!             │                                                             ├─▶ shade, terrarium
//!             └──▶ which level, which tiles ──▶ budget ──▶ shapes ──────────┼─▶ mesh
//!                                                                           └─▶ terrain
//! ```
//!
//! | module | contents |
//! |---|---|
//! | `coord`, `layer`, `drawn` | names of grids and layers, numbers of tiles, limits, errors |
//! | `projection`, `grid` | the way from pixels to coordinates of the file |
//! | `source`, `heights`, `facts` | a file to draw, its range of heights, what describes it |
//! | `budget`, `samples` | tiles that a drawing needs; the points at which it asks |
//! | `draw`, `terrarium`, `image`, `colours` | pictures |
//! | `terrain` | meshes for Cesium |
//!
//! [`MapSource`] has an example.

mod budget;
mod chains;
mod colours;
mod coord;
mod draw;
mod drawn;
mod edges;
mod facets;
mod facts;
mod gather;
mod grid;
mod heights;
mod image;
mod layer;
mod mesh;
mod paint;
mod picture;
mod projection;
mod quantized;
mod samples;
mod shade;
mod shapes;
mod source;
mod terrain;
mod terrarium;
mod vector;
mod window;

pub use coord::{GridKind, TerrainCoord, TileCoord, UnknownGrid};
pub use drawn::{DrawError, DrawLimits, Drawn, NoGrid};
pub use facts::LayerFacts;
pub use grid::TileGrid;
pub use layer::{Layer, UnknownLayer, VectorLayer};
pub use source::MapSource;
pub use terrain::{TerrainFacts, TerrainRange};
