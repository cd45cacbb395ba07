//! Why a build failed.

use std::io;
use std::path::{Path, PathBuf};

use crate::geometry::Point;

/// Why a build failed. Nothing stands under the output's name then, or what stood there before.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The system refused.
    #[error("{path}: cannot {what}", path = path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was to be done.
        what: &'static str,
        /// What the system says.
        source: io::Error,
    },
    /// The output exists, and was not to be replaced.
    #[error("{path} exists already; choose another name, or force its replacement", path = .0.display())]
    OutputExists(PathBuf),
    /// Another build writes to the same output.
    #[error("{path} is locked: another build is writing this output", path = .0.display())]
    Locked(PathBuf),
    /// The work folder's name is taken by something else.
    #[error("{path} exists and is no work folder of a build; move it away", path = .0.display())]
    NotOurs(PathBuf),
    /// An option is out of range.
    #[error("{option} must be from {min} to {max}, not {found}")]
    Option {
        /// The option.
        option: &'static str,
        /// Its smallest value.
        min: usize,
        /// Its largest value.
        max: usize,
        /// What it was.
        found: usize,
    },
    /// A coordinate is NaN, infinite, or beyond what the exact predicates can take.
    #[error(
        "record {record} lies at ({}, {}): coordinates must be 0 or of a magnitude from {:e} to {:e}",
        point.x, point.y, Point::MIN_MAGNITUDE, Point::MAX_MAGNITUDE
    )]
    InvalidPoint {
        /// The record.
        record: u64,
        /// Where it is.
        point: Point,
    },
    /// A z is NaN or infinite.
    #[error("record {record} has z {z}, which is not finite")]
    InvalidZ {
        /// The record.
        record: u64,
        /// Its z.
        z: f64,
    },
    /// A batch has another number of records, or of z, than of points.
    #[error("a batch has {points} points, {z} z and {records} records")]
    Batch {
        /// Its points.
        points: usize,
        /// Its z.
        z: usize,
        /// Its records.
        records: usize,
    },
    /// Two records lie at one place, where that was to be an error.
    #[error("records {} and {} both lie at ({}, {})", records[0], records[1], point.x, point.y)]
    Duplicate {
        /// The first record that lies on an earlier one, after the first of those.
        records: [u64; 2],
        /// Where they are.
        point: Point,
    },
    /// The points do not fit in the memory that the build may use.
    #[error(
        "the first {points} points and the work on them need {needed} MiB of memory, and {budget} MiB are allowed; allow \
         more, or use fewer threads or smaller tiles",
        needed = needed.div_ceil(1 << 20), budget = budget >> 20
    )]
    Memory {
        /// Points so far.
        points: u64,
        /// Bytes they need.
        needed: u64,
        /// Bytes allowed.
        budget: u64,
    },
    /// There are more points than a build numbers.
    #[error("there are more than {0} points, the most that a build takes")]
    TooManyPoints(usize),
    /// There would be more tiles than a directory holds.
    #[error("there would be {tiles} tiles, and a file holds {max}; use larger tiles")]
    TooManyTiles {
        /// Tiles there would be.
        tiles: usize,
        /// Tiles that a directory holds.
        max: u32,
    },
    /// The build was asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// A computing thread panicked: a defect of this library.
    #[error("internal error: {0}")]
    Internal(String),
}

impl BuildError {
    pub(super) fn io(path: &Path, what: &'static str, source: io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            what,
            source,
        }
    }
}
