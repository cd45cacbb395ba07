//! What a query may use, and why it could not be answered.

use std::str::FromStr;
use std::sync::Arc;
use std::time::Duration;

use super::Explored;
use crate::geometry::Point;
use crate::store::ReadError;

/// How exact answers are to be. All have a lower and an upper bound, so that one can tell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Mode {
    /// Exact, but for rounding.
    #[default]
    Exact,
    /// The upper bound is at most 1 + this times the lower one, but for rounding. Paths are [fast](Self::Fast) ones where the bounds of
    /// these are close enough; else the exact search goes on until they are. Streams of sites and of paths are exact.
    Within(f64),
    /// A short way along edges of the triangulation, pulled taut: its length is the value, and not less than the true one. The lower
    /// bound is the straight line, or, where the file says that it has no break lines, a length that all ways along edges have at least,
    /// divided by 2.42 (Bose and Keil 2006), if that is more. The way along edges is a shortest one to a site, and to a point at most 1/8
    /// longer than that.
    Fast,
}

impl FromStr for Mode {
    type Err = UnknownMode;

    fn from_str(text: &str) -> Result<Self, UnknownMode> {
        let tolerance = |text: &str| text.parse().ok().filter(|&tolerance| is_tolerance(tolerance));
        match (text, text.strip_prefix("within:")) {
            ("exact", _) => Ok(Self::Exact),
            ("fast", _) => Ok(Self::Fast),
            (_, Some(part)) => tolerance(part).map(Self::Within).ok_or(UnknownMode),
            _ => Err(UnknownMode),
        }
    }
}

/// A text names no mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a mode is exact, fast, or within: and a number that is not negative, as within:0.05")]
pub struct UnknownMode;

/// Whether bounds may differ by such a part.
pub(super) fn is_tolerance(tolerance: f64) -> bool {
    tolerance >= 0.0 && tolerance.is_finite()
}

/// What a query may use, and what it gives back beside distances.
#[derive(Clone, Debug, Default)]
pub struct QueryOptions {
    pub(super) max_tiles: Option<u64>,
    pub(super) max_time: Option<Duration>,
    pub(super) paths: bool,
    pub(super) certify: bool,
    pub(super) explored: Option<Explored>,
    pub(super) mode: Mode,
}

impl QueryOptions {
    /// Lets the query ask for so many different tiles at most. It then ends with [`QueryError::OutOfBudget`].
    #[must_use]
    pub fn max_tiles(mut self, tiles: u64) -> Self {
        self.max_tiles = Some(tiles);
        self
    }

    /// Lets the query take so long at most. It then ends with [`QueryError::OutOfBudget`].
    #[must_use]
    pub fn max_time(mut self, time: Duration) -> Self {
        self.max_time = Some(time);
        self
    }

    /// Says how exact answers are to be.
    #[must_use]
    pub fn mode(mut self, mode: Mode) -> Self {
        self.mode = mode;
        self
    }

    /// Asks for the path to each site, and not just how long it is.
    #[must_use]
    pub fn paths(mut self) -> Self {
        self.paths = true;
        self
    }

    /// Has each path proved by a walk through the triangles that it passes, with exact predicates. Asks for paths.
    #[must_use]
    pub fn certified(mut self) -> Self {
        self.paths = true;
        self.certify = true;
        self
    }

    /// Has the triangles collected that the search goes through.
    #[must_use]
    pub fn explored(mut self, into: &Explored) -> Self {
        self.explored = Some(into.clone());
        self
    }
}

/// Why a query has no answer.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum QueryError {
    /// The file could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A coordinate is not finite, or too large.
    #[error("({x}, {y}) is no point that a triangulation can have; coordinates are finite, and their magnitude is at most 2^200", x = point.x, y = point.y)]
    NotAPoint {
        /// The point.
        point: Point,
    },
    /// The file has no triangles, so there is nothing to walk on.
    #[error("{file} has no triangles to walk on: all its points lie on one line")]
    NoTriangles {
        /// The file.
        file: Arc<str>,
    },
    /// The point that the query starts from lies in an obstacle.
    #[error("({x}, {y}) lies in an obstacle{}", .nearest_free.map_or_else(String::new, |p| format!("; the nearest free point is ({}, {})", p.x, p.y)), x = point.x, y = point.y)]
    InsideObstacle {
        /// The point.
        point: Point,
        /// The nearest point where one may be, rounded; none if there is none.
        nearest_free: Option<Point>,
    },
    /// The query used up the tiles or the time that it may use.
    #[error("the query used up what it may use; what was not found is at least {at_least} away")]
    OutOfBudget {
        /// All that was not found so far is at least as far away.
        at_least: f64,
    },
    /// Answers were to be within a part of the truth that is negative or no number.
    #[error("answers cannot be within {tolerance} of the truth; give a number that is not negative, as 0.05")]
    NoTolerance {
        /// The part.
        tolerance: f64,
    },
    /// The file has break lines, for which the bound of the CDT distance does not hold.
    #[error(
        "{file} has break lines: they block nobody but hold edges in place, so that the CDT distance is not bounded by the walking distance there; ask for that instead, in any mode, or build the file without them"
    )]
    BreakLines {
        /// The file.
        file: Arc<str>,
    },
    /// A path contradicts the file: a fault of this library.
    #[error("the path is not one that can be walked: {reason}")]
    Uncertified {
        /// Where it fails.
        reason: String,
    },
}

impl QueryError {
    /// The same, if it is that a budget was used up, with what is known of the rest.
    pub(super) fn at_least(self, at_least: f64) -> Self {
        match self {
            Self::OutOfBudget { .. } => Self::OutOfBudget { at_least },
            other => other,
        }
    }
}
