//! Triangle's `.poly` files: their sections, and the file with points beside them.
//!
//! ```text
//! 4 2 0 0             points, dimension (2), attributes, markers: as in a .node file
//! 1  0.0 0.0          index from 0 or 1, x, y, attributes, marker
//! …
//! 4 0                 segments, markers (0 or 1)
//! 1  1 2              number, the indices of two points, marker
//! …
//! 1                   holes
//! 1  0.5 0.5          number, x, y
//! 0                   regions (this line may be missing)
//! …                   number, x, y, attribute, area
//! ```
//!
//! If the number of points is 0, they are in the `.node` file of the same stem beside it (`a.node` of `a.poly`, `a.node.gz` of
//! `a.poly.gz`). `#` begins a comment. Markers and regions are not read, and as in Triangle the numbers of segments and
//! holes are anything. Source: <https://www.cs.cmu.edu/~quake/triangle.poly.html>. No count is believed: rows are
//! counted, and none may be left over.

use crate::input::error::{InputError, Place};
use crate::input::formats::node::{fields, whole_number};
use crate::input::formats::text_lines::Lines;
use crate::shown;
use std::io;
use std::path::{Path, PathBuf};

/// The path of the `.node` file beside a `.poly` file; `None` if that has another suffix.
fn node_beside(poly: &Path) -> Option<PathBuf> {
    let name = poly.file_name()?.to_str()?;
    let (name, zipped) = match name.to_ascii_lowercase().ends_with(".gz") {
        true => (&name[..name.len() - 3], ".gz"),
        false => (name, ""),
    };
    let (stem, suffix) = name.rsplit_once('.')?;
    let is_poly = suffix.eq_ignore_ascii_case("poly");
    is_poly.then(|| poly.with_file_name(format!("{stem}.node{zipped}")))
}

/// Opens the `.node` file that has the points of a `.poly` file, by this function.
pub fn open_node_beside<T>(poly: &Path, open: impl FnOnce(&Path) -> Result<T, InputError>) -> Result<T, InputError> {
    let node = node_beside(poly).ok_or_else(|| no_points(poly, "its name does not end in .poly".to_owned(), None))?;
    open(&node).map_err(|error| match error {
        InputError::Open { path, source } => {
            no_points(poly, format!("{} cannot be opened", shown::path(&path)), Some(source))
        }
        other => other,
    })
}

/// The error of a `.poly` file that has no points, and no file with points beside it, for this reason.
pub fn no_points(poly: &Path, reason: String, source: Option<io::Error>) -> InputError {
    InputError::Malformed {
        path: poly.to_owned(),
        place: Place::File,
        problem: format!("by its first line its points are in the .node file of the same stem beside it, but {reason}"),
        hint: "put that file there, or the points into this one",
        source: source.map(Into::into),
    }
}

const COUNT_HINT: &str = "the file is cut short, or one of its counts is wrong";

/// Rows of a kind, behind the line with their number.
#[derive(Clone, Copy)]
pub struct Section {
    what: &'static str,
    pub claimed: u64,
    pub read: u64,
}

impl Section {
    /// Reads the line with the number of the rows, which has so many fields at most.
    pub fn begin(lines: &mut Lines, what: &'static str, most: usize) -> Result<Self, InputError> {
        if !lines.next_row()? {
            let problem = format!("the file ends before the number of {what}");
            return Err(lines.malformed(problem, COUNT_HINT));
        }
        Self::of_row(lines, what, most)
    }

    pub fn of_row(lines: &Lines, what: &'static str, most: usize) -> Result<Self, InputError> {
        let mut numbers = fields(lines.text()).map(whole_number);
        match numbers.next().flatten() {
            // A row more, or less, of what is before shows by its fields.
            Some(claimed) if numbers.by_ref().take(most).count() < most => Ok(Self { what, claimed, read: 0 }),
            _ => {
                let problem = format!("the number of {what} is due, and the row is `{}`", lines.excerpt());
                Err(lines.malformed(problem, COUNT_HINT))
            }
        }
    }

    /// Goes to the next row; false behind the last one.
    pub fn next_row(&mut self, lines: &mut Lines) -> Result<bool, InputError> {
        if self.read == self.claimed {
            return Ok(false);
        }
        if !lines.next_row()? {
            let problem = format!("the file ends after {} of {} {}", self.read, self.claimed, self.what);
            return Err(lines.malformed(problem, COUNT_HINT));
        }
        self.read += 1;
        Ok(true)
    }

    /// Fails if a row comes behind the last one, which ends the file.
    pub fn end(&self, lines: &mut Lines) -> Result<(), InputError> {
        if !lines.next_row()? {
            return Ok(());
        }
        let row = lines.excerpt();
        let problem = format!("a row behind the last of {} {}: `{row}`", self.claimed, self.what);
        Err(lines.malformed(problem, COUNT_HINT))
    }
}
