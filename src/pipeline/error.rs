//! Why a build failed.

use std::io;
use std::path::{Path, PathBuf};

use crate::constraints::crossings::first::{Crossing, KEPT};
use crate::constraints::error::ConstraintError;
use crate::constraints::polygons::check::InvertedPolygons;
use crate::constraints::without_z::VertexWithoutZ;
use crate::edit::EditError;
use crate::geometry::Point;
use crate::memory::{MemoryShortage, MemoryUse};
use crate::shown;
use crate::store::ReadError;

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
    /// There is too little memory.
    #[error(transparent)]
    Memory(#[from] MemoryShortage),
    /// Lines or polygons cannot become constraints.
    #[error(transparent)]
    Constraint(ConstraintError),
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
    /// A method was called after points had come; it must be called before.
    #[error(
        "{call} was called after points were pushed; lines, sites, hole points and expectations come before points"
    )]
    Order {
        /// The name of the method.
        call: &'static str,
    },
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
            EditError::Memory(shortage) => Self::Memory(MemoryShortage {
                of: MemoryUse::Regions,
                ..shortage
            }),
            EditError::Cancelled => Self::Cancelled,
            other => Self::Internal(format!("segments could not be inserted at the end: {other}")),
        }
    }
}
