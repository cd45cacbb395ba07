//! Contours in polygons, against closed forms and against a cut of all contours in floating point.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::sync::Arc;

use super::contours::{Contour, contours, doubled_area, exported, options, parsed, point, winding_wall};
use super::rasters::{build, obstacle, terrain};
use crate::support::runtime;
use delaunay_tiles::export::Format;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::terrain::Clip;

type Edges = Vec<[Point; 2]>;

fn ring(corners: &[(f64, f64)]) -> Edges {
    let corner = |i: usize| Point::new(corners[i % corners.len()].0, corners[i % corners.len()].1);
    (0..corners.len()).map(|i| [corner(i), corner(i + 1)]).collect()
}

fn square(x: f64, y: f64, size: f64) -> Edges {
    ring(&[(x, y), (x + size, y), (x + size, y + size), (x, y + size)])
}

fn turned(ring: Edges) -> Edges {
    ring.into_iter().map(|[a, b]| [b, a]).collect()
}

/// A star in the unit square with a square hole, and a polygon that overlaps it.
pub(super) fn star() -> Edges {
    let corners: Vec<(f64, f64)> = (0..20u32)
        .map(|i| {
            let (angle, radius) = (f64::from(i) / 20.0 * TAU, [0.48, 0.25][i as usize % 2]);
            (0.52 + radius * angle.cos(), 0.51 + radius * angle.sin())
        })
        .collect();
    let hole = turned(square(0.45, 0.7, 0.05));
    [ring(&corners), hole, square(0.01, 0.02, 0.3)].concat()
}

fn clip(edges: &Edges) -> Option<Arc<Clip>> {
    Some(Arc::new(Clip::new(edges.clone())))
}

fn distance([a, b]: [Point; 2]) -> f64 {
    (a.x - b.x).hypot(a.y - b.y)
}

/// Returns whether a point is in the polygons, by its winding number alone.
fn is_inside(edges: &Edges, p: Point) -> bool {
    let winding = edges.iter().map(|[a, b]| {
        let right = a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) > p.x;
        i32::from(right && a.y <= p.y && p.y < b.y) - i32::from(right && b.y <= p.y && p.y < a.y)
    });
    winding.sum::<i32>() > 0
}

/// Returns the length of the part of a segment that is in the polygons, from all its crossings.
fn covered(edges: &Edges, [p, q]: [Point; 2]) -> f64 {
    let mut shares = vec![0.0, 1.0];
    for [a, b] in edges {
        let of = |s: Point| (b.x - a.x) * (s.y - a.y) - (b.y - a.y) * (s.x - a.x);
        let share = of(p) / (of(p) - of(q));
        if (0.0..=1.0).contains(&share) {
            shares.push(share);
        }
    }
    shares.sort_by(f64::total_cmp);
    let at = |share: f64| Point::new(p.x + share * (q.x - p.x), p.y + share * (q.y - p.y));
    let parts = shares
        .windows(2)
        .filter(|pair| is_inside(edges, at((pair[0] + pair[1]) / 2.0)));
    parts.map(|pair| pair[1] - pair[0]).sum::<f64>() * distance([p, q])
}

fn segments(contour: &Contour) -> impl Iterator<Item = [Point; 2]> {
    contour.points.windows(2).map(|pair| [pair[0], pair[1]].map(point))
}

/// Returns the sum over the segments of each level.
fn sums(contours: &BTreeSet<Contour>, of: impl Fn([Point; 2]) -> f64) -> BTreeMap<u64, f64> {
    let mut sums = BTreeMap::new();
    for contour in contours {
        let sum = segments(contour).map(&of).sum::<f64>();
        *sums.entry(contour.z).or_insert(0.0) += sum;
    }
    sums.retain(|_, &mut sum| sum > 1e-9);
    sums
}

/// Checks the contours in polygons, given all contours.
fn check(all: &BTreeSet<Contour>, cut: &BTreeSet<Contour>, edges: &Edges) {
    let (expected, found) = (sums(all, |ends| covered(edges, ends)), sums(cut, distance));
    assert!(expected.keys().eq(found.keys()) && !found.is_empty());
    for (level, length) in &found {
        assert!(
            (length / expected[level] - 1.0).abs() < 1e-9,
            "{length}, not {}",
            expected[level]
        );
    }
    let clip = Clip::new(edges.clone());
    let of_all: BTreeSet<_> = all.iter().flat_map(|contour| &contour.points).collect();
    let is_on_edge = |p: Point| {
        edges
            .iter()
            .any(|&[a, b]| distance([a, p]) + distance([p, b]) - distance([a, b]) < 1e-12)
    };
    let mut ends = 0;
    for contour in cut {
        let last = contour.points.len() - 1;
        for (index, &position) in contour.points.iter().enumerate() {
            let is_end = !contour.is_closed && (index == 0 || index == last);
            if of_all.contains(&position) {
                assert!(clip.covers(point(position)));
            } else {
                assert!(is_end && is_on_edge(point(position)), "{contour:?} {index}");
                ends += 1;
            }
        }
    }
    assert!(ends > 0);
    // What no edge cuts is the same contour.
    let is_whole = |contour: &&Contour| {
        let (inside, length) = segments(contour).fold((0.0, 0.0), |(inside, length), ends| {
            (inside + covered(edges, ends), length + distance(ends))
        });
        (inside / length - 1.0).abs() < 1e-9
    };
    let wholes: Vec<_> = all.iter().filter(is_whole).collect();
    assert!(wholes.iter().all(|whole| cut.contains(whole)));
    assert_eq!(
        wholes.iter().filter(|whole| whole.is_closed).count(),
        cut.iter().filter(|contour| contour.is_closed).count()
    );
}

#[test]
fn contours_in_polygons_are_the_covered_parts_of_all_whatever_the_tiles() {
    runtime().block_on(async {
        let (points, z) = terrain(4);
        let mut of_tiles = Vec::new();
        for (tile_vertices, threads) in [(4, 1), (50, 4), (50, 1), (5000, 4)] {
            let scratch = build(&points, &z, &obstacle(), tile_vertices, threads).await;
            let reader = scratch.open().await;
            let cut = contours(&reader, options(0.75, 0.1).clip(clip(&star()))).await;
            if tile_vertices == 50 {
                let all = contours(&reader, options(0.75, 0.1)).await;
                check(&all, &cut, &star());
                assert!(
                    cut.len() > 500 && cut.iter().any(|contour| contour.is_closed),
                    "{}",
                    cut.len()
                );
            }
            of_tiles.push(cut);
        }
        assert!(of_tiles.iter().all(|cut| *cut == of_tiles[0]));
    });
}

#[test]
fn a_cone_in_polygons_has_arcs_and_whole_rings() {
    runtime().block_on(async {
        let (corners, mut points, mut z) = (64u32, vec![Point::default()], vec![10.0]);
        for (radius, corner) in (1..=10).flat_map(|radius| (0..corners).map(move |corner| (radius, corner))) {
            let angle = f64::from(corner) / f64::from(corners) * TAU;
            points.push(Point::new(
                f64::from(radius) * angle.cos(),
                f64::from(radius) * angle.sin(),
            ));
            z.push(10.0 - f64::from(radius));
        }
        for tile_vertices in [4, 5000] {
            let scratch = build(&points, &z, &SegmentBatch::default(), tile_vertices, 2).await;
            let reader = scratch.open().await;
            // The east: half a ring at each level, from the axis to the axis.
            let east = ring(&[(0.0, -20.0), (20.0, -20.0), (20.0, 20.0), (0.0, 20.0)]);
            let found = contours(&reader, options(1.0, 0.0).clip(clip(&east))).await;
            assert_eq!(found.len(), 9);
            for contour in &found {
                let radius = 10.0 - f64::from_bits(contour.z);
                let length: f64 = segments(contour).map(distance).sum();
                let expected = f64::from(corners) * radius * (TAU / f64::from(corners) / 2.0).sin();
                assert!(
                    !contour.is_closed && (length / expected - 1.0).abs() < 1e-12,
                    "{radius}"
                );
                let [from, to] = [0, contour.points.len() - 1].map(|i| point(contour.points[i]));
                // The higher ground stays on the left.
                assert!((from.y + radius).abs() < 1e-12 && (to.y - radius).abs() < 1e-12);
                assert!(from.x.abs() < 1e-12 && to.x.abs() < 1e-12);
            }
            // Between two squares: the ring at 1 touches the inner one from inside, that at 2 is whole, and
            // that at 3 is cut at four corners.
            let between = [square(-2.5, -2.5, 5.0), turned(square(-1.0, -1.0, 2.0))].concat();
            let found = contours(&reader, options(1.0, 0.0).clip(clip(&between))).await;
            let (whole, arcs): (Vec<_>, Vec<_>) = found.iter().partition(|contour| contour.is_closed);
            assert_eq!((whole.len(), arcs.len()), (1, 4));
            let around: Vec<Point> = whole[0].points.iter().map(|&p| point(p)).collect();
            let expected = f64::from(corners) * 4.0 * (TAU / f64::from(corners)).sin();
            assert!((doubled_area(&around) / expected - 1.0).abs() < 1e-12);
            for arc in arcs {
                let ends = [0, arc.points.len() - 1].map(|i| point(arc.points[i]));
                assert!(ends.iter().all(|end| end.x.abs().max(end.y.abs()) == 2.5), "{ends:?}");
            }
            // Along the ring at 3 itself, and beside all.
            let along: Vec<_> = points[129..193].iter().map(|p| (p.x, p.y)).collect();
            let found = contours(&reader, options(3.0, 1.0).clip(clip(&ring(&along)))).await;
            assert!(found.len() == 1 && found.iter().all(|contour| contour.is_closed));
            let beside = exported(
                &reader,
                options(1.0, 0.0).clip(clip(&square(30.0, 0.0, 1.0))),
                Format::GeoJson,
            )
            .await;
            assert!(parsed(Format::GeoJson, &beside.unwrap().output).is_empty());
        }
    });
}

/// A contour that is longer than what is read at once.
#[test]
fn a_long_contour_is_cut_like_others() {
    runtime().block_on(async {
        let scratch = winding_wall().await;
        let reader = scratch.open().await;
        let all = contours(&reader, options(2.0, 0.5)).await;
        let around = options(2.0, 0.5).clip(clip(&square(-1.0, -1.0, 200.0)));
        assert_eq!(contours(&reader, around).await, all);
        let hollow = [square(10.3, 20.7, 140.1), turned(square(60.2, 60.3, 20.6))].concat();
        let inside = options(2.0, 0.5).clip(clip(&hollow));
        let found = contours(&reader, inside.clone()).await;
        check(&all, &found, &hollow);
        assert!(found.len() > 100, "{}", found.len());
        let in_fgb = exported(&reader, inside, Format::FlatGeobuf).await.unwrap();
        assert!(
            parsed(Format::FlatGeobuf, &in_fgb.output)
                .into_iter()
                .collect::<BTreeSet<_>>()
                == found
        );
    });
}
