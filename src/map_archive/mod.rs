//! The map tiles of a layer as one file that needs no server: a PMTiles archive, version 3.
//!
//! In: a file to draw, a layer, a grid and a range of zooms. Out: an archive with the same bytes that
//! [`MapSource::draw`](crate::map_tiles::MapSource::draw) gives, vector tiles compressed with gzip.
//!
//! ```text
//! plan: descent ──▶ how many map tiles ──▶ too many? ──▶ an estimate, and an error
//! write: descent ──▶ draw, some at once ──▶ in order ──▶ crate pmtiles ──▶ output
//! ```
//!
//! A descent goes from the tile of zoom 0 to its quarters, in the order of the archive, and leaves
//! out quarters in which the directory of the file has nothing. So the work is that of the tiles that
//! there are, and nothing is kept of them but the directory of the archive.
//!
//! The archive is a function of the file and of the options but for [`ArchiveOptions::at_once`].
//!
//! Source: "PMTiles Version 3 Specification", <https://github.com/protomaps/PMTiles>.

mod descent;
mod drawing;
mod error;
mod header;
mod measured;
mod options;
mod plan;
mod write;

pub use error::{ArchiveError, TooMany};
pub use options::{ArchiveOptions, UnknownZooms, Zooms};
pub use plan::{ArchivePlan, plan};
pub use write::{ArchiveSummary, write};
