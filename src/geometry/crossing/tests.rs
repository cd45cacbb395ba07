use proptest::prelude::*;

use crate::geometry::crossing::*;
use crate::geometry::oracle;
use crate::geometry::oracle::Exact;

/// Returns the exact crossing of two lines by the textbook's determinants: the numerators of x and
/// y, and the denominator.
fn exact_crossing([a, b]: [Point; 2], [c, d]: [Point; 2]) -> ([Exact; 2], Exact) {
    let e = |v: f64| Exact::from(v);
    let cross = |p: Point, q: Point| &(&e(p.x) * &e(q.y)) - &(&e(p.y) * &e(q.x));
    let (abx, aby, cdx, cdy) = (
        &e(a.x) - &e(b.x),
        &e(a.y) - &e(b.y),
        &e(c.x) - &e(d.x),
        &e(c.y) - &e(d.y),
    );
    let numerator = |ab: &Exact, cd: &Exact| &(&cross(a, b) * cd) - &(ab * &cross(c, d));
    let denominator = &(&abx * &cdy) - &(&aby * &cdx);
    ([numerator(&abx, &cdx), numerator(&aby, &cdy)], denominator)
}

/// Compares a fraction with a number.
fn order(numerator: &Exact, denominator: &Exact, number: &Exact) -> Ordering {
    let sign = numerator.sign_of_difference(&(number * denominator));
    if denominator.sign() == Ordering::Less {
        sign.reverse()
    } else {
        sign
    }
}

fn is_even(v: f64) -> bool {
    v.to_bits() & 1 == 0
}

/// Returns the coordinates next to `v`, below and above.
fn neighbours(v: f64) -> [f64; 2] {
    let least = Point::MIN_MAGNITUDE;
    let down = if v == least { 0.0 } else { v.next_down() };
    let up = if v == -least { 0.0 } else { v.next_up() };
    if v == 0.0 { [-least, least] } else { [down, up] }
}

/// Checks that `v` is the coordinate nearest to the fraction.
fn check_nearest(numerator: &Exact, denominator: &Exact, v: f64) {
    assert!(
        Point::new(v, 0.0).is_valid() && (v != 0.0 || v.is_sign_positive()),
        "{v:e}"
    );
    let [down, up] = neighbours(v);
    let twice = numerator + numerator;
    for (neighbour, beyond) in [(down, Ordering::Less), (up, Ordering::Greater)] {
        let sum = &Exact::from(v) + &Exact::from(neighbour);
        let order = order(&twice, denominator, &sum);
        assert_ne!(order, beyond, "{neighbour:e} is nearer than {v:e}");
        let wins_ties = is_even(v) && v.abs() != Point::MIN_MAGNITUDE || neighbour != 0.0 && is_even(v);
        assert!(
            order != Ordering::Equal || wins_ties,
            "{neighbour:e} and not {v:e} by the tie rule"
        );
    }
}

fn cross_by_oracle([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let opposite = |p: Ordering, q: Ordering| p != Ordering::Equal && p == q.reverse();
    opposite(oracle::orient2d(a, b, c), oracle::orient2d(a, b, d))
        && opposite(oracle::orient2d(c, d, a), oracle::orient2d(c, d, b))
}

/// Checks the crossing of two segments. Returns whether they cross.
fn check([a, b, c, d]: [Point; 4]) -> bool {
    let (ab, cd) = ([a, b], [c, d]);
    let expected = cross_by_oracle(ab, cd);
    assert_eq!(segments_cross(a, b, c, d), expected, "{ab:?} {cd:?}");
    let point = crossing_point(a, b, c, d);
    assert_eq!(point.is_some(), expected);
    let Some(point) = point else { return false };
    let ([x, y], denominator) = exact_crossing(ab, cd);
    check_nearest(&x, &denominator, point.x);
    check_nearest(&y, &denominator, point.y);
    for [a, b, c, d] in [[b, a, c, d], [a, b, d, c], [d, c, b, a], [c, d, a, b]] {
        let other = crossing_point(a, b, c, d).unwrap();
        assert_eq!(
            [other.x.to_bits(), other.y.to_bits()],
            [point.x.to_bits(), point.y.to_bits()]
        );
    }
    for (p, q) in [(a, b), (c, d)] {
        assert!(Rect::around([p, q]).contains(point), "{point:?} is beside {p:?} {q:?}");
    }
    check_outside(ab, cd, point);
    check_cells(&ExactCrossing::of(ab, cd).unwrap(), &[x, y], &denominator, point);
    true
}

/// Checks in which cells the exact point lies. The cells have a corner at the rounded point or next
/// to it.
fn check_cells(crossing: &ExactCrossing, [x, y]: &[Exact; 2], denominator: &Exact, point: Point) {
    for cut_x in neighbours(point.x).into_iter().chain([point.x]) {
        for cut_y in neighbours(point.y).into_iter().chain([point.y]) {
            let right = order(x, denominator, &Exact::from(cut_x)).is_gt();
            let above = order(y, denominator, &Exact::from(cut_y)).is_gt();
            let half_line = |beyond: bool, cut: f64| {
                if beyond {
                    (cut, f64::INFINITY)
                } else {
                    (f64::NEG_INFINITY, cut)
                }
            };
            for quadrant in 0..4 {
                let (is_right, is_above) = (quadrant & 1 == 1, quadrant & 2 == 2);
                let ((min_x, max_x), (min_y, max_y)) = (half_line(is_right, cut_x), half_line(is_above, cut_y));
                let cell = Rect::new(min_x, min_y, max_x, max_y);
                let expected = (is_right == right && is_above == above).then_some(point);
                assert_eq!(crossing.rounded_if_in(cell), expected, "{cell:?}");
            }
        }
    }
}

/// Checks that the point is never outside a rectangle that contains it, and is outside one that is
/// far away.
fn check_outside(ab: [Point; 2], cd: [Point; 2], point: Point) {
    let Point { x, y } = point;
    let largest = ab
        .iter()
        .chain(&cd)
        .fold(0.0f64, |most, p| most.max(p.x.abs()).max(p.y.abs()));
    let infinity = f64::INFINITY;
    for (min_x, max_x, min_y, max_y) in [
        (x, x, y, y),
        (x, infinity, -infinity, y),
        (-infinity, x, y, infinity),
        (-infinity, infinity, -infinity, infinity),
    ] {
        assert!(!cross_outside(ab, cd, Rect::new(min_x, min_y, max_x, max_y)));
    }
    if !is_nearly_degenerate(ab, cd) {
        let far = [x - largest, x - largest / 2.0];
        assert!(cross_outside(ab, cd, Rect::new(far[0], -infinity, far[1], infinity)) || largest < 1e-40);
    }
}

/// Returns whether rounding matters to the area of one of the triangles, as for segments that are
/// nearly collinear.
fn is_nearly_degenerate([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    [c, d].into_iter().any(|p| {
        let (left, right) = ((a.x - p.x) * (b.y - p.y), (a.y - p.y) * (b.x - p.x));
        (left - right).abs() < (left.abs() + right.abs()) * 1e-3
    })
}

fn four(coordinate: impl Strategy<Value = f64> + Clone) -> impl Strategy<Value = [Point; 4]> {
    let point = (coordinate.clone(), coordinate).prop_map(|(x, y)| Point::new(x, y).normalized());
    prop::array::uniform4(point)
}

/// Generates two segments whose ends are near each other. They may cross.
fn near_parallel() -> impl Strategy<Value = [Point; 4]> {
    let step = || prop_oneof![Just(0i64), -3..=3i64, -1000..=1000i64];
    (four(-1e3..1e3), prop::array::uniform4(step())).prop_map(|([a, b, ..], [i, j, k, l])| {
        let moved = |v: f64, steps: i64| f64::from_bits(v.to_bits().wrapping_add_signed(steps));
        let near = |p: Point, i, j| Point::new(moved(p.x, i), moved(p.y, j)).normalized();
        [a, b, near(a, i, j), near(b, k, l)]
    })
}

fn magnitudes() -> impl Strategy<Value = f64> + Clone {
    (-1.0..1.0, -40..40).prop_map(|(m, e): (f64, i32)| m * 2f64.powi(e))
}

fn at_the_limits() -> impl Strategy<Value = f64> + Clone {
    let least = Point::MIN_MAGNITUDE;
    let most = Point::MAX_MAGNITUDE;
    prop_oneof![
        prop::sample::select(vec![
            0.0,
            least,
            -least,
            least.next_up(),
            most,
            -most,
            most.next_down(),
            1.0
        ]),
        (-1.0..1.0).prop_map(move |m: f64| m * most),
        (1.0..4.0, any::<bool>()).prop_map(move |(m, sign): (f64, bool)| if sign { m * least } else { -m * least }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn crossings_of_random_segments_are_exact(points in four(-10.0..10.0)) {
        check(points);
    }

    #[test]
    fn crossings_on_small_integers_are_exact(points in four((-4..5).prop_map(f64::from))) {
        check(points);
    }

    /// Only even integers are numbers in this range, so many coordinates are halfway between two
    /// numbers.
    #[test]
    fn ties_round_to_even(points in four((0..12).prop_map(|i| 2f64.powi(53) + 2.0 * f64::from(i)))) {
        check(points);
    }

    /// Coordinates of the crossing are smaller than the smallest valid magnitude, or halfway to it.
    #[test]
    fn crossings_on_tiny_integers_are_exact(points in four((-4..5).prop_map(|i| f64::from(i) * Point::MIN_MAGNITUDE))) {
        check(points);
    }

    #[test]
    fn crossings_of_mixed_magnitudes_are_exact(points in four(magnitudes())) {
        check(points);
    }

    #[test]
    fn crossings_at_the_limits_are_exact(points in four(at_the_limits())) {
        check(points);
    }

    #[test]
    fn crossings_of_nearly_parallel_segments_are_exact(points in near_parallel()) {
        check(points);
    }
}

#[test]
fn segments_that_only_touch_do_not_cross() {
    let p = |x, y| Point::new(x, y);
    let (a, b) = (p(0.0, 0.0), p(4.0, 0.0));
    for (c, d) in [
        (p(2.0, 0.0), p(2.0, 3.0)),
        (b, p(5.0, 5.0)),
        (p(1.0, 0.0), p(9.0, 0.0)),
        (a, b),
        (p(2.0, 0.0), p(2.0, 0.0)),
        (p(5.0, -1.0), p(5.0, 1.0)),
    ] {
        assert!(!check([a, b, c, d]), "{c:?} {d:?}");
    }
    assert!(check([a, b, p(1.0, -1.0), p(3.0, 2.0)]));
}

#[test]
fn coordinates_that_are_too_small_round_to_the_nearest_valid_one() {
    let least = Point::MIN_MAGNITUDE;
    // The line through (0, 0) and (4, 1) times the least magnitude, at x from 1 to 3 times it.
    for (x, y) in [(1.0, 0.0), (2.0, 0.0), (3.0, least)] {
        for sign in [1.0, -1.0] {
            let [a, b] = [Point::new(0.0, 0.0), Point::new(4.0 * least, sign * least)];
            let [c, d] = [-1.0, 1.0].map(|y| Point::new(x * least, y));
            let expected = Point::new(x * least, if y == 0.0 { 0.0 } else { sign * y });
            assert_eq!(crossing_point(a, b, c, d), Some(expected));
            assert!(check([a, b, c, d]));
        }
    }
}

#[test]
fn segments_with_invalid_ends_do_not_cross() {
    for v in [f64::NAN, f64::INFINITY, 1e300] {
        let (a, b) = (Point::new(-v, 0.0), Point::new(v, 0.0));
        assert_eq!(crossing_point(a, b, Point::new(0.0, -v), Point::new(1.0, 1.0)), None);
    }
}
