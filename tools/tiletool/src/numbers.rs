//! Formats of numbers, texts and tables for people.

use std::fmt::Write;

use delaunay_tiles::geometry::Rect;
use delaunay_tiles::shown;
use serde::Serialize;

/// A rectangle in the output of `--json`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Bounds {
    pub min_x: f64,
    pub min_y: f64,
    pub max_x: f64,
    pub max_y: f64,
}

impl Bounds {
    /// Creates the bounds of a rectangle, or `None` if it is empty.
    pub fn new(rect: Rect) -> Option<Self> {
        (!rect.is_empty()).then_some(Self {
            min_x: rect.min_x,
            min_y: rect.min_y,
            max_x: rect.max_x,
            max_y: rect.max_y,
        })
    }
}

/// The format of coordinates in a rectangle, with enough digits to distinguish a hundred-thousandth
/// of its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinates {
    /// A fixed number of decimals.
    Fixed(usize),
    /// An exponent, and a fixed number of decimals before it.
    Scientific(usize),
}

impl Coordinates {
    /// Maximum number of significant digits of an f64.
    const DIGITS: i32 = 17;

    /// Returns the format for coordinates within `bounds`.
    pub fn within(bounds: Rect) -> Self {
        let corners = [bounds.min_x, bounds.min_y, bounds.max_x, bounds.max_y];
        let largest = corners.into_iter().map(f64::abs).fold(0.0, f64::max);
        let (width, height) = bounds.size();
        let size = width.max(height);
        let exponent = |v: f64| v.log10().floor() as i32;
        if bounds.is_empty() || largest == 0.0 || !largest.is_finite() {
            return Self::Fixed(0);
        }
        let finest = exponent(if size > 0.0 { size } else { largest }) - 5;
        let top = exponent(largest);
        if (-4..12).contains(&top) {
            Self::Fixed((-finest).clamp(0, Self::DIGITS - 1 - top.max(0)) as usize)
        } else {
            Self::Scientific((top - finest).clamp(0, Self::DIGITS - 1) as usize)
        }
    }

    /// Formats a coordinate.
    pub fn show(self, value: f64) -> String {
        match self {
            Self::Fixed(decimals) => format!("{value:.decimals$}"),
            Self::Scientific(decimals) => format!("{value:.decimals$e}"),
        }
    }
}

/// A row of a report: its title, or none if it continues the row above, and its text.
pub type Row = (&'static str, String);

/// Returns a report for people: a title, and groups of rows.
pub fn report(title: &str, groups: &[Vec<Row>]) -> String {
    let mut text = format!("{title}\n");
    for (number, group) in groups.iter().filter(|group| !group.is_empty()).enumerate() {
        if number > 0 {
            text.push('\n');
        }
        for (name, value) in group {
            text += &format!("  {name:<18} {value}\n");
        }
    }
    text
}

/// Returns the rows of the bounds in x and y and, if it is known, in z.
pub fn bounds(rect: Rect, z: Option<[f64; 2]>, coordinates: Coordinates) -> Vec<Row> {
    if rect.is_empty() {
        return vec![("bounds", "none".to_owned())];
    }
    let mut ranges = vec![("x", rect.min_x, rect.max_x), ("y", rect.min_y, rect.max_y)];
    ranges.extend(z.map(|[low, high]| ("z", low, high)));
    let ranges: Vec<_> = ranges
        .into_iter()
        .map(|(axis, min, max)| (axis, coordinates.show(min), coordinates.show(max)))
        .collect();
    let width = |of: fn(&(&str, String, String)) -> usize| ranges.iter().map(of).max().unwrap_or(0);
    let (left, right) = (width(|range| range.1.len()), width(|range| range.2.len()));
    let row = |(n, (axis, min, max)): (usize, &(&str, String, String))| {
        let title = if n == 0 { "bounds" } else { "" };
        (title, format!("{axis}  {min:>left$} to {max:>right$}"))
    };
    ranges.iter().enumerate().map(row).collect()
}

/// Returns the start of a text, up to `limit` characters, on one line.
pub fn shortened(text: &str, limit: usize) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    shown::beginning(&words.join(" "), limit)
}

/// Formats a share for people: `12.5 %`.
pub fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// A table with a header. Columns are right-aligned and two spaces apart.
pub struct Table {
    columns: usize,
    cells: Vec<String>,
}

impl Table {
    /// Creates a table without rows.
    pub fn new(header: &[&str]) -> Self {
        Self {
            columns: header.len(),
            cells: header.iter().map(|&name| name.to_owned()).collect(),
        }
    }

    /// Appends a row. It must have as many cells as the header.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.cells.extend(cells);
        debug_assert!(self.cells.len().is_multiple_of(self.columns));
    }

    /// Returns the table as text, with `indent` spaces before each line.
    pub fn show(&self, indent: usize) -> String {
        let mut widths = vec![0; self.columns];
        for (cell, column) in self.cells.iter().zip((0..self.columns).cycle()) {
            widths[column] = widths[column].max(cell.chars().count());
        }
        let mut text = String::new();
        for row in self.cells.chunks(self.columns) {
            text.extend(std::iter::repeat_n(' ', indent));
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                let gap = if column == 0 { "" } else { "  " };
                // Writing to a string cannot fail.
                let _ = write!(text, "{gap}{cell:>width$}");
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_have_the_digits_that_their_region_needs() {
        let show = |bounds: [f64; 4], value: f64| {
            let [min_x, min_y, max_x, max_y] = bounds;
            Coordinates::within(Rect::new(min_x, min_y, max_x, max_y)).show(value)
        };
        assert_eq!(show([0.0, 0.0, 1.0, 1.0], 0.5), "0.50000");
        assert_eq!(
            show([636_000.0, 848_000.0, 639_000.0, 853_000.0], 637_000.25),
            "637000.25"
        );
        assert_eq!(show([-1e30, 0.0, 1e30, 1.0], 1.25e29), "1.25000e29");
        assert_eq!(show([0.0, 0.0, 1e-30, 1e-30], 1e-31), "1.00000e-31");
        assert_eq!(show([3.0, 4.0, 3.0, 4.0], 3.0), "3.00000");
        assert_eq!(show([0.0, 0.0, 0.0, 0.0], 0.0), "0");
        assert_eq!(Coordinates::within(Rect::EMPTY), Coordinates::Fixed(0));
        assert_eq!(Coordinates::within(Rect::PLANE), Coordinates::Fixed(0));
    }

    #[test]
    fn a_long_text_is_cut_and_on_one_line() {
        assert_eq!(shortened("a \n b", 9), "a b");
        assert_eq!(shortened("abcdef", 3), "abc…");
    }
}
