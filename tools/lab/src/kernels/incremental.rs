//! The second candidate for the library's kernel: incremental insertion along a space-filling curve.
//!
//! In: distinct points in any order. Out: the canonical Delaunay triangulation, as from every [`Engine`].
//!
//! Sources: Bowyer (1981) and Watson (1981) for the cavity; Amenta, Choi and Rote, "Incremental constructions con BRIO"
//! (2003) for random rounds that are each sorted in space; Boissonnat, Devillers and Hornus, "Incremental construction
//! of the Delaunay graph in medium dimension" (2009) for the rounds that CGAL's `spatial_sort` makes: a quarter of the
//! points goes to the rounds before. Departures: the Hilbert curve is that of a fixed grid, by keys, not by medians; the
//! circle test is the perturbed one, so that the result is canonical.
//!
//! As in the library's own kernel, every hull edge u → v has a ghost triangle (v, u, ∞) on its outer side, so a point
//! outside the hull is inserted like any other.

use std::time::Duration;

use cpu_time::ThreadTime;

use delaunay_tiles::geometry::{HalfEdge, Orientation, Point, Rect, TriangleId, in_circle, orient2d};
use delaunay_tiles::mesh::{Engine, Triangulation};

use super::hilbert::Curve;

/// The corner of ghosts: the point at infinity.
const GHOST: u32 = u32::MAX;

/// The order in which points are inserted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// Along one Hilbert curve through all points.
    Hilbert,
    /// In random rounds, each three times as large as all before it together, along a Hilbert curve within.
    #[default]
    Brio,
}

/// A directed side of a triangle: `triangle << 2 | corner that it starts at`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Side(u32);

impl Side {
    const UNSET: Self = Self(u32::MAX);

    fn new(triangle: u32, corner: u32) -> Self {
        Self(triangle << 2 | corner)
    }

    fn triangle(self) -> usize {
        (self.0 >> 2) as usize
    }

    fn corner(self) -> usize {
        (self.0 & 3) as usize
    }

    fn next(self) -> Self {
        Self(if self.corner() == 2 { self.0 - 2 } else { self.0 + 1 })
    }

    fn prev(self) -> Self {
        Self(if self.corner() == 0 { self.0 + 2 } else { self.0 - 1 })
    }
}

#[derive(Clone, Copy)]
struct Tri {
    corners: [u32; 3],
    twins: [Side; 3],
}

/// The incremental engine, with the memory that it keeps between calls.
#[derive(Default)]
pub struct Incremental {
    order: Order,
    /// The points' keys on the curve with their index in the caller's array, sorted.
    keyed: Vec<(u64, u32)>,
    /// The caller's index of each point, in the order of insertion.
    indices: Vec<u32>,
    /// The points in the order of insertion; vertices are positions in it.
    points: Vec<Point>,
    triangles: Vec<Tri>,
    /// For each triangle its number in the result, none for ghosts.
    renumbered: Vec<Option<u32>>,
    cavity: Cavity,
    /// How long the last call took to order the points, to insert them, and to write the result.
    pub parts: [Duration; 3],
}

/// What one insertion needs, kept so that none allocates.
#[derive(Default)]
struct Cavity {
    /// Sides of removed triangles still to be looked across, the next one last.
    pending: Vec<Side>,
    /// The triangles that are removed.
    removed: Vec<u32>,
    /// The edges around them, counter-clockwise: the vertex that each starts at, and its side outside the cavity.
    around: Vec<(u32, Side)>,
}

impl Incremental {
    /// An engine that inserts in this order.
    #[must_use]
    pub fn new(order: Order) -> Self {
        Self {
            order,
            ..Self::default()
        }
    }

    /// Fills `indices` and `points`.
    fn arrange(&mut self, points: &[Point]) {
        let curve = Curve::over(Rect::around(points.iter().copied()));
        self.keyed.clear();
        self.keyed
            .extend(points.iter().zip(0u32..).map(|(&p, i)| (curve.key(p), i)));
        self.keyed.sort_unstable_by_key(|k| k.0);
        self.indices.clear();
        match self.order {
            Order::Hilbert => self.indices.extend(self.keyed.iter().map(|k| k.1)),
            Order::Brio => self.deal_into_rounds(),
        }
        self.points.clear();
        self.points.extend(self.indices.iter().map(|&i| points[i as usize]));
    }

    /// Deals the sorted points into random rounds, in which they stay sorted: the last one has three quarters of them,
    /// the one before three quarters of the rest, and so on, down to one of about 64.
    fn deal_into_rounds(&mut self) {
        let rounds = (self.keyed.len() / 64).max(1).ilog2() / 2 + 1;
        let round = |index: u32| {
            // Knuth's multiplicative hash, its best bits down.
            let hash = (u64::from(index) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15).swap_bytes();
            rounds - 1 - (hash.trailing_zeros() / 2).min(rounds - 1)
        };
        let mut starts = [0usize; 17];
        for &(_, index) in &self.keyed {
            starts[round(index) as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        self.indices.resize(self.keyed.len(), 0);
        for &(_, index) in &self.keyed {
            let place = &mut starts[round(index) as usize];
            self.indices[*place] = index;
            *place += 1;
        }
    }

    /// Makes the first triangle with its ghosts; false if all points lie on one line.
    fn start(&mut self) -> bool {
        self.triangles.clear();
        if self.points.len() < 3 {
            return false;
        }
        let (a, b) = (self.points[0], self.points[1]);
        let apart = |&&c: &&Point| orient2d(a, b, c) != Orientation::Collinear;
        let Some(third) = self.points[2..].iter().position(|c| apart(&c)).map(|i| i + 2) else {
            return false;
        };
        // To its place by a rotation, so that the others stay in order.
        self.points[2..=third].rotate_right(1);
        self.indices[2..=third].rotate_right(1);
        if orient2d(a, b, self.points[2]) == Orientation::Clockwise {
            self.points.swap(1, 2);
            self.indices.swap(1, 2);
        }
        self.triangles.reserve(2 * self.points.len());
        // Ghosts 1, 2, 3 lie beyond the sides 0, 1, 2 of triangle 0.
        self.triangles.push(Tri {
            corners: [0, 1, 2],
            twins: [1, 2, 3].map(|ghost| Side::new(ghost, 0)),
        });
        for side in 0..3 {
            let (following, preceding) = ((side + 1) % 3 + 1, (side + 2) % 3 + 1);
            self.triangles.push(Tri {
                corners: [(side + 1) % 3, side, GHOST],
                twins: [Side::new(0, side), Side::new(preceding, 2), Side::new(following, 1)],
            });
        }
        true
    }

    /// Walks from triangle `from` to one that `p` is in conflict with: that contains it, or the ghost of a hull edge
    /// that it lies beyond.
    ///
    /// Goes across any side that has `p` strictly on its right. That ends, in a Delaunay triangulation (Edelsbrunner
    /// 1990); with exact predicates and the tie rule there is no other.
    fn locate(&self, from: u32, p: Point) -> u32 {
        let start = &self.triangles[from as usize];
        let mut at = match start.corners.iter().position(|&c| c == GHOST) {
            Some(corner) => start.twins[(corner + 1) % 3],
            None => Side::new(from, 0),
        };
        if self.is_beyond(at, p) {
            at = self.twin(at);
        }
        // p is not beyond the side `at` where the triangle was entered.
        loop {
            if self.origin(at.prev()) == GHOST {
                return at.triangle() as u32;
            }
            if self.is_beyond(at.next(), p) {
                at = self.twin(at.next());
            } else if self.is_beyond(at.prev(), p) {
                at = self.twin(at.prev());
            } else {
                return at.triangle() as u32;
            }
        }
    }

    /// Whether `p` is strictly to the right of a side.
    #[inline(always)]
    fn is_beyond(&self, side: Side, p: Point) -> bool {
        let (a, b) = (self.point(self.origin(side)), self.point(self.origin(side.next())));
        orient2d(a, b, p) == Orientation::Clockwise
    }

    /// Whether `p` destroys the triangle: lies in its circle or, if it is a ghost, beyond its hull edge or within it.
    #[inline(always)]
    fn in_conflict(&self, side: Side, p: Point) -> bool {
        let [a, b, c] = [side, side.next(), side.prev()].map(|s| self.origin(s));
        if a != GHOST && b != GHOST && c != GHOST {
            return in_circle(self.point(a), self.point(b), self.point(c), p);
        }
        let (v, u) = if c == GHOST {
            (a, b)
        } else if a == GHOST {
            (b, c)
        } else {
            (c, a)
        };
        let (u, v) = (self.point(u), self.point(v));
        match orient2d(u, v, p) {
            Orientation::Clockwise => true,
            Orientation::CounterClockwise => false,
            Orientation::Collinear => u.lex_cmp(p) == p.lex_cmp(v),
        }
    }

    /// Replaces all triangles that `vertex` is in conflict with, `first` among them, by a fan around it. Returns a
    /// triangle of the fan.
    ///
    /// ```text
    ///     ┌───────┐         ┌───────┐      The removed triangles hang together and have no vertex among them: seen
    ///     │╲     ╱│         │╲     ╱│      from the first one they are a tree, and gone through from left to right
    ///     │ ╲ p ╱ │    →    │  ╲ ╱  │      it yields the edges around them in order. k edges surround k - 2
    ///     │  ╲ ╱  │         │   p   │      triangles, ghosts included, so the fan takes their places and two more.
    ///     │   ╳   │         │  ╱ ╲  │
    ///     └───────┘         └───────┘
    /// ```
    #[inline]
    fn insert(&mut self, vertex: u32, first: u32) -> u32 {
        let p = self.point(vertex);
        let mut cavity = std::mem::take(&mut self.cavity);
        cavity.removed.clear();
        cavity.around.clear();
        cavity.removed.push(first);
        cavity.pending.extend([2, 1, 0].map(|corner| Side::new(first, corner)));
        while let Some(side) = cavity.pending.pop() {
            let across = self.twin(side);
            if self.in_conflict(across, p) {
                cavity.removed.push(across.triangle() as u32);
                cavity.pending.extend([across.prev(), across.next()]);
            } else {
                cavity.around.push((self.origin(side), across));
            }
        }
        let edges = cavity.around.len();
        debug_assert_eq!(edges, cavity.removed.len() + 2);
        let last = self.triangles.len() as u32 + 1;
        cavity.removed.extend([last - 1, last]);
        let blank = Tri {
            corners: [GHOST; 3],
            twins: [Side::UNSET; 3],
        };
        self.triangles.extend([blank; 2]);
        let mut preceding = last;
        for (i, &(from, outside)) in cavity.around.iter().enumerate() {
            let triangle = cavity.removed[i];
            let (to, following) = if i + 1 < edges {
                (cavity.around[i + 1].0, cavity.removed[i + 1])
            } else {
                (cavity.around[0].0, cavity.removed[0])
            };
            self.triangles[triangle as usize] = Tri {
                corners: [from, to, vertex],
                twins: [outside, Side::new(following, 2), Side::new(preceding, 1)],
            };
            self.triangles[outside.triangle()].twins[outside.corner()] = Side::new(triangle, 0);
            preceding = triangle;
        }
        self.cavity = cavity;
        last
    }

    /// Writes the triangles that are no ghosts, in the caller's indices.
    fn emit(&mut self, mesh: &mut Triangulation) {
        self.renumbered.clear();
        let mut count = 0;
        let mut ghost_edge = None;
        for (i, triangle) in (0..).zip(&self.triangles) {
            let ghost = (0..).zip(triangle.corners).find(|c| c.1 == GHOST);
            self.renumbered.push(ghost.is_none().then_some(count));
            count += u32::from(ghost.is_none());
            if let Some((corner, _)) = ghost {
                ghost_edge = Some(Side::new(i, corner).next());
            }
        }
        mesh.triangles.reserve(count as usize);
        mesh.neighbours.reserve(count as usize);
        for triangle in self.triangles.iter().filter(|t| !t.corners.contains(&GHOST)) {
            mesh.triangles.push(triangle.corners.map(|v| self.indices[v as usize]));
            mesh.neighbours.push(triangle.twins.map(|twin| {
                let number = self.renumbered[twin.triangle()];
                number
                    .map(|number| HalfEdge::new(TriangleId(number), twin.corner() as u32))
                    .into()
            }));
        }
        let first = ghost_edge.expect("a triangulation has a hull");
        let mut edge = first;
        loop {
            // The hull edge u → v of the ghost (v, u, ∞), then the one that leaves v.
            mesh.hull.push(self.indices[self.origin(edge.next()) as usize]);
            edge = self.twin(edge.prev()).prev();
            if edge == first {
                return;
            }
        }
    }

    fn point(&self, vertex: u32) -> Point {
        self.points[vertex as usize]
    }

    fn origin(&self, side: Side) -> u32 {
        self.triangles[side.triangle()].corners[side.corner()]
    }

    fn twin(&self, side: Side) -> Side {
        self.triangles[side.triangle()].twins[side.corner()]
    }
}

impl Engine for Incremental {
    fn triangulate(&mut self, points: &[Point], mesh: &mut Triangulation) {
        assert!(points.len() < 1 << 29, "side handles hold fewer than 2^29 points");
        let begin = ThreadTime::now();
        mesh.clear();
        self.arrange(points);
        let arranged = ThreadTime::now();
        if !self.start() {
            mesh.hull.extend(0..points.len() as u32);
            mesh.hull
                .sort_unstable_by(|&a, &b| points[a as usize].lex_cmp(points[b as usize]));
            return;
        }
        let mut newest = 0;
        for vertex in 3..points.len() as u32 {
            let first = self.locate(newest, self.point(vertex));
            newest = self.insert(vertex, first);
        }
        let inserted = ThreadTime::now();
        self.emit(mesh);
        self.parts = [
            arranged.duration_since(begin),
            inserted.duration_since(arranged),
            inserted.elapsed(),
        ];
    }
}
