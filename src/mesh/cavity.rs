//! Triangulates one side of the cavity that a new constraint leaves.
//!
//! In: the chain of vertices from one end of the constraint to the other, all on its left. Out: the constrained Delaunay
//! triangulation of the polygon between them, by position in the chain.
//!
//! ```text
//!        u₂ ─ u₃            ears are cut off in random order,     …and put back in reverse, each with
//!       ╱       ╲  u₅       while a triangle is left…             the flips that it calls for
//!     u₁         u₄╱ ╲
//!    ╱                ╲
//!   a ───────────────── b
//! ```
//!
//! Every vertex of the chain sees the constraint along an edge that crossed it, and these legs do not cross. Two
//! neighbours, their legs and the constraint bound a region without a vertex; of the triangle at a convex vertex of the
//! chain, each half, left and right of the leg, lies in one of these. So **every strictly convex vertex of the chain is an
//! ear**, whichever were cut before; and there is always one, since the angles of the polygon would be too large otherwise.
//! All polygons on the way are simple, but that the chain may pass an edge or a vertex twice, without space between; and
//! flips keep each triangulation constrained Delaunay, as in Lawson's insertion.
//!
//! As in Chew's algorithm for convex polygons (1990), a vertex that was chosen at random has few edges on average, so few
//! flips are needed: linear expected time where most vertices are convex. Shewchuk and Brown (2015) let other vertices than
//! convex ones go too, which bounds the time for every chain, and mend what overlaps then; here nothing overlaps. Chains
//! with few convex vertices leave little to flip, since two vertices of a reflex chain do not see each other.

use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, in_circle, orient2d};

/// No place among the ears.
const NOWHERE: u32 = u32::MAX;

/// What lies across a half-edge: another one, or the chain at a position, which the highest bit says. Four bytes, where an enum
/// takes eight.
#[derive(Clone, Copy, Debug)]
struct Across(u32);

impl Across {
    const CHAIN: u32 = 1 << 31;

    fn chain(position: u32) -> Self {
        Self(Self::CHAIN | position)
    }

    fn half_edge(half_edge: HalfEdge) -> Self {
        Self(half_edge.0)
    }

    /// The half-edge, or else the position.
    fn get(self) -> Result<HalfEdge, u32> {
        match self.0 & Self::CHAIN {
            0 => Ok(HalfEdge(self.0)),
            _ => Err(self.0 ^ Self::CHAIN),
        }
    }
}

/// Triangulates chains; keeps its memory.
#[derive(Debug, Default)]
pub(crate) struct Cavity {
    /// The corners of each triangle, counter-clockwise, by position. The first triangle's side 0 may have been flipped away
    /// from it: `sides` knows where the constraint is.
    pub(crate) triangles: Vec<[u32; 3]>,
    neighbours: Vec<[Across; 3]>,
    /// For each position the half-edge between it and the next; for the last the half-edge on the constraint.
    pub(crate) sides: Vec<HalfEdge>,
    at: Vec<Point>,
    next: Vec<u32>,
    previous: Vec<u32>,
    /// The positions of ears, and where each position stands among these.
    ears: Vec<u32>,
    places: Vec<u32>,
    /// The vertices that were cut off, between which others.
    cut: Vec<[u32; 3]>,
    stack: Vec<HalfEdge>,
    random: u64,
}

impl Cavity {
    /// Triangulates the polygon of a chain of at least three points, which lies left of the line from its first to its last.
    /// Returns false if there is no such polygon.
    #[must_use]
    pub(crate) fn triangulate(&mut self, chain: impl ExactSizeIterator<Item = Point>) -> bool {
        self.at.clear();
        self.at.extend(chain);
        if !self.cut_ears() {
            return false;
        }
        let last = self.at.len() as u32 - 1;
        let top = self.next[0];
        self.triangles.clear();
        self.neighbours.clear();
        self.triangles.push([0, last, top]);
        self.neighbours.push([last, top, 0].map(Across::chain));
        self.sides.clear();
        self.sides.resize(self.at.len(), HalfEdge(0));
        for (side, position) in HalfEdge::of_triangle(TriangleId(0)).into_iter().zip([last, top, 0]) {
            self.sides[position as usize] = side;
        }
        while let Some(ear) = self.cut.pop() {
            self.put_back(ear);
        }
        true
    }

    /// The half-edge across, or none on the boundary.
    pub(crate) fn twin(&self, side: HalfEdge) -> Option<HalfEdge> {
        self.across(side).get().ok()
    }

    fn across(&self, side: HalfEdge) -> Across {
        self.neighbours.as_flattened()[side.index()]
    }

    /// Cuts ears off, in random order, until one vertex is left above the constraint. Returns false if there are too few.
    fn cut_ears(&mut self) -> bool {
        let count = self.at.len() as u32;
        let last = count - 1;
        self.next.clear();
        self.next.extend(1..=count);
        self.previous.clear();
        self.previous
            .extend((0..count).map(|position| position.wrapping_sub(1)));
        self.ears.clear();
        self.places.clear();
        self.places.resize(count as usize, NOWHERE);
        self.cut.clear();
        // The same numbers for the same cavity: files must not depend on which thread has cut what before.
        self.random = u64::from(count);
        for position in 1..last {
            self.note(position);
        }
        for _ in 0..count.saturating_sub(3) {
            let place = self.choose();
            let Some(&ear) = self.ears.get(place) else { return false };
            self.remove(place);
            let [before, after] = [self.previous[ear as usize], self.next[ear as usize]];
            self.cut.push([before, ear, after]);
            self.next[before as usize] = after;
            self.previous[after as usize] = before;
            for neighbour in [before, after] {
                if neighbour != 0 && neighbour != last {
                    self.note(neighbour);
                }
            }
        }
        true
    }

    /// Keeps the ears up to date with what a position is now.
    fn note(&mut self, position: u32) {
        let around = [self.next[position as usize], position, self.previous[position as usize]];
        let [a, b, c] = around.map(|position| self.at[position as usize]);
        let is_ear = orient2d(a, b, c) == Orientation::CounterClockwise;
        let place = self.places[position as usize];
        if is_ear && place == NOWHERE {
            self.places[position as usize] = self.ears.len() as u32;
            self.ears.push(position);
        } else if !is_ear && place != NOWHERE {
            self.remove(place as usize);
        }
    }

    fn remove(&mut self, place: usize) {
        let position = self.ears.swap_remove(place);
        self.places[position as usize] = NOWHERE;
        if let Some(&moved) = self.ears.get(place) {
            self.places[moved as usize] = place as u32;
        }
    }

    /// A random place among the ears. (Knuth's multiplier; which numbers come decides about the time alone.)
    fn choose(&mut self) -> usize {
        self.random = self
            .random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (((self.random >> 32) * self.ears.len() as u64) >> 32) as usize
    }

    /// Puts an ear back, and flips what is not Delaunay any more.
    ///
    /// ```text
    ///     ─ before ─── after ─          before ─ ear ─ after
    ///         inside                         ╲  inside ╱
    /// ```
    fn put_back(&mut self, [before, ear, after]: [u32; 3]) {
        let triangle = TriangleId(self.triangles.len() as u32);
        let inner = self.sides[before as usize];
        let [outer_after, outer_before, base] = HalfEdge::of_triangle(triangle);
        self.triangles.push([after, ear, before]);
        self.neighbours
            .push([Across::chain(ear), Across::chain(before), Across::half_edge(inner)]);
        self.link(Across::half_edge(inner), base);
        self.sides[ear as usize] = outer_after;
        self.sides[before as usize] = outer_before;
        self.stack.push(base);
        while let Some(side) = self.stack.pop() {
            self.legalise(side);
        }
    }

    /// Flips an edge whose far corner lies in the circle of the triangle at `side`, whose own corner was just put back.
    ///
    /// ```text
    ///        ear                ear
    ///      ╱     ╲            ╱  │  ╲
    ///     a ─side→ b    →    a   │   b
    ///      ╲     ╱            ╲  │  ╱
    ///         d                  d
    /// ```
    fn legalise(&mut self, side: HalfEdge) {
        let Some(twin) = self.twin(side) else { return };
        let corner = |side: HalfEdge| self.triangles.as_flattened()[side.index()];
        let [a, b, ear] = [side, side.next(), side.prev()].map(corner);
        let d = corner(twin.prev());
        let [pa, pb, pear, pd] = [a, b, ear, d].map(|position| self.at[position as usize]);
        if !in_circle(pa, pb, pear, pd) {
            return;
        }
        let [b_ear, ear_a, a_d, d_b] =
            [side.next(), side.prev(), twin.next(), twin.prev()].map(|side| self.across(side));
        let [t, u] = [side, twin].map(HalfEdge::triangle);
        let [of_d_b, of_b_ear, ear_d] = HalfEdge::of_triangle(t);
        let [of_a_d, d_ear, of_ear_a] = HalfEdge::of_triangle(u);
        self.triangles[t.index()] = [d, b, ear];
        self.triangles[u.index()] = [a, d, ear];
        self.neighbours[t.index()] = [d_b, b_ear, Across::half_edge(d_ear)];
        self.neighbours[u.index()] = [a_d, Across::half_edge(ear_d), ear_a];
        self.link(d_b, of_d_b);
        self.link(b_ear, of_b_ear);
        self.link(a_d, of_a_d);
        self.link(ear_a, of_ear_a);
        self.stack.extend([of_d_b, of_a_d]);
    }

    /// Tells what lies across a side, a triangle or the boundary, that the side is `side` now.
    fn link(&mut self, across: Across, side: HalfEdge) {
        match across.get() {
            Ok(twin) => self.neighbours.as_flattened_mut()[twin.index()] = Across::half_edge(side),
            Err(position) => self.sides[position as usize] = side,
        }
    }
}
