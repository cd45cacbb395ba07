//! Points of queries, from the command line and from files.

use std::path::Path;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::RowFile;
use delaunay_tiles::shown;
use delaunay_tiles_answers::question::{Question, numbers};

use crate::common;

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
        common::note(format_args!("{} has no rows of {expected}", common::shown(path)));
    }
    Ok(questions)
}
