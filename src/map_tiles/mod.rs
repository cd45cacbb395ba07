//! Map tiles: the triangulation as pictures, heights, vector tiles and terrain meshes.
//!
//! In: an open tile file and the number of a map tile. Out: the bytes of the map tile. Drawing is a
//! pure function of the file, the grid, the number and the limits: the same bytes on every machine
//! of a kind, whatever the threads, the cache and the tiles of the file.
//!
//! ```text
//!  coord ──▶ grid ──▶ which points of the file ──▶ samples ──▶ heights, ground ──▶ shade, terrarium
//!              │                                                                        │
//!              └────▶ which level, which tiles ──▶ budget ──▶ shapes, facets ─────▶ paint, mesh
//!                                                                └────────────────▶ terrain
//! ```
//!
//! | module | contents |
//! |---|---|
//! | `coord`, `layer`, `drawn` | names of grids and layers, numbers of tiles, limits, errors |
//! | `projection`, `grid` | the way from fractions of a square to coordinates of the file |
//! | `source`, `heights`, `facts` | a file to draw, its range of heights, what describes it |
//! | `budget`, `gather` | the tiles that a drawing needs; what it asks of them |
//! | `presence` | whether the file has anything in a map tile, without drawing it |
//! | `lattice`, `samples`, `edges` | the points at which a picture asks; pixels that need more of them |
//! | `window`, `chains`, `shapes`, `facets` | what of the plane is in a tile, in whole units |
//! | `draw`, `picture`, `shade`, `paint` | pictures |
//! | `colours`, `image`, `terrarium` | colours, PNG, heights as colours |
//! | `mesh`, `vector` | vector tiles |
//! | `terrain`, `quantized` | meshes for Cesium |
//!
//! Sources: Horn, "Hill shading and the reflectance map" (1981); Sutherland and Hodgman, "Reentrant
//! polygon clipping" (1974); Mapbox Vector Tile specification 2.1; Cesium, "quantized-mesh-1.0".
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
mod lattice;
mod layer;
mod mesh;
mod paint;
mod picture;
mod presence;
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
