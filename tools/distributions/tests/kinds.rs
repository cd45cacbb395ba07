//! Each kind has the properties that its description states.

use std::collections::{HashMap, HashSet};

use distributions::{Kind, points, points3};

fn collect(kind: Kind, n: u64) -> Vec<[f64; 2]> {
    points(kind, n, 7).collect()
}

fn bits(p: [f64; 2]) -> [u64; 2] {
    p.map(f64::to_bits)
}

/// Returns the greatest difference between the distribution of a sample and a cumulative
/// distribution (Kolmogorov-Smirnov).
fn difference(mut sample: Vec<f64>, cumulative: impl Fn(f64) -> f64) -> f64 {
    sample.sort_by(f64::total_cmp);
    let n = sample.len() as f64;
    let at = |(i, &x): (usize, &f64)| {
        (cumulative(x) - i as f64 / n)
            .abs()
            .max((cumulative(x) - (i + 1) as f64 / n).abs())
    };
    sample.iter().enumerate().map(at).fold(0.0, f64::max)
}

/// Returns a bound that one sample of n in 5000 exceeds by chance; the samples of these seeds do
/// not.
fn tolerance(n: u64) -> f64 {
    2.15 / (n as f64).sqrt()
}

/// Returns whether `x` is a multiple of `step`, up to rounding.
fn is_multiple(x: f64, step: f64) -> bool {
    let quotient = x / step;
    (quotient - quotient.round()).abs() < 1e-4
}

#[test]
fn names_parse_to_the_kind_that_wrote_them() {
    for kind in Kind::ALL {
        assert_eq!(kind.to_string().parse(), Ok(kind));
        assert!(kind.name().chars().all(|c| c.is_ascii_lowercase() || c == '-'));
        assert!(!kind.about().is_empty());
    }
    let names: HashSet<_> = Kind::ALL.map(Kind::name).into();
    assert_eq!(names.len(), Kind::ALL.len());
    let error = "gird".parse::<Kind>().unwrap_err().to_string();
    assert!(
        error.contains("'gird'") && error.contains("line-singularity"),
        "{error}"
    );
}

#[test]
fn every_call_returns_the_same_n_finite_points() {
    for kind in Kind::ALL {
        for n in [0, 1, 2, 3, 7, 100, 10_000] {
            let cloud = collect(kind, n);
            assert_eq!(cloud.len() as u64, n, "{kind}");
            assert!(cloud.iter().flatten().all(|x| x.is_finite()), "{kind}");
            assert_eq!(cloud, collect(kind, n), "{kind}");
            assert_eq!(points(kind, n, 7).size_hint(), (n as usize, Some(n as usize)));
        }
    }
}

#[test]
fn different_seeds_give_different_points() {
    for kind in Kind::ALL {
        let [a, b] = [1, 2].map(|seed| points(kind, 1000, seed).collect::<Vec<_>>());
        // Cities of different seeds differ only in the vertices between crossings.
        assert_ne!(a, b, "{kind}");
    }
}

#[test]
fn sets_larger_than_any_memory_are_generated() {
    for kind in Kind::ALL {
        let some: Vec<_> = points(kind, 1 << 50, 7).take(1000).collect();
        assert_eq!(some.len(), 1000);
        assert!(some.iter().flatten().all(|x| x.is_finite()), "{kind}");
    }
}

#[test]
fn only_lidar_points_have_heights() {
    for kind in Kind::ALL {
        let cloud: Vec<_> = points3(kind, 1000, 7).collect();
        assert!(
            cloud.iter().map(|&[x, y, _]| [x, y]).eq(points(kind, 1000, 7)),
            "{kind}"
        );
        assert_eq!(cloud.iter().any(|p| p[2] != 0.0), kind.has_z(), "{kind}");
        assert!(cloud.iter().all(|p| is_multiple(p[2], 0.01) && p[2] < 360.0));
    }
}

#[test]
fn uniform_points_are_uniform_in_the_square() {
    let n = 100_000;
    for i in 0..2 {
        let sample: Vec<f64> = points(Kind::Uniform, n, 7).map(|p| p[i]).collect();
        assert!(sample.iter().all(|x| (0.0..1.0).contains(x)));
        assert!(difference(sample, |x| x) < tolerance(n));
    }
}

#[test]
fn kuzmin_points_have_their_radial_mass_and_uniform_angles() {
    let n = 100_000;
    let cloud = collect(Kind::Kuzmin, n);
    let radii = cloud.iter().map(|[x, y]| x.hypot(*y)).collect();
    assert!(difference(radii, |r| 1.0 - 1.0 / (1.0 + r * r).sqrt()) < tolerance(n));
    let angles = cloud.iter().map(|[x, y]| y.atan2(*x)).collect();
    assert!(difference(angles, |a| 0.5 + a / std::f64::consts::TAU) < tolerance(n));
}

#[test]
fn line_singularity_points_are_dense_near_their_line() {
    let n = 100_000;
    let b = 0.01;
    let cloud = collect(Kind::LineSingularity, n);
    assert!(cloud.iter().flatten().all(|x| (0.0..=1.0).contains(x)));
    // x = b/(u - bu + b) solved for u, which decreases as x increases
    let mass = |x: f64| 1.0 - (b / x - b) / (1.0 - b);
    assert!(difference(cloud.iter().map(|p| p[0]).collect(), mass) < tolerance(n));
    assert!(difference(cloud.iter().map(|p| p[1]).collect(), |v| v) < tolerance(n));
    let near = cloud.iter().filter(|p| p[0] < 2.0 * b).count();
    assert!((48_000..52_000).contains(&near), "{near}");
}

#[test]
fn grid_has_each_of_its_first_cells_once() {
    for (n, columns) in [(1, 1), (9, 3), (10, 4), (1000, 32), (20_000, 142)] {
        let cells: HashSet<[u64; 2]> = points(Kind::Grid, n, 7).map(|p| p.map(|x| x as u64)).collect();
        let expected: HashSet<[u64; 2]> = (0..n).map(|i| [i % columns, i / columns]).collect();
        assert_eq!(cells, expected);
    }
}

#[test]
fn lidar_scans_in_lines() {
    let n = 1_000_000;
    let cloud = collect(Kind::Lidar, n);
    assert!(cloud.iter().all(|&[x, y]| {
        // As LAS computes it: the nearest integer, times the scale, plus the offset, to the last
        // bit.
        let [i, j] = [(x - 600_000.0) * 100.0, (y - 4_900_000.0) * 100.0].map(f64::round);
        x == i * 0.01 + 600_000.0 && y == j * 0.01 + 4_900_000.0
    }));
    let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let far = cloud.windows(2).filter(|w| apart(w[0], w[1]) > 2.0).count();
    assert!(far <= 2, "{far} gaps, expected one between two strips");
    let width = cloud.iter().map(|p| p[0]).fold(0.0, f64::max) - 600_000.0;
    assert!((500.0..700.0).contains(&width), "{width}");
}

#[test]
fn circle_points_are_exact_up_to_their_largest_number() {
    for n in [3, 10, 1000, 50_000] {
        let cloud = collect(Kind::Circle, n);
        let squares: HashSet<i128> = cloud
            .iter()
            .map(|p| p.iter().map(|&x| (x as i128) * (x as i128)).sum())
            .collect();
        assert_eq!(squares.len(), 1, "one radius");
        assert!(cloud.iter().flatten().all(|x| x.fract() == 0.0 && x.abs() < 9e15));
        assert_eq!(cloud.iter().map(|&p| bits(p)).collect::<HashSet<_>>().len() as u64, n);
    }
    assert!(points(Kind::Circle, 400_000, 7).all(|[x, y]| (x * x + y * y - 1.0).abs() < 1e-15));
}

#[test]
fn parabola_and_line_are_exact() {
    let mut parabola = collect(Kind::Parabola, 5000);
    let mut line = collect(Kind::Line, 5000);
    assert!(!parabola.is_sorted_by_key(|p| p[0]) && !line.is_sorted_by_key(|p| p[0]));
    parabola.sort_by(|a, b| a[0].total_cmp(&b[0]));
    line.sort_by(|a, b| a[0].total_cmp(&b[0]));
    for i in 0..5000 {
        let x = i as f64;
        assert_eq!(parabola[i], [x, x * x]);
        assert_eq!(line[i], [3.0 * x, x]);
    }
}

#[test]
fn each_of_four_lines_has_a_quarter_of_the_points() {
    let n = 8000;
    let cloud = collect(Kind::FourLines, n);
    assert_eq!(cloud.iter().map(|&p| bits(p)).collect::<HashSet<_>>().len() as u64, n);
    let mut counts = [0; 4];
    for [x, y] in cloud {
        assert!(x.abs().max(y.abs()) % 2.0 == 1.0);
        let on = [y == 0.0, x == 0.0, x == y, x == -y];
        assert_eq!(on.iter().filter(|&&b| b).count(), 1);
        counts[on.iter().position(|&b| b).unwrap()] += 1;
    }
    assert_eq!(counts, [n / 4; 4]);
}

#[test]
fn clusters_are_uneven_on_every_scale() {
    let cloud = collect(Kind::Clusters, 100_000);
    // At each of these sizes, a few cells of a grid have most of the points.
    for (cells, share) in [(16.0, 0.4), (128.0, 0.2), (1024.0, 0.1)] {
        let mut counts: HashMap<[i64; 2], usize> = HashMap::new();
        cloud
            .iter()
            .for_each(|p| *counts.entry(p.map(|x| (x * cells).floor() as i64)).or_default() += 1);
        let mut counts: Vec<usize> = counts.into_values().collect();
        counts.sort_unstable_by(|a, b| b.cmp(a));
        let top: usize = counts.iter().take(cells as usize / 2).sum();
        assert!(top as f64 > share * 1e5, "{cells}: {top}");
    }
}

#[test]
fn duplicates_are_equal_to_the_bit() {
    let n = 80_000;
    let mut counts: HashMap<[u64; 2], u64> = HashMap::new();
    collect(Kind::Duplicates, n)
        .into_iter()
        .for_each(|p| *counts.entry(bits(p)).or_default() += 1);
    assert!((9_000..=10_000).contains(&counts.len()), "{}", counts.len());
    assert_eq!(counts.values().filter(|&&c| c > 1000).count(), 4);
}

#[test]
fn contours_have_a_point_every_unit_on_lines_40_apart() {
    let n = 100_000;
    let cloud = collect(Kind::Contours, n);
    let steps: Vec<f64> = cloud
        .windows(2)
        .map(|w| (w[0][0] - w[1][0]).hypot(w[0][1] - w[1][1]))
        .collect();
    let lines = 1 + steps.iter().filter(|&&step| step > 2.0).count();
    assert!((45..52).contains(&lines), "{lines}");
    assert!(steps.iter().all(|&step| (0.95..1.05).contains(&step) || step > 100.0));
    assert!(cloud.iter().flatten().all(|&x| is_multiple(x, 0.01)));
    // At each x, lines are in order and at least 20 apart.
    let mut columns: HashMap<i64, Vec<f64>> = HashMap::new();
    cloud
        .iter()
        .for_each(|p| columns.entry(p[0].round() as i64).or_default().push(p[1]));
    for heights in columns.values() {
        assert!(
            heights
                .windows(2)
                .all(|w| w[1] - w[0] > 20.0 || (w[1] - w[0]).abs() < 2.0)
        );
    }
}

#[test]
fn streets_share_their_crossings() {
    let cloud = collect(Kind::Streets, 50_000);
    let mut counts: HashMap<[u64; 2], u64> = HashMap::new();
    for &p in &cloud {
        assert!(p.iter().all(|&x| is_multiple(x, 0.01)));
        let [along, across] = [0.8 * p[0] + 0.6 * p[1], 0.8 * p[1] - 0.6 * p[0]];
        let on = |x: f64| (x / 100.0 - (x / 100.0).round()).abs() < 2e-4;
        assert!(on(along) || on(across), "{p:?} is on no street");
        if on(along) && on(across) {
            *counts.entry(bits(p)).or_default() += 1;
        }
    }
    let twice = counts.values().filter(|&&count| count == 2).count();
    assert!(twice > 2000 && counts.values().all(|&count| count <= 2), "{twice}");
}

#[test]
fn consecutive_track_points_are_near_each_other() {
    let cloud = collect(Kind::Tracks, 200_000);
    assert!(cloud.iter().flatten().all(|x| (x * 1e6).round() / 1e6 == *x));
    assert!(
        cloud
            .iter()
            .all(|[lon, lat]| (8.0..9.0).contains(lon) && (47.0..48.0).contains(lat))
    );
    let jumps = cloud
        .windows(2)
        .filter(|w| (w[0][0] - w[1][0]).abs().max((w[0][1] - w[1][1]).abs()) > 5e-4)
        .count();
    assert!((60..250).contains(&jumps), "{jumps} tracks after the first");
}

#[test]
fn offset_points_are_a_grid_far_from_the_origin() {
    let n = 10_000;
    let cells: HashSet<[i64; 2]> = points(Kind::Offset, n, 7)
        .map(|p| {
            p.map(|x| {
                let i = ((x - 1e6) * 1e3).round();
                assert_eq!(x, 1e6 + i * 1e-3);
                i as i64
            })
        })
        .collect();
    assert_eq!(cells.len() as u64, n);
    assert!(cells.iter().flatten().all(|i| (0..100).contains(i)));
}

#[test]
fn nearly_collinear_runs_miss_their_line_by_an_ulp() {
    let cloud = collect(Kind::NearlyCollinear, 10_000);
    for run in cloud.chunks(1000) {
        let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let start = run[0];
        let end = *run
            .iter()
            .max_by(|a, b| distance(**a, start).total_cmp(&distance(**b, start)))
            .unwrap();
        let cross = |p: [f64; 2]| (end[0] - start[0]) * (p[1] - start[1]) - (end[1] - start[1]) * (p[0] - start[0]);
        let off: Vec<f64> = run.iter().map(|&p| cross(p).abs() / distance(start, end)).collect();
        assert!(off.iter().all(|&d| d < 3e-15));
        assert!(off.iter().filter(|&&d| d > 0.0).count() > 500, "but not on it");
    }
}
