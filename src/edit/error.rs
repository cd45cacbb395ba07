//! Errors of an edit.

use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::constraints::error::ConstraintError;
use crate::constraints::polygons::check::{InvertedPolygons, Overlapping};
use crate::geometry::Point;
use crate::memory::MemoryShortage;
use crate::shown;
use crate::store::{EdgeSource, Failure, LogError, ReadError};

/// The reason why a file could not be edited. The file is unchanged.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// An operation on the file failed.
    #[error("{file}: cannot {what} it", file = shown::path(file))]
    Io {
        /// The file.
        file: PathBuf,
        /// The operation that failed.
        what: &'static str,
        /// The system's error.
        source: Arc<io::Error>,
    },
    /// The log of the file cannot be used.
    #[error(transparent)]
    Log(#[from] LogError),
    /// Another editor has the file locked.
    #[error("{file}: another editor has it locked; try again later", file = shown::path(.0))]
    Busy(PathBuf),
    /// The file is in parts.
    #[error("{file}: a file in parts is not edited; write it into one file first, as by `tiletool compact`", file = shown::path(.0))]
    InParts(PathBuf),
    /// With the new vertices, the file would have more tiles than are possible.
    #[error(
        "with the new vertices, the file would have more than {max} tiles, which is the most; build it with larger tiles"
    )]
    TooManyTiles {
        /// Largest number of tiles of a file.
        max: u32,
    },
    /// Ends of lines have no z, but the file's vertices have z.
    #[error(
        "an end at ({}, {}) has no z, and no vertex is there; {count} ends would get z = 0, although the file has z; give \
         z to all ends, take it from the surface (--missing-z drape), or allow z = 0 (--missing-z zero)",
        point.x, point.y
    )]
    NoZ {
        /// The number of the line of the first such end, in the order of the lines.
        line: u64,
        /// The first such end.
        point: Point,
        /// Number of vertices that would have no z.
        count: u64,
    },
    /// A point is not valid.
    #[error(
        "a point lies at ({}, {}): coordinates must be 0 or of a magnitude from {:e} to {:e}",
        .0.x, .0.y, Point::MIN_MAGNITUDE, Point::MAX_MAGNITUDE
    )]
    InvalidPoint(Point),
    /// A z is infinite.
    #[error("the point at ({}, {}) has z {z}, which is not finite", point.x, point.y)]
    InvalidZ {
        /// The point.
        point: Point,
        /// Its z.
        z: f64,
    },
    /// There is no point at a position.
    #[error("there is no point at ({}, {}); {count} such positions are given (leave them out with --skip-missing)", point.x, point.y)]
    NoPoint {
        /// The first such position.
        point: Point,
        /// Number of positions without a point.
        count: u64,
    },
    /// There is no site at a position.
    #[error("there is no site at ({}, {}); {count} such positions are given (leave them out with --skip-missing)", point.x, point.y)]
    NoSite {
        /// The first such position.
        point: Point,
        /// Number of positions without a site.
        count: u64,
    },
    /// The arrays of a batch of sites differ in length.
    #[error("a batch has {sites} sites, {z} elevations and {ids} ids")]
    SiteBatch {
        /// Number of sites.
        sites: usize,
        /// Number of elevations.
        z: usize,
        /// Number of ids.
        ids: usize,
    },
    /// No line has a segment that is to be removed.
    #[error(
        "no line of this kind has the segment from ({}, {}) to ({}, {}); {count} such segments are given (leave them out with \
         --skip-missing)",
        ends[0].x, ends[0].y, ends[1].x, ends[1].y
    )]
    NoLine {
        /// The ends of the first such segment.
        ends: [Point; 2],
        /// Number of segments that no line has.
        count: u64,
    },
    /// No line has a number that is to be removed.
    #[error("the file has no line {line}; {count} such numbers are given (leave them out with --skip-missing)")]
    NoLineNumber {
        /// The first such number.
        line: u64,
        /// Number of such numbers.
        count: u64,
    },
    /// An obstacle is to be removed, but not with all its rings.
    #[error("the obstacle has more rings than those given, for example at ({}, {}); remove it by its number, {line} (--line)", point.x, point.y)]
    PartOfObstacle {
        /// The number of the line in the file.
        line: u64,
        /// The end of an edge that is not given.
        point: Point,
    },
    /// The lines of the file were split, so that they cannot be told apart.
    #[error(
        "the lines of the file were split where they cross (--crossings split or --steiner), so none can be removed; build the \
         file without it"
    )]
    SplitLines,
    /// Points have no z, but the file's vertices have z.
    #[error(
        "the point at ({}, {}) has no z, but the file has z; {count} such points are given; give z to all points, or allow \
         z = 0 (--missing-z zero)",
        point.x, point.y
    )]
    PointWithoutZ {
        /// The first such point.
        point: Point,
        /// Number of points without z.
        count: u64,
    },
    /// Points have z, but the file's vertices have none.
    #[error(
        "the points have z, but the vertices of the file have none; leave z out (--dims 2), or build the file with z"
    )]
    HasNoZ,
    /// A vertex lies where lines cross, so that it cannot be removed.
    #[error(
        "the vertex at ({}, {}) cannot go: lines {} and {} cross there; build the file without it",
        point.x, point.y, lines[0].number(), lines[1].number()
    )]
    LinesCross {
        /// The vertex.
        point: Point,
        /// The lines.
        lines: [EdgeSource; 2],
    },
    /// Without what is removed, all vertices would lie on one line, and some of its edges would be
    /// constraints. An editor builds such a file anew, so it does not return this.
    #[error("all vertices that are left would lie on one line")]
    NothingLeft,
    /// A line crosses a constraint.
    #[error(
        "a line crosses a constraint: from ({}, {}) to ({}, {}), and from ({}, {}) to ({}, {}); let them meet in a vertex",
        subsegment[0].x, subsegment[0].y, subsegment[1].x, subsegment[1].y, edge[0].x, edge[0].y, edge[1].x, edge[1].y
    )]
    Crossed {
        /// The line.
        line: EdgeSource,
        /// The line that the constraint comes from.
        other: Option<EdgeSource>,
        /// The part of the line that crosses the constraint.
        subsegment: [Point; 2],
        /// The constraint that it crosses.
        edge: [Point; 2],
    },
    /// A ring of an obstacle does not close.
    #[error("a ring of an obstacle does not close")]
    OpenRing {
        /// The number of the ring's line.
        line: u64,
    },
    /// Polygons are inside out.
    #[error(
        "it is inside out at ({}, {}): one of its holes is outside the polygon or inside another hole, or one of its rings \
         has the opposite direction there; {} polygons are inside out",
        .0.first.point.x, .0.first.point.y, .0.polygons
    )]
    Inverted(InvertedPolygons),
    /// An obstacle covers a place more than once, and its rings cross in vertices of the file.
    #[error("it covers ({}, {}) more than once, and its rings cross each other", .0.point.x, .0.point.y)]
    Overlapping(Overlapping),
    /// Segments are given by record numbers, which a file does not keep.
    #[error("the ends of segments are given as record numbers; a file can be changed by coordinates only")]
    Records,
    /// There is not enough memory.
    #[error(transparent)]
    Memory(#[from] MemoryShortage),
    /// Lines or polygons cannot become constraints.
    #[error(transparent)]
    Constraint(#[from] ConstraintError),
    /// The file was built anew for the edit, and that failed.
    #[error(transparent)]
    Build(Arc<dyn Error + Send + Sync>),
    /// The edit was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// A defect of the library.
    #[error("internal error: {0}")]
    Internal(String),
}

impl EditError {
    pub(crate) fn io(file: &Path, what: &'static str, source: io::Error) -> Self {
        Self::Io {
            file: file.to_owned(),
            what,
            source: Arc::new(source),
        }
    }
}

impl Failure for EditError {
    const CANCELLED: Self = Self::Cancelled;

    fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled)
    }
}
