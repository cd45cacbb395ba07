//! The part of a triangle that polygons cover.
//!
//! In: a triangle and polygons. Out: small triangles that together are the part. Where the number of
//! windings is above 0, a point is in a polygon, however many polygons overlap there.
//!
//! ```text
//!      ╱╲           Horizontal slabs that contain no end and no crossing of edges are
//!  ___╱__╲___       cut by edges into trapezoids. From left to right, each edge
//!    ╱▒▒╱ ╲         changes the winding number, and each side of the triangle whether
//!  _╱▒▒╱___╲_       the trapezoid is in it.
//! ```
//!
//! Which edges meet a slab, and the winding number on its left, is exact. Positions on edges are rounded,
//! relative to the size of the triangle and of the edge.

use super::clip::Clip;
use crate::geometry::{Point, Rect};

/// Edges cross in a slab if they change places by more than this share of their size. Less is rounding:
/// what it moves is a triangle of this share.
const NOISE: f64 = 1.0 / (1u64 << 44) as f64;

/// An edge of a polygon or of the triangle, from its lower to its upper end.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// The y of the ends.
    y: [f64; 2],
    /// The x of the ends, relative to the origin.
    x: [f64; 2],
    /// The winding number of polygons on the right of the edge, less that on the left.
    winding: i64,
    /// The same for the triangle.
    triangle: i64,
}

impl Edge {
    /// Returns an edge. The x are relative to `origin`. A level edge spans no slab, but ends one.
    fn new([a, b]: [Point; 2], origin: f64, is_of_polygon: bool) -> Self {
        let (low, high, change) = if a.y < b.y { (a, b, -1) } else { (b, a, 1) };
        Self {
            y: [low.y, high.y],
            x: [low.x - origin, high.x - origin],
            winding: if is_of_polygon { change } else { 0 },
            triangle: if is_of_polygon { 0 } else { change },
        }
    }

    /// Returns the x of the edge at a y between those of its ends.
    fn at(&self, y: f64) -> f64 {
        let ([low, high], [from, to]) = (self.y, self.x);
        if y == high {
            return to;
        }
        from + (to - from) * ((y - low) / (high - low))
    }
}

/// An edge that spans a slab.
#[derive(Clone, Copy)]
struct Spanning {
    /// The x at the lower and at the upper side of the slab.
    x: [f64; 2],
    /// The size that roundings are relative to.
    size: f64,
    winding: i64,
    triangle: i64,
}

/// A slab to be cut.
struct Slab {
    y: [f64; 2],
    /// The numbers of the edges that meet it.
    edges: Vec<u32>,
}

/// Calls `piece` with the corners and the area of triangles that together are the part of a triangle that
/// polygons cover. They depend on the triangle and on the polygons alone.
pub(crate) fn overlap(corners: [Point; 3], clip: &Clip, mut piece: impl FnMut([Point; 3], f64)) {
    let around = Rect::around(corners);
    let origin = corners[0].x;
    let sides = (0..3).map(|i| Edge::new([corners[i], corners[(i + 1) % 3]], origin, false));
    let near = clip.edges_near(around);
    let near = near.into_iter().map(|ends| Edge::new(ends, origin, true));
    let edges: Vec<Edge> = sides.chain(near).collect();
    let (width, height) = around.size();
    let mut slabs = vec![Slab {
        y: [around.min_y, around.max_y],
        edges: (0..edges.len() as u32).collect(),
    }];
    while let Some(mut slab) = slabs.pop() {
        let [low, high] = slab.y;
        let edge = |number: u32| &edges[number as usize];
        slab.edges
            .retain(|&number| edge(number).y[0] < high && edge(number).y[1] > low);
        let is_inside = |y: &f64| low < *y && *y < high;
        let ends = slab.edges.iter().flat_map(|&number| edge(number).y);
        if let Some(y) = middle(ends.filter(is_inside).collect()) {
            slabs.extend(slab.cut(y));
            continue;
        }
        let spanning = slab
            .edges
            .iter()
            .map(|&number| spanning(edge(number), slab.y, width + height));
        let mut spanning: Vec<Spanning> = spanning.collect();
        spanning.sort_by(|a, b| {
            let sum = |edge: &Spanning| edge.x[0] + edge.x[1];
            sum(a).total_cmp(&sum(b)).then(a.x[0].total_cmp(&b.x[0]))
        });
        let crossings = spanning
            .windows(2)
            .filter_map(|pair| crossing(pair[0], pair[1], slab.y));
        if let Some(y) = middle(crossings.filter(is_inside).collect()) {
            slabs.extend(slab.cut(y));
            continue;
        }
        // Above the lower side, because lower ends belong to edges, and upper ones do not.
        let left = clip.winding_left_of(around.min_x, low + (high - low) / 2.0);
        trapezoids(&spanning, left, |[left, right]| {
            let [a, b] = [[left[0], low], [right[0], low]].map(|[x, y]| Point::new(x + origin, y));
            let [d, c] = [[left[1], high], [right[1], high]].map(|[x, y]| Point::new(x + origin, y));
            let area = |side: usize| (right[side] - left[side]).max(0.0) * (high - low) / 2.0;
            piece([a, b, c], area(0));
            piece([a, c, d], area(1));
        });
    }
}

impl Slab {
    /// Returns the parts above and below a y.
    fn cut(self, y: f64) -> [Self; 2] {
        let [low, high] = self.y;
        [
            Self {
                y: [y, high],
                edges: self.edges.clone(),
            },
            Self {
                y: [low, y],
                edges: self.edges,
            },
        ]
    }
}

/// Returns the median of some numbers.
fn middle(mut numbers: Vec<f64>) -> Option<f64> {
    let half = numbers.len() / 2;
    (!numbers.is_empty()).then(|| *numbers.select_nth_unstable_by(half, f64::total_cmp).1)
}

fn spanning(edge: &Edge, [low, high]: [f64; 2], size: f64) -> Spanning {
    Spanning {
        x: [edge.at(low), edge.at(high)],
        size: size + (edge.x[1] - edge.x[0]).abs(),
        winding: edge.winding,
        triangle: edge.triangle,
    }
}

/// Returns the y at which two edges cross in a slab, if they do.
fn crossing(one: Spanning, other: Spanning, [low, high]: [f64; 2]) -> Option<f64> {
    let [below, above] = [0, 1].map(|side| other.x[side] - one.x[side]);
    let noise = NOISE * (one.size + other.size);
    let is_crossing = below.min(above) < -noise && below.max(above) > noise;
    is_crossing.then(|| low + (high - low) * (below.abs() / (below.abs() + above.abs())))
}

/// Calls `trapezoid` with the x of the left and of the right side, each at the bottom and at the top, of
/// the parts of a slab that are in the triangle and in a polygon. `winding` is the winding number on the
/// left of all edges.
fn trapezoids(sorted: &[Spanning], mut winding: i64, mut trapezoid: impl FnMut([[f64; 2]; 2])) {
    let mut triangle = 0;
    let mut open: Option<[f64; 2]> = None;
    for edge in sorted {
        winding += edge.winding;
        triangle += edge.triangle;
        let is_covered = winding > 0 && triangle > 0;
        match open {
            None if is_covered => open = Some(edge.x),
            Some(left) if !is_covered => {
                trapezoid([left, edge.x]);
                open = None;
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(corners: &[(f64, f64)]) -> Vec<Point> {
        corners.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    fn ring(corners: &[(f64, f64)]) -> Vec<[Point; 2]> {
        let corners = points(corners);
        (0..corners.len())
            .map(|i| [corners[i], corners[(i + 1) % corners.len()]])
            .collect()
    }

    /// Returns the area of the part of the triangle (0, 0), (8, 0), (0, 8) that polygons cover, moved by
    /// `far`; that of each piece is checked.
    fn covered(edges: &[[Point; 2]], far: f64) -> f64 {
        let moved = |p: Point| Point::new(p.x + far, p.y - far);
        let clip = Clip::new(edges.iter().map(|ends| ends.map(moved)).collect());
        let corners = [(0.0, 0.0), (8.0, 0.0), (0.0, 8.0)].map(|(x, y)| moved(Point::new(x, y)));
        let mut areas = Vec::new();
        for turns in 0..3 {
            let mut corners = corners;
            corners.rotate_left(turns);
            let mut sum = 0.0;
            overlap(corners, &clip, |[a, b, c], area| {
                let expected = ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2.0;
                assert!((area - expected).abs() < 1e-9 * (1.0 + far), "{area} {expected}");
                sum += area;
            });
            areas.push(sum);
        }
        assert!(areas.iter().all(|area| (area - areas[0]).abs() < 1e-9), "{areas:?}");
        areas[0]
    }

    #[test]
    fn the_covered_area_is_that_of_closed_forms() {
        let square = |x: f64, y: f64, size: f64| ring(&[(x, y), (x + size, y), (x + size, y + size), (x, y + size)]);
        let mut hollow = square(-1.0, -1.0, 20.0);
        hollow.extend(square(1.0, 1.0, 1.0).iter().map(|&[a, b]| [b, a]));
        for (edges, expected) in [
            (vec![], 0.0),
            (square(1.0, 1.0, 2.0), 4.0),
            (square(3.0, 3.0, 2.0), 2.0),
            (square(-1.0, -1.0, 20.0), 32.0),
            (hollow, 31.0),
            // Inside out.
            (square(1.0, 1.0, 2.0).iter().map(|&[a, b]| [b, a]).collect(), 0.0),
            // The same twice, two that overlap, and two that touch.
            ([square(1.0, 1.0, 2.0), square(1.0, 1.0, 2.0)].concat(), 4.0),
            ([square(1.0, 1.0, 2.0), square(2.0, 2.0, 2.0)].concat(), 7.0),
            ([square(1.0, 1.0, 2.0), square(3.0, 1.0, 2.0)].concat(), 8.0),
            // Along the sides of the triangle, and the triangle itself.
            (ring(&[(0.0, 0.0), (5.0, 0.0), (5.0, 3.0), (0.0, 8.0)]), 32.0 - 4.5),
            (ring(&[(0.0, 0.0), (8.0, 0.0), (0.0, 8.0)]), 32.0),
            // Outer triangle of a side, crossing and crossed.
            (ring(&[(-9.0, 1.0), (20.0, 1.0), (20.0, 3.0), (-9.0, 3.0)]), 12.0),
            (ring(&[(-9.0, -9.0), (1.0, -9.0), (1.0, 20.0), (-9.0, 20.0)]), 7.5),
            // An hourglass: one half is inside out.
            (ring(&[(1.0, 1.0), (3.0, 1.0), (1.0, 3.0), (3.0, 3.0)]), 1.0),
        ] {
            for far in [0.0, 3000.0] {
                let area = covered(&edges, far);
                assert!((area - expected).abs() < 1e-9, "{edges:?}: {area}, not {expected}");
            }
        }
    }

    /// A circle of many edges in one triangle, and overlapping ones, by the area of their polygons.
    #[test]
    fn polygons_of_many_edges_have_their_area() {
        let circle = |x: f64, steps: u32| {
            let at = |i: u32| f64::from(i) / f64::from(steps) * std::f64::consts::TAU;
            let corners: Vec<_> = (0..steps).map(|i| (x + at(i).cos(), 2.0 + at(i).sin())).collect();
            ring(&corners)
        };
        let area = |steps: u32| f64::from(steps) / 2.0 * (std::f64::consts::TAU / f64::from(steps)).sin();
        assert!((covered(&circle(2.0, 5000), 0.0) - area(5000)).abs() < 1e-9);
        // Two circles of radius 1 at the distance 1 share 2π/3 − √3/2.
        let both = [circle(1.5, 6000), circle(2.5, 6000)].concat();
        let shared = std::f64::consts::TAU / 3.0 - 3f64.sqrt() / 2.0;
        let expected = std::f64::consts::TAU - shared;
        assert!((covered(&both, 0.0) - expected).abs() < 1e-5);
        assert!((covered(&both, 0.0) - covered(&both, 100.0)).abs() < 1e-9);
    }
}
