//! Regions and sources as an in-core search finds them.

use std::collections::HashMap;

use delaunay_tiles::geometry::{HalfEdge, Orientation, Point, TriangleId, orient2d};
use delaunay_tiles::input::SiteId;
use delaunay_tiles::mesh::{Constrained, EngineKind, Inserter, Topology, Triangulation};
use delaunay_tiles::store::{EdgeSource, LineKind};

use super::Input;
use crate::support::distinct;

/// The region, the depth and the hole flag of a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleFacts {
    pub(crate) component: usize,
    pub(crate) depth: i32,
    pub(crate) is_hole: bool,
}

/// What a build must find.
pub(crate) struct Expected {
    pub(crate) triangles: HashMap<Key, TriangleFacts>,
    pub(crate) regions: usize,
    pub(crate) has_regions: bool,
    pub(crate) hole_regions: usize,
    /// Each edge, from its smaller end on, with one of its sources.
    pub(crate) sources: Vec<([Point; 2], EdgeSource)>,
    pub(crate) sites: Vec<(Point, String)>,
    pub(crate) sites_in_holes: u64,
}

/// The corners of a triangle, sorted.
pub(crate) type Key = [[u64; 2]; 3];

pub(crate) fn key(corners: [Point; 3]) -> Key {
    let mut key = corners.map(|p| [p.x.to_bits(), p.y.to_bits()]);
    key.sort_unstable();
    key
}

impl Expected {
    pub(crate) fn of(input: &Input) -> Self {
        let corners = input.lines.iter().flat_map(|line| line.corners());
        let sites = input.sites.iter().map(|(point, _)| point);
        let points = distinct(
            &input
                .points
                .iter()
                .chain(corners)
                .chain(sites)
                .copied()
                .collect::<Vec<_>>(),
        );
        let number = |p: Point| points.binary_search_by(|q| q.lex_cmp(p)).unwrap() as u32;
        let mut mesh = Triangulation::default();
        EngineKind::Native.create().triangulate(&points, &mut mesh);
        let mut mesh = Constrained::new(mesh, points.len());
        let mut inserter = Inserter::default();
        let segments = || input.lines.iter().flat_map(|line| line.segments());
        for segment in segments() {
            inserter.insert(&points, &mut mesh, segment.map(number)).unwrap();
        }

        let corners = |triangle: usize| mesh.mesh().triangles[triangle].map(|v| points[v as usize]);
        let count = mesh.mesh().triangles.len();
        let mut component = vec![usize::MAX; count];
        let mut regions = 0;
        let mut is_exterior = Vec::new();
        for first in 0..count {
            if component[first] != usize::MAX {
                continue;
            }
            is_exterior.push(false);
            component[first] = regions;
            let mut reached = vec![first];
            while let Some(triangle) = reached.pop() {
                let half_edges = HalfEdge::of_triangle(TriangleId(triangle as u32));
                for half_edge in half_edges
                    .into_iter()
                    .filter(|&half_edge| !mesh.is_constraint(half_edge))
                {
                    match mesh
                        .mesh()
                        .twin(half_edge)
                        .half_edge()
                        .map(|twin| twin.triangle().index())
                    {
                        None => is_exterior[regions] = true,
                        Some(other) if component[other] == usize::MAX => {
                            component[other] = regions;
                            reached.push(other);
                        }
                        Some(_) => {}
                    }
                }
            }
            regions += 1;
        }
        let obstacles = || input.lines.iter().filter(|line| line.kind == LineKind::Obstacle);
        let rings: Vec<[Point; 2]> = obstacles().flat_map(|line| line.segments()).collect();
        let mut is_hole = vec![false; regions];
        let depths: Vec<i32> = (0..count).map(|triangle| winding(&rings, corners(triangle))).collect();
        for triangle in 0..count {
            let is_seeded = input.seeds.iter().any(|&seed| contains(corners(triangle), seed));
            let region = component[triangle];
            is_hole[region] |= depths[triangle] != 0 || is_seeded || input.exterior_is_hole && is_exterior[region];
        }
        // A vertex beside free space: that of a triangle, or the outside.
        let mut is_reached = vec![false; points.len()];
        for (triangle, corners) in mesh.mesh().triangles.iter().enumerate() {
            let is_free = !is_hole[component[triangle]];
            for half_edge in HalfEdge::of_triangle(TriangleId(triangle as u32)) {
                let is_hull = mesh.mesh().twin(half_edge).half_edge().is_none();
                if is_free || is_hull && !input.exterior_is_hole {
                    let [from, to] = [half_edge, half_edge.next()].map(|side| corners[side.corner() as usize]);
                    is_reached[from as usize] = true;
                    is_reached[to as usize] = true;
                }
            }
        }
        let in_holes = input.sites.iter().filter(|site| !is_reached[number(site.0) as usize]);
        let sites_in_holes = in_holes.count() as u64;
        let triangles = (0..count).map(|triangle| {
            let of = TriangleFacts {
                component: component[triangle],
                depth: depths[triangle],
                is_hole: is_hole[component[triangle]],
            };
            (key(corners(triangle)), of)
        });
        Self {
            triangles: triangles.collect(),
            regions,
            has_regions: !input.lines.is_empty() || !input.seeds.is_empty() || input.exterior_is_hole,
            hole_regions: is_hole.iter().filter(|is_hole| **is_hole).count(),
            sources: sources(input, &points),
            sites: named(&input.sites),
            sites_in_holes,
        }
    }
}

fn named(sites: &[(Point, SiteId)]) -> Vec<(Point, String)> {
    let mut sites: Vec<(Point, String)> = sites.iter().map(|(point, id)| (*point, id.to_string())).collect();
    sites.sort_by(|a, b| a.0.lex_cmp(b.0).then(a.1.cmp(&b.1)));
    sites
}

/// Returns whether a closed triangle contains a point.
fn contains([a, b, c]: [Point; 3], p: Point) -> bool {
    [(a, b), (b, c), (c, a)]
        .into_iter()
        .all(|(from, to)| orient2d(from, to, p) != Orientation::Clockwise)
}

/// Returns the winding number of rings around the centroid of a triangle. All coordinates are small
/// integers, so everything is exact.
fn winding(rings: &[[Point; 2]], [a, b, c]: [Point; 3]) -> i32 {
    let middle = Point::new(a.x + b.x + c.x, a.y + b.y + c.y);
    let mut winding = 0;
    for segment in rings {
        let [from, to] = segment.map(|p| Point::new(3.0 * p.x, 3.0 * p.y));
        if (from.y <= middle.y) != (to.y <= middle.y) {
            let turn = orient2d(from, to, middle);
            match from.y <= middle.y {
                true if turn == Orientation::CounterClockwise => winding += 1,
                false if turn == Orientation::Clockwise => winding -= 1,
                _ => {}
            }
        }
    }
    winding
}

/// Returns the sources of every edge along a line.
fn sources(input: &Input, points: &[Point]) -> Vec<([Point; 2], EdgeSource)> {
    let mut sources = Vec::new();
    for (line, number) in input.lines.iter().zip(0..) {
        for [a, b] in line.segments() {
            let source = EdgeSource::new(line.kind, number);
            let (low, high, source) = match a.lex_cmp(b).is_lt() {
                true => (a, b, source),
                false => (b, a, source.reversed()),
            };
            let is_between = |p: &&Point| {
                p.lex_cmp(low).is_ge() && p.lex_cmp(high).is_le() && orient2d(a, b, **p) == Orientation::Collinear
            };
            let on_it: Vec<Point> = points.iter().filter(is_between).copied().collect();
            if a != b {
                sources.extend(on_it.windows(2).map(|pair| ([pair[0], pair[1]], source)));
            }
        }
    }
    let order = |a: &([Point; 2], EdgeSource), b: &([Point; 2], EdgeSource)| {
        let ends = a.0[0].lex_cmp(b.0[0]).then(a.0[1].lex_cmp(b.0[1]));
        ends.then(a.1.cmp(&b.1))
    };
    sources.sort_by(order);
    // For obstacles, each occurrence counts.
    sources.dedup_by(|a, b| a == b && a.1.kind() != LineKind::Obstacle);
    sources
}
