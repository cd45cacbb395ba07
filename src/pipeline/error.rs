//! Why a build failed.

use std::io;
use std::path::{Path, PathBuf};

use crate::constraints::crossings::first::{Crossing, KEPT};
use crate::constraints::crossings::split::SplitError;
use crate::constraints::polygons::check::InvertedPolygons;
use crate::constraints::without_z::VertexWithoutZ;
use crate::edit::error::EditError;
use crate::geometry::Point;
use crate::shown;
use crate::store::{EdgeSource, ReadError};

/// Why a build failed. Nothing stands under the output's name then, or what stood there before.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The system refused.
    #[error("{path}: cannot {what}", path = shown::path(path))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was to be done.
        what: &'static str,
        /// What the system says.
        source: io::Error,
    },
    /// The output exists, and was not to be replaced.
    #[error("{path} exists already; choose another name, or force its replacement", path = shown::path(.0))]
    OutputExists(PathBuf),
    /// Another build writes to the same output.
    #[error("{path} is locked: another build is writing this output", path = shown::path(.0))]
    Locked(PathBuf),
    /// The work folder's name is taken by something else.
    #[error("{path} exists and is no work folder of a build; move it away", path = shown::path(.0))]
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
    /// The budget is too small for a single tile.
    #[error(
        "{budget} MiB of memory are allowed, and the work on one tile and its block takes {needed} MiB; allow more, or use \
         smaller tiles",
        needed = needed.div_ceil(1 << 20), budget = budget >> 20
    )]
    Memory {
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        budget: u64,
    },
    /// Segments take too much of the memory.
    #[error(
        "{budget} MiB of memory are allowed, and with so many segments {needed} MiB are needed, since all are kept in memory; \
         allow more",
        needed = needed.div_ceil(1 << 20), budget = budget >> 20
    )]
    Segments {
        /// Bytes needed at least.
        needed: u64,
        /// Bytes allowed.
        budget: u64,
    },
    /// Seams do not shrink as they should, so the root would not fit: points on a curve, say.
    #[error(
        "these points have so many neighbours across cells that merging takes about {needed} MiB of memory, and {budget} MiB \
         are allowed; allow that much",
        needed = needed.div_ceil(1 << 20), budget = budget >> 20
    )]
    Seams {
        /// Bytes needed, about.
        needed: u64,
        /// Bytes allowed.
        budget: u64,
    },
    /// Segments that go through many tiles hold more triangles than there is memory for.
    #[error(
        "segments cross so many tiles that the triangles on their way take about {needed} MiB of memory, and {budget} MiB are \
         allowed; allow that much",
        needed = needed.div_ceil(1 << 20), budget = budget >> 20
    )]
    Held {
        /// Bytes needed, about.
        needed: u64,
        /// Bytes allowed.
        budget: u64,
    },
    /// So many lines run along each other that it takes too much memory to note them with each edge.
    #[error(
        "so many lines run along each other at ({}, {}) that edges take {needed} MiB of memory or more to know all of theirs, and \
         {budget} MiB are allowed; leave out those that are there more than once, or allow more",
        point.x, point.y, needed = needed.div_ceil(1 << 20), budget = budget >> 20
    )]
    Overlaps {
        /// A vertex that they run through.
        point: Point,
        /// Bytes needed at least.
        needed: u64,
        /// Bytes allowed.
        budget: u64,
    },
    /// Segments cross where no vertex lies.
    #[error(
        "{count} pairs of segments cross: {}; let them meet in a point, leave one of them out, or have them split where they \
         cross",
        listed(first, *count)
    )]
    Crossings {
        /// The first of them, by the numbers of their lines and by place; at most ten.
        first: Vec<Crossing>,
        /// How many there are.
        count: u64,
    },
    /// Vertices have no z, and others have.
    #[error(
        "{count} vertices have no z, and others have; the first is {first}; give z to all, or allow that they get z = 0 \
         (--missing-z zero)"
    )]
    NoZ {
        /// The one of the smallest record number.
        first: VertexWithoutZ,
        /// How many there are.
        count: u64,
    },
    /// Sites came with another number of z, or of ids.
    #[error("a batch has {sites} sites, z for {z} and ids for {ids}")]
    SiteBatch {
        /// How many there are.
        sites: usize,
        /// How many have z.
        z: usize,
        /// How many have an id.
        ids: usize,
    },
    /// A site is not a point.
    #[error("site {site} at ({}, {}) with z {z} is no valid point", point.x, point.y)]
    InvalidSite {
        /// The number of the site, from 0.
        site: u64,
        /// Where it is.
        point: Point,
        /// Its z.
        z: f64,
    },
    /// A hole point is not a point.
    #[error("hole point {seed} at ({}, {}) is no valid point", point.x, point.y)]
    InvalidSeed {
        /// The number of the hole point, from 0.
        seed: u64,
        /// Where it is.
        point: Point,
    },
    /// Sites and hole points are kept in memory.
    #[error(
        "sites and hole points take a quarter of {needed} MiB of memory, and {budget} MiB are allowed in all; allow that much",
        needed = needed.div_ceil(1 << 20), budget = budget >> 20
    )]
    Sites {
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        budget: u64,
    },
    /// Segments that cross cannot be split.
    #[error(transparent)]
    Split(#[from] SplitError),
    /// Splitting segments where they cross is done in memory.
    #[error(
        "splitting segments where they cross takes about {needed} MiB of memory, and {budget} MiB are allowed; allow that much",
        needed = needed.div_ceil(1 << 20), budget = budget >> 20
    )]
    SplitMemory {
        /// Bytes needed, about.
        needed: u64,
        /// Bytes allowed.
        budget: u64,
    },
    /// A ring of a polygon does not close, or is not what it should be: its two sides are the same.
    #[error("the rings of obstacle {obstacle} do not close; each must end where it begins")]
    OpenRing {
        /// The number of the polygon's record.
        obstacle: u64,
    },
    /// Rings of a polygon are nested wrongly, so that somewhere a hole is taken out of nothing.
    #[error(
        "obstacle {} is inside out at ({}, {}): a hole of it lies outside of it or in another of its holes, or a ring of it \
         runs round there the other way; {} polygons are inside out; put it right, or have lines split where they cross, \
         which covers such parts too",
        .0.first.obstacle, .0.first.point.x, .0.first.point.y, .0.polygons
    )]
    Inverted(InvertedPolygons),
    /// A polygon is too large to be checked.
    #[error(
        "so much of obstacle {obstacle} lies side by side that checking it takes about {needed} MiB of memory, and {budget} MiB \
         are allowed for that; allow {factor} times as much in all",
        needed = needed.div_ceil(1 << 20), budget = budget >> 20, factor = needed.div_ceil((*budget).max(1))
    )]
    PolygonMemory {
        /// The number of the polygon's record.
        obstacle: u64,
        /// Bytes needed, at most.
        needed: u64,
        /// Bytes allowed.
        budget: u64,
    },
    /// A batch does not tell of all segments which polygon they are of.
    #[error("a batch has {segments} segments by their ends, and {polygons} numbers of polygons")]
    PolygonNumbers {
        /// Segments by their ends.
        segments: usize,
        /// Numbers of polygons.
        polygons: usize,
    },
    /// There are more late triangles than can be numbered, or telling regions apart takes too much memory.
    #[error(
        "telling the regions between segments apart takes about {needed} MiB of memory, and {budget} MiB are allowed; allow \
         that much",
        needed = needed.div_ceil(1 << 20), budget = budget >> 20
    )]
    Regions {
        /// Bytes needed, about.
        needed: u64,
        /// Bytes allowed.
        budget: u64,
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
    /// There is not enough room on the disk.
    #[error(
        "{path}: the build needs about {needed} MiB of disk, and {free} MiB are free there",
        path = shown::path(path), needed = needed.div_ceil(1 << 20), free = free >> 20
    )]
    Disk {
        /// The folder.
        path: PathBuf,
        /// Bytes needed, about.
        needed: u64,
        /// Bytes free.
        free: u64,
    },
    /// What an interrupted build left belongs to other inputs or options.
    #[error(
        "{path} holds the work of a build with other inputs or options, and cannot be resumed with these ({what}); build \
         without resuming to start again",
        path = shown::path(path)
    )]
    OtherBuild {
        /// The work folder.
        path: PathBuf,
        /// What differs.
        what: String,
    },
    /// Inputs that cannot be read again cannot be resumed.
    #[error("only a build whose inputs can be read again can be resumed; standard input cannot")]
    NotResumable,
    /// Points were pushed into a build that goes on and had them all.
    #[error("the build that is resumed has all its points already")]
    PointsComplete,
    /// There would be more tiles than a directory holds.
    #[error("there would be more than {max} tiles, the most that a file holds; use larger tiles")]
    TooManyTiles {
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

/// The first crossings, and whether there are more.
fn listed(first: &[Crossing], count: u64) -> String {
    let mut text = first.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    // Segments that are there twice cross twice, and are told of once.
    if first.len() == KEPT && count > KEPT as u64 {
        text += "; and more";
    }
    text
}

impl BuildError {
    pub(crate) fn io(path: &Path, what: &'static str, source: io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            what,
            source,
        }
    }
}

impl From<EditError> for BuildError {
    fn from(error: EditError) -> Self {
        match error {
            EditError::Io { file, what, source } => {
                let source = io::Error::new(source.kind(), source);
                Self::io(&file, what, source)
            }
            // What was just written cannot be read back.
            EditError::Read(error) => {
                let (file, kind) = match &error {
                    ReadError::Io { file, source, .. } => (file, source.kind()),
                    ReadError::Invalid { file, .. }
                    | ReadError::Tile { file, .. }
                    | ReadError::NoSuchTile { file, .. } => (file, io::ErrorKind::InvalidData),
                    ReadError::Memory { .. } | ReadError::Thread(_) | ReadError::Cancelled => {
                        return Self::Internal(format!("what was put off could not be read back: {error}"));
                    }
                };
                let path = PathBuf::from(&**file);
                Self::io(&path, "read the tiles in", io::Error::new(kind, error))
            }
            EditError::OpenRing { line } => Self::OpenRing { obstacle: line },
            EditError::Memory { needed, allowed } => Self::Regions {
                needed,
                budget: allowed,
            },
            EditError::Cancelled => Self::Cancelled,
            other => Self::Internal(format!("segments could not be inserted at the end: {other}")),
        }
    }
}
