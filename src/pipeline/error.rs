//! Errors of a build.

use std::io;
use std::path::{Path, PathBuf};

use crate::constraints::crossings::first::{Crossing, KEPT};
use crate::constraints::error::ConstraintError;
use crate::constraints::polygons::check::{InvertedPolygons, Overlapping};
use crate::constraints::without_z::VertexWithoutZ;
use crate::edit::EditError;
use crate::geometry::Point;
use crate::memory::{MemoryShortage, MemoryUse};
use crate::shown;
use crate::store::ReadError;

/// Error of a build. The output is then as it was before: absent, or the file that it was.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// A system call failed.
    #[error("{path}: cannot {what}", path = shown::path(path))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The action that failed.
        what: &'static str,
        /// The error of the system.
        source: io::Error,
    },
    /// The output exists and was not to be replaced.
    #[error("{path} exists already; choose another name, or force its replacement", path = shown::path(.0))]
    OutputExists(PathBuf),
    /// Another build writes to the same output.
    #[error("{path} is locked: another build is writing this output", path = shown::path(.0))]
    Locked(PathBuf),
    /// A file or folder that is not a build's has the work folder's name.
    #[error("{path} exists and is not a work folder of a build; move it away", path = shown::path(.0))]
    NotOurs(PathBuf),
    /// The work of an interrupted build of this output could be resumed, and was not to be
    /// discarded.
    #[error(
        "{path} holds the work of an interrupted build, {mib} MiB; resume that build, or force its replacement",
        path = shown::path(path), mib = bytes.div_ceil(1 << 20)
    )]
    WorkKept {
        /// The work folder.
        path: PathBuf,
        /// Bytes of its files, and of those that were spilled elsewhere.
        bytes: u64,
    },
    /// An option is out of range.
    #[error("{option} must be from {min} to {max}, not {found}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// Its smallest value.
        min: usize,
        /// Its largest value.
        max: usize,
        /// The value given.
        found: usize,
    },
    /// A coordinate is NaN, infinite, or outside the range of the exact predicates.
    #[error(
        "record {record} lies at ({}, {}): coordinates must be 0 or of a magnitude from {:e} to {:e}",
        point.x, point.y, Point::MIN_MAGNITUDE, Point::MAX_MAGNITUDE
    )]
    InvalidPoint {
        /// Number of the record.
        record: u64,
        /// Its position.
        point: Point,
    },
    /// A z is NaN or infinite.
    #[error("record {record} has z {z}, which is not finite")]
    InvalidZ {
        /// Number of the record.
        record: u64,
        /// Its z.
        z: f64,
    },
    /// A batch has a different number of records, or of z, than of points.
    #[error("a batch has {points} points, {z} z and {records} records")]
    Batch {
        /// Number of points.
        points: usize,
        /// Number of z.
        z: usize,
        /// Number of records.
        records: usize,
    },
    /// Two records are at the same position, and [`Duplicates::Error`](crate::Duplicates::Error) is
    /// set.
    #[error("records {} and {} both lie at ({}, {})", records[0], records[1], point.x, point.y)]
    Duplicate {
        /// The number of the first duplicate record, preceded by the smallest record number at its
        /// position.
        records: [u64; 2],
        /// Their position.
        point: Point,
    },
    /// There is too little memory.
    #[error(transparent)]
    Memory(#[from] MemoryShortage),
    /// Lines or polygons cannot become constraints.
    #[error(transparent)]
    Constraint(ConstraintError),
    /// Segments cross where there is no vertex.
    #[error(
        "{count} pairs of segments cross: {}; let them meet in a point, leave one of them out, or have them split where they \
         cross",
        listed(first, *count)
    )]
    Crossings {
        /// The first crossings, by the numbers of their lines and by position; at most ten.
        first: Vec<Crossing>,
        /// Number of pairs of segments that cross.
        count: u64,
    },
    /// There are ponds, and the points have no z.
    #[error(
        "the points have no z, so ponds have no shore to take theirs from; leave out the ponds, or give points with z"
    )]
    PondsWithoutZ,
    /// The shores of ponds have too many edges.
    #[error(
        "the shores of ponds have more than {} edges; simplify them",
        crate::terrain::Shores::MAX_EDGES
    )]
    TooManyShores,
    /// Some vertices have no z, and others have.
    #[error(
        "{count} vertices have no z, and others have; the first is {first}; give z to all, or allow that they get z = 0 \
         (--missing-z zero)"
    )]
    NoZ {
        /// The vertex without z that has the smallest record number.
        first: VertexWithoutZ,
        /// Number of vertices without z.
        count: u64,
    },
    /// A batch of sites has a different number of z, or of ids, than of sites.
    #[error("a batch has {sites} sites, z for {z} and ids for {ids}")]
    SiteBatch {
        /// Number of sites.
        sites: usize,
        /// Number of z.
        z: usize,
        /// Number of ids.
        ids: usize,
    },
    /// A site's position or z is not valid.
    #[error("site {site} at ({}, {}) with z {z} is no valid point", point.x, point.y)]
    InvalidSite {
        /// Number of the site, from 0.
        site: u64,
        /// Its position.
        point: Point,
        /// Its z.
        z: f64,
    },
    /// A hole point is not valid.
    #[error("hole point {seed} at ({}, {}) is no valid point", point.x, point.y)]
    InvalidSeed {
        /// Number of the hole point, from 0.
        seed: u64,
        /// Its position.
        point: Point,
    },
    /// A ring of a polygon does not close, or the polygon has the same depth on both sides of a
    /// ring.
    #[error("the rings of obstacle {obstacle} do not close; each must end where it begins")]
    OpenRing {
        /// Number of the polygon's record.
        obstacle: u64,
    },
    /// Rings of a polygon are nested wrongly, so that somewhere a hole is not inside the polygon.
    #[error(
        "obstacle {} is inside out at ({}, {}): one of its holes is outside the polygon or inside another hole, or one of \
         its rings has the opposite direction there; {} polygons are inside out; correct the polygon, or split crossing \
         lines, which covers such parts too",
        .0.first.obstacle, .0.first.point.x, .0.first.point.y, .0.polygons
    )]
    Inverted(InvertedPolygons),
    /// An obstacle covers a place more than once, and its rings cross where something else has a
    /// vertex. If they do not cross, the obstacle is normalised instead.
    #[error(
        "obstacle {} covers ({}, {}) more than once, and its rings cross each other; correct it, or split crossing lines, \
         so that it covers each place once",
        .0.obstacle, .0.point.x, .0.point.y
    )]
    Overlapping(Overlapping),
    /// There is not enough room on the disk.
    #[error(
        "{path}: the build needs about {needed} MiB of disk, and {free} MiB are free there",
        path = shown::path(path), needed = needed.div_ceil(1 << 20), free = free >> 20
    )]
    Disk {
        /// The folder.
        path: PathBuf,
        /// Bytes needed, estimated.
        needed: u64,
        /// Bytes free.
        free: u64,
    },
    /// The work of an interrupted build belongs to other inputs or options.
    #[error(
        "{path} holds the work of a build with other inputs or options, and cannot be resumed with these ({what}); repeat \
         that build, or start again without resuming and force its replacement",
        path = shown::path(path)
    )]
    OtherBuild {
        /// The work folder.
        path: PathBuf,
        /// The first setting of the interrupted build that differs.
        what: String,
    },
    /// Tiles cannot be compressed, because the library was built without the feature `compression`.
    #[error("this program cannot compress tiles: it was built without the feature `compression`")]
    NoCompression,
    /// The build cannot be resumed, because its inputs cannot be read again.
    #[error("only a build whose inputs can be read again can be resumed; standard input cannot")]
    NotResumable,
    /// The build of a file left no blocks to tasks, or what it left is damaged.
    #[error("{path}: there are no tasks; plan them first, as `tiletool build --tasks` does", path = shown::path(.0))]
    NoTasks(PathBuf),
    /// A build has no such block.
    #[error("there is no block {block}; the build has {blocks}, numbered from 0")]
    NoBlock {
        /// The number of the block.
        block: u32,
        /// Number of blocks.
        blocks: u32,
    },
    /// A build has no such input.
    #[error("there is no input {input}; the build has {inputs}, numbered from 0")]
    NoInput {
        /// The number of the input.
        input: u32,
        /// Number of inputs.
        inputs: u32,
    },
    /// A point of an input has a record number that the plan does not give to it.
    #[error("input {input} has a record {record}, which it did not announce; plan the inputs again")]
    RecordOfInput {
        /// The number of the input.
        input: u32,
        /// The record number.
        record: u64,
    },
    /// The points of inputs were not distributed yet.
    #[error("{left} of the inputs were not distributed yet, {first} is the first; do their tasks")]
    InputsLeft {
        /// The number of the first of them.
        first: u32,
        /// Number of these inputs.
        left: u64,
    },
    /// Segments lie between points of records, and tasks distribute the points.
    #[error(
        "segments between records need their points; build without tasks for inputs, or give the segments by positions"
    )]
    InputsForRecords,
    /// A task may take less memory than the plan has for it.
    #[error(
        "a task of this build needs {} MiB of memory, and may take {}; do it where there is more, or plan the build with less",
        needed.div_ceil(1 << 20), given >> 20
    )]
    TaskMemory {
        /// Bytes needed.
        needed: u64,
        /// Bytes that it may take.
        given: u64,
    },
    /// The blocks of the build that is resumed were left to tasks in an object store, and the options name
    /// none.
    #[error("{folder}: the blocks of this build are in an object store; resume it with that store", folder = shown::path(.0))]
    NoStore(PathBuf),
    /// The output has another file name than the manifest in the object store.
    #[error("{output}: in the store, the file has the name {name}; give the output the same name", output = shown::path(.output))]
    StoreName {
        /// The output.
        output: PathBuf,
        /// The name of the manifest.
        name: String,
    },
    /// A method was called after points were pushed that must be called before.
    #[error(
        "{call} was called after points were pushed; lines, sites, hole points and expectations come before points"
    )]
    Order {
        /// Name of the method.
        call: &'static str,
    },
    /// Points were pushed into a resumed build that has all its points already.
    #[error("the build that is resumed has all its points already")]
    PointsComplete,
    /// There would be more tiles than a directory holds.
    #[error("there would be more than {max} tiles, the most that a file holds; use larger tiles")]
    TooManyTiles {
        /// Most tiles of a directory.
        max: u32,
    },
    /// The build was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// A computing thread panicked, or another defect of this library was found.
    #[error("internal error: {0}")]
    Internal(String),
}

/// Returns the text of the first crossings, and whether there are more.
fn listed(first: &[Crossing], count: u64) -> String {
    let mut text = first.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    // Duplicate segments cross repeatedly, and their crossing is listed once.
    if first.len() == KEPT && count > KEPT as u64 {
        text += "; and more";
    }
    text
}

impl BuildError {
    /// Returns whether the input is at fault, in a way that is found after all of it has arrived:
    /// the same build would end in the same error.
    pub(crate) fn is_of_input(&self) -> bool {
        matches!(
            self,
            Self::Duplicate { .. }
                | Self::TooManyTiles { .. }
                | Self::Crossings { .. }
                | Self::NoZ { .. }
                | Self::OpenRing { .. }
                | Self::Inverted(_)
                | Self::Overlapping(_)
        )
    }

    pub(crate) fn io(path: &Path, what: &'static str, source: io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            what,
            source,
        }
    }
}

impl From<ConstraintError> for BuildError {
    fn from(error: ConstraintError) -> Self {
        match error {
            ConstraintError::Io { path, what, source } => Self::Io {
                path,
                what,
                source: io::Error::new(source.kind(), source),
            },
            ConstraintError::Memory(shortage) => Self::Memory(shortage),
            other => Self::Constraint(other),
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
            // The file that was just written cannot be read back.
            EditError::Read(ReadError::Memory { needed, allowed, .. }) => Self::Memory(MemoryShortage {
                of: MemoryUse::Edit,
                needed,
                budget: allowed,
            }),
            EditError::Read(error) => {
                let (file, kind) = match &error {
                    ReadError::Io { file, source, .. } => (file, source.kind()),
                    ReadError::Invalid { file, .. }
                    | ReadError::Tile { file, .. }
                    | ReadError::NoSuchTile { file, .. } => (file, io::ErrorKind::InvalidData),
                    ReadError::Memory { .. } | ReadError::Thread(_) | ReadError::Cancelled => {
                        return Self::Internal(format!("deferred segments could not be read back: {error}"));
                    }
                };
                let path = PathBuf::from(&**file);
                Self::io(&path, "read the tiles in", io::Error::new(kind, error))
            }
            EditError::OpenRing { line } => Self::OpenRing { obstacle: line },
            EditError::Memory(shortage) => Self::Memory(MemoryShortage {
                of: MemoryUse::Regions,
                ..shortage
            }),
            EditError::Cancelled => Self::Cancelled,
            other => Self::Internal(format!("segments could not be inserted at the end: {other}")),
        }
    }
}
