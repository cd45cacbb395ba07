//! What comes in: points, segments and sites from files, each as one blocking stream of batches.
//!
//! | what | from | by |
//! |---|---|---|
//! | points | the formats below | [`PointSource`] |
//! | lines: break lines, walls | GeoJSON, rows `x1,y1,x2,y2`, raw pairs of record numbers | [`SegmentSource::open`] |
//! | obstacles | GeoJSON's polygons, directed | [`SegmentSource::open_obstacles`] |
//! | segments and hole points | Triangle's `.poly` | [`PolySource`] |
//! | sites: points with an id | GeoJSON's points, rows `x,y,id` | [`SiteSource`] |
//! | rows of text of any kind | lines | [`RowFile`] |
//!
//! The rest of this page is about points; the others say on their own pages what they read, count and keep.
//!
//! In: paths (or streams) in any mix of the formats below, and [`InputOptions`]. Out: [`PointBatch`]es in input order,
//! every point valid ([`Point::is_valid`]), normalized ([`Point::normalized`]) and with its record number. Why one stream:
//! several files are one point set, and whoever triangulates must not know formats.
//!
//! ```text
//!   paths ─> PointSource ─> one reader at a time ─> Sink ─> PointBatch
//!              │ open: peeks at every file             │ checks, counts, numbers every record
//!              ├ has_z, crs, total_bytes               └ InputError::Record, or skipped
//!              └ expected_points, sample, identity
//! ```
//!
//! | format | module | as a stream | feature |
//! |---|---|---|---|
//! | rows of text: comma, semicolon, tab, blanks | `text` over `rows` | yes | `text` |
//! | raw little-endian f64 | `raw` | yes | |
//! | Triangle's and TetGen's `.node` | `node` | yes | |
//! | the points of Triangle's `.poly` | `node`; `poly` has the rest | yes, but for those with a `.node` beside them | |
//! | GeoJSON, newline-delimited too | `geojson` over `json` | yes | `geojson` |
//! | LAS, LAZ, COPC | `las`, `laz` | no: needs a file | `las` |
//!
//! **Memory** is bounded whatever the file: a read buffer of 256 KiB, a batch, and for text one row of at most 1 MiB
//! with the ends of its fields, for GeoJSON one name of at most 2 MiB, for LAZ the decompressor's state of one chunk;
//! for a sample of the points 4 MiB. No length or count that a file claims is believed before it is
//! compared with the file's size. Every file is hostile: what is wrong with it becomes an [`InputError`], never a panic.
//!
//! **A file that changes** while it is read (in length, time of modification, or by another one
//! that takes its place between two openings) is [`InputError::Changed`] at the latest when its
//! last batch is due, and nothing that was read of it counts. [`FileStamp`]s let a caller say the
//! same of files that several sources read. A [`Reading`] shows how far a source is and stops it,
//! in the middle of a long stretch without records too.
//!
//! **Record numbers** are u64 positions from 0 over all inputs in order. Every record counts, those that are skipped,
//! withheld or filtered too, so that a number finds its record again whatever the options: text rows (not header,
//! comment and blank lines), pairs or triples of f64, points of `.node` and `.poly`, GeoJSON positions in document order
//! (the closing one of a ring too), LAS points.
//!
//! **z**: [`PointSource::has_z`] is known at open, since every file's header or first record is
//! looked at. If any input has z then every batch has z for all of its points, and a point without
//! one is an error, or gets 0.0 and a note reports it ([`MissingZ`]); otherwise no batch has any.
//! Ends of lines and sites without z have NaN in batches that have z: whether they need one depends
//! on what lies there. A NaN of a file never gets in.

mod bytes;
mod caught;
mod error;
mod files;
#[cfg(feature = "geojson")]
mod geojson;
#[cfg(feature = "geojson")]
mod json;
#[cfg(feature = "las")]
mod las;
#[cfg(feature = "las")]
mod laz;
mod lines;
mod node;
mod options;
mod poly;
mod raw;
mod reader;
mod row_file;
#[cfg(feature = "text")]
mod rows;
mod sample;
mod segments;
mod sink;
#[cfg_attr(
    not(any(feature = "text", feature = "geojson")),
    allow(dead_code, unused_variables, reason = "sites are read from text and GeoJSON alone")
)]
mod sites;
mod source;
#[cfg_attr(
    not(any(feature = "text", feature = "geojson")),
    allow(dead_code, reason = "without these formats nothing has places but points")
)]
mod spot;
#[cfg(feature = "text")]
mod text;
mod watch;

pub use caught::panic_is_caught;
pub use error::{InputError, Place};
pub use options::{Column, Columns, Format, InputOptions, MissingZ, Returns};
pub use poly::PolySource;
pub use row_file::RowFile;
pub use segments::{LineOrigin, SegmentBatch, SegmentSource};
pub use sink::InputCounts;
pub use sites::{SiteBatch, SiteId, SiteSource};
pub use source::PointSource;
pub use watch::{FileStamp, Reading};

use crate::geometry::Point;

/// A batch of points in input order.
#[derive(Clone, Debug, Default)]
pub struct PointBatch {
    /// The points: valid and normalized.
    pub points: Vec<Point>,
    /// Their elevations: finite. Empty if the source has none ([`PointSource::has_z`]), else as long as `points`.
    pub z: Vec<f64>,
    /// Their record numbers, ascending; as long as `points`.
    pub records: Vec<u64>,
}

impl PointBatch {
    /// The number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether the batch has no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Removes all points and keeps the memory.
    pub fn clear(&mut self) {
        self.points.clear();
        self.z.clear();
        self.records.clear();
    }
}
