//! How questions ended, as columns.

use delaunay_tiles::Point;
use delaunay_tiles::query::{Distance, QueryError};
use futures::{Stream, TryStreamExt};
use tiletool::query::answer::Status;

use super::batch::space;
use crate::columns::Column;
use crate::error::Outcome;

/// A point that there is not.
pub const NOWHERE: Point = Point {
    x: f64::NAN,
    y: f64::NAN,
};

/// How questions ended: a code each, the lower bound of what was not found, the point that is inside
/// an obstacle, and the nearest free point.
#[derive(Default)]
pub struct Ends {
    codes: Vec<u8>,
    bounds: Vec<f64>,
    inside: Vec<Point>,
    nearest_free: Vec<Point>,
}

impl Ends {
    /// Appends the end of a question.
    pub fn push(&mut self, status: Status) {
        let (bound, inside, free) = match status {
            Status::Ok | Status::Unreachable => (f64::NAN, NOWHERE, None),
            Status::Inside(point, free) => (f64::NAN, point, free),
            Status::Budget(bound) => (bound, NOWHERE, None),
        };
        self.codes.push(code(status));
        self.bounds.push(bound);
        self.inside.push(inside);
        self.nearest_free.push(free.unwrap_or(NOWHERE));
    }

    /// Returns the four columns.
    pub fn into_columns(self) -> Vec<Column> {
        vec![
            Column::U8(self.codes),
            Column::F64(self.bounds),
            Column::points(&self.inside),
            Column::points(&self.nearest_free),
        ]
    }
}

/// Returns the index of a status in the Python part's list of words.
pub const fn code(status: Status) -> u8 {
    match status {
        Status::Ok => 0,
        Status::Unreachable => 1,
        Status::Inside(..) => 2,
        Status::Budget(_) => 3,
    }
}

/// Converts an error that is an answer.
///
/// # Errors
/// Returns all other errors.
pub fn status(error: QueryError) -> Outcome<Status> {
    match error {
        QueryError::InsideObstacle { point, nearest_free } => Ok(Status::Inside(point, nearest_free)),
        QueryError::OutOfBudget { lower_bound } => Ok(Status::Budget(lower_bound)),
        other => Err(other.into()),
    }
}

/// Returns up to `most` items of a stream, and how the stream ended.
///
/// # Errors
/// Returns the errors of the stream that are no answers.
pub async fn first<T>(
    mut stream: impl Stream<Item = Result<T, QueryError>> + Unpin,
    most: usize,
) -> Outcome<(Status, Vec<T>)> {
    let mut found = Vec::new();
    while found.len() < most {
        match stream.try_next().await {
            Ok(Some(item)) => found.push(item),
            Ok(None) => break,
            Err(error) => return Ok((status(error)?, found)),
        }
    }
    Ok((Status::Ok, found))
}

/// Distances with their bounds, as three columns.
#[derive(Default)]
pub struct Distances([Vec<f64>; 3]);

impl Distances {
    /// Returns no distances, with space for `count`.
    ///
    /// # Errors
    /// Fails if there is not enough memory.
    pub fn with_space(count: usize) -> Outcome<Self> {
        Ok(Self([space(count)?, space(count)?, space(count)?]))
    }

    /// Appends a distance.
    pub fn push(&mut self, distance: Distance) {
        let Distance { value, lower, upper } = distance;
        for (column, number) in self.0.iter_mut().zip([value, lower, upper]) {
            column.push(number);
        }
    }

    /// Returns the values, the lower and the upper bounds.
    pub fn into_columns(self) -> [Column; 3] {
        self.0.map(Column::F64)
    }
}

/// Returns what is known of a distance that was not found: it is infinite if nothing connects the
/// points, and not a number if a point is inside an obstacle or a limit was reached.
pub const fn missing(status: Status) -> Distance {
    let [value, lower, upper] = match status {
        Status::Ok | Status::Unreachable => [f64::INFINITY; 3],
        Status::Inside(..) => [f64::NAN; 3],
        Status::Budget(bound) => [f64::NAN, bound, f64::INFINITY],
    };
    Distance { value, lower, upper }
}
