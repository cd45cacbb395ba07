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
//! every point [valid](crate::geometry::Point::is_valid), [normalized](crate::geometry::Point::normalized) and with its
//! record number. Why one stream: several files are one point set, and whoever triangulates must not know formats.
//!
//! ```text
//!   paths ─> PointSource ─> one reader at a time ─> Sink ─> PointBatch
//!              │ open: peeks at every file             │ checks, counts, numbers every record
//!              ├ has_z, crs, total_bytes               └ InputError::Record, or skipped
//!              └ expected_points, sample, identity
//! ```
//!
//! All three kinds of record go through one [`Source`]. The rooms, each of which uses those before it:
//!
//! | room | what |
//! |---|---|
//! | `watch`, `bytes` | bytes of files and streams: counted, stopped, unzipped |
//! | `reader` | what a format does, and the sink where it puts its records |
//! | `points`, `lines`, `sites` | batches, and what their sinks take |
//! | `formats` | a room or file per format, in it a reader per kind of record |
//! | `source` | the stream of batches, and which formats each kind is read from |
//!
//! | format | in `formats` | as a stream | feature |
//! |---|---|---|---|
//! | rows of text: comma, semicolon, tab, blanks | `text` | yes | `text` |
//! | raw little-endian f64 | `raw` | yes | |
//! | Triangle's and TetGen's `.node` | `node` | yes | |
//! | the points of Triangle's `.poly` | `node`; `poly` has the rest | yes, but for those with a `.node` beside them | |
//! | GeoJSON, newline-delimited too | `geojson` | yes | `geojson` |
//! | LAS, LAZ, COPC | `las` | no: needs a file | `las` |
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
#[cfg_attr(
    not(all(feature = "text", feature = "geojson")),
    allow(dead_code, reason = "most flaws are of records in text or GeoJSON")
)]
mod flaw;
mod formats;
mod lines;
mod options;
mod points;
mod reader;
mod sample;
#[cfg_attr(
    not(any(feature = "text", feature = "geojson")),
    allow(dead_code, reason = "sites are read from text and GeoJSON alone")
)]
mod sites;
mod source;
mod spot;
mod watch;

pub use caught::panic_is_caught;
pub use error::{InputError, Place, RecordKind};
pub use lines::SegmentBatch;
pub use options::{Column, Columns, Format, InputOptions, MissingZ, Returns};
pub use points::{InputCounts, PointBatch};
pub use sites::{SiteBatch, SiteId};
pub use source::{LineOrigin, PointSource, PolySource, RowFile, SegmentSource, SiteSource, Source};
pub use watch::{FileStamp, Reading};
