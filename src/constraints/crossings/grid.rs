//! A grid over a set of segments, and the cells that each may pass.
//!
//! Points go to cells by a function of each coordinate that is monotonic, so that every point has a cell, and the cells of
//! the points of a rectangle are a rectangle of cells. What is beyond the grid belongs to its outermost cells. A segment goes
//! to the cells of its bounding box, if these are few, or else, row by row or column by column, to those about its line:
//! perhaps more than it passes, and at least that of each of its points within the contents, rounded to coordinates or not.

use std::ops::RangeInclusive;

use crate::constraints::crossings::boxes::{bounds, common, in_order};
use crate::geometry::{Point, Rect};

/// The most cells of a grid: what is distributed to them is written in as many places at once.
const MOST_CELLS: f64 = 4096.0;

/// Segments in a cell, if each were in one.
const PER_CELL: f64 = 12.0;

/// Cells in which a segment may be on average.
const MOST_COPIES: f64 = 3.0;

/// Columns and rows of a grid that is to part what is long.
const COARSE: u32 = 6;

/// Part of the largest coordinate that the grid must exceed in width to be cut: 2⁻³⁰. With at most 2¹² columns each is then
/// wider than 2¹⁰ units in the last place.
const RESOLUTION: f64 = 1.0 / (1u64 << 30) as f64;

/// Part of a cell by which rounding may move a line, at most: otherwise it goes to all cells of its bounding box.
const MOST_SLACK: f64 = 1.0 / 16.0;

/// Part of a cell that is added on each side: twice the slack, for the error of the line and that of the point on it.
const MARGIN: f64 = 2.0 * MOST_SLACK;

/// Where the segments of a bucket are in its rectangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extents {
    /// A rectangle around all.
    pub(crate) contents: Rect,
    /// A rectangle around most: what the grid is to part.
    pub(crate) core: Rect,
    /// Their width and height within the core, on average.
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Extents {
    /// Looks at segments, some of which may not be in the rectangle. The core is shrunk to the contents.
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

    /// Whether columns and rows can be told apart.
    fn can_be_cut(&self) -> (bool, bool) {
        let can_be_cut = |low: f64, high: f64| high - low > low.abs().max(high.abs()) * RESOLUTION;
        let core = self.core;
        (can_be_cut(core.min_x, core.max_x), can_be_cut(core.min_y, core.max_y))
    }
}

/// The cells of a segment's bounding box: the first and the last column and row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellRange {
    columns: [u16; 2],
    rows: [u16; 2],
    /// Whether it is too large for all of them to be the segment's.
    is_long: bool,
}

/// Equal intervals of an axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// Where the contents begin and end.
    contents: [f64; 2],
    /// Where the first interval begins, unless there is only one.
    begin: f64,
    count: u32,
    /// Intervals per unit of length; 0 if there is only one.
    per_unit: f64,
}

/// Columns and rows.
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

    /// The interval of a coordinate. More or less may be added, in intervals.
    #[inline]
    fn interval(&self, coordinate: f64, more: f64) -> u32 {
        // A cast of what is negative is 0.
        (((coordinate - self.begin) * self.per_unit + more) as u32).min(self.count - 1)
    }

    /// A range that has all coordinates of the contents whose interval it is, and some more.
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

    /// Whether rounding moves a point on a line between these coordinates by less than the slack.
    fn resolves(&self, a: f64, b: f64) -> bool {
        error(a, b) * self.per_unit <= MOST_SLACK
    }

    /// The intervals between these that a segment passes where its coordinate along the other axis is in a range.
    ///
    /// The segment is not level with this axis.
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
            // None.
            return RangeInclusive::new(1, 0);
        }
        let (from, to) = (self.interval(from, -MARGIN), self.interval(to, MARGIN));
        from.max(first)..=to.min(last)
    }
}

/// More than the error of a computed point of a line between two coordinates, and more than the rounding of an exact one: some
/// units in their last place.
fn error(a: f64, b: f64) -> f64 {
    const FEW_UNITS: f64 = 1.0 / (1u64 << 48) as f64;
    (a.abs() + b.abs()) * FEW_UNITS
}

impl Grid {
    /// A grid with a few segments in each cell, unless they are so long that they would be in too many, and what part of all
    /// pairs of segments are together in a cell, summed up over the cells. None if the segments are too close together for
    /// any grid.
    ///
    /// Segments whose width is the part w of the grid's, and whose height is the part h, on average, are each in about
    /// c = 1 + w · (columns - 1) + h · (rows - 1) cells. So there are as many columns and rows as keep c small, in the ratio
    /// that makes it smallest. The pairs in all cells are then c² / cells of all pairs.
    pub(crate) fn new(extents: &Extents, count: usize) -> Option<(Self, f64)> {
        let (width, height) = extents.core.size();
        let cells = (count as f64 / PER_CELL).clamp(1.0, MOST_CELLS);
        // What is far smaller than a cell makes no difference.
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

    /// A grid with few cells. None if the segments are too close together for any.
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

    /// How many cells there are.
    pub(crate) fn cells(&self) -> u32 {
        self.x.count * self.y.count
    }

    /// The cell of a point.
    pub(crate) fn cell_of(&self, p: Point) -> u32 {
        self.y.interval(p.y, 0.0) * self.x.count + self.x.interval(p.x, 0.0)
    }

    /// A rectangle that has all points of the contents whose cell it is, and some more.
    pub(crate) fn rect(&self, cell: u32) -> Rect {
        let [min_x, max_x] = self.x.range(cell % self.x.count);
        let [min_y, max_y] = self.y.range(cell / self.x.count);
        Rect::new(min_x, min_y, max_x, max_y)
    }

    /// The cells of a segment's bounding box.
    #[inline]
    pub(crate) fn range(&self, [a, b]: [Point; 2]) -> CellRange {
        // There are at most 2^12.
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

    /// Visits those cells that the segment may pass, along the axis in which it passes more.
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
