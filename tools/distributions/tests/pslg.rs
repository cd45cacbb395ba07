//! PSLGs: their counts, and that no segments cross.

use distributions::{Kind, LongSegments, Pslg, Unsupported};

const KINDS: [Kind; 3] = [Kind::Uniform, Kind::Kuzmin, Kind::LineSingularity];

type Point = [f64; 2];

/// Returns the sign of the turn a, b, c, or 0 if f64 cannot decide (J. R. Shewchuk's bound for the
/// error, 1997).
fn turn(a: Point, b: Point, c: Point) -> i32 {
    let left = (a[0] - c[0]) * (b[1] - c[1]);
    let right = (a[1] - c[1]) * (b[0] - c[0]);
    let det = left - right;
    if det.abs() > 3.4e-16 * (left.abs() + right.abs()) {
        if det > 0.0 { 1 } else { -1 }
    } else {
        0
    }
}

/// Returns whether two segments are certainly disjoint: one is strictly on one side of the other's
/// line.
fn apart([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let boxes_apart = (0..2).any(|i| a[i].max(b[i]) < c[i].min(d[i]) || c[i].max(d[i]) < a[i].min(b[i]));
    boxes_apart || turn(a, b, c) * turn(a, b, d) > 0 || turn(c, d, a) * turn(c, d, b) > 0
}

/// Asserts that no two segments meet except in a common end, and that two with a common end are not
/// collinear.
fn assert_plane(points: &[Point], segments: &[[u32; 2]]) {
    let ends: Vec<[Point; 2]> = segments.iter().map(|s| s.map(|i| points[i as usize])).collect();
    for i in 0..segments.len() {
        for j in 0..i {
            match segments[i].iter().find(|end| segments[j].contains(end)) {
                Some(common) => {
                    let other = |s: [u32; 2]| points[if s[0] == *common { s[1] } else { s[0] } as usize];
                    let [a, b] = [other(segments[i]), other(segments[j])];
                    assert_ne!(turn(points[*common as usize], a, b), 0, "segments {i} and {j} overlap");
                }
                None => assert!(apart(ends[i], ends[j]), "{:?} crosses {:?}", ends[i], ends[j]),
            }
        }
    }
}

#[test]
fn segments_of_a_pslg_do_not_cross() {
    for kind in KINDS {
        for (n, seed) in [(3000, 1), (10, 2), (11, 3), (30, 4), (30, 5), (100, 6), (300, 7)] {
            let pslg = Pslg::new(kind, n, 1.0, seed).unwrap();
            let points: Vec<Point> = pslg.points().collect();
            let segments: Vec<[u32; 2]> = pslg.segments().collect();
            assert_eq!(points.len() as u64, n);
            assert_eq!(segments.len() as u64, n / 3 * 3);
            assert_plane(&points, &segments);
        }
    }
}

#[test]
fn segments_in_wide_sectors_do_not_cross() {
    // With few cells, sectors are wide, and most first draws intersect the inner circle.
    for seed in 0..200 {
        let pslg = Pslg::new(Kind::Kuzmin, 45, 1.0, seed).unwrap();
        assert_plane(&pslg.points().collect::<Vec<_>>(), &pslg.segments().collect::<Vec<_>>());
    }
}

#[test]
fn every_number_of_points_is_possible() {
    for kind in KINDS {
        for n in 0..50 {
            let pslg = Pslg::new(kind, n, 1.0, 3).unwrap();
            assert_eq!(pslg.points().count() as u64, n);
            assert_eq!(pslg.points().size_hint(), (n as usize, Some(n as usize)));
            assert!(pslg.segments().flatten().all(|end| u64::from(end) < n));
            assert!(pslg.points().flatten().all(f64::is_finite));
        }
    }
}

#[test]
fn alpha_is_the_number_of_segments_per_point() {
    let n = 300_000;
    for (alpha, slack) in [(0.0, 0), (0.1, 2000), (0.5, 2000), (1.0, 0)] {
        let pslg = Pslg::new(Kind::Uniform, n, alpha, 5).unwrap();
        let expected = (alpha * n as f64) as u64;
        let count = pslg.segments().count() as u64;
        assert!(count.abs_diff(expected) <= slack, "alpha {alpha}: {count}");
        assert!(
            pslg.points().eq(Pslg::new(Kind::Uniform, n, 1.0, 5).unwrap().points()),
            "points do not depend on alpha"
        );
    }
}

#[test]
fn a_cell_has_all_three_segments_or_none() {
    let segments: Vec<[u32; 2]> = Pslg::new(Kind::Kuzmin, 3000, 0.3, 5).unwrap().segments().collect();
    for triple in segments.chunks(3) {
        let a = triple[0][0];
        assert_eq!(a % 3, 0);
        assert_eq!(triple, [[a, a + 1], [a + 1, a + 2], [a + 2, a]]);
    }
}

#[test]
fn points_of_a_pslg_keep_their_distribution() {
    let n = 30_000;
    let points = |kind| Pslg::new(kind, n, 0.5, 5).unwrap().points();
    let half = |count: usize| (14_500..15_500).contains(&count);
    assert!(half(points(Kind::Uniform).filter(|p| p[0] < 0.5).count()));
    assert!(half(points(Kind::Uniform).filter(|p| p[1] < 0.5).count()));
    assert!(half(points(Kind::LineSingularity).filter(|p| p[0] < 0.0198).count()));
    // M(√3) = 1 - 1/2
    assert!(half(points(Kind::Kuzmin).filter(|[x, y]| x * x + y * y < 3.0).count()));
    assert!(half(points(Kind::Kuzmin).filter(|[x, _]| *x < 0.0).count()));
    let order: Vec<bool> = points(Kind::Uniform).map(|p| p[1] < 0.5).collect();
    assert!(
        half(order[..15_000].iter().filter(|&&low| low).count() * 2),
        "cells come in no order"
    );
}

#[test]
fn pslgs_larger_than_memory_are_generated() {
    let pslg = Pslg::new(Kind::Kuzmin, 1 << 32, 1.0, 5).unwrap();
    assert_eq!(pslg.points().take(999).count(), 999);
    assert_eq!(pslg.segments().take(3).last(), Some([2, 0]));
    let long = LongSegments::new(0, 1 << 31, 5).unwrap();
    assert_eq!(long.points().take(999).count(), 999);
    let points: Vec<Point> = long.points().take(2000).collect();
    assert_plane(&points, &long.segments().take(1000).collect::<Vec<_>>());
}

#[test]
fn unsupported_kinds_alphas_and_sizes_are_refused() {
    assert_eq!(
        Pslg::new(Kind::Grid, 10, 0.5, 1).unwrap_err(),
        Unsupported::Kind(Kind::Grid)
    );
    assert_eq!(
        Pslg::new(Kind::Uniform, 10, 1.5, 1).unwrap_err(),
        Unsupported::Alpha(1.5)
    );
    assert!(Pslg::new(Kind::Uniform, 10, f64::NAN, 1).is_err());
    assert!(Pslg::new(Kind::Uniform, (1 << 32) + 1, 0.5, 1).is_err());
    let error = LongSegments::new(1 << 32, 1, 1).unwrap_err();
    assert_eq!(error, Unsupported::Records((1 << 32) + 2));
    assert!(error.to_string().contains("4294967298"));
    assert!(LongSegments::new(1, u64::MAX, 1).is_err());
    let error = Unsupported::Kind(Kind::Lidar).to_string();
    assert_eq!(
        error,
        "there is no PSLG of kind lidar, only of uniform, kuzmin, line-singularity"
    );
}

#[test]
fn long_segments_cross_the_square_and_not_each_other() {
    for (m, seed) in [(1, 1), (2, 2), (2000, 3), (2000, 4)] {
        let long = LongSegments::new(500, m, seed).unwrap();
        let points: Vec<Point> = long.points().collect();
        let segments: Vec<[u32; 2]> = long.segments().collect();
        assert_eq!((points.len() as u64, long.records()), (500 + 2 * m, 500 + 2 * m));
        assert_eq!(segments.len() as u64, m);
        assert!(points.iter().flatten().all(|x| (0.0..=1.0).contains(x)));
        assert!(segments.iter().flatten().all(|&end| end >= 500));
        for s in &segments {
            let [left, right] = s.map(|i| points[i as usize]);
            assert!(left[0] < 0.01 && right[0] > 0.99);
        }
        assert_plane(&points, &segments);
    }
}

#[test]
fn slopes_of_long_segments_are_unordered() {
    let long = LongSegments::new(0, 2000, 3).unwrap();
    let ends: Vec<Point> = long.points().collect();
    let slopes: Vec<f64> = ends.chunks(2).map(|s| s[1][1] - s[0][1]).collect();
    assert!(slopes.iter().any(|slope| slope.abs() > 0.15), "some are steep");
    assert!(slopes.iter().any(|slope| slope.abs() < 0.01), "some are flat");
    let rises = ends
        .chunks(2)
        .zip(ends.chunks(2).skip(1))
        .filter(|(a, b)| a[0][1] < b[0][1])
        .count();
    assert!((900..1100).contains(&rises), "{rises}");
}
