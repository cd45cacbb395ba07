//! Points of queries, and their text.

use anyhow::{Context, bail};
use delaunay_tiles::geometry::Point;

/// The point or points of one query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Question {
    /// A query at a point.
    At(Point),
    /// A query between two points.
    Way(Point, Point),
}

impl Question {
    /// Returns the point where the search begins.
    pub const fn place(&self) -> Point {
        match *self {
            Self::At(at) | Self::Way(at, _) => at,
        }
    }
}

/// Parses a point, written as `X,Y`.
///
/// # Errors
/// Fails if the text is not two finite numbers separated by a comma.
pub fn point(text: &str) -> anyhow::Result<Point> {
    match numbers(text).as_deref() {
        Some(&[x, y]) => Ok(Point::new(x, y)),
        _ => bail!("a point is two numbers separated by a comma, such as 3.5,-4"),
    }
}

/// Parses a distance: a number of at least 0.
///
/// # Errors
/// Fails if the text is something else.
pub fn radius(text: &str) -> anyhow::Result<f64> {
    let radius = text.parse().ok().filter(|radius: &f64| *radius >= 0.0);
    radius.context("a distance is a number of at least 0")
}

/// Parses the length of an edge: a finite number above 0.
///
/// # Errors
/// Fails if the text is something else.
pub fn length(text: &str) -> Result<f64, String> {
    let length = text
        .parse()
        .ok()
        .filter(|length: &f64| *length > 0.0 && length.is_finite());
    length.ok_or_else(|| "a length is a number above 0".to_owned())
}

/// Parses finite numbers that are separated by commas; `None` if it is something else.
pub fn numbers(row: &str) -> Option<Vec<f64>> {
    let numbers = row.split(',').map(|cell| cell.trim().parse().ok());
    numbers
        .collect::<Option<Vec<f64>>>()
        .filter(|numbers| numbers.iter().all(|number| number.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_must_be_finite_and_distances_not_negative() {
        assert_eq!(point("-3.5, 4e2").unwrap(), Point::new(-3.5, 400.0));
        for text in ["", "1", "1,2,3", "a,b", "1,NaN", "inf,0", "1;2"] {
            assert!(point(text).is_err(), "{text}");
        }
        assert_eq!(radius("0").unwrap(), 0.0);
        for text in ["-1", "NaN", "far"] {
            assert!(radius(text).is_err(), "{text}");
        }
    }
}
