//! A grid over a set of segments, and the cells that each segment may pass.
//!
//! Each coordinate of a point is mapped to a column or row by a monotonic function. So every point
//! has a cell, and the cells of the points of a rectangle form a rectangle of cells. Points beyond
//! the grid belong to its outermost cells. A segment goes to the cells of its bounding box if these
//! are few. Otherwise it goes, row by row or column by column, to the cells near its line. These
//! may be more cells than it passes; they include at least the cell of each of its points within
//! the contents, rounded to coordinates or not.

use std::ops::RangeInclusive;

use crate::constraints::crossings::boxes::{bounds, common, in_order};
use crate::geometry::{Point, Rect};

/// Largest number of cells of a grid. Distribution writes to this number of memory locations at
/// once.
const MOST_CELLS: f64 = 4096.0;

/// Number of segments per cell, if each segment were in one cell.
const PER_CELL: f64 = 12.0;

/// Largest average number of cells per segment.
const MOST_COPIES: f64 = 3.0;

/// Number of columns and of rows of a grid that separates long segments.
const COARSE: u32 = 6;

/// Smallest ratio of the grid's extent to its largest coordinate at which the extent is divided:
/// 2⁻³⁰. With at most 2¹² columns, each column is then wider than 2¹⁰ units in the last place.
const RESOLUTION: f64 = 1.0 / (1u64 << 30) as f64;

/// Largest fraction of a cell by which rounding may move a line. If it is exceeded, the segment
/// goes to all cells of its bounding box.
const MOST_SLACK: f64 = 1.0 / 16.0;

/// Fraction of a cell that is added on each side: twice the slack, for the error of the line and
/// the error of the point on it.
const MARGIN: f64 = 2.0 * MOST_SLACK;

/// The extents of the segments of a bucket within its rectangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extents {
    /// A rectangle around all segments.
    pub(crate) contents: Rect,
    /// A rectangle around most segments. The grid divides it.
    pub(crate) core: Rect,
    /// The average width and height of the segments within the core.
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Extents {
    /// Measures segments, some of which may be outside of `rect`. Shrinks `core` to the contents.
    pub(crate) fn measure(segments: impl Iterator<Item = [Point; 2]>, rect: Rect, core: Rect) -> Self {
        let mut contents = Rect::EMPTY;
        let (mut widths, mut heights, mut count) = (0.0, 0.0, 0.0);
        for segment in segments {
            let part = common(bounds(segment), rect);
            if !part.is_empty() {
                contents = contents.union(part);
                let in_core = common(part, core);
                widths += (in_core.max_x - in_core.min_x).max(0.0);
                heights += (in_core.max_y - in_core.min_y).max(0.0);
                count += 1.0;
            }
        }
        Self {
            contents,
            core: common(core, contents),
            width: widths / count,
            height: heights / count,
        }
    }

    /// Returns whether columns and whether rows can be distinguished.
    fn can_be_cut(&self) -> (bool, bool) {
        let can_be_cut = |low: f64, high: f64| high - low > low.abs().max(high.abs()) * RESOLUTION;
        let core = self.core;
        (can_be_cut(core.min_x, core.max_x), can_be_cut(core.min_y, core.max_y))
    }
}

/// The first and last column and row of the cells of a segment's bounding box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellRange {
    columns: [u16; 2],
    rows: [u16; 2],
    /// Whether the range is too large for the segment to be in all of its cells.
    is_long: bool,
}

/// A division of an axis into equal intervals.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// Start and end of the contents.
    contents: [f64; 2],
    /// Start of the first interval, unless there is only one interval.
    begin: f64,
    count: u32,
    /// Intervals per unit of length; 0 if there is only one interval.
    per_unit: f64,
}

/// A grid of columns and rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    x: Axis,
    y: Axis,
}

impl Axis {
    fn new(contents: [f64; 2], [begin, end]: [f64; 2], count: u32) -> Self {
        let per_unit = if count > 1 {
            f64::from(count) / (end - begin)
        } else {
            0.0
        };
        Self {
            contents,
            begin,
            count,
            per_unit,
        }
    }

    /// Returns the interval of a coordinate that is shifted by `more` intervals, which may be
    /// negative.
    #[inline]
    fn interval(&self, coordinate: f64, more: f64) -> u32 {
        // A cast turns a negative number into 0.
        (((coordinate - self.begin) * self.per_unit + more) as u32).min(self.count - 1)
    }

    /// Returns a range that contains all coordinates of the contents in this interval, and a
    /// margin.
    fn range(&self, interval: u32) -> [f64; 2] {
        let [mut from, mut to] = self.contents;
        if interval > 0 {
            from = from.max(self.begin + (f64::from(interval) - MARGIN) / self.per_unit);
        }
        if interval + 1 < self.count {
            to = to.min(self.begin + (f64::from(interval + 1) + MARGIN) / self.per_unit);
        }
        [from, to]
    }

    /// Returns whether rounding moves a point on a line between these coordinates by less than the
    /// slack.
    fn resolves(&self, a: f64, b: f64) -> bool {
        error(a, b) * self.per_unit <= MOST_SLACK
    }

    /// Returns the intervals from `first` to `last` that a segment passes where its coordinate
    /// along the other axis is in `range`.
    ///
    /// The segment must not be parallel to this axis.
    fn passed(
        &self,
        [first, last]: [u32; 2],
        [a, b]: [f64; 2],
        other: [f64; 2],
        range: [f64; 2],
    ) -> RangeInclusive<u32> {
        let slope = (b - a) / (other[1] - other[0]);
        let [least, most] = in_order(other[0], other[1]);
        let [from, to] = range.map(|along| a + (along.max(least).min(most) - other[0]) * slope);
        let [from, to] = in_order(from, to);
        let error = 2.0 * error(a, b);
        if to + error < self.contents[0] || from - error > self.contents[1] {
            // An empty range.
            return RangeInclusive::new(1, 0);
        }
        let (from, to) = (self.interval(from, -MARGIN), self.interval(to, MARGIN));
        from.max(first)..=to.min(last)
    }
}

/// Returns a bound on the error of a computed point of a line between two coordinates. It also
/// bounds the rounding of an exact point. It is some units in the last place of the coordinates.
fn error(a: f64, b: f64) -> f64 {
    const FEW_UNITS: f64 = 1.0 / (1u64 << 48) as f64;
    (a.abs() + b.abs()) * FEW_UNITS
}

impl Grid {
    /// Makes a grid with a few segments in each cell, or with fewer cells if the segments are so
    /// long that they would be in too many. Also returns which fraction of all pairs of segments
    /// share a cell, summed over the cells. Returns `None` if the segments are too close together
    /// for any grid.
    ///
    /// Let w and h be the average width and height of the segments, as fractions of the grid's
    /// width and height. Then each segment is in about c = 1 + w · (columns - 1) + h · (rows - 1)
    /// cells. The numbers of columns and rows are such that c stays small, in the ratio that
    /// minimizes c. The pairs in all cells are then c² / cells of all pairs.
    pub(crate) fn new(extents: &Extents, count: usize) -> Option<(Self, f64)> {
        let (width, height) = extents.core.size();
        let cells = (count as f64 / PER_CELL).clamp(1.0, MOST_CELLS);
        // An extent far smaller than a cell makes no difference.
        let part = |mean: f64, length: f64| (mean / length).max(1.0 / cells);
        let (mut columns, mut rows) = match extents.can_be_cut() {
            (false, false) => return None,
            (true, false) => (cells, 1.0),
            (false, true) => (1.0, cells),
            (true, true) => {
                let ratio = (part(extents.height, height) / part(extents.width, width)).sqrt();
                let columns = (cells.sqrt() * ratio).clamp(1.0, cells);
                (columns, cells / columns)
            }
        };
        let copies = |columns: f64, rows: f64| {
            let more = |count: f64, mean: f64, length: f64| {
                if count > 1.0 {
                    part(mean, length) * (count - 1.0)
                } else {
                    0.0
                }
            };
            1.0 + more(columns, extents.width, width) + more(rows, extents.height, height)
        };
        while copies(columns, rows) > MOST_COPIES {
            (columns, rows) = ((columns * 0.8).max(1.0), (rows * 0.8).max(1.0));
        }
        let (columns, rows) = (columns.round(), rows.round());
        let pairs = copies(columns, rows).powi(2) / (columns * rows);
        Some((Self::of(extents, columns as u32, rows as u32), pairs))
    }

    /// Makes a grid with few cells. Returns `None` if the segments are too close together for any
    /// grid.
    pub(crate) fn coarse(extents: &Extents) -> Option<Self> {
        let count = |can_be_cut: bool| if can_be_cut { COARSE } else { 1 };
        let (x, y) = extents.can_be_cut();
        (x || y).then(|| Self::of(extents, count(x), count(y)))
    }

    fn of(extents: &Extents, columns: u32, rows: u32) -> Self {
        let (contents, core) = (extents.contents, extents.core);
        Self {
            x: Axis::new([contents.min_x, contents.max_x], [core.min_x, core.max_x], columns),
            y: Axis::new([contents.min_y, contents.max_y], [core.min_y, core.max_y], rows),
        }
    }

    /// Returns the number of cells.
    pub(crate) fn cells(&self) -> u32 {
        self.x.count * self.y.count
    }

    /// Returns the cell of a point.
    pub(crate) fn cell_of(&self, p: Point) -> u32 {
        self.y.interval(p.y, 0.0) * self.x.count + self.x.interval(p.x, 0.0)
    }

    /// Returns a rectangle that contains all points of the contents in this cell, and a margin.
    pub(crate) fn rect(&self, cell: u32) -> Rect {
        let [min_x, max_x] = self.x.range(cell % self.x.count);
        let [min_y, max_y] = self.y.range(cell / self.x.count);
        Rect::new(min_x, min_y, max_x, max_y)
    }

    /// Returns the cells of a segment's bounding box.
    #[inline]
    pub(crate) fn range(&self, [a, b]: [Point; 2]) -> CellRange {
        // There are at most 2^12 columns or rows.
        let columns = in_order(a.x, b.x).map(|x| self.x.interval(x, 0.0) as u16);
        let rows = in_order(a.y, b.y).map(|y| self.y.interval(y, 0.0) as u16);
        let is_long = columns[1] - columns[0] + (rows[1] - rows[0]) > 2;
        CellRange {
            columns,
            rows,
            is_long: is_long && self.x.resolves(a.x, b.x) && self.y.resolves(a.y, b.y),
        }
    }

    /// Visits the cells of a segment with this range.
    #[inline]
    pub(crate) fn visit(&self, range: CellRange, ends: impl FnOnce() -> [Point; 2], mut visit: impl FnMut(u32)) {
        let [columns, rows] = [range.columns, range.rows].map(|range| range.map(u32::from));
        if range.is_long {
            return self.visit_along(ends(), [columns, rows], visit);
        }
        for row in rows[0]..=rows[1] {
            for column in columns[0]..=columns[1] {
                visit(row * self.x.count + column);
            }
        }
    }

    /// Visits the cells that the segment may pass, along the axis on which it passes more of them.
    #[inline(never)]
    fn visit_along(&self, [a, b]: [Point; 2], [columns, rows]: [[u32; 2]; 2], mut visit: impl FnMut(u32)) {
        if rows[1] - rows[0] >= columns[1] - columns[0] {
            for row in rows[0]..=rows[1] {
                let its = self.x.passed(columns, [a.x, b.x], [a.y, b.y], self.y.range(row));
                its.for_each(|column| visit(row * self.x.count + column));
            }
        } else {
            for column in columns[0]..=columns[1] {
                let its = self.y.passed(rows, [a.y, b.y], [a.x, b.x], self.x.range(column));
                its.for_each(|row| visit(row * self.x.count + column));
            }
        }
    }
}
