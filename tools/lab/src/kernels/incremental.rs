//! The second candidate for the library's kernel: incremental insertion along a space-filling
//! curve.
//!
//! The input is distinct points in any order. The output is the canonical Delaunay triangulation,
//! as from every [`Engine`].
//!
//! Sources: Bowyer (1981) and Watson (1981) for the cavity; Amenta, Choi and Rote, "Incremental
//! constructions con BRIO" (2003) for random rounds that are each sorted in space; Boissonnat,
//! Devillers and Hornus, "Incremental construction of the Delaunay graph in medium dimension"
//! (2009) for the rounds of CGAL's `spatial_sort`: a quarter of the points goes to the earlier
//! rounds. Differences: the Hilbert curve is that of a fixed grid, by keys, not by medians; the
//! circle test is the perturbed one, so that the result is canonical.
//!
//! As in the library's own kernel, every hull edge u → v has a ghost triangle (v, u, ∞) outside of
//! it, so a point outside the hull is inserted like any other.

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
    /// In random rounds, each three times as large as all earlier rounds together; within a round
    /// along a Hilbert curve.
    #[default]
    Brio,
}

/// A half-edge in 32 bits: `triangle << 2 | corner that it starts at`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct PackedHalfEdge(u32);

impl PackedHalfEdge {
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
    twins: [PackedHalfEdge; 3],
}

/// The incremental engine, with the memory that it keeps between calls.
#[derive(Default)]
pub struct Incremental {
    order: Order,
    /// The points' keys on the curve with their indices in the caller's array, sorted.
    keyed: Vec<(u64, u32)>,
    /// The caller's index of each point, in the order of insertion.
    indices: Vec<u32>,
    /// The points in the order of insertion; vertices are indices into it.
    points: Vec<Point>,
    triangles: Vec<Tri>,
    /// The number of each triangle in the result; `None` for ghosts.
    renumbered: Vec<Option<u32>>,
    cavity: Cavity,
    /// The time that the last call took to order the points, to insert them, and to write the
    /// result.
    pub parts: [Duration; 3],
}

/// The memory of one insertion, kept so that insertions do not allocate.
#[derive(Default)]
struct Cavity {
    /// Half-edges of removed triangles whose twins are not yet tested, the next one last.
    pending: Vec<PackedHalfEdge>,
    /// The triangles that are removed.
    removed: Vec<u32>,
    /// The edges around them, counter-clockwise: the vertex that each starts at, and its half-edge
    /// outside the cavity.
    around: Vec<(u32, PackedHalfEdge)>,
}

impl Incremental {
    /// Creates an engine that inserts in this order.
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

    /// Deals the sorted points into random rounds, in which they stay sorted. The last round has
    /// three quarters of them, the one before three quarters of the rest, and so on, down to one of
    /// about 64.
    fn deal_into_rounds(&mut self) {
        let rounds = (self.keyed.len() / 64).max(1).ilog2() / 2 + 1;
        let round = |index: u32| {
            // Knuth's multiplicative hash, with its best bits moved down.
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

    /// Makes the first triangle with its ghosts; returns `false` if all points are collinear.
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
        // A rotation, so that the others stay in order.
        self.points[2..=third].rotate_right(1);
        self.indices[2..=third].rotate_right(1);
        if orient2d(a, b, self.points[2]) == Orientation::Clockwise {
            self.points.swap(1, 2);
            self.indices.swap(1, 2);
        }
        self.triangles.reserve(2 * self.points.len());
        // Ghosts 1, 2, 3 are the twins of the half-edges 0, 1, 2 of triangle 0.
        self.triangles.push(Tri {
            corners: [0, 1, 2],
            twins: [1, 2, 3].map(|ghost| PackedHalfEdge::new(ghost, 0)),
        });
        for edge in 0..3 {
            let (following, preceding) = ((edge + 1) % 3 + 1, (edge + 2) % 3 + 1);
            self.triangles.push(Tri {
                corners: [(edge + 1) % 3, edge, GHOST],
                twins: [
                    PackedHalfEdge::new(0, edge),
                    PackedHalfEdge::new(preceding, 2),
                    PackedHalfEdge::new(following, 1),
                ],
            });
        }
        true
    }

    /// Walks from triangle `from` to one that `p` is in conflict with: the triangle that contains
    /// it, or the ghost of a hull edge that has it on the outside.
    ///
    /// Crosses any half-edge that has `p` strictly on its right. That terminates in a Delaunay
    /// triangulation (Edelsbrunner 1990); with exact predicates and the tie rule every
    /// triangulation here is one.
    fn locate(&self, from: u32, p: Point) -> u32 {
        let start = &self.triangles[from as usize];
        let mut at = match start.corners.iter().position(|&c| c == GHOST) {
            Some(corner) => start.twins[(corner + 1) % 3],
            None => PackedHalfEdge::new(from, 0),
        };
        if self.is_to_the_right(at, p) {
            at = self.twin(at);
        }
        // p is not to the right of the half-edge `at` through which the triangle was entered.
        loop {
            if self.origin(at.prev()) == GHOST {
                return at.triangle() as u32;
            }
            if self.is_to_the_right(at.next(), p) {
                at = self.twin(at.next());
            } else if self.is_to_the_right(at.prev(), p) {
                at = self.twin(at.prev());
            } else {
                return at.triangle() as u32;
            }
        }
    }

    /// Returns whether `p` is strictly to the right of a half-edge.
    #[inline(always)]
    fn is_to_the_right(&self, half_edge: PackedHalfEdge, p: Point) -> bool {
        let (a, b) = (
            self.point(self.origin(half_edge)),
            self.point(self.origin(half_edge.next())),
        );
        orient2d(a, b, p) == Orientation::Clockwise
    }

    /// Returns whether `p` destroys the triangle: is inside its circle or, for a ghost, outside its
    /// hull edge or on that edge.
    #[inline(always)]
    fn in_conflict(&self, half_edge: PackedHalfEdge, p: Point) -> bool {
        let [a, b, c] = [half_edge, half_edge.next(), half_edge.prev()].map(|s| self.origin(s));
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

    /// Replaces all triangles that `vertex` is in conflict with, `first` among them, by a fan
    /// around it. Returns a triangle of the fan.
    ///
    /// The removed triangles are connected and have no vertex in their interior. Seen from the
    /// first one they are a tree; its traversal from left to right gives the edges around them in
    /// order. k edges surround k - 2 triangles, ghosts included, so the fan takes their indices and
    /// two more.
    ///
    /// ```text
    ///     ┌───────┐         ┌───────┐
    ///     │╲     ╱│         │╲     ╱│
    ///     │ ╲ p ╱ │    →    │  ╲ ╱  │
    ///     │  ╲ ╱  │         │   p   │
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
        cavity
            .pending
            .extend([2, 1, 0].map(|corner| PackedHalfEdge::new(first, corner)));
        while let Some(half_edge) = cavity.pending.pop() {
            let twin = self.twin(half_edge);
            if self.in_conflict(twin, p) {
                cavity.removed.push(twin.triangle() as u32);
                cavity.pending.extend([twin.prev(), twin.next()]);
            } else {
                cavity.around.push((self.origin(half_edge), twin));
            }
        }
        let edges = cavity.around.len();
        debug_assert_eq!(edges, cavity.removed.len() + 2);
        let last = self.triangles.len() as u32 + 1;
        cavity.removed.extend([last - 1, last]);
        let blank = Tri {
            corners: [GHOST; 3],
            twins: [PackedHalfEdge::UNSET; 3],
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
                twins: [
                    outside,
                    PackedHalfEdge::new(following, 2),
                    PackedHalfEdge::new(preceding, 1),
                ],
            };
            self.triangles[outside.triangle()].twins[outside.corner()] = PackedHalfEdge::new(triangle, 0);
            preceding = triangle;
        }
        self.cavity = cavity;
        last
    }

    /// Writes the triangles that are not ghosts, in the caller's indices.
    fn emit(&mut self, mesh: &mut Triangulation) {
        self.renumbered.clear();
        let mut count = 0;
        let mut ghost_edge = None;
        for (i, triangle) in (0..).zip(&self.triangles) {
            let ghost = (0..).zip(triangle.corners).find(|c| c.1 == GHOST);
            self.renumbered.push(ghost.is_none().then_some(count));
            count += u32::from(ghost.is_none());
            if let Some((corner, _)) = ghost {
                ghost_edge = Some(PackedHalfEdge::new(i, corner).next());
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
            // The hull edge u → v of the ghost (v, u, ∞), then the hull edge that leaves v.
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

    fn origin(&self, half_edge: PackedHalfEdge) -> u32 {
        self.triangles[half_edge.triangle()].corners[half_edge.corner()]
    }

    fn twin(&self, half_edge: PackedHalfEdge) -> PackedHalfEdge {
        self.triangles[half_edge.triangle()].twins[half_edge.corner()]
    }
}

impl Engine for Incremental {
    fn triangulate(&mut self, points: &[Point], mesh: &mut Triangulation) {
        assert!(points.len() < 1 << 29, "half-edges hold fewer than 2^29 points");
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
