//! Reading of points, segments and sites from files, each as one blocking stream of batches.
//!
//! | what | from | type |
//! |---|---|---|
//! | points | the formats below | [`PointSource`] |
//! | lines: break lines, walls | vector data, rows `x1,y1,x2,y2`, raw pairs of record numbers | [`SegmentSource::open`] |
//! | obstacles | polygons of vector data, directed | [`SegmentSource::open_obstacles`] |
//! | edges of a triangulation | `.node` with `.ele`, PLY, OBJ | [`SegmentSource::open_edges`] |
//! | segments and hole points | Triangle's `.poly` | [`PolySource`] |
//! | sites: points with an id | points of vector data, rows `x,y,id` | [`SiteSource`] |
//! | rows of text of any kind | lines | [`RowFile`] |
//!
//! Vector data is GeoJSON, FlatGeobuf, Shapefile and GeoPackage. The same features give the same
//! records in each of these formats.
//!
//! The rest of this page describes points. The pages of the other sources say what they read, count
//! and keep.
//!
//! In: paths (or streams) in any mix of the formats below, and [`InputOptions`]. Out:
//! [`PointBatch`]es in input order. Every point is [valid](crate::geometry::Point::is_valid),
//! [normalized](crate::geometry::Point::normalized) and has its record number. All files go into
//! one stream because several files are one point set, and because code that triangulates must not
//! depend on formats.
//!
//! ```text
//!   paths ─> PointSource ─> one reader at a time ─> Sink ─> PointBatch
//!              │ open: peeks at every file             │ checks, counts, numbers every record
//!              ├ has_z, crs, total_bytes               └ InputError::Record, or skipped
//!              └ expected_points, sample, identity
//! ```
//!
//! All three kinds of record go through one [`Source`]. Each of these modules uses only those above
//! it:
//!
//! | module | contents |
//! |---|---|
//! | `layer` | the names of layers of a GeoPackage |
//! | `decoders` | threads that decode pieces of a file |
//! | `watch`, `bytes` | bytes of files and streams: counted, stopped, unzipped |
//! | `reader` | the reader of a format, and the sink for its records |
//! | `points`, `lines`, `sites` | batches, and the sinks of their records |
//! | `content` | what a file is by its first bytes |
//! | `formats` | a folder or file per format, with a reader per kind of record |
//! | `source` | the stream of batches, and the formats from which each kind is read |
//! | `about`, `describe` | what a file has: counts, bounds, fields, reference system, layers |
//!
//! | format | in `formats` | as a stream | feature |
//! |---|---|---|---|
//! | rows of text: comma, semicolon, tab, blanks | `text` | yes | `text` |
//! | raw little-endian f64 | `raw` | yes | |
//! | Triangle's and TetGen's `.node` | `node` | yes | |
//! | the points of Triangle's `.poly` | `node`; `poly` has the rest | yes, unless a `.node` file beside it has the points | |
//! | GeoJSON, also newline-delimited | `geojson` | yes | `geojson` |
//! | FlatGeobuf | `flatgeobuf` | yes | `flatgeobuf` |
//! | Shapefile | `shapefile` | yes | `shapefile` |
//! | GeoPackage | `geopackage` | no: needs a file | `geopackage` |
//! | LAS, LAZ, COPC | `las` | no: needs a file | `las` |
//! | PLY | `ply` | yes | |
//! | Wavefront OBJ | `obj` | yes | |
//! | Parquet, GeoParquet | `parquet` | no: needs a file | `parquet` |
//!
//! Vector data goes through `formats::shapes`, which makes points, segments, rings and sites of
//! geometries, whatever the format.
//!
//! **Memory** is bounded for every file: a read buffer of 256 KiB and a batch; for text one row of
//! at most 1 MiB with the ends of its fields; for GeoJSON one name of at most 2 MiB; for FlatGeobuf,
//! Shapefile and GeoPackage one feature of at most 512 MiB, which they have as a whole; for LAZ the
//! decompressor's state for one chunk and 16 bytes for each other chunk, and if parts of a COPC file
//! are chosen, at most 200 bytes for each; for Parquet the metadata, of at most 8 MiB in the file, and a
//! page of each column, of at most 16 MiB; for edges 1 MiB of those seen last; for a sample of the
//! points 4 MiB. No length or count in a
//! file is trusted before it is compared with the file's size. Every file is treated as hostile:
//! whatever is wrong with it becomes an [`InputError`], never a panic.
//!
//! **Parts**: a COPC file is an octree of points. If [`InputOptions::copc_level`],
//! [`InputOptions::copc_resolution`] or [`InputOptions::bounds`] exclude nodes, these are not read.
//! The points and their record numbers are the same as if they were.
//!
//! **A file that changes** while it is read (in length, in time of modification, or because another
//! file replaces it between two openings) is reported as [`InputError::Changed`], at the latest
//! when its last batch is requested. Everything that was read from it must then be discarded. With
//! [`FileStamp`]s a caller can check files that several sources read in the same way. A [`Reading`]
//! shows the progress of a source and stops it, even while it reads a long part without records.
//!
//! **Record numbers** are u64 positions, counted from 0 over all inputs in order. Every record
//! counts, including skipped, withheld and filtered ones, so that a number identifies its record
//! whatever the options. The records are: text rows (not header, comment and blank lines), pairs or
//! triples of f64, points of `.node` and `.poly`, positions of vector data in the order of the file
//! (including the closing one of a ring), LAS points, vertices of PLY and OBJ, rows of columns of
//! Parquet, and positions in the geometries of GeoParquet.
//!
//! **z**: [`PointSource::has_z`] is known at open, since every file's header or first record is
//! examined. If any input has z, then every batch has z for all of its points. A point without z is
//! then an error, or gets 0.0 and a note reports it ([`MissingZ`]). If no input has z, no batch has
//! any. Ends of lines and sites without z have NaN in batches that have z, because they need no z
//! of their own where a point with z has the same position. A NaN in a file is never accepted.

mod about;
mod bytes;
mod caught;
mod content;
#[cfg(any(feature = "las", feature = "text"))]
mod decoders;
mod describe;
mod error;
#[cfg_attr(
    not(all(feature = "text", feature = "geojson")),
    allow(dead_code, reason = "most flaws are of records in text or GeoJSON")
)]
mod flaw;
mod format;
mod formats;
mod layer;
mod lines;
mod options;
mod point_z;
mod points;
mod reader;
mod sample;
#[cfg_attr(
    not(any(feature = "text", feature = "geojson")),
    allow(dead_code, reason = "sites are read from text and GeoJSON alone")
)]
mod sites;
mod source;
mod watch;

pub use about::{CopcInfo, Field, LasInfo};
pub use caught::panic_is_caught;
pub use describe::{Contents, FileInfo, ItemCounts, describe};
pub use error::{InputError, Location, RecordKind};
pub use format::Format;
pub use lines::SegmentBatch;
pub use options::{Column, Columns, InputOptions, MissingZ, Returns};
pub use points::{InputCounts, PointBatch};
pub use sites::{SiteBatch, SiteId};
pub use source::{LineOrigin, PointSource, PolySource, RowFile, SegmentSource, SiteSource, Source};
pub use watch::{FileStamp, Reading};
