//! Parquet files with points: columns of coordinates, or GeoParquet's geometries.
//!
//! In: a file. Out: its points, one batch of rows after another. Sources: the Apache Parquet format,
//! and GeoParquet 1.1.
//!
//! | module | contents |
//! |---|---|
//! | `thrift` | checks of the metadata that the crate does not make |
//! | `chunks` | the bytes of the file, and the limits on pages |
//! | `metadata` | the end of the file: schema, row groups, keys |
//! | `geo` | the key `geo` of GeoParquet |
//! | `choice` | which columns have the points |
//! | `column` | the values of a column in a row group |
//! | `wkb` | points in WKB |
//! | `reader` | the reader of points |
//!
//! - **Columns** are those that the option `columns` names, by name or by number from 1 among the
//!   leaves of the schema; else the geometry column; else those with the names that text files have
//!   too (`names`). They are numbers: float, double, integers, or decimals of up to 64 bits. Each row
//!   is a record. Null is an invalid record.
//! - **Geometries** are WKB (ISO or with the flags of PostGIS), or `point`, a struct of x, y and z.
//!   Points and MultiPoints are read, and each position is a record. Rows without a geometry, and
//!   empty geometries, have no records.
//!
//! The crate `parquet` decodes pages, without Arrow. It trusts sizes, and so they are checked first:
//!
//! - The metadata at the end of the file has at most 8 MiB. Its schema is scanned before the crate
//!   reads it, because the crate recurses into groups and copies the path of each leaf.
//! - A page has at most 16 MiB, compressed and not. Its header is scanned before the crate allocates.
//!   gzip is decoded once more to count its bytes, and the old codec LZ4 is refused (not LZ4_RAW),
//!   because the crate decodes these two without a limit.
//! - Geometries are read page by page, because they hold the pages that they are in.
//! - A dictionary has at most a million values, and no more than its page has room for.
//! - Pages with lengths of values in an encoding of their own (DELTA_LENGTH_BYTE_ARRAY and the like)
//!   are refused, because the crate allocates by the number of lengths that they claim.
//!
//! **Memory**: the metadata; for each column a page and a dictionary. The crate's panics are caught.

mod choice;
mod chunks;
mod column;
mod geo;
mod metadata;
mod reader;
mod thrift;
mod wkb;

pub use reader::{no_stream, open};
