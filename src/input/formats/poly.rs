//! The sections of Triangle's `.poly` files, and the file with points beside them.
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
//! If the number of points is 0, they are in the `.node` file of the same stem beside it (`a.node`
//! for `a.poly`, `a.node.gz` for `a.poly.gz`). `#` begins a comment. Markers and regions are not
//! read. As in Triangle, the numbers at the beginning of the rows of segments and holes are
//! arbitrary. Source: <https://www.cs.cmu.edu/~quake/triangle.poly.html>. No count is trusted: rows
//! are counted, and no rows may be left over.

use crate::input::error::{InputError, Location};
use crate::input::formats::node::{fields, whole_number};
use crate::input::formats::text_lines::Lines;
use crate::shown;
use std::io;
use std::path::{Path, PathBuf};

/// Returns the path of the file with the suffix `other` beside `path`, which must have the suffix
/// `suffix`; either may have `.gz` behind it.
pub fn beside(path: &Path, suffix: &str, other: &str) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let (name, zipped) = match name.to_ascii_lowercase().ends_with(".gz") {
        true => (&name[..name.len() - 3], ".gz"),
        false => (name, ""),
    };
    let (stem, found) = name.rsplit_once('.')?;
    let has_suffix = found.eq_ignore_ascii_case(suffix);
    has_suffix.then(|| path.with_file_name(format!("{stem}.{other}{zipped}")))
}

/// Opens the `.node` file that has the points of a `.poly` file, with the function `open`.
pub fn open_node_beside<T>(poly: &Path, open: impl FnOnce(&Path) -> Result<T, InputError>) -> Result<T, InputError> {
    let node = beside(poly, "poly", "node")
        .ok_or_else(|| no_points(poly, "its name does not end in .poly".to_owned(), None))?;
    open(&node).map_err(|error| match error {
        InputError::Open { path, source } => {
            no_points(poly, format!("{} cannot be opened", shown::path(&path)), Some(source))
        }
        other => other,
    })
}

/// Returns the error of a `.poly` file without points for which there is no file with points beside
/// it, for the reason `reason`.
pub fn no_points(poly: &Path, reason: String, source: Option<io::Error>) -> InputError {
    InputError::Malformed {
        path: poly.to_owned(),
        location: Location::File,
        problem: format!("by its first line its points are in the .node file of the same stem beside it, but {reason}"),
        hint: "put that file there, or the points into this one",
        source: source.map(Into::into),
    }
}

const COUNT_HINT: &str = "the file is cut short, or one of its counts is wrong";

/// A section: a line with a number of rows, then these rows.
#[derive(Clone, Copy)]
pub struct Section {
    what: &'static str,
    pub claimed: u64,
    pub read: u64,
}

impl Section {
    /// Reads the line with the number of rows, which has at most `most` fields.
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
            // If the section before has a row too many or too few, the number of fields here shows
            // it.
            Some(claimed) if numbers.by_ref().take(most).count() < most => Ok(Self { what, claimed, read: 0 }),
            _ => {
                let problem = format!("expected the number of {what}, found the row `{}`", lines.excerpt());
                Err(lines.malformed(problem, COUNT_HINT))
            }
        }
    }

    /// Reads the next row; returns false after the last one.
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

    /// Fails if rows follow the last one, which must end the file.
    pub fn end(&self, lines: &mut Lines) -> Result<(), InputError> {
        if !lines.next_row()? {
            return Ok(());
        }
        let row = lines.excerpt();
        let problem = format!("a row after the last of {} {}: `{row}`", self.claimed, self.what);
        Err(lines.malformed(problem, COUNT_HINT))
    }
}
