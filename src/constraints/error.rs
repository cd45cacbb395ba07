//! Why lines and polygons cannot become constraints.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::geometry::Point;
use crate::memory::MemoryShortage;
use crate::shown;
use crate::store::EdgeSource;

/// Why lines and polygons cannot become constraints of a build or an edit.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConstraintError {
    /// The system refused.
    #[error("{path}: cannot {what}", path = shown::path(path))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was to be done.
        what: &'static str,
        /// What the system says.
        source: Arc<io::Error>,
    },
    /// There is too little memory.
    #[error(transparent)]
    Memory(#[from] MemoryShortage),
    /// Segments that cross cannot be split.
    #[error(transparent)]
    Split(#[from] SplitError),
    /// A batch does not tell of all segments which polygon they are of.
    #[error("a batch has {segments} segments by their ends, and {polygons} numbers of polygons")]
    PolygonNumbers {
        /// Segments by their ends.
        segments: usize,
        /// Numbers of polygons.
        polygons: usize,
    },
    /// The end of a segment is not a point.
    #[error("an end of segment {segment} at ({}, {}) is no valid point", point.x, point.y)]
    InvalidEnd {
        /// The number of the segment, from 0.
        segment: u64,
        /// Its end.
        point: Point,
    },
    /// The z of a segment's end is infinite.
    #[error("an end of segment {segment} has z {z}, which is not finite")]
    InvalidEndZ {
        /// The number of the segment, from 0.
        segment: u64,
        /// Its z.
        z: f64,
    },
    /// A line's number is beyond what a file holds.
    #[error("segment {segment} belongs to line {line}, and lines are numbered up to {max}", max = EdgeSource::MAX_NUMBER)]
    LineNumber {
        /// The number of the segment, from 0.
        segment: u64,
        /// The number of its line.
        line: u64,
    },
    /// Segments came with another number of z, or of lines.
    #[error("a batch has {segments} segments, pairs of z for {z} and lines for {lines}")]
    SegmentBatch {
        /// How many there are.
        segments: usize,
        /// How many have z.
        z: usize,
        /// How many have a line.
        lines: usize,
    },
    /// A segment was to join a record that no point came of.
    #[error("segment {segment} joins record {record}, and there is no point with that number")]
    NoSuchRecord {
        /// The number of the segment among those by records, from 0.
        segment: u64,
        /// The number.
        record: u64,
    },
}

impl ConstraintError {
    pub(crate) fn io(path: &Path, what: &'static str, source: io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            what,
            source: Arc::new(source),
        }
    }
}

/// Why segments cannot be split.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SplitError {
    /// After the last round some still cross.
    #[error(
        "{crossings} pairs of segments still cross after they were split {rounds} times, one at ({}, {}): lines lie too \
         close to each other there to be told apart by their coordinates; leave some of them out, or move the coordinates \
         closer to zero, where they are finer",
        point.x, point.y
    )]
    StillCrossing {
        /// After how many rounds.
        rounds: usize,
        /// How many pairs.
        crossings: u64,
        /// The lexicographically smallest crossing point.
        point: Point,
    },
    /// There are more crossings than allowed.
    #[error("more than {limit} pairs of segments cross; look for the wrong ones, or allow more memory")]
    TooMany {
        /// How many pairs may cross in one round.
        limit: usize,
    },
}
