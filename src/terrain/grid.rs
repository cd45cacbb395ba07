//! The geometry of a raster: square cells in rows, the northern one first.

use std::ops::Range;

use crate::geometry::{Point, Rect};

/// The cells of a raster: squares in columns from left to right and rows from top to bottom.
///
/// ```
/// use delaunay_tiles::geometry::{Point, Rect};
/// use delaunay_tiles::terrain::Grid;
///
/// let grid = Grid::covering(Rect::new(0.5, 0.5, 9.0, 4.0), 2.0, Point::default()).unwrap();
/// assert_eq!((grid.columns(), grid.rows()), (5, 2));
/// assert_eq!(grid.bounds(), Rect::new(0.0, 0.0, 10.0, 4.0));
/// assert_eq!((grid.centre(0, 0).x, grid.centre(0, 0).y), (1.0, 3.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    left: f64,
    top: f64,
    resolution: f64,
    columns: u32,
    rows: u32,
}

/// The error of a grid that cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// The resolution is not a positive number.
    #[error("a resolution is a number above 0, and not {0}")]
    Resolution(f64),
    /// There is nothing to cover.
    #[error("there is no area to cover with cells")]
    Empty,
    /// There would be too many columns or rows.
    #[error("{columns:.0} columns and {rows:.0} rows are more than {most} each; choose a larger resolution", most = Grid::MAX)]
    TooLarge {
        /// The number of columns.
        columns: f64,
        /// The number of rows.
        rows: f64,
    },
    /// The coordinates are too large for cells of this size.
    #[error("cells of size {0} cannot be told apart at coordinates as large as these; choose a larger resolution")]
    TooFine(f64),
}

impl Grid {
    /// The largest number of columns and of rows.
    pub const MAX: u32 = i32::MAX as u32;

    /// Creates a grid of cells of size `resolution` that covers `bounds`: the corners of the cells are
    /// whole multiples of `resolution` away from the point `align`.
    ///
    /// # Errors
    /// Fails if `resolution` is not a positive number, if `bounds` is empty, or if the cells would be
    /// too many or too small.
    pub fn covering(bounds: Rect, resolution: f64, align: Point) -> Result<Self, GridError> {
        Self::checked(bounds, resolution)?;
        let snapped = |v: f64, origin: f64| origin + ((v - origin) / resolution).floor() * resolution;
        let left = snapped(bounds.min_x, align.x);
        let top = -snapped(-bounds.max_y, -align.y);
        Self::from_corner(left, top, bounds, resolution)
    }

    /// Creates a grid of cells of size `resolution` whose upper left corner is that of `bounds`, and
    /// which covers `bounds`.
    ///
    /// # Errors
    /// As [`covering`](Self::covering).
    pub fn starting_at(bounds: Rect, resolution: f64) -> Result<Self, GridError> {
        Self::checked(bounds, resolution)?;
        Self::from_corner(bounds.min_x, bounds.max_y, bounds, resolution)
    }

    fn checked(bounds: Rect, resolution: f64) -> Result<(), GridError> {
        if !(resolution > 0.0 && resolution.is_finite()) {
            return Err(GridError::Resolution(resolution));
        }
        match bounds.is_empty() {
            true => Err(GridError::Empty),
            false => Ok(()),
        }
    }

    fn from_corner(left: f64, top: f64, bounds: Rect, resolution: f64) -> Result<Self, GridError> {
        // A width that is a multiple of the resolution, but for rounding, needs no further column.
        let count = |length: f64| {
            let cells = length / resolution;
            let nearest = cells.round();
            let count = if (cells - nearest).abs() <= 1e-9 * nearest {
                nearest
            } else {
                cells.ceil()
            };
            count.max(1.0)
        };
        let (columns, rows) = (count(bounds.max_x - left), count(top - bounds.min_y));
        let most = f64::from(Self::MAX);
        if !(columns <= most && rows <= most) {
            return Err(GridError::TooLarge { columns, rows });
        }
        let grid = Self {
            left,
            top,
            resolution,
            columns: columns as u32,
            rows: rows as u32,
        };
        let [last, end] =
            [1, 0].map(|before| grid.centre(grid.columns - 1 - before.min(grid.columns - 1), grid.rows - 1));
        let Rect { max_x, min_y, .. } = grid.bounds();
        let distinct = (grid.columns == 1 || last.x < end.x) && end.x < max_x && end.y > min_y;
        match distinct && grid.centre(0, 0).x > left && grid.centre(0, 0).y < top {
            true => Ok(grid),
            false => Err(GridError::TooFine(resolution)),
        }
    }

    /// Returns a grid of the same upper left corner whose cells are `factor` times as large.
    #[must_use]
    pub fn coarser(&self, factor: u32) -> Self {
        Self {
            resolution: self.resolution * f64::from(factor),
            columns: self.columns.div_ceil(factor),
            rows: self.rows.div_ceil(factor),
            ..*self
        }
    }

    /// Returns the number of columns.
    #[must_use]
    pub fn columns(&self) -> u32 {
        self.columns
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// Returns the number of cells.
    #[must_use]
    pub fn cells(&self) -> u64 {
        u64::from(self.columns) * u64::from(self.rows)
    }

    /// Returns the length of the sides of a cell.
    #[must_use]
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// Returns the rectangle of all cells.
    #[must_use]
    pub fn bounds(&self) -> Rect {
        Rect {
            min_x: self.left,
            min_y: self.top - f64::from(self.rows) * self.resolution,
            max_x: self.left + f64::from(self.columns) * self.resolution,
            max_y: self.top,
        }
    }

    /// Returns the centre of the cell in a column and a row, both counted from 0.
    #[must_use]
    pub fn centre(&self, column: u32, row: u32) -> Point {
        let x = self.left + (f64::from(column) + 0.5) * self.resolution;
        let y = self.top - (f64::from(row) + 0.5) * self.resolution;
        Point::new(x, y).representable()
    }
}

/// Some columns and rows of a grid, with the coordinates of their centres.
#[derive(Clone, Debug)]
pub(crate) struct Window {
    resolution: f64,
    /// The centres of the columns, increasing.
    xs: Vec<f64>,
    /// The centres of the rows, decreasing.
    ys: Vec<f64>,
}

impl Window {
    pub(crate) fn new(grid: &Grid, columns: Range<u32>, rows: Range<u32>) -> Self {
        Self {
            resolution: grid.resolution,
            xs: columns.map(|column| grid.centre(column, 0).x).collect(),
            ys: rows.map(|row| grid.centre(0, row).y).collect(),
        }
    }

    pub(crate) fn columns(&self) -> usize {
        self.xs.len()
    }

    pub(crate) fn rows(&self) -> usize {
        self.ys.len()
    }

    /// Returns the rectangle around the centres.
    pub(crate) fn around_centres(&self) -> Rect {
        match (&*self.xs, &*self.ys) {
            ([left, ..], [top, ..]) => Rect::new(*left, self.ys[self.ys.len() - 1], self.xs[self.xs.len() - 1], *top),
            _ => Rect::EMPTY,
        }
    }

    #[inline]
    pub(crate) fn centre(&self, column: usize, row: usize) -> Point {
        Point::new(self.xs[column], self.ys[row])
    }

    /// Returns the columns whose centres have `min <= x <= max`.
    #[inline]
    pub(crate) fn columns_in(&self, min: f64, max: f64) -> Range<usize> {
        self.column_from(min)..self.column_from(max.next_up())
    }

    /// Returns the first column whose centre has `x >= min`; the number of columns if there is none.
    #[inline]
    pub(crate) fn column_from(&self, min: f64) -> usize {
        first_from(&self.xs, (min - self.xs[0]) / self.resolution, |&x| x < min)
    }

    /// Returns the rows whose centres have `min <= y <= max`.
    #[inline]
    pub(crate) fn rows_in(&self, min: f64, max: f64) -> Range<usize> {
        let from = |max: f64| first_from(&self.ys, (self.ys[0] - max) / self.resolution, |&y| y > max);
        from(max)..from(min.next_down())
    }
}

/// Returns the first index whose number is not before what is searched for; `estimate` is close to it.
#[inline]
fn first_from(sorted: &[f64], estimate: f64, is_before: impl Fn(&f64) -> bool) -> usize {
    // Saturates at 0 and at the length.
    let mut index = (estimate as usize).min(sorted.len());
    while index > 0 && !is_before(&sorted[index - 1]) {
        index -= 1;
    }
    while index < sorted.len() && is_before(&sorted[index]) {
        index += 1;
    }
    index
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_cover_their_bounds_without_a_column_too_many() {
        let bounds = Rect::new(0.0, 0.0, 0.3, 0.7);
        let grid = Grid::covering(bounds, 0.1, Point::default()).unwrap();
        assert_eq!((grid.columns(), grid.rows()), (3, 7));
        let moved = Grid::covering(bounds, 0.1, Point::new(0.05, 0.05)).unwrap();
        assert_eq!((moved.columns(), moved.rows()), (4, 8));
        assert!(moved.bounds().min_x < 0.0 && moved.bounds().max_y > 0.7);
        let exact = Grid::starting_at(Rect::new(1.0, 1.0, 2.1, 1.5), 0.25).unwrap();
        assert_eq!((exact.columns(), exact.rows()), (5, 2));
        assert_eq!((exact.bounds().min_x, exact.bounds().max_y), (1.0, 1.5));
        let point = Grid::covering(Rect::new(3.0, 3.0, 3.0, 3.0), 1.0, Point::default()).unwrap();
        assert_eq!(point.cells(), 1);
    }

    #[test]
    fn bad_grids_are_errors() {
        let bounds = Rect::new(0.0, 0.0, 1.0, 1.0);
        for resolution in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(
                Grid::covering(bounds, resolution, Point::default()),
                Err(GridError::Resolution(_))
            ));
        }
        assert_eq!(Grid::starting_at(Rect::EMPTY, 1.0), Err(GridError::Empty));
        assert!(matches!(
            Grid::starting_at(bounds, 1e-12),
            Err(GridError::TooLarge { .. })
        ));
        let far = Rect::new(1e20, 1e20, 1e20 + 1e6, 1e20 + 1e6);
        assert!(matches!(Grid::starting_at(far, 1.0), Err(GridError::TooFine(_))));
    }

    #[test]
    fn windows_find_centres_in_closed_intervals() {
        let grid = Grid::starting_at(Rect::new(-2.0, 0.0, 3.0, 4.0), 1.0).unwrap();
        let window = Window::new(&grid, 1..4, 0..4);
        assert_eq!(window.around_centres(), Rect::new(-0.5, 0.5, 1.5, 3.5));
        for (interval, columns) in [
            ((-0.5, 1.5), 0..3),
            ((-0.4, 1.4), 1..2),
            ((0.5, 0.5), 1..2),
            ((0.6, 0.7), 2..2),
            ((-9.0, 9.0), 0..3),
        ] {
            assert_eq!(window.columns_in(interval.0, interval.1), columns, "{interval:?}");
        }
        assert_eq!(window.rows_in(0.5, 2.5), 1..4);
        assert_eq!(window.rows_in(2.6, 2.9), 1..1);
    }
}
