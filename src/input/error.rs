//! The errors of this module. Each says which file, which record, line or offset, what was found
//! and what to do.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{fmt, io};

use crate::shown;

/// The problem of a file that is not COPC where the options require it, and what to do.
pub const NOT_COPC: (&str, &str) = (
    "this is not a COPC file",
    "only COPC files have levels and resolutions: leave these options out, or convert the file",
);

/// A location in a file, as reported by [`InputError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Location {
    /// The file as a whole.
    File,
    /// A line of text, counted from 1.
    Line(u64),
    /// A byte offset, counted from 0. In a gzip file the offset counts decompressed bytes.
    Byte(u64),
    /// A point of a LAS file, counted from 0 in that file.
    Point(u64),
    /// A feature of a file of vector data, counted from 0 in that file.
    Feature(u64),
    /// A row of a Parquet file, counted from 0 in that file.
    Row(u64),
}

impl Location {
    /// Returns the text to put before a message about this location.
    fn prefix(self) -> String {
        match self {
            Self::File => String::new(),
            location => format!("{location}: "),
        }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => f.write_str("file"),
            Self::Line(n) => write!(f, "line {n}"),
            Self::Byte(n) => write!(f, "byte {n}"),
            Self::Point(n) => write!(f, "point {n}"),
            Self::Feature(n) => write!(f, "feature {n}"),
            Self::Row(n) => write!(f, "row {n}"),
        }
    }
}

/// The kind of a record, as reported by [`InputError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RecordKind {
    /// A point.
    Point,
    /// A segment of a line.
    Segment,
    /// An obstacle: a feature with polygons.
    Obstacle,
    /// A site.
    Site,
    /// A face or a line of a mesh, whose edges are read.
    Face,
}

impl RecordKind {
    /// Returns the word for a record of this kind in messages.
    fn name(self) -> &'static str {
        match self {
            Self::Point => "record",
            Self::Segment => "segment",
            Self::Obstacle => "obstacle",
            Self::Site => "site",
            Self::Face => "face",
        }
    }

    /// Returns the advice that follows a message about an invalid record.
    fn advice(self) -> &'static str {
        match self {
            Self::Point => "; correct it, or skip invalid records (option `skip_invalid`)",
            Self::Segment | Self::Obstacle | Self::Site | Self::Face => "",
        }
    }

    /// Returns what is wrong with the name of a file, and the suffixes that identify a format.
    fn naming(self) -> &'static str {
        match self {
            Self::Point => {
                "neither the name nor the content tells the format; set the option `format`, or use one of the suffixes \
                 .csv .tsv .txt .xyz .f64 .node .poly .ply .obj .geojson .json .geojsonl .fgb (and .gz after any of \
                 these), .shp .gpkg .las .laz .parquet"
            }
            Self::Segment => {
                "neither the name nor the content tells how segments are written in it; use one of the suffixes \
                 .geojson .json .geojsonl .fgb .shp .csv .tsv .txt (and .gz after any of these), .gpkg .u32 .u64"
            }
            Self::Obstacle => {
                "polygons are read from GeoJSON, FlatGeobuf, Shapefile and GeoPackage, and neither the name nor the \
                 content tells that this is one; use one of the suffixes .geojson .json .geojsonl .fgb .shp (and .gz \
                 after any of these), .gpkg"
            }
            Self::Face => {
                "edges are read from .node files with an .ele file beside them, from .ply and .obj (and .gz after any \
                 of these)"
            }
            Self::Site => {
                "neither the name nor the content tells how sites are written in it; use one of the suffixes .geojson \
                 .json .geojsonl .fgb .shp .csv .tsv .txt .xyz (and .gz after any of these), .gpkg"
            }
        }
    }
}

/// The error of a failed read of an input.
///
/// ```
/// use delaunay_tiles::input::{InputError, RecordKind, SegmentSource};
///
/// let unknown = SegmentSource::open(&["walls.dwg".into()]).map(|_| ());
/// let kind = RecordKind::Segment;
/// assert!(matches!(unknown, Err(InputError::UnknownFormat { kind: found, .. }) if found == kind));
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// The file cannot be opened.
    #[error("{}: cannot be opened; does it exist, and may you read it?", shown::path(path))]
    Open {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        source: io::Error,
    },
    /// The operating system or the gzip decoder failed within the file.
    #[error(
        "{}: byte {offset}: reading failed; the file is damaged or cut short, or its medium failed",
        shown::path(path)
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// The number of bytes read before. In a gzip file it counts decompressed bytes.
        offset: u64,
        /// The error of the operating system or of the decoder.
        source: io::Error,
    },
    /// The file changed after it was opened. Everything that was read from it must be discarded.
    #[error(
        "{}: the file changed while it was read: {what}; nothing was made of it; read it while no program writes to it",
        shown::path(path)
    )]
    Changed {
        /// The file.
        path: PathBuf,
        /// What changed.
        what: String,
    },
    /// The reading was [stopped](crate::input::Reading::stop).
    #[error("the reading was stopped")]
    Stopped,
    /// Neither the file name nor an option determines the format of the records of kind `kind`.
    #[error("{}: {}", shown::path(path), kind.naming())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The kind of record that was expected.
        kind: RecordKind,
    },
    /// The library was built without the reader for this format.
    #[error(
        "{}: {what} cannot be read: built without the feature `{feature}`",
        shown::path(path)
    )]
    MissingFeature {
        /// The file.
        path: PathBuf,
        /// The format.
        what: String,
        /// The feature of the crate that enables the reader.
        feature: &'static str,
    },
    /// A record is invalid. With [`skip_invalid`](crate::input::InputOptions::skip_invalid),
    /// invalid points are counted instead of being reported.
    #[error("{}: {} {number} ({location}): {found}{}", shown::path(path), kind.name(), kind.advice())]
    Record {
        /// The file.
        path: PathBuf,
        /// The kind of the record.
        kind: RecordKind,
        /// The number of the record, counted over all inputs.
        number: u64,
        /// Where the record is in the file.
        location: Location,
        /// What was found.
        found: String,
    },
    /// The structure of the file is broken. The error concerns the file, not a single record, so
    /// that `skip_invalid` does not apply.
    #[error("{}: {}{problem}; {hint}", shown::path(path), location.prefix())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where the problem is in the file.
        location: Location,
        /// What was found.
        problem: String,
        /// What to do.
        hint: &'static str,
        /// The decoder's error, if a decoder reported one.
        source: Option<Box<dyn Error + Send + Sync>>,
    },
    /// An option has an invalid value.
    #[error("invalid {option} `{value}`: {expected}")]
    Option {
        /// The name of the option.
        option: &'static str,
        /// Its value.
        value: String,
        /// The values that are valid.
        expected: String,
    },
}

impl InputError {
    /// Returns the error of a file whose structure is broken, without a decoder's error as its
    /// source.
    pub(super) fn malformed(path: &Path, location: Location, problem: impl Into<String>, hint: &'static str) -> Self {
        Self::Malformed {
            path: path.to_owned(),
            location,
            problem: problem.into(),
            hint,
            source: None,
        }
    }

    /// Returns the error of a read that failed after `offset` bytes.
    pub(super) fn read(path: &Path, offset: u64, source: io::Error) -> Self {
        Self::Read {
            path: path.to_owned(),
            offset,
            source,
        }
    }
}
