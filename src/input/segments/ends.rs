//! Ends of segments, and what is wrong with them.

use crate::geometry::Point;
use crate::input::sink::describe;
use crate::input::{InputError, Place};
use std::path::Path;

/// A valid end of a segment.
pub(super) fn end(
    path: &Path,
    segment: u64,
    (x, y): (f64, f64),
    place: impl FnOnce() -> Place,
) -> Result<Point, InputError> {
    let point = Point::new(x, y);
    if point.is_valid() {
        return Ok(point.normalized());
    }
    Err(wrong(path, segment, place(), describe(x, y, None)))
}

/// The error of a record that is no segment.
pub(super) fn wrong(path: &Path, segment: u64, place: Place, found: String) -> InputError {
    InputError::Segment {
        path: path.to_owned(),
        segment,
        place,
        found,
    }
}
