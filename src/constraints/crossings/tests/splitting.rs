//! Properties of splitting: no crossings are left, nothing is lost, and nothing depends on the
//! order.

use std::collections::BTreeSet;

use crate::constraints::crossings::split;
use crate::constraints::crossings::split::{Split, TaggedSegment};
use crate::constraints::crossings::tests::*;
use crate::constraints::error::SplitError;
use crate::geometry::{Point, Rect};

fn numbered(segments: &[[Point; 2]]) -> Vec<TaggedSegment<u32>> {
    let numbered = segments.iter().zip(0..);
    numbered.map(|(&ends, tag)| TaggedSegment { ends, tag }).collect()
}

/// Returns the subsegments in sorted order.
fn sorted(subsegments: &[TaggedSegment<u32>]) -> Vec<(u32, [[u64; 2]; 2])> {
    let mut all: Vec<_> = subsegments
        .iter()
        .map(|subsegment| (subsegment.tag, subsegment.ends.map(bits)))
        .collect();
    all.sort_unstable();
    all
}

/// Checks that the subsegments of each segment form a chain from one end to the other that never
/// turns back.
fn check_chains(segments: &[[Point; 2]], subsegments: &[TaggedSegment<u32>]) {
    for (&[from, to], number) in segments.iter().zip(0..) {
        let its: Vec<[Point; 2]> = subsegments.iter().filter(|p| p.tag == number).map(|p| p.ends).collect();
        assert_eq!((its[0][0], its[its.len() - 1][1]), (from, to));
        for pair in its.windows(2) {
            assert_eq!(pair[0][1], pair[1][0]);
        }
        for &[p, q] in its.iter().filter(|_| from != to) {
            assert_ne!(p, q);
            let is_forward = |from: f64, to: f64, p: f64, q: f64| (to - from) * (q - p) >= 0.0;
            assert!(is_forward(from.x, to.x, p.x, q.x) && is_forward(from.y, to.y, p.y, q.y));
        }
    }
}

/// Returns the ends that lie exactly in the interior of a segment.
fn touches(segments: &[[Point; 2]]) -> BTreeSet<(usize, [u64; 2])> {
    let mut all = BTreeSet::new();
    for (number, &[a, b]) in segments.iter().enumerate() {
        for &end in segments.iter().flatten() {
            let is_within = bounds([a, b]).contains(end) && end != a && end != b;
            if is_within && orient2d(a, b, end) == Orientation::Collinear {
                all.insert((number, bits(end)));
            }
        }
    }
    all
}

/// Splits segments, and checks all guarantees.
fn check_split(segments: &[[Point; 2]]) -> Split {
    let mut subsegments = numbered(segments);
    let done = split(&mut subsegments, usize::MAX).unwrap();
    let ends: Vec<[Point; 2]> = subsegments.iter().map(|subsegment| subsegment.ends).collect();
    assert_eq!(by_brute_force(&ends), Crossings::new());
    check_chains(segments, &subsegments);

    let crossings = by_brute_force(segments);
    assert_eq!(done.crossings.first().copied().unwrap_or(0), crossings.len() as u64);
    assert!(done.points.is_sorted_by(|p, q| p.lex_cmp(*q).is_lt()));
    let points: BTreeSet<[u64; 2]> = done.points.iter().map(|&p| bits(p)).collect();
    assert!(crossings.values().all(|point| points.contains(point)));
    // The vertices are exactly the old and the new ones.
    let before: BTreeSet<[u64; 2]> = segments.iter().flatten().map(|&p| bits(p)).collect();
    let after: BTreeSet<[u64; 2]> = ends.iter().flatten().map(|&p| bits(p)).collect();
    assert_eq!(after, &before | &points);
    // Segments pass through their former crossing points, and still touch the points that they
    // touched.
    let passes = |number: usize, point: [u64; 2]| {
        let its = subsegments
            .iter()
            .filter(|subsegment| subsegment.tag as usize == number);
        let at = Point::new(f64::from_bits(point[0]), f64::from_bits(point[1]));
        let mut its = its.map(|subsegment| subsegment.ends);
        its.any(|[a, b]| {
            a == at || b == at || bounds([a, b]).contains(at) && orient2d(a, b, at) == Orientation::Collinear
        })
    };
    for (&[one, other], &point) in &crossings {
        assert!(passes(one as usize, point) && passes(other as usize, point));
    }
    for (number, point) in touches(segments) {
        assert!(passes(number, point));
    }
    done
}

/// Splits segments in another order, some of them reversed. The subsegments must be the same.
fn check_order(segments: &[[Point; 2]], order: &[u32]) {
    let mut subsegments = numbered(segments);
    let mut others = subsegments.clone();
    others.sort_by_key(|segment| order[segment.tag as usize % order.len()]);
    let is_reversed = |segment: &TaggedSegment<u32>| order[segment.tag as usize % order.len()] % 2 == 1;
    let reverse = |segments: &mut [TaggedSegment<u32>]| {
        let reversed = segments.iter_mut().filter(|segment| is_reversed(segment));
        reversed.for_each(|segment| segment.ends.reverse());
    };
    reverse(&mut others);
    let done = split(&mut subsegments, usize::MAX);
    assert_eq!(done, split(&mut others, usize::MAX));
    if done.is_ok() {
        reverse(&mut others);
        assert_eq!(sorted(&subsegments), sorted(&others));
    }
}

fn order() -> impl Strategy<Value = Vec<u32>> {
    prop::collection::vec(any::<u32>(), 40)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn splitting_segments_on_a_grid_keeps_all_guarantees(segments in prop::collection::vec(small(), 1..40), order in order()) {
        check_split(&segments);
        check_order(&segments, &order);
    }

    #[test]
    fn splitting_float_segments_keeps_all_guarantees(segments in prop::collection::vec(float(), 1..40), order in order()) {
        check_split(&segments);
        check_order(&segments, &order);
    }

    /// Only integers are representable in this range.
    #[test]
    fn splitting_coarse_coordinates_keeps_all_guarantees(segments in prop::collection::vec(small(), 1..40), order in order()) {
        let coarse = |p: Point| Point::new(p.x + 2f64.powi(52), p.y + 2f64.powi(52));
        let segments: Vec<_> = segments.iter().map(|segment| segment.map(coarse)).collect();
        check_split(&segments);
        check_order(&segments, &order);
    }
}

/// A rounded crossing point moves the subsegments of a segment across a third segment, which ends
/// close to it.
#[test]
fn rounds_are_limited() {
    let coarse = |[x, y]: [i32; 2]| Point::new(f64::from(x) + 2f64.powi(52), f64::from(y) + 2f64.powi(52));
    let mut random = 1u32;
    let mut next = || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 16) as i32 % 100
    };
    let segments: Vec<[Point; 2]> = (0..150).map(|_| [(); 2].map(|()| coarse([next(), next()]))).collect();
    let done = check_split(&segments);
    let rounds = done.crossings.len();
    assert!(rounds > 1);
    for enough in [rounds, rounds + 1] {
        assert_eq!(
            split_in_rounds(&mut numbered(&segments), usize::MAX, enough).as_ref(),
            Ok(&done)
        );
    }
    for (last, &left) in done.crossings.iter().enumerate() {
        let error = split_in_rounds(&mut numbered(&segments), usize::MAX, last).unwrap_err();
        let SplitError::StillCrossing {
            rounds,
            crossings,
            point,
        } = error
        else {
            panic!("{error}")
        };
        assert_eq!((rounds, crossings), (last, left));
        assert!(done.points.contains(&point));
        assert!(error.to_string().contains(&format!("{left} pairs")));
    }
}

#[test]
fn the_number_of_crossings_is_limited() {
    let comb = |i: i32| [point([i, -1]), point([i, 10])];
    let mut segments: Vec<[Point; 2]> = (1..8).map(comb).collect();
    segments.push([point([0, 0]), point([9, 0])]);
    assert_eq!(check_split(&segments).crossings, [7]);
    assert!(split(&mut numbered(&segments), 7).is_ok());
    assert_eq!(
        split(&mut numbered(&segments), 6),
        Err(SplitError::TooMany { limit: 6 })
    );
}

/// The crossing point is rounded to an end of one segment, so only the other segment is bent.
#[test]
fn a_point_that_is_rounded_to_an_end_makes_no_subsegment_of_zero_length() {
    let one = 1.0f64.next_up();
    let segments = [
        [Point::new(0.0, 0.0), Point::new(one, one)],
        [Point::new(1.0, one), Point::new(one.next_up(), 1.0)],
    ];
    let done = check_split(&segments);
    assert_eq!((done.crossings, done.points), (vec![1], vec![Point::new(one, one)]));
}

/// Two walls that end on a third one stay on it when it is bent.
#[test]
fn ends_on_a_bent_segment_stay_on_it() {
    let wall = [point([0, 0]), point([7, 21])];
    let segments = [
        wall,
        [point([1, 3]), point([5, 3])],
        [point([2, 6]), point([0, 6])],
        [point([0, 11]), point([9, 10])],
    ];
    let mut subsegments = numbered(&segments);
    let done = split(&mut subsegments, 10).unwrap();
    assert_eq!(done.points.len(), 1);
    let of_wall: Vec<Point> = subsegments
        .iter()
        .filter(|subsegment| subsegment.tag == 0)
        .map(|subsegment| subsegment.ends[1])
        .collect();
    assert_eq!(of_wall, [point([1, 3]), point([2, 6]), done.points[0], point([7, 21])]);
    check_split(&segments);
}

/// Splits segments without any other points.
fn split<T: Copy>(segments: &mut Vec<TaggedSegment<T>>, limit: usize) -> Result<Split, SplitError> {
    split::split(segments, limit, &[], &mut |_, _| Ok(()))
}

fn split_in_rounds<T: Copy>(
    segments: &mut Vec<TaggedSegment<T>>,
    limit: usize,
    rounds: usize,
) -> Result<Split, SplitError> {
    split::split_in_rounds(segments, (limit, rounds), &[], &mut |_, _| Ok(()))
}

#[test]
fn points_on_bent_segments_cut_them() {
    let p = Point::new;
    // The crossing point of the first two has an x that is not a double. The third crosses nothing.
    let segments = [
        [p(0.0, 0.0), p(9.0, 3.0)],
        [p(5.0, -1.0), p(4.0, 3.0)],
        [p(0.0, 5.0), p(9.0, 8.0)],
    ];
    let points = [
        p(6.0, 2.0),
        p(3.0, 1.0),
        p(3.0, 1.5),
        p(3.0, 6.0),
        p(9.0, 3.0),
        p(3.0, 1.0),
    ];
    for batch in [1, 2, 6] {
        let mut asked = 0;
        let mut given = |_: Rect, take: &mut dyn FnMut(&[Point])| {
            asked += 1;
            points.chunks(batch).for_each(take);
            Ok::<_, SplitError>(())
        };
        let mut subsegments = numbered(&segments);
        let done = split::split(&mut subsegments, 10, &[], &mut given).unwrap();
        assert_eq!((done.crossings.as_slice(), done.points.len(), asked), (&[1][..], 1, 1));
        let crossing = done.points[0];
        assert!(
            crate::geometry::orient2d(p(0.0, 0.0), crossing, p(3.0, 1.0)) != crate::geometry::Orientation::Collinear
        );
        let of = |number| -> Vec<[Point; 2]> {
            let its = subsegments.iter().filter(|subsegment| subsegment.tag == number);
            its.map(|subsegment| subsegment.ends).collect()
        };
        let along = |corners: &[Point]| corners.windows(2).map(|ends| [ends[0], ends[1]]).collect::<Vec<_>>();
        assert_eq!(
            of(0),
            along(&[p(0.0, 0.0), p(3.0, 1.0), crossing, p(6.0, 2.0), p(9.0, 3.0)])
        );
        assert_eq!(of(1), along(&[p(5.0, -1.0), crossing, p(4.0, 3.0)]));
        assert_eq!(of(2), segments[2..]);
    }
}
