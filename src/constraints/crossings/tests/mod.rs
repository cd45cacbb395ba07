//! Tests of crossings against brute force: the predicate on all pairs.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use proptest::prelude::*;

use crate::constraints::crossings::boxes::bounds;
use crate::constraints::crossings::find::find;
use crate::constraints::crossings::search::search;
use crate::geometry::{Orientation, Point, Rect, crossing_point, orient2d};

mod shapes;
mod splitting;

/// The pairs that cross, the smaller number first, and the bits of their crossing points.
type Crossings = BTreeMap<[u32; 2], [u64; 2]>;

fn bits(p: Point) -> [u64; 2] {
    [p.x.to_bits(), p.y.to_bits()]
}

fn point([x, y]: [i32; 2]) -> Point {
    Point::new(x.into(), y.into())
}

/// Returns the pairs that are found in a cell. Asserts that each is found once.
fn found_in(segments: &[[Point; 2]], cell: Rect) -> Crossings {
    let mut all = Crossings::new();
    let done = find(segments, cell, &mut |one, other, point| {
        let before = all.insert([one.min(other), one.max(other)], bits(point));
        assert_eq!(before, None, "{one} and {other} are found twice");
        ControlFlow::Continue(())
    });
    assert!(done.is_continue());
    all
}

/// Returns all pairs that cross, searched from left to right.
fn by_brute_force(segments: &[[Point; 2]]) -> Crossings {
    let mut order: Vec<(Rect, u32)> = segments.iter().map(|&segment| bounds(segment)).zip(0..).collect();
    order.sort_by(|a, b| a.0.min_x.total_cmp(&b.0.min_x));
    let mut all = Crossings::new();
    for (position, &(one, i)) in order.iter().enumerate() {
        for &(other, j) in order[position + 1..]
            .iter()
            .take_while(|(other, _)| other.min_x <= one.max_x)
        {
            let ([a, b], [c, d]) = (segments[i as usize], segments[j as usize]);
            if one.intersects(other)
                && let Some(point) = crossing_point(a, b, c, d)
            {
                all.insert([i.min(j), i.max(j)], bits(point));
            }
        }
    }
    all
}

fn check(segments: &[[Point; 2]]) {
    assert_eq!(found_in(segments, Rect::PLANE), by_brute_force(segments));
}

/// Returns whether a segment meets a closed cell with finite sides.
fn meets([a, b]: [Point; 2], cell: Rect) -> bool {
    let corners = [
        Point::new(cell.min_x, cell.min_y),
        Point::new(cell.max_x, cell.min_y),
        Point::new(cell.max_x, cell.max_y),
        Point::new(cell.min_x, cell.max_y),
    ];
    let sides = corners.map(|corner| orient2d(a, b, corner));
    let is_aside = a != b && sides[0] != Orientation::Collinear && sides.iter().all(|side| *side == sides[0]);
    bounds([a, b]).intersects(cell) && !is_aside
}

/// Cuts a cell recursively. Returns the resulting cells.
fn cut(cell: Rect, cuts: &[(bool, Point)]) -> Vec<Rect> {
    let Some((&(by_x, at), cuts)) = cuts.split_first() else {
        return vec![cell];
    };
    let (low, high) = if by_x {
        (Rect { max_x: at.x, ..cell }, Rect { min_x: at.x, ..cell })
    } else {
        (Rect { max_y: at.y, ..cell }, Rect { min_y: at.y, ..cell })
    };
    if low.is_empty() || high.is_empty() || low == cell || high == cell {
        return self::cut(cell, cuts);
    }
    let (one, other) = cuts.split_at(cuts.len() / 2);
    [self::cut(low, one), self::cut(high, other)].concat()
}

/// Checks that each pair is found in one cell if a cell is given only the segments that meet it.
/// Cuts pass through ends and through rounded crossing points, which may be on the other side of a
/// cut than the exact ones.
fn check_cells(segments: &[[Point; 2]], cuts: &[(bool, usize)]) {
    let all = by_brute_force(segments);
    let mut points: Vec<Point> = segments.iter().flatten().copied().collect();
    points.extend(
        all.values()
            .map(|&[x, y]| Point::new(f64::from_bits(x), f64::from_bits(y))),
    );
    let cuts: Vec<(bool, Point)> = cuts
        .iter()
        .map(|&(by_x, at)| (by_x, points[at % points.len()]))
        .collect();
    let far = 1e9;
    let mut sum = Crossings::new();
    for cell in cut(Rect::new(-far, -far, far, far), &cuts) {
        let its: Vec<u32> = (0..)
            .zip(segments)
            .filter(|(_, s)| meets(**s, cell))
            .map(|(i, _)| i)
            .collect();
        let of_cell: Vec<[Point; 2]> = its.iter().map(|&i| segments[i as usize]).collect();
        for ([i, j], point) in found_in(&of_cell, cell) {
            let before = sum.insert([its[i as usize], its[j as usize]], point);
            assert_eq!(before, None, "found in two cells");
        }
    }
    assert_eq!(sum, all);
}

fn small() -> impl Strategy<Value = [Point; 2]> {
    prop::array::uniform2(prop::array::uniform2(0..10).prop_map(point))
}

fn float() -> impl Strategy<Value = [Point; 2]> {
    prop::array::uniform2((-1.0..1.0, -1.0..1.0).prop_map(|(x, y)| Point::new(x, y)))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn crossings_of_few_segments_on_a_grid_equal_brute_force(segments in prop::collection::vec(small(), 0..60)) {
        check(&segments);
    }

    #[test]
    fn crossings_of_few_float_segments_equal_brute_force(segments in prop::collection::vec(float(), 0..60)) {
        check(&segments);
    }

    #[test]
    fn every_pair_is_found_in_one_cell(
        segments in prop::collection::vec(small(), 2..40),
        cuts in prop::collection::vec((any::<bool>(), any::<usize>()), 0..12),
    ) {
        check_cells(&segments, &cuts);
    }

    #[test]
    fn every_pair_of_floats_is_found_in_one_cell(
        segments in prop::collection::vec(float(), 2..30),
        cuts in prop::collection::vec((any::<bool>(), any::<usize>()), 0..12),
    ) {
        check_cells(&segments, &cuts);
    }
}

#[test]
fn the_callback_can_stop_the_search() {
    let comb: Vec<[Point; 2]> = (0..300).map(|i| [point([i, 0]), point([i, 9])]).collect();
    let mut segments = comb.clone();
    segments.extend((0..300).map(|i| [Point::new(-1.0, f64::from(i) / 50.0 + 1.0), Point::new(300.0, 2.0)]));
    for limit in [1, 2, 1000] {
        let mut count = 0;
        let done = find(&segments, Rect::PLANE, &mut |_, _, _| {
            count += 1;
            if count == limit {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        assert_eq!((done, count), (ControlFlow::Break(()), limit));
    }
}
