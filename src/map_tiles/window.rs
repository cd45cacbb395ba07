//! A map tile with a margin, in whole units, and what of the plane is in it.
//!
//! A tile is 4096 units wide, 16 for each pixel. A point is rounded once, to a unit of the whole
//! zoom, so all tiles round it alike, and shapes that share corners share them after rounding too.

use crate::geometry::{Point, Rect};
use crate::map_tiles::coord::TileCoord;
use crate::map_tiles::grid::{PIXELS, TileGrid};

/// The number of units along a side of a tile.
pub(super) const EXTENT: u32 = 4096;
/// The number of units along a side of a pixel.
pub(super) const PER_PIXEL: i32 = (EXTENT / PIXELS) as i32;
/// Segments that become curves are divided until they are so many units long.
const STRAIGHT: i64 = 512;
/// A segment is divided at most so many times.
const DEPTH: u32 = 24;

/// A position in units of a tile, y downwards.
pub(super) type Unit = [i32; 2];
/// A position in units that may be far outside of the tile.
pub(super) type Far = [i64; 2];

/// A map tile with a margin.
#[derive(Clone)]
pub(super) struct Window {
    grid: TileGrid,
    at: TileCoord,
    margin: i64,
    /// A rectangle of the file around the window.
    rect: Rect,
}

impl Window {
    /// Creates the window of a tile with a margin of so many units.
    pub(super) fn new(grid: &TileGrid, at: TileCoord, margin: i32) -> Self {
        let pixels = f64::from(margin) / f64::from(PER_PIXEL) + 1.0;
        Self {
            rect: grid.rect_of(at, pixels),
            grid: grid.clone(),
            at,
            margin: margin.into(),
        }
    }

    /// Returns a rectangle of the file that contains all of its points in the window.
    pub(super) fn rect(&self) -> Rect {
        self.rect
    }

    /// Returns the position of a point of the file. `None` if it has no place in the grid, or one
    /// that is very far away.
    pub(super) fn units(&self, p: Point) -> Option<Far> {
        let all = f64::from(EXTENT) * f64::from(1u32 << self.at.z());
        let numbers = [self.at.x(), self.at.y()];
        let [x, y] = self.grid.fraction(p)?;
        let near = |v: f64| v.abs() < 64.0;
        (near(x) && near(y)).then(|| {
            let unit = |v: f64, number: u32| (v * all).round() as i64 - i64::from(number) * i64::from(EXTENT);
            [unit(x, numbers[0]), unit(y, numbers[1])]
        })
    }

    /// Returns the position of a point, if it is in the window.
    pub(super) fn inside(&self, p: Point) -> Option<Unit> {
        let range = self.range();
        self.units(p)
            .filter(|at| at.iter().all(|v| range.contains(v)))
            .map(|at| at.map(|v| v as i32))
    }

    fn range(&self) -> std::ops::RangeInclusive<i64> {
        -self.margin..=i64::from(EXTENT) + self.margin
    }

    /// Returns whether the bounds of positions meet the window.
    pub(super) fn meets(&self, positions: &[Far]) -> bool {
        (0..2).all(|axis| {
            let values = || positions.iter().map(|at| at[axis]);
            let range = self.range();
            values().max().is_some_and(|most| most >= *range.start())
                && values().min().is_some_and(|least| least <= *range.end())
        })
    }

    /// Passes the parts of a segment in the window to `take`. Where segments of the file are curves
    /// in the grid, the segment is divided.
    pub(super) fn curve(&self, ends: [Point; 2], take: &mut impl FnMut([Unit; 2])) {
        if !Rect::around(ends).intersects(self.rect) {
            return;
        }
        let [Some(a), Some(b)] = ends.map(|end| self.units(end)) else {
            return;
        };
        let depth = if self.grid.is_straight() { 0 } else { DEPTH };
        self.divide(ends, [a, b], depth, take);
    }

    /// Passes the part of a segment in the window to `take`. The segment is straight in the grid.
    pub(super) fn line(&self, ends: [Point; 2], take: &mut impl FnMut([Unit; 2])) {
        if !Rect::around(ends).intersects(self.rect) {
            return;
        }
        if let [Some(a), Some(b)] = ends.map(|end| self.units(end))
            && let Some(part) = self.clip([a, b])
        {
            take(part);
        }
    }

    fn divide(&self, ends: [Point; 2], units: [Far; 2], depth: u32, take: &mut impl FnMut([Unit; 2])) {
        let [a, b] = units;
        let length = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
        if depth == 0 || length <= STRAIGHT {
            if let Some(part) = self.clip(units) {
                take(part);
            }
            return;
        }
        // A curve stays near its ends.
        let far = length / 4;
        let least = [a[0].min(b[0]) - far, a[1].min(b[1]) - far];
        let most = [a[0].max(b[0]) + far, a[1].max(b[1]) + far];
        if !self.meets(&[least, most]) {
            return;
        }
        let middle = |a: f64, b: f64| a + (b - a) / 2.0;
        let m = Point::new(middle(ends[0].x, ends[1].x), middle(ends[0].y, ends[1].y));
        if let Some(at) = self.units(m) {
            self.divide([ends[0], m], [a, at], depth - 1, take);
            self.divide([m, ends[1]], [at, b], depth - 1, take);
        }
    }

    /// Returns the part of a segment in the window, if it is longer than nothing.
    pub(super) fn clip(&self, mut units: [Far; 2]) -> Option<[Unit; 2]> {
        let range = self.range();
        for axis in 0..2 {
            for (side, is_least) in [(*range.start(), true), (*range.end(), false)] {
                let is_out = |v: i64| if is_least { v < side } else { v > side };
                match units.map(|at| is_out(at[axis])) {
                    [true, true] => return None,
                    [false, false] => {}
                    [true, false] => units[0] = cross(units, axis, side),
                    [false, true] => units[1] = cross(units, axis, side),
                }
            }
        }
        (units[0] != units[1]).then(|| units.map(|at| at.map(|v| v as i32)))
    }

    /// Returns the part of a convex polygon in the window, with the same orientation; without
    /// corners if there is none. Polygons that share an edge share what is left of it.
    pub(super) fn clip_polygon(&self, corners: &[Far]) -> Vec<Unit> {
        let range = self.range();
        let mut corners = corners.to_vec();
        let is_in = |at: &Far| at.iter().all(|v| range.contains(v));
        if !corners.iter().all(is_in) {
            for axis in 0..2 {
                for (side, is_least) in [(*range.start(), true), (*range.end(), false)] {
                    corners = cut(&corners, axis, side, is_least);
                }
            }
        }
        let mut units: Vec<Unit> = corners.iter().map(|at| at.map(|v| v as i32)).collect();
        units.dedup();
        if units.len() > 1 && units.first() == units.last() {
            units.pop();
        }
        units
    }
}

/// Returns the part of a convex polygon on one side of a line along an axis.
fn cut(corners: &[Far], axis: usize, side: i64, is_least: bool) -> Vec<Far> {
    let is_out = |at: Far| if is_least { at[axis] < side } else { at[axis] > side };
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (i, &from) in corners.iter().enumerate() {
        let to = corners[(i + 1) % corners.len()];
        if !is_out(from) {
            kept.push(from);
        }
        if is_out(from) != is_out(to) {
            kept.push(cross([from, to], axis, side));
        }
    }
    kept
}

/// Returns where a segment crosses a line along an axis, the same for both directions of the
/// segment.
fn cross(mut ends: [Far; 2], axis: usize, side: i64) -> Far {
    ends.sort_unstable();
    let [a, b] = ends.map(|end| end.map(i128::from));
    let other = 1 - axis;
    let (length, part) = (b[axis] - a[axis], i128::from(side) - a[axis]);
    // Rounded to the nearest unit, upwards if there are two.
    let moved = (2 * (b[other] - a[other]) * part + length).div_euclid(2 * length);
    let mut at = [side; 2];
    at[other] = (a[other] + moved) as i64;
    at
}

/// Returns twice the area of a polygon: positive if it is clockwise on a screen, as the exterior
/// rings of vector tiles are.
pub(super) fn doubled_area(corners: &[Unit]) -> i64 {
    let next = corners.iter().cycle().skip(1);
    let wide = |v: i32| i64::from(v);
    corners
        .iter()
        .zip(next)
        .map(|(a, b)| wide(a[0]) * wide(b[1]) - wide(b[0]) * wide(a[1]))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The only tile of zoom 0, over a square of 4096 by 4096.
    fn window(margin: i32) -> Window {
        let grid = TileGrid::native(Rect::new(0.0, 0.0, 4096.0, 4096.0), 1.0, None).unwrap();
        Window::new(&grid, TileCoord::new(0, 0, 0).unwrap(), margin)
    }

    #[test]
    fn a_point_has_the_same_place_in_all_tiles() {
        let grid = TileGrid::native(Rect::new(0.0, 0.0, 64.0, 64.0), 1.0, None).unwrap();
        let p = Point::new(32.0, 21.123);
        let [west, east] = [3, 4].map(|x| Window::new(&grid, TileCoord::new(3, x, 5).unwrap(), 64));
        let (a, b) = (west.units(p).unwrap(), east.units(p).unwrap());
        assert_eq!(a, [b[0] + 4096, b[1]]);
        assert!(west.inside(p).is_some() && east.inside(p).is_some());
    }

    #[test]
    fn what_is_left_of_a_shared_edge_is_shared() {
        let window = window(64);
        let (a, b) = ([-5000, 1234], [9000, 4321]);
        let above = window.clip_polygon(&[a, b, [2000, -7777]]);
        let below = window.clip_polygon(&[b, a, [2000, 9999]]);
        let shared = above.iter().filter(|corner| below.contains(corner)).count();
        assert_eq!(shared, 2, "{above:?} {below:?}");
        let line = window.clip([a, b]).unwrap();
        assert!(line.iter().all(|end| above.contains(end)));
        assert_eq!(window.clip([b, a]).unwrap(), [line[1], line[0]]);
        assert_eq!(window.clip([[-5000, 0], [-4000, 9]]), None);
    }

    #[test]
    fn clipping_keeps_the_orientation_and_the_area() {
        let window = window(0);
        let corners = window.clip_polygon(&[[-4096, 0], [4096, 0], [4096, 8192]]);
        // A triangle of half the size is cut off in the west, and one below.
        assert_eq!(doubled_area(&corners), 2 * 4096 * 4096);
        assert!(doubled_area(&[[0, 0], [1, 0], [1, 1]]) > 0);
        assert!(window.clip_polygon(&[[-9, -9], [-1, -9], [-1, -1]]).is_empty());
    }
}
