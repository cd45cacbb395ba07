//! Why a query has no answer.

use std::sync::Arc;

use crate::geometry::Point;
use crate::store::ReadError;

/// Why a query has no answer.
///
/// [Examples](crate::query#examples).
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
    pub(crate) fn at_least(self, at_least: f64) -> Self {
        self.bounded(|_| at_least)
    }

    /// The same, if it is that a budget was used up, with what is known of the rest, given what it says.
    pub(crate) fn bounded(self, at_least: impl FnOnce(f64) -> f64) -> Self {
        match self {
            Self::OutOfBudget { at_least: known } => Self::OutOfBudget {
                at_least: at_least(known),
            },
            other => other,
        }
    }
}
