//! Many segments of all shapes: the search finds the same crossings as brute force, and does not
//! test too many pairs.

use std::cell::Cell;
use std::ops::ControlFlow;

use crate::constraints::crossings::tests::*;
use crate::geometry::{Point, Rect};

/// A pseudo-random number generator, the same each time.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed ^ (mixed >> 31)
    }

    /// Returns a number from 0 to 1.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn point(&mut self) -> Point {
        Point::new(self.unit(), self.unit())
    }

    /// Returns a segment whose length is about `length`.
    fn short(&mut self, length: f64) -> [Point; 2] {
        let (a, step) = (self.point(), self.point());
        [
            a,
            Point::new(a.x + (step.x - 0.5) * length, a.y + (step.y - 0.5) * length),
        ]
    }

    fn shuffle<T>(&mut self, list: &mut [T]) {
        for last in (1..list.len()).rev() {
            list.swap(last, self.next() as usize % (last + 1));
        }
    }
}

fn moved(p: Point, x: f64, y: f64) -> Point {
    Point::new(p.x + x, p.y + y)
}

/// Returns the edges of a triangulated grid whose vertices are moved a little.
fn mesh(side: usize, random: &mut Random) -> Vec<[Point; 2]> {
    let vertices: Vec<Point> = (0..side * side)
        .map(|i| {
            moved(
                point([(i % side) as i32, (i / side) as i32]),
                random.unit() / 4.0,
                random.unit() / 4.0,
            )
        })
        .collect();
    let mut edges = Vec::new();
    for a in (0..side * (side - 1)).filter(|i| i % side + 1 < side) {
        let [right, up] = [a + 1, a + side];
        edges.extend([[a, right], [a, up], [right, up]].map(|edge| edge.map(|v| vertices[v])));
    }
    random.shuffle(&mut edges);
    edges
}

fn star(rays: usize, centre: Point, mut length: impl FnMut() -> f64) -> Vec<[Point; 2]> {
    let ray = |i: usize| {
        let (sine, cosine) = (i as f64 / rays as f64 * std::f64::consts::TAU).sin_cos();
        let length = length();
        [centre, moved(centre, cosine * length, sine * length)]
    };
    (0..rays).map(ray).collect()
}

/// Returns the number of tested pairs per segment.
fn tests_per_segment(segments: &[[Point; 2]]) -> f64 {
    let tests = Cell::new(0u64);
    let meet = |_: [Point; 2], _: [Point; 2], _: Rect| {
        tests.set(tests.get() + 1);
        None
    };
    let done = search(segments, Rect::PLANE, &meet, &mut |_, _, _| ControlFlow::Continue(()));
    assert!(done.is_continue());
    tests.get() as f64 / segments.len() as f64
}

#[track_caller]
fn check_effort(segments: &[[Point; 2]], most: f64) {
    let tests = tests_per_segment(segments);
    assert!(tests <= most, "{tests} pairs are tested for each of {}", segments.len());
}

#[test]
fn edges_of_a_mesh_do_not_cross() {
    // More than the search copies to be contiguous.
    let mut segments = mesh(90, &mut Random(1));
    assert_eq!(found_in(&segments, Rect::PLANE), Crossings::new());
    check_effort(&segments, 10.0);
    // Now add some that cross.
    segments.extend((0..20).map(|i| [point([i, -1]), point([80 - 3 * i, 91])]));
    check(&segments);
}

#[test]
fn many_short_segments_take_few_tests() {
    let mut random = Random(2);
    let segments: Vec<_> = (0..40_000).map(|_| random.short(0.01)).collect();
    check(&segments);
    check_effort(&segments, 10.0);
}

#[test]
fn long_segments_across_short_ones_take_few_tests() {
    let mut random = Random(3);
    let mut segments: Vec<_> = (0..20_000).map(|_| random.short(0.01)).collect();
    segments.extend((0..60).map(|_| [random.point(), random.point()]));
    random.shuffle(&mut segments);
    check(&segments);
    check_effort(&segments, 10.0);
}

#[test]
fn crossings_of_long_segments_equal_brute_force() {
    let mut random = Random(4);
    let segments: Vec<_> = (0..400).map(|_| [random.point(), random.point()]).collect();
    check(&segments);
}

#[test]
fn crossings_among_touching_integer_segments_equal_brute_force() {
    let mut random = Random(5);
    let mut coordinate = |most: u64| (random.next() % most) as i32;
    let segments: Vec<_> = (0..20_000)
        .map(|_| {
            let a = [coordinate(300), coordinate(300)];
            [point(a), point([a[0] + coordinate(9) - 4, a[1] + coordinate(9) - 4])]
        })
        .collect();
    check(&segments);
}

#[test]
fn stars_take_few_tests() {
    let mut random = Random(6);
    let centre = Point::new(0.25, 0.5);
    let even = star(20_000, centre, || 1.0);
    assert_eq!(found_in(&even, Rect::PLANE), Crossings::new());
    check_effort(&even, 0.0);
    let mut uneven = star(20_000, centre, || random.unit().powi(4));
    check_effort(&uneven, 1.0);
    // A few segments across the rays, and many elsewhere.
    let mut random = Random(7);
    uneven.extend((0..30).map(|_| random.short(0.5)));
    uneven.extend((0..20_000).map(|_| random.short(0.002).map(|p| moved(p, 1.5, 0.0))));
    random.shuffle(&mut uneven);
    check(&uneven);
}

#[test]
fn segments_between_the_rays_of_a_star_take_few_tests() {
    let rays = 4000;
    let mut segments = star(rays, Point::new(0.0, 0.0), || 1.0);
    for i in 0..rays {
        let (sine, cosine) = ((i as f64 + 0.5) / rays as f64 * std::f64::consts::TAU).sin_cos();
        segments.push([0.6, 0.601].map(|at| Point::new(cosine * at, sine * at)));
    }
    assert_eq!(found_in(&segments, Rect::PLANE), Crossings::new());
    check_effort(&segments, 400.0);
}

#[test]
fn two_facing_stars_take_few_tests() {
    let between = |i: i32| Point::new(0.5, f64::from(i) / 20_000.0);
    let mut segments: Vec<_> = (0..20_000).map(|i| [Point::new(0.0, 0.0), between(i)]).collect();
    segments.extend((0..20_000).map(|i| [Point::new(1.0, 0.0), between(i)]));
    assert_eq!(found_in(&segments, Rect::PLANE), Crossings::new());
    check_effort(&segments, 400.0);
}

#[test]
fn combs_of_any_slope_take_few_tests() {
    for [x, y] in [[0, 1], [1, 0], [1, 1], [-7, 3]] {
        let along = |i: f64, at: f64| {
            Point::new(
                i * f64::from(y) + at * f64::from(x),
                at * f64::from(y) - i * f64::from(x),
            )
        };
        let mut segments: Vec<_> = (0..20_000)
            .map(|i| [along(i.into(), 0.0), along(i.into(), 1e5)])
            .collect();
        assert_eq!(found_in(&segments, Rect::PLANE), Crossings::new());
        check_effort(&segments, 20.0);
        segments.push([along(-0.5, -1.0), along(2000.5, 7e4)]);
        assert_eq!(found_in(&segments, Rect::PLANE).len(), 2001);
    }
}

#[test]
fn copies_of_one_segment_take_few_tests() {
    let (a, b) = (point([0, 0]), point([3, 1]));
    let mut segments = vec![[a, b]; 10_000];
    segments.extend(vec![[b, a]; 10_000]);
    assert_eq!(found_in(&segments, Rect::PLANE), Crossings::new());
    check_effort(&segments, 0.0);
    segments.extend([[point([1, 2]), point([2, -2])]; 3]);
    assert_eq!(found_in(&segments, Rect::PLANE).len(), 60_000);
}

#[test]
fn overlapping_chains_do_not_cross() {
    let segments: Vec<_> = (0..20_000)
        .map(|i| [point([i, 2 * i]), point([i + 4, 2 * i + 8])])
        .collect();
    assert_eq!(found_in(&segments, Rect::PLANE), Crossings::new());
    check_effort(&segments, 20.0);
}

#[test]
fn crossings_in_nested_clusters_equal_brute_force() {
    let mut random = Random(8);
    let mut segments = Vec::new();
    for level in 0..40 {
        let size = 0.1f64.powi(level);
        let short = |segment: [Point; 2]| segment.map(|p| Point::new(p.x * size, p.y * size));
        segments.extend((0..300).map(|_| short(random.short(0.2))));
    }
    check(&segments);
}

/// Segments so close together that a grid cannot distinguish their positions, and long ones whose
/// rounding is far too coarse for the grid.
#[test]
fn crossings_within_a_few_units_in_the_last_place_equal_brute_force() {
    let mut random = Random(9);
    let unit = 2f64.powi(-33);
    let mut near = || 1e6 + (random.next() % 64) as f64 * unit;
    let mut segments: Vec<_> = (0..300).map(|_| [(); 2].map(|()| Point::new(near(), near()))).collect();
    check(&segments);
    segments.extend((0..300).map(|_| random.short(2e-9).map(|p| moved(p, -0.5, -0.5))));
    segments.extend((0..40).map(|_| {
        random
            .short(1e-12)
            .map(|p| Point::new((p.x - 0.5) * 1e-9, (p.y - 0.5) * 1e-9))
    }));
    segments.extend((0..40).map(|i| {
        [
            Point::new(-1e30, f64::from(i) * 1e10),
            Point::new(1e30, f64::from(i) * -1e10),
        ]
    }));
    check(&segments);
}
