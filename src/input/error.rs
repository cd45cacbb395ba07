//! What can go wrong with an input, with the evidence: file, record, line or offset, what was found, what to do.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{fmt, io};

use crate::shown;

/// Where in a file something was found, in [`InputError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of text, from 1.
    Line(u64),
    /// A byte offset from 0; of the decompressed bytes if the file is gzip.
    Byte(u64),
    /// A point of a LAS file, from 0 in that file.
    Point(u64),
}

impl Place {
    /// The place before what is said about it.
    fn prefix(self) -> String {
        match self {
            Self::File => String::new(),
            place => format!("{place}: "),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => f.write_str("file"),
            Self::Line(n) => write!(f, "line {n}"),
            Self::Byte(n) => write!(f, "byte {n}"),
            Self::Point(n) => write!(f, "point {n}"),
        }
    }
}

/// What a record of a file is, in [`InputError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RecordKind {
    /// A point, or what should be one.
    Point,
    /// A segment of a line.
    Segment,
    /// An obstacle: a feature with polygons.
    Obstacle,
    /// A site.
    Site,
}

impl RecordKind {
    /// What a record is called in messages.
    fn name(self) -> &'static str {
        match self {
            Self::Point => "record",
            Self::Segment => "segment",
            Self::Obstacle => "obstacle",
            Self::Site => "site",
        }
    }

    /// What to do about a record that is wrong.
    fn advice(self) -> &'static str {
        match self {
            Self::Point => "; correct it, or pass over such records with --skip-invalid",
            Self::Segment | Self::Obstacle | Self::Site => "",
        }
    }

    /// What is wrong with the name of a file, and which names tell a format.
    fn naming(self) -> &'static str {
        match self {
            Self::Point => {
                "the name does not tell the format; give it with --format, or use one of the suffixes .csv .tsv .txt \
                 .xyz .f64 .node .poly .geojson .json .geojsonl .las .laz (and .gz after any but the last two)"
            }
            Self::Segment => {
                "the name does not tell how segments are written in it; use one of the suffixes .geojson .json \
                 .geojsonl .csv .tsv .txt (and .gz after any of these), .u32 .u64"
            }
            Self::Obstacle => {
                "obstacles are read from GeoJSON, and the name does not tell that this is some; use one of the \
                 suffixes .geojson .json .geojsonl (and .gz after any of these)"
            }
            Self::Site => {
                "the name does not tell how sites are written in it; use one of the suffixes .geojson .json .geojsonl \
                 .csv .tsv .txt .xyz (and .gz after any of these)"
            }
        }
    }
}

/// Why an input could not be read.
///
/// ```
/// use delaunay_tiles::input::{InputError, RecordKind, SegmentSource};
///
/// let unknown = SegmentSource::open(&["walls.shp".into()]).map(|_| ());
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
        /// Why.
        source: io::Error,
    },
    /// The operating system, or the gzip decoder, failed within the file.
    #[error(
        "{}: byte {offset}: reading failed; the file is damaged or cut short, or its medium failed",
        shown::path(path)
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// The bytes read before (decompressed ones if the file is gzip).
        offset: u64,
        /// Why.
        source: io::Error,
    },
    /// A file is not what it was when it was opened: what was read of it is of no use.
    #[error(
        "{}: the file changed while it was read: {what}; nothing was made of it; read it when nobody writes to it",
        shown::path(path)
    )]
    Changed {
        /// The file.
        path: PathBuf,
        /// In which way.
        what: String,
    },
    /// The reading was [stopped](crate::input::Reading::stop).
    #[error("the reading was stopped")]
    Stopped,
    /// Neither the name nor an option tells the format in which a file has records of this kind.
    #[error("{}: {}", shown::path(path), kind.naming())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The records that it should have.
        kind: RecordKind,
    },
    /// The library was built without the reader.
    #[error(
        "{}: {what} cannot be read: built without the feature `{feature}`",
        shown::path(path)
    )]
    MissingFeature {
        /// The file.
        path: PathBuf,
        /// The format.
        what: String,
        /// The feature of the crate that has its reader.
        feature: &'static str,
    },
    /// A record is not what it should be. Of points it is counted instead with
    /// [`skip_invalid`](crate::input::InputOptions::skip_invalid).
    #[error("{}: {} {number} ({place}): {found}{}", shown::path(path), kind.name(), kind.advice())]
    Record {
        /// The file.
        path: PathBuf,
        /// What the record should be.
        kind: RecordKind,
        /// The number of the record, over all inputs.
        number: u64,
        /// Where in the file.
        place: Place,
        /// What was found.
        found: String,
    },
    /// The file's structure is broken: no record of its own is to blame, and none can be passed over.
    #[error("{}: {}{problem}; {hint}", shown::path(path), place.prefix())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where in the file.
        place: Place,
        /// What was found.
        problem: String,
        /// What to do.
        hint: &'static str,
        /// The decoder's error, if it comes from one.
        source: Option<Box<dyn Error + Send + Sync>>,
    },
    /// An option has a value that is not possible.
    #[error("`{value}` is not possible for {option}; {expected}")]
    Option {
        /// The option.
        option: &'static str,
        /// Its value.
        value: String,
        /// What is possible.
        expected: String,
    },
}

impl InputError {
    /// The error of a file whose structure is broken, with no decoder's error behind it.
    pub(super) fn malformed(path: &Path, place: Place, problem: impl Into<String>, hint: &'static str) -> Self {
        Self::Malformed {
            path: path.to_owned(),
            place,
            problem: problem.into(),
            hint,
            source: None,
        }
    }

    /// The error of a read that failed behind `offset` bytes.
    pub(super) fn read(path: &Path, offset: u64, source: io::Error) -> Self {
        Self::Read {
            path: path.to_owned(),
            offset,
            source,
        }
    }
}
