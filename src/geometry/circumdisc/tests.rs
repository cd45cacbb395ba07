use proptest::prelude::*;
use proptest::strategy::ValueTree;

use crate::geometry::circumdisc::*;
use crate::geometry::oracle;
use crate::geometry::predicates::{Orientation, orient2d};

/// Returns the corners in counter-clockwise order, or `None` if they are collinear.
fn counter_clockwise([a, b, c]: [Point; 3]) -> Option<[Point; 3]> {
    match orient2d(a, b, c) {
        Orientation::CounterClockwise => Some([a, b, c]),
        Orientation::Collinear => None,
        Orientation::Clockwise => Some([a, c, b]),
    }
}

/// Returns the centre and the radius, rounded.
fn circumcircle([a, b, c]: [Point; 3]) -> (Point, f64) {
    let (ux, uy, vx, vy) = (b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y);
    let d = 2.0 * (ux * vy - uy * vx);
    let (uu, vv) = (ux * ux + uy * uy, vx * vx + vy * vy);
    let (x, y) = ((vy * uu - uy * vv) / d, (ux * vv - vx * uu) / d);
    (Point::new(a.x + x, a.y + y), x.hypot(y))
}

/// Returns the bounding square of the disc, grown by `margin` radii, with its sides moved by
/// `nudges` units in the last place.
fn cell_around(triangle: [Point; 3], margin: f64, nudges: [i32; 4]) -> Rect {
    let (centre, radius) = circumcircle(triangle);
    let reach = radius * (1.0 + margin);
    let nudged =
        |v: f64, steps: i32| (0..steps.abs()).fold(v, |v, _| if steps < 0 { v.next_down() } else { v.next_up() });
    Rect::new(
        nudged(centre.x - reach, nudges[0]),
        nudged(centre.y - reach, nudges[1]),
        nudged(centre.x + reach, nudges[2]),
        nudged(centre.y + reach, nudges[3]),
    )
}

fn has_numbers(cell: Rect) -> bool {
    [cell.min_x, cell.min_y, cell.max_x, cell.max_y]
        .iter()
        .all(|side| !side.is_nan())
}

/// Asserts that the certificate of each rotation is sound, for the cell and for each of its
/// half-planes.
fn assert_sound([a, b, c]: [Point; 3], cell: Rect) {
    let far = Rect::PLANE;
    for cell in [
        cell,
        Rect {
            min_x: cell.min_x,
            ..far
        },
        Rect {
            min_y: cell.min_y,
            ..far
        },
        Rect {
            max_x: cell.max_x,
            ..far
        },
        Rect {
            max_y: cell.max_y,
            ..far
        },
    ] {
        let truth = oracle::disc_strictly_inside(a, b, c, cell);
        for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
            assert!(
                truth || !disc_strictly_inside(a, b, c, cell),
                "{a:?} {b:?} {c:?} {cell:?}"
            );
        }
    }
}

fn three(coordinate: impl Strategy<Value = f64> + Clone) -> impl Strategy<Value = [Point; 3]> {
    let point = (coordinate.clone(), coordinate).prop_map(|(x, y)| Point::new(x, y).normalized());
    prop::array::uniform3(point)
}

fn coordinates() -> impl Strategy<Value = [Point; 3]> {
    let mixed = (-10.0..10.0, -30..=30).prop_map(|(m, e): (f64, i32)| m * 10f64.powi(e));
    let extreme = prop::sample::select(vec![
        0.0,
        Point::MIN_MAGNITUDE,
        Point::MIN_MAGNITUDE.next_up(),
        -Point::MIN_MAGNITUDE,
        1.0,
        Point::MAX_MAGNITUDE,
        -Point::MAX_MAGNITUDE,
        Point::MAX_MAGNITUDE.next_down(),
    ]);
    prop_oneof![
        three((-6..=6).prop_map(f64::from)),
        three(-1.0..1.0),
        three((0..1000).prop_map(|i| 1e6 + f64::from(i) * 1e-3)),
        three(mixed),
        three(extreme),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 10_000, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn the_certificate_is_sound_for_nearly_touching_discs(
        corners in coordinates(),
        nudges in prop::array::uniform4(-3..=3),
        margin in prop_oneof![Just(0.0), -1e-14..1e-14, -1e-8..1e-8, -1.0..2.0],
    ) {
        if let Some(triangle) = counter_clockwise(corners) {
            let cell = cell_around(triangle, margin, nudges);
            if has_numbers(cell) {
                assert_sound(triangle, cell);
            }
        }
    }

    /// Flat triangles: the determinant is mostly rounding error, and the disc is huge.
    #[test]
    fn the_certificate_is_sound_for_slivers(
        corners in three(-1.0..1.0),
        t in -1.0..2.0,
        offset in -1e-15..1e-15,
        margin in prop_oneof![Just(0.0), -1e-3..1e-3, -1.0..10.0],
    ) {
        let [a, b, _] = corners;
        let c = Point::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y) + offset);
        if let Some(triangle) = counter_clockwise([a, b, c]) {
            let cell = cell_around(triangle, margin, [0; 4]);
            if has_numbers(cell) {
                assert_sound(triangle, cell);
            }
        }
    }

    /// Discs with a known integer bounding box: the points (3, 4), (-4, 3) and (4, -3) are on a
    /// circle of radius 5.
    #[test]
    fn a_touching_disc_is_not_certified(x in -1000..1000, y in -1000..1000, side in 0..4usize) {
        let at = |dx: i32, dy: i32| Point::new(f64::from(x + dx), f64::from(y + dy));
        let triangle = [at(3, 4), at(-4, 3), at(4, -3)];
        let by = |grow: f64| {
            let (low, high) = (at(-5, -5), at(5, 5));
            Rect::new(low.x - grow, low.y - grow, high.x + grow, high.y + grow)
        };
        let [a, b, c] = triangle;
        prop_assert!(!disc_strictly_inside(a, b, c, by(0.0)));
        prop_assert!(disc_strictly_inside(a, b, c, by(1e-11)));
        let mut cell = by(1.0);
        *[&mut cell.min_x, &mut cell.min_y, &mut cell.max_x, &mut cell.max_y][side] =
            [by(0.0).min_x, by(0.0).min_y, by(0.0).max_x, by(0.0).max_y][side];
        prop_assert!(!disc_strictly_inside(a, b, c, cell));
    }
}

/// Returns the share of certified triangles among those whose disc is inside by `margin` radii.
fn share_certified(corners: impl Strategy<Value = [Point; 3]>, margin: f64) -> f64 {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let (mut inside, mut certified) = (0, 0);
    while inside < 20_000 {
        let corners = corners.new_tree(&mut runner).unwrap().current();
        let Some([a, b, c]) = counter_clockwise(corners) else {
            continue;
        };
        let cell = cell_around([a, b, c], margin, [0; 4]);
        if oracle::disc_strictly_inside(a, b, c, cell) {
            inside += 1;
            certified += i32::from(disc_strictly_inside(a, b, c, cell));
        }
    }
    f64::from(certified) / f64::from(inside)
}

#[test]
fn nearly_every_disc_inside_is_certified() {
    let uniform = share_certified(three(-1.0..1.0), 1e-9);
    assert!(uniform > 0.999, "uniform: {uniform}");
    let offset = share_certified(three((0..1000).prop_map(|i| 1e6 + f64::from(i) * 1e-3)), 1e-6);
    assert!(offset > 0.999, "offset: {offset}");
    let grid = share_certified(three((0..10).prop_map(f64::from)), 1e-12);
    assert!(grid > 0.999, "grid: {grid}");
}

/// Small and large triangles within the limits are certified like others: nothing underflows or
/// overflows.
#[test]
fn triangles_at_the_limits_are_certified() {
    let corners = [(1.0, 1.0), (2.0, 1.0), (1.5, 1.75)];
    for unit in [Point::MIN_MAGNITUDE, 1.0, Point::MAX_MAGNITUDE / 4.0] {
        let [a, b, c] = corners.map(|(x, y)| Point::new(x * unit, y * unit));
        assert!(disc_strictly_inside(a, b, c, cell_around([a, b, c], 1e-9, [0; 4])));
        assert!(!disc_strictly_inside(a, b, c, cell_around([a, b, c], -1e-9, [0; 4])));
    }
}

#[test]
fn sides_at_infinity_are_not_tested() {
    let [a, b, c] = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| Point::new(x, y));
    assert!(disc_strictly_inside(a, b, c, Rect::PLANE));
    assert!(disc_strictly_inside(
        a,
        b,
        c,
        Rect {
            max_x: 1.3,
            ..Rect::PLANE
        }
    ));
    assert!(!disc_strictly_inside(
        a,
        b,
        c,
        Rect {
            max_x: 1.2,
            ..Rect::PLANE
        }
    ));
    assert!(!disc_strictly_inside(a, b, c, Rect::EMPTY));
    assert!(
        !disc_strictly_inside(
            a,
            c,
            b,
            Rect {
                max_x: 1e9,
                ..Rect::PLANE
            }
        ),
        "clockwise"
    );
    assert!(
        !disc_strictly_inside(
            a,
            b,
            b,
            Rect {
                max_x: 1e9,
                ..Rect::PLANE
            }
        ),
        "no triangle"
    );
}

#[test]
fn invalid_numbers_are_not_certified() {
    let [a, b, c] = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| Point::new(x, y));
    let cell = Rect::new(-9.0, -9.0, 9.0, f64::INFINITY);
    assert!(disc_strictly_inside(a, b, c, cell));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
        for p in [Point::new(bad, 0.5), Point::new(0.5, bad)] {
            assert!(!disc_strictly_inside(p, b, c, cell));
            assert!(!disc_strictly_inside(a, p, c, cell));
            assert!(!disc_strictly_inside(a, b, p, cell));
        }
    }
    assert!(!disc_strictly_inside(
        a,
        b,
        c,
        Rect {
            min_x: f64::NAN,
            ..cell
        }
    ));
    assert!(!disc_strictly_inside(
        a,
        b,
        c,
        Rect {
            max_y: f64::NAN,
            ..cell
        }
    ));
}
