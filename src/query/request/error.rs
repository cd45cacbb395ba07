//! The errors of queries.

use std::sync::Arc;

use crate::geometry::Point;
use crate::store::ReadError;

/// The error of a query.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum QueryError {
    /// The file could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A coordinate is not finite, or too large.
    #[error("({x}, {y}) is not a valid point; coordinates must be finite, with a magnitude of at most 2^200", x = point.x, y = point.y)]
    NotAPoint {
        /// The point.
        point: Point,
    },
    /// The file has no triangles, so it has no space to walk in.
    #[error("{file} has no triangles to walk on: all its points are collinear")]
    NoTriangles {
        /// The name of the file.
        file: Arc<str>,
    },
    /// The query starts from a point in an obstacle.
    #[error("({x}, {y}) is inside an obstacle{}", .nearest_free.map_or_else(String::new, |p| format!("; the nearest free point is ({}, {})", p.x, p.y)), x = point.x, y = point.y)]
    InsideObstacle {
        /// The point.
        point: Point,
        /// The nearest free point, rounded; `None` if no point is free.
        nearest_free: Option<Point>,
    },
    /// The query reached its limit of tiles or time.
    #[error(
        "the query reached its limit of tiles or time; everything that was not found is at least {lower_bound} away"
    )]
    OutOfBudget {
        /// A lower bound of the distance of everything that was not found.
        lower_bound: f64,
    },
    /// The tolerance of [`Mode::Within`](super::options::Mode::Within) is negative or not finite.
    #[error("{tolerance} is not a valid tolerance; give a finite number that is not negative, such as 0.05")]
    NoTolerance {
        /// The tolerance.
        tolerance: f64,
    },
    /// The file has break lines, for which the bound of the CDT distance does not hold.
    #[error(
        "{file} has break lines, with which the CDT distance is not bounded by the walking distance; query the walking distance instead, in any mode, or build the file without break lines"
    )]
    BreakLines {
        /// The name of the file.
        file: Arc<str>,
    },
    /// A path contradicts the file. This is a bug in this library.
    #[error("the path cannot be walked: {reason}")]
    Uncertified {
        /// Where the path fails.
        reason: String,
    },
}

impl QueryError {
    /// If a limit was reached, replaces its lower bound; otherwise returns the error unchanged.
    pub(crate) fn lower_bound(self, lower_bound: f64) -> Self {
        self.bounded(|_| lower_bound)
    }

    /// If a limit was reached, maps its lower bound; otherwise returns the error unchanged.
    pub(crate) fn bounded(self, map: impl FnOnce(f64) -> f64) -> Self {
        match self {
            Self::OutOfBudget { lower_bound: known } => Self::OutOfBudget {
                lower_bound: map(known),
            },
            other => other,
        }
    }
}
