//! Errors of lines and polygons that cannot become constraints.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::geometry::Point;
use crate::memory::MemoryShortage;
use crate::shown;
use crate::store::EdgeSource;

/// The reason why lines and polygons cannot become constraints of a build or an edit.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConstraintError {
    /// An operation on a file or folder failed.
    #[error("{path}: cannot {what}", path = shown::path(path))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The operation that failed.
        what: &'static str,
        /// The system's error.
        source: Arc<io::Error>,
    },
    /// There is not enough memory.
    #[error(transparent)]
    Memory(#[from] MemoryShortage),
    /// Segments that cross cannot be split.
    #[error(transparent)]
    Split(#[from] SplitError),
    /// A batch has polygon numbers for some of its segments only.
    #[error(
        "a batch has {segments} segments by their ends, but {polygons} polygon numbers; give one for each segment, or none"
    )]
    PolygonNumbers {
        /// Number of segments that are given by their ends.
        segments: usize,
        /// Number of polygon numbers.
        polygons: usize,
    },
    /// An end of a segment is not a valid point.
    #[error("an end of segment {segment} at ({}, {}) is not a valid point", point.x, point.y)]
    InvalidEnd {
        /// The number of the segment, from 0.
        segment: u64,
        /// The end.
        point: Point,
    },
    /// The z of a segment's end is infinite.
    #[error("an end of segment {segment} has z {z}, which is not finite")]
    InvalidEndZ {
        /// The number of the segment, from 0.
        segment: u64,
        /// The z.
        z: f64,
    },
    /// The number of a line is larger than a file can store.
    #[error("segment {segment} belongs to line {line}, but the largest line number is {max}", max = EdgeSource::MAX_NUMBER)]
    LineNumber {
        /// The number of the segment, from 0.
        segment: u64,
        /// The number of its line.
        line: u64,
    },
    /// A batch has another number of z or of lines than of segments.
    #[error(
        "a batch has {segments} segments, but {z} pairs of z and {lines} line numbers; give a line number for each segment, and a pair of z for each or for none"
    )]
    SegmentBatch {
        /// Number of segments.
        segments: usize,
        /// Number of segments with z.
        z: usize,
        /// Number of segments with a line.
        lines: usize,
    },
    /// A segment refers to a record for which there is no point.
    #[error("segment {segment} refers to record {record}, but no point has that record number")]
    NoSuchRecord {
        /// The number of the segment among those given by record numbers, from 0.
        segment: u64,
        /// The record number.
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

/// The reason why segments cannot be split.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SplitError {
    /// Some segments still cross after the last round.
    #[error(
        "{crossings} pairs of segments still cross after they were split {rounds} times, one at ({}, {}): lines are too \
         close to each other there to be distinguished by their coordinates; leave some of them out, or move the \
         coordinates closer to zero, where they are finer",
        point.x, point.y
    )]
    StillCrossing {
        /// Number of rounds.
        rounds: usize,
        /// Number of pairs that still cross.
        crossings: u64,
        /// The lexicographically smallest crossing point.
        point: Point,
    },
    /// There are more crossings than allowed.
    #[error("more than {limit} pairs of segments cross; check the input for wrong segments, or allow more memory")]
    TooMany {
        /// Largest number of pairs that may cross in one round.
        limit: usize,
    },
}
