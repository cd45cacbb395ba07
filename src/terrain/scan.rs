//! The cells whose centres a triangle contains.
//!
//! In: a facet and a window of a grid. Out: each centre in the closed triangle, once, with its exact
//! place: inside, on an edge or on a corner.

use std::ops::Range;

use super::facet::{Facet, Place};
use super::grid::Window;
use crate::geometry::{Orientation, Point, Rect, orient2d};

/// Rows with more candidates than this are not tested cell by cell.
const FEW: usize = 4;

/// Calls `hit` with the column, the row, the centre and its place for each centre in the triangle.
pub(crate) fn scan(facet: &Facet, window: &Window, mut hit: impl FnMut(usize, usize, Point, Place)) {
    let corners = facet.corners().map(|corner| corner.point);
    let around = Rect::around(corners);
    let columns = window.columns_in(around.min_x, around.max_x);
    if columns.is_empty() {
        return;
    }
    for row in window.rows_in(around.min_y, around.max_y) {
        let y = window.centre(0, row).y;
        // A row along an edge has many centres on it.
        let is_level = (0..3).any(|i| corners[i].y == y && corners[(i + 1) % 3].y == y);
        let mut test = |column| {
            let centre = window.centre(column, row);
            if let Some(place) = facet.place(centre) {
                hit(column, row, centre, place);
            }
        };
        if columns.len() <= FEW || is_level {
            columns.clone().for_each(test);
            continue;
        }
        let inside = columns_inside(&corners, window, row, columns.clone());
        if inside.len() <= 2 {
            inside.for_each(test);
            continue;
        }
        test(inside.start);
        test(inside.end - 1);
        for column in inside.start + 1..inside.end - 1 {
            hit(column, row, window.centre(column, row), Place::Inside);
        }
    }
}

/// Returns the columns of `within` whose centres in a row are in the closed triangle. No edge of it
/// lies along the row. Exact.
fn columns_inside(corners: &[Point; 3], window: &Window, row: usize, within: Range<usize>) -> Range<usize> {
    let Range { mut start, mut end } = within;
    let y = window.centre(0, row).y;
    for i in 0..3 {
        let (from, to) = (corners[i], corners[(i + 1) % 3]);
        if from.y == to.y {
            continue;
        }
        let is_outside = |column: usize| orient2d(from, to, window.centre(column, row)) == Orientation::Clockwise;
        let crossing = from.x + (y - from.y) * ((to.x - from.x) / (to.y - from.y));
        let estimate = window.column_from(crossing).clamp(start, end.max(start));
        let mut bound = estimate;
        if to.y < from.y {
            // The triangle is on the right of an edge that goes down.
            while bound > start && !is_outside(bound - 1) {
                bound -= 1;
            }
            while bound < end && is_outside(bound) {
                bound += 1;
            }
            start = bound;
        } else {
            while bound < end && !is_outside(bound) {
                bound += 1;
            }
            while bound > start && is_outside(bound - 1) {
                bound -= 1;
            }
            end = bound;
        }
    }
    start..end.max(start)
}

#[cfg(test)]
mod tests {
    use super::super::facet::Corner;
    use super::super::grid::Grid;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]
        /// Half of the coordinates are those of centres or of corners of cells, for ties.
        #[test]
        fn a_scan_finds_what_a_test_of_each_cell_finds(
            xy in prop::array::uniform6(prop_oneof![(0..61u32).prop_map(|v| f64::from(v) / 2.0), 0.0..30.0]),
            left in 0..8u32,
        ) {
            let point = |i: usize| Point::new(xy[2 * i], xy[2 * i + 1]);
            let mut points = [point(0), point(1), point(2)];
            match orient2d(points[0], points[1], points[2]) {
                Orientation::Collinear => return Ok(()),
                Orientation::Clockwise => points.swap(1, 2),
                Orientation::CounterClockwise => {}
            }
            let facet = Facet::new(points.map(|point| Corner { point, z: 0.0 }));
            let grid = Grid::starting_at(Rect::new(0.0, 0.0, 30.0, 30.0), 1.0).unwrap();
            let window = Window::new(&grid, left..28, 1..29);
            let mut found = Vec::new();
            scan(&facet, &window, |column, row, centre, place| {
                assert_eq!(centre, window.centre(column, row));
                found.push((row, column, place));
            });
            found.sort_by_key(|&(row, column, _)| (row, column));
            let all = (0..window.rows()).flat_map(|row| (0..window.columns()).map(move |column| (row, column)));
            let expected: Vec<_> = all
                .filter_map(|(row, column)| Some((row, column, facet.place(window.centre(column, row))?)))
                .collect();
            prop_assert_eq!(found, expected);
        }
    }
}
