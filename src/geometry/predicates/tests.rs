use std::fs;
use std::path::Path;

use proptest::prelude::*;

use crate::geometry::predicates::*;
use crate::geometry::{BoxFilter, Chord, Rect, oracle};

/// Reads the lines `index coordinates… sign` of a file of the `robust` crate. Its signs have the
/// same meaning as ours.
fn third_party_cases(name: &str, points: usize) -> Vec<(Vec<Point>, Ordering)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/robust-predicates")
        .join(name);
    let text = fs::read_to_string(&path).unwrap();
    let cases = text.lines().map(|line| {
        let numbers: Vec<f64> = line.split_whitespace().map(|word| word.parse().unwrap()).collect();
        assert_eq!(numbers.len(), 2 + 2 * points, "{line}");
        let points = numbers[1..=2 * points]
            .chunks(2)
            .map(|xy| Point::new(xy[0], xy[1]))
            .collect();
        (points, numbers[numbers.len() - 1].partial_cmp(&0.0).unwrap())
    });
    cases.collect()
}

#[test]
fn orient2d_agrees_with_robust_predicates() {
    let cases = third_party_cases("orient2d.txt", 3);
    assert_eq!(cases.len(), 1000);
    for (p, sign) in cases {
        assert_eq!(oracle::orient2d(p[0], p[1], p[2]), sign, "{p:?}");
        check_orient2d(p[0], p[1], p[2]);
    }
}

#[test]
fn incircle_agrees_with_robust_predicates() {
    let cases = third_party_cases("incircle.txt", 4);
    assert_eq!(cases.len(), 1000);
    for (p, sign) in cases {
        assert_eq!(oracle::incircle(p[0], p[1], p[2], p[3]), sign, "{p:?}");
        check_incircle(p[0], p[1], p[2], p[3]);
    }
}

/// Compares all stages with the oracle, including stages that an earlier one makes unnecessary.
fn check_orient2d(a: Point, b: Point, c: Point) {
    let expected = oracle::orient2d(a, b, c);
    assert_eq!(orient2d(a, b, c), Orientation::from(expected), "{a:?} {b:?} {c:?}");
    assert_eq!(orient2d_exact(a, b, c), expected, "exact: {a:?} {b:?} {c:?}");
    assert_eq!(orient2d_expansion(a, b, c), expected, "expansion: {a:?} {b:?} {c:?}");
}

fn check_incircle(a: Point, b: Point, c: Point, d: Point) {
    let expected = oracle::incircle(a, b, c, d);
    assert_eq!(incircle(a, b, c, d), expected, "{a:?} {b:?} {c:?} {d:?}");
    assert_eq!(incircle_exact(a, b, c, d), expected, "exact: {a:?} {b:?} {c:?} {d:?}");
    assert_eq!(
        incircle_expansion(a, b, c, d),
        expected,
        "expansion: {a:?} {b:?} {c:?} {d:?}"
    );
}

fn check_turn(one: [Point; 2], other: [Point; 2]) {
    let expected = oracle::turn(one, other);
    assert_eq!(turn(one, other), Orientation::from(expected), "{one:?} {other:?}");
    assert_eq!(turn_exact(one, other), expected, "exact: {one:?} {other:?}");
    assert_eq!(turn_expansion(one, other), expected, "expansion: {one:?} {other:?}");
}

/// Checks the tests of a chord with the filter of the smallest box and of a larger one.
fn check_chord(chord: Chord, p: Point, q: Point) {
    let Chord { l, r } = chord;
    let bounds = Rect::around([l, r, p, q]);
    let corner = Point::new(bounds.max_x + bounds.size().1, bounds.max_y + bounds.size().0);
    for filter in [bounds, bounds.including(corner)].map(BoxFilter::new) {
        let (of_p, of_q) = (chord.view(p), chord.view(q));
        for (point, view) in [(p, of_p), (q, of_q)] {
            let side = oracle::orient2d(l, r, point);
            assert_eq!(chord.is_left(&filter, &view), side.is_gt(), "{l:?} {r:?} {point:?}");
            assert_eq!(chord.is_right(&filter, &view), side.is_lt(), "{l:?} {r:?} {point:?}");
        }
        if oracle::orient2d(l, r, p).is_gt() {
            let inside = chord.circle_contains(&filter, &of_p, &of_q);
            match oracle::incircle(l, r, p, q) {
                Ordering::Equal => assert_eq!(inside, in_circle(l, r, p, q), "{l:?} {r:?} {p:?} {q:?}"),
                sign => assert_eq!(inside, sign.is_gt(), "{l:?} {r:?} {p:?} {q:?}"),
            }
        }
    }
}

fn check([a, b, c, d]: [Point; 4]) {
    check_orient2d(a, b, c);
    check_chord(Chord { l: a, r: b }, c, d);
    check_chord(Chord { l: b, r: a }, d, c);
    check_turn([a, b], [c, d]);
    check_turn([a, b], [d, c]);
    check_turn([a, b], [b, a]);
    check_incircle(a, b, c, d);
}

/// Generates four points with independent coordinates.
fn four(coordinate: impl Strategy<Value = f64> + Clone) -> impl Strategy<Value = [Point; 4]> {
    let point = (coordinate.clone(), coordinate).prop_map(|(x, y)| Point::new(x, y).normalized());
    prop::array::uniform4(point)
}

fn mixed_magnitude() -> impl Strategy<Value = f64> + Clone {
    (-10.0..10.0, -30..=30).prop_map(|(m, e): (f64, i32)| m * 10f64.powi(e))
}

/// Generates the limits, numbers near them with all bits set, and numbers that cancel with them.
fn at_the_limits() -> impl Strategy<Value = f64> + Clone {
    let full = 2.0 - f64::EPSILON;
    let (least, most) = (Point::MIN_MAGNITUDE, Point::MAX_MAGNITUDE);
    let magnitudes = vec![
        0.0,
        least,
        least * full,
        least.next_up(),
        1.0,
        full,
        most,
        most.next_down(),
        most / full,
    ];
    (prop::sample::select(magnitudes), any::<bool>()).prop_map(|(m, negative)| if negative { -m } else { m })
}

fn nudged(v: f64, steps: i32) -> f64 {
    (0..steps.abs()).fold(v, |v, _| if steps < 0 { v.next_down() } else { v.next_up() })
}

/// Makes a point valid that arithmetic may have made invalid: tiny coordinates become zero.
fn valid(p: Point) -> Point {
    let flush = |v: f64| if v.abs() < Point::MIN_MAGNITUDE { 0.0 } else { v };
    Point::new(flush(p.x), flush(p.y))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn predicates_are_exact_on_small_grids(p in four((-4..=4).prop_map(f64::from)), scale in -100..100, shift in -3..3) {
        let scale = 2f64.powi(scale);
        check(p.map(|p| Point::new((p.x + f64::from(shift)) * scale, (p.y - 1000.0) * scale)));
    }

    #[test]
    fn predicates_are_exact_on_decimals_with_an_offset(p in four((0..40).prop_map(|i| 1e6 + f64::from(i) * 1e-3))) {
        check(p);
    }

    #[test]
    fn predicates_are_exact_on_decimals_around_zero(p in four((-300..300).prop_map(|i| f64::from(i) / 100.0))) {
        check(p);
        let [a, b, ..] = p;
        check([a, b, Point::new(-a.x, -a.y).normalized(), Point::new(-b.x, -b.y).normalized()]);
    }

    #[test]
    fn predicates_are_exact_on_mixed_magnitudes(p in four(mixed_magnitude())) {
        check(p);
    }

    #[test]
    fn predicates_are_exact_at_the_limits(p in four(at_the_limits())) {
        check(p);
    }

    #[test]
    fn predicates_are_exact_when_nearly_collinear(
        p in four(prop_oneof![-1.0..1.0, mixed_magnitude()]),
        t in 0.0..1.0,
        s in -2.0..2.0,
        nudge in -2..=2,
    ) {
        let [a, b, ..] = p;
        let on_line = |t: f64| valid(Point::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)));
        let c = on_line(t);
        check([a, b, valid(Point::new(c.x, nudged(c.y, nudge))), on_line(s)]);
    }

    #[test]
    fn predicates_are_exact_when_nearly_cocircular(
        angles in prop::array::uniform4(0.0..std::f64::consts::TAU),
        radius in prop_oneof![Just(1.0), 1e-3..1e3],
        centre in prop_oneof![Just((0.0, 0.0)), (-1.0..1.0, -1.0..1.0), Just((5e5, 4e6)), Just((1e-20, 1e-9))],
        nudge in -2..=2,
    ) {
        let mut p = angles.map(|t: f64| {
            valid(Point::new(centre.0 + radius * t.cos(), centre.1 + radius * t.sin()))
        });
        p[3] = valid(Point::new(nudged(p[3].x, nudge), p[3].y));
        check(p);
    }

    /// Walks over the circle through three points ulp by ulp, and over the line through two.
    #[test]
    fn predicates_are_exact_on_both_sides_of_their_zeros(
        angles in prop::array::uniform4(0.0..std::f64::consts::TAU),
        centre in prop_oneof![Just((0.0, 0.0)), Just((5e5, 4e6)), (-1.0..1.0, -1.0..1.0)],
        first in -200..190,
    ) {
        let mut p = angles.map(|t: f64| valid(Point::new(centre.0 + t.cos(), centre.1 + t.sin())));
        let [a, b, ..] = p;
        let middle = Point::new(a.x + (b.x - a.x) / 2.0, a.y + (b.y - a.y) / 2.0);
        let (on_circle, on_line) = (p[3], valid(middle));
        for step in first..first + 10 {
            p[3] = valid(Point::new(on_circle.x, nudged(on_circle.y, step)));
            check(p);
            check([a, b, valid(Point::new(on_line.x, nudged(on_line.y, step))), p[3]]);
        }
    }

    /// Checks circles through four grid points, in all orders: rotating the triangle changes
    /// nothing, exchanging `d` with the vertex opposite the common edge changes nothing, and the
    /// diagonal avoids the largest point.
    #[test]
    fn ties_depend_on_coordinates_alone(
        x in 0..9u8, y in 0..9u8,
        picks in prop::sample::subsequence((0..12usize).collect::<Vec<_>>(), 4),
        shrink in any::<bool>(),
    ) {
        // The twelve integer points at distance 5 from a centre.
        const CIRCLE: [(i8, i8); 12] = [
            (5, 0), (4, 3), (3, 4), (0, 5), (-3, 4), (-4, 3), (-5, 0), (-4, -3), (-3, -4), (0, -5), (3, -4), (4, -3),
        ];
        let scale = if shrink { 0.125 } else { 1.0 };
        let quad: Vec<Point> = picks.iter().map(|&i| {
            let (dx, dy) = CIRCLE[i];
            Point::new(scale * (f64::from(x) + f64::from(dx)), scale * (f64::from(y) + f64::from(dy)))
        }).collect();
        let largest = (0..4).max_by(|&i, &j| quad[i].lex_cmp(quad[j])).unwrap();
        for start in 0..4 {
            // The points are in order around the circle. The diagonal of (a, b, c) and (c, d, a) is
            // ac.
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| quad[(start + i) % 4]);
            prop_assert_eq!(incircle(a, b, c, d), Ordering::Equal);
            let diagonal_avoids_largest = largest % 2 != start % 2;
            for inside in [in_circle(a, b, c, d), in_circle(b, c, a, d), in_circle(c, a, b, d)] {
                prop_assert_eq!(!inside, diagonal_avoids_largest);
            }
            for inside in [in_circle(c, d, a, b), in_circle(d, a, c, b), in_circle(a, c, d, b)] {
                prop_assert_eq!(!inside, diagonal_avoids_largest);
            }
        }
    }

    #[test]
    fn in_circle_agrees_with_incircle_except_for_ties(p in four((0..30).prop_map(f64::from))) {
        let [a, b, c, d] = match orient2d(p[0], p[1], p[2]) {
            Orientation::CounterClockwise => p,
            Orientation::Clockwise => [p[1], p[0], p[2], p[3]],
            Orientation::Collinear => return Ok(()),
        };
        match oracle::incircle(a, b, c, d) {
            Ordering::Equal => {}
            sign => prop_assert_eq!(in_circle(a, b, c, d), sign == Ordering::Greater),
        }
        for vertex in [a, b, c] {
            prop_assert!(!in_circle(a, b, c, vertex));
        }
    }

    #[test]
    fn wide_products_are_exact(a in any::<i128>(), b in any::<i128>(), c in any::<i128>(), d in any::<i128>()) {
        use num_bigint::BigInt;
        let [a, b, c, d] = [a, b, c, d].map(|v| v >> 2);
        for [a, b, c, d] in [[a, b, c, d], [a >> 60, b, a, b >> 60], [a, -b, -b, a], [0, b, -b, 0], [a, b, a, b + 1]] {
            let exact = (BigInt::from(a) * b).cmp(&(BigInt::from(c) * d));
            prop_assert_eq!(wide_product(a, b).cmp(&wide_product(c, d)), exact);
        }
    }
}

/// Numbers with all bits set give the smallest and largest determinants within the limits.
#[test]
fn predicates_are_exact_at_the_extremes_of_the_determinant() {
    let most = Point::MAX_MAGNITUDE;
    let least = Point::MIN_MAGNITUDE;
    for unit in [
        least,
        least.next_up(),
        least * (2.0 - f64::EPSILON),
        most / 4.0,
        most.next_down() / 4.0,
    ] {
        for [x, y] in [
            [1.0, 1.0],
            [2.0, 1.0],
            [1.0, 3.0],
            [4.0, 4.0],
            [-4.0, 4.0],
            [-4.0, -4.0],
            [0.0, 1.0],
        ] {
            let p = |x: f64, y: f64| Point::new(x * unit, y * unit).normalized();
            check([p(-4.0, -4.0), p(4.0, -4.0), p(4.0, 4.0), p(x, y)]);
            check([p(-4.0, -4.0), p(4.0, -4.0), p(x, y), p(1.0, 2.0)]);
            let q = p(x, y);
            check(
                [p(-4.0, -4.0), p(4.0, -4.0), p(4.0, 4.0), Point::new(q.x.next_up(), q.y)]
                    .map(|p| Point::new(p.x.clamp(-most, most), p.y.clamp(-most, most)))
                    .map(valid),
            );
        }
    }
}

/// Two neighbouring numbers at the lower limit differ by 2⁻¹⁹⁴, so the determinants are
/// 2⁻³⁸⁸ and 2⁻⁷⁷⁶, the smallest possible values.
#[test]
fn predicates_are_exact_for_the_least_differences() {
    let low = Point::MIN_MAGNITUDE;
    let high = low.next_up();
    let [a, b, c, d] = [(low, low), (high, low), (high, high), (low, high)].map(|(x, y)| Point::new(x, y));
    assert_eq!(orient2d(a, b, c), Orientation::CounterClockwise);
    assert_eq!(incircle(a, b, c, d), Ordering::Equal);
    check([a, b, c, d]);
    let further = Point::new(low, high.next_up());
    assert_eq!(incircle(a, b, c, further), Ordering::Less);
    check([a, b, c, further]);
    check([a, b, further, c]);
}

/// The diagonal of a unit square must avoid the corner with the largest x and y.
#[test]
fn the_diagonal_of_a_square_avoids_its_upper_right_corner() {
    let [a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Point::new(x, y));
    assert!(in_circle(a, b, c, d), "diagonal ac ends at the largest corner");
    assert!(!in_circle(b, c, d, a), "diagonal bd does not");
}

#[test]
fn equal_points_are_collinear_and_on_the_circle() {
    let [a, b, c] = [(0.1, 0.2), (0.7, -0.3), (0.4, 0.9)].map(|(x, y)| Point::new(x, y));
    assert_eq!(orient2d(a, a, b), Orientation::Collinear);
    assert_eq!(orient2d(a, b, a), Orientation::Collinear);
    assert_eq!(orient2d(a, a, a), Orientation::Collinear);
    assert_eq!(
        orient2d_exact(Point::default(), Point::default(), Point::default()),
        Ordering::Equal
    );
    for d in [a, b, c] {
        assert_eq!(incircle(a, b, c, d), Ordering::Equal);
        assert!(!in_circle(a, b, c, d));
    }
}
