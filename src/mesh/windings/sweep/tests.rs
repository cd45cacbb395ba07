use proptest::prelude::*;

use crate::constraints::error::ConstraintError;
use crate::constraints::polygons::check::PolygonCheck;
use crate::mesh::windings::sweep::*;

/// Generates the sides of arbitrary rings on a grid.
pub(crate) fn rings() -> impl Strategy<Value = Vec<[Point; 2]>> {
    let ring = prop::collection::vec((0i32..7, 0i32..7), 1..7);
    prop::collection::vec(ring, 1..5).prop_map(|rings| {
        let sides = |ring: Vec<(i32, i32)>| -> Vec<[Point; 2]> {
            let at = |index: usize| {
                let (x, y) = ring[index % ring.len()];
                Point::new(x.into(), y.into())
            };
            (0..ring.len()).map(|index| [at(index), at(index + 1)]).collect()
        };
        rings.into_iter().flat_map(sides).collect()
    })
}

/// Returns the winding of segments around a point that is on none of them.
fn winding(segments: &[[Point; 2]], p: Point) -> i32 {
    let mut winding = 0;
    for &[a, b] in segments {
        if (a.y <= p.y) != (b.y <= p.y) {
            winding += match orient2d(a, b, p) {
                Orientation::CounterClockwise if a.y <= p.y => 1,
                Orientation::Clockwise if a.y > p.y => -1,
                _ => 0,
            };
        }
    }
    winding
}

/// Returns whether any pair crosses elsewhere than in an end of a segment, and whether all pairs
/// cross in representable points.
fn crossings(segments: &[[Point; 2]]) -> (bool, bool) {
    let (mut any, mut all_at_points) = (false, true);
    for (at, &one) in segments.iter().enumerate() {
        for &other in &segments[..at] {
            if let Some(point) = ExactCrossing::of(one, other).map(|crossing| crossing.rounded()) {
                let is_on = |[a, b]: [Point; 2]| orient2d(a, b, point) == Orientation::Collinear;
                any |= !segments.as_flattened().contains(&point);
                all_at_points &= is_on(one) && is_on(other);
            }
        }
    }
    (any, all_at_points)
}

/// Sweeps strips that cover the plane. Returns the first point of all strips, or `None` if one of
/// them has no windings.
fn in_strips(segments: &[[Point; 2]], cuts: &[f64]) -> Option<Option<Point>> {
    let mut sides = vec![f64::NEG_INFINITY];
    sides.extend(cuts);
    sides.push(f64::INFINITY);
    let mut smallest = None;
    for strip in sides.windows(2) {
        let meets = |ends: &&[Point; 2]| {
            let [a, b] = ends.map(|end| end.x);
            a.max(b) >= strip[0] && a.min(b) <= strip[1]
        };
        let sweep = Sweep::new(segments.iter().filter(meets).copied());
        match sweep.run(Some([strip[0], strip[1]]), &mut |_| {}) {
            Outcome::Seen { first, .. } => smallest = smallest.or(first),
            _ => return None,
        }
    }
    Some(smallest)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    /// On both sides of each swept part, the windings equal those that a ray counts, and no part is
    /// left out.
    #[test]
    fn windings_equal_those_that_a_ray_counts(segments in rings(), cuts in prop::collection::vec(-1i32..8, 0..3)) {
        let sweep = Sweep::new(segments.iter().copied());
        let mut parts = Vec::new();
        let outcome = sweep.run(None, &mut |part| parts.push(part));
        let (_, all_at_points) = crossings(&segments);
        let Outcome::Seen { first, faces, overlap, meets } = outcome else {
            prop_assert_eq!(outcome, Outcome::Crosses);
            prop_assert!(!all_at_points);
            return Ok(());
        };
        // A segment that cancels another may end at a crossing, which is then a vertex. The sweep
        // ignores such segments.
        let is_changed = |&[a, b]: &[Point; 2]| sweep.edge_between(a, b).is_some();
        let changed: Vec<[Point; 2]> = segments.iter().copied().filter(is_changed).collect();
        prop_assert!(!meets || crossings(&changed).0);
        let (mut smallest, mut smallest_overlap): (Option<Point>, Option<Point>) = (None, None);
        for part in &parts {
            let [a, b] = part.ends;
            prop_assert!(a.lex_cmp(b).is_lt());
            let beside = |side: f64| {
                let middle = Point::new(0.499 * a.x + 0.501 * b.x, 0.499 * a.y + 0.501 * b.y);
                let step = side * 1e-7 / (b.x - a.x).hypot(b.y - a.y);
                Point::new(middle.x - step * (b.y - a.y), middle.y + step * (b.x - a.x))
            };
            let expected = [-1.0, 1.0].map(|side| winding(&segments, beside(side)));
            prop_assert_eq!(part.windings, expected, "{:?}", part);
            if expected.iter().any(|&winding| winding < 0) {
                smallest = smallest.into_iter().chain([a]).min_by(|p, q| p.lex_cmp(*q));
            }
            if expected.iter().any(|&winding| winding > 1) {
                smallest_overlap = smallest_overlap.into_iter().chain([a]).min_by(|p, q| p.lex_cmp(*q));
            }
        }
        prop_assert_eq!(overlap, smallest_overlap);
        prop_assert_eq!(first.is_some(), smallest.is_some());
        prop_assert_eq!(first.is_some(), faces > 0);
        if let (Some(first), Some(smallest)) = (first, smallest) {
            prop_assert_eq!(first, smallest);
        }
        // No part of any segment is left out, except of those that cancel each other.
        for edge in 0..sweep.edge_count() {
            let mut its: Vec<EdgePart> = parts.iter().filter(|part| part.edge == edge).copied().collect();
            its.sort_by(|one, other| one.ends[0].lex_cmp(other.ends[0]));
            prop_assert_eq!(its[0].ends[0], sweep.edges[edge].ends[0]);
            prop_assert_eq!(its[its.len() - 1].ends[1], sweep.edges[edge].ends[1]);
            prop_assert!(its.windows(2).all(|pair| pair[0].ends[1] == pair[1].ends[0]));
        }
        // Strips give the same result.
        let mut cuts: Vec<f64> = cuts.into_iter().map(f64::from).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        prop_assert_eq!(in_strips(&segments, &cuts), Some(first));
    }

    /// The result does not depend on the memory.
    #[test]
    fn polygons_on_the_disk_have_the_same_faults_as_in_memory(polygons in prop::collection::vec(rings(), 1..4)) {
        let folder = tempfile::tempdir().unwrap();
        let faults = |memory: u64| {
            let mut check = PolygonCheck::new(folder.path(), memory);
            for (polygon, number) in polygons.iter().zip(0..) {
                for &ends in polygon {
                    check.take(number, 10 + number, ends)?;
                }
            }
            check.finish()
        };
        let expected = faults(u64::MAX).unwrap();
        match faults(0) {
            Ok(found) => prop_assert_eq!(found, expected),
            Err(error) => prop_assert!(matches!(error, ConstraintError::Memory(_)), "{}", error),
        }
    }

    #[test]
    fn a_ring_that_does_not_close_is_found(segments in rings(), left_out in 0usize..20) {
        let mut segments: Vec<[Point; 2]> = segments.into_iter().filter(|[a, b]| a != b).collect();
        prop_assume!(!segments.is_empty());
        segments.remove(left_out % segments.len());
        let outcome = Sweep::new(segments.into_iter()).run(None, &mut |_| {});
        prop_assert!(matches!(outcome, Outcome::Open | Outcome::Crosses), "{:?}", outcome);
    }
}

#[test]
fn faces_are_counted_once() {
    let at = |x: i32, y: i32| Point::new(x.into(), y.into());
    let ring = |corners: &[(i32, i32)]| -> Vec<[Point; 2]> {
        let next = corners.iter().cycle().skip(1);
        corners
            .iter()
            .zip(next)
            .map(|(&(a, b), &(c, d))| [at(a, b), at(c, d)])
            .collect()
    };
    let faces = |segments: &[Vec<[Point; 2]>]| match Sweep::new(segments.concat().into_iter()).run(None, &mut |_| {}) {
        Outcome::Seen { first, faces, .. } => (first, faces),
        other => panic!("{other:?}"),
    };
    let turned = |x: i32, y: i32| ring(&[(x, y), (x, y + 1), (x + 1, y + 1), (x + 1, y)]);
    // A face that opens to the left begins at three corners, and is counted once.
    let comb = ring(&[(0, 0), (3, 1), (0, 2), (3, 3), (0, 4), (9, 4), (9, 0)]);
    let comb: Vec<[Point; 2]> = comb.into_iter().map(|[a, b]| [b, a]).collect();
    assert_eq!(
        faces(&[ring(&[(0, 0), (3, 1), (0, 2), (3, 3), (0, 4), (9, 4), (9, 0)])]),
        (Some(at(0, 0)), 1)
    );
    assert_eq!(faces(&[comb]), (None, 0));
    // Faces that touch in a corner are two.
    assert_eq!(faces(&[turned(0, 0), turned(1, 1)]), (Some(at(0, 0)), 2));
    // Faces of different windings are different faces.
    assert_eq!(
        faces(&[turned(5, 5), ring(&[(0, 0), (0, 9), (9, 9), (9, 0)])]),
        (Some(at(0, 0)), 2)
    );
}

/// More edges above each other than one list of the status has.
#[test]
fn a_status_of_many_lists_gives_the_same_windings() {
    let mut corners = Vec::new();
    for tooth in 0..2000 {
        let y = f64::from(tooth);
        corners.extend([
            Point::new(0.0, y),
            Point::new(1000.0, y + 0.25),
            Point::new(0.0, y + 0.5),
        ]);
    }
    corners.extend([Point::new(-1.0, 2000.0), Point::new(-1.0, 0.0)]);
    let sides = |corners: &[Point]| -> Vec<[Point; 2]> {
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).map(|(&a, &b)| [a, b]).collect()
    };
    let mut segments = sides(&corners);
    let run = |segments: &[[Point; 2]]| Sweep::new(segments.iter().copied()).run(None, &mut |_| {});
    let seen = |first, faces| Outcome::Seen {
        first,
        faces,
        overlap: None,
        meets: false,
    };
    assert_eq!(run(&segments), seen(None, 0));
    // A hole in the last tooth, and one beside it.
    let hole = |x: f64, y: f64| sides(&[Point::new(x, y), Point::new(x, y + 0.1), Point::new(x + 1.0, y + 0.05)]);
    segments.extend(hole(5.0, 1999.2));
    assert_eq!(run(&segments), seen(None, 0));
    segments.extend(hole(500.0, 1999.6));
    assert_eq!(run(&segments), seen(Some(Point::new(500.0, 1999.6)), 1));
}
