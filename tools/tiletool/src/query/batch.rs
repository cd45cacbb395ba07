//! Points of queries, from the command line and from files.

use std::path::Path;

use anyhow::{Context, bail};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::RowFile;
use delaunay_tiles::shown;

use crate::common;

/// The point or points of one query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Question {
    At(Point),
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
pub fn point(text: &str) -> anyhow::Result<Point> {
    match numbers(text).as_deref() {
        Some(&[x, y]) => Ok(Point::new(x, y)),
        _ => bail!("a point is two numbers separated by a comma, such as 3.5,-4"),
    }
}

/// Parses a distance: a number of at least 0.
pub fn radius(text: &str) -> anyhow::Result<f64> {
    let radius = text.parse().ok().filter(|radius: &f64| *radius >= 0.0);
    radius.context("a distance is a number of at least 0")
}

fn numbers(row: &str) -> Option<Vec<f64>> {
    let numbers = row.split(',').map(|cell| cell.trim().parse().ok());
    numbers
        .collect::<Option<Vec<f64>>>()
        .filter(|numbers| numbers.iter().all(|number| number.is_finite()))
}

/// Reads a file of points, or of pairs of points if `ways`. The first row may be a header. Blank
/// rows and rows that begin with # are skipped.
pub fn read(path: &Path, ways: bool) -> anyhow::Result<Vec<Question>> {
    let mut rows = RowFile::open(path)?;
    let (expected, hint) = match ways {
        false => ("x,y", "a row is two numbers separated by a comma"),
        true => ("from_x,from_y,to_x,to_y", "a row is four numbers separated by commas"),
    };
    let mut questions = Vec::new();
    let mut is_first = true;
    while let Some((row, _)) = rows.next_row()? {
        let text = std::str::from_utf8(row).unwrap_or_default();
        let question = match (numbers(text).as_deref(), ways) {
            (Some(&[x, y]), false) => Question::At(Point::new(x, y)),
            (Some(&[x, y, to_x, to_y]), true) => Question::Way(Point::new(x, y), Point::new(to_x, to_y)),
            // A header has no numbers.
            (None, _) if is_first && text.split(',').all(|cell| cell.trim().parse::<f64>().is_err()) => {
                is_first = false;
                continue;
            }
            _ => {
                let problem = format!("`{}` is not {expected}", shown::excerpt(row));
                return Err(rows.wrong_row(problem, hint).into());
            }
        };
        is_first = false;
        questions.push(question);
    }
    if questions.is_empty() {
        common::say(format_args!("note: {} has no rows of {expected}", common::shown(path)));
    }
    Ok(questions)
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
