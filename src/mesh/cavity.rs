//! Triangulates the part of a cavity on one side of a new constraint, and the star of a vertex that
//! is removed.
//!
//! Input: the chain of vertices from one end of the constraint to the other, all on its left, or
//! the link of the vertex. Output: the constrained Delaunay triangulation of the polygon between
//! chain and constraint, or within the link. Vertices are named by their position in the chain.
//!
//! ```text
//!        u₂ ─ u₃            Cut ears off in random order until one triangle is left.
//!       ╱       ╲  u₅       Then put them back in reverse order, each with the flips
//!     u₁         u₄╱ ╲      that it needs.
//!    ╱                ╲
//!   a ───────────────── b
//! ```
//!
//! Each vertex of the chain sees the constraint along an edge that crossed the constraint: its leg.
//! Legs do not cross each other. Two neighbouring vertices, their legs and the constraint bound a
//! region without a vertex. The leg of a convex vertex of the chain cuts the triangle at that
//! vertex into a left and a right half, and each half lies in one of these regions. So **every
//! strictly convex vertex of the chain is an ear**, whichever ears were cut off before. There is
//! always such a vertex, since the angles of the polygon would be too large otherwise. All
//! intermediate polygons are simple, except that the chain may pass an edge or a vertex twice,
//! without space between the two passes. Flips keep each triangulation constrained Delaunay, as in
//! Lawson's insertion.
//!
//! As in Chew's algorithm for convex polygons (1990), a vertex that was chosen at random has few
//! edges on average, so few flips are needed: the expected time is linear where most vertices are
//! convex. Shewchuk and Brown (2015) also remove vertices that are not convex, which bounds the
//! time for every chain, and then repair the overlaps. Here nothing overlaps. Chains with few
//! convex vertices leave little to flip, since two vertices of a reflex chain do not see each
//! other.
//!
//! The star of a removed vertex v is triangulated in the same way (Devillers, *On deletion in
//! Delaunay triangulations*, 2002, cuts ears too, but chooses them so that none needs a flip). Its
//! link is closed, and the legs of its vertices meet in v. The ear at b between a and c is cut off
//! only if v does not lie strictly on its side of the line through a and c: then both halves of
//! the ear lie in the triangles of v at b. With more than three vertices left there is such an ear,
//! since an edge at v can be flipped. Once v lies on a side of the polygon, that side acts as the
//! constraint above.

use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, in_circle, orient2d};

/// Marks a position that is not in the list of ears.
const NOT_AN_EAR: u32 = u32::MAX;

/// The twin of a half-edge of the cavity: another half-edge, or the chain at a position, which the
/// highest bit marks. It takes four bytes, where an enum takes eight.
#[derive(Clone, Copy, Debug)]
struct PackedTwin(u32);

impl PackedTwin {
    const CHAIN: u32 = 1 << 31;

    fn chain(position: u32) -> Self {
        Self(Self::CHAIN | position)
    }

    fn half_edge(half_edge: HalfEdge) -> Self {
        Self(half_edge.0)
    }

    /// Returns the half-edge, or the position in the chain as the error.
    fn get(self) -> Result<HalfEdge, u32> {
        match self.0 & Self::CHAIN {
            0 => Ok(HalfEdge(self.0)),
            _ => Err(self.0 ^ Self::CHAIN),
        }
    }
}

/// Triangulates chains. It keeps its memory between calls.
#[derive(Debug, Default)]
pub(crate) struct Cavity {
    /// The corners of each triangle as positions in the chain, counter-clockwise. The constraint is
    /// half-edge 0 of the first triangle until a flip moves it; `edges` says where it is.
    pub(crate) triangles: Vec<[u32; 3]>,
    neighbours: Vec<[PackedTwin; 3]>,
    /// For each position, the half-edge between it and the next position. For the last position,
    /// the half-edge on the constraint.
    pub(crate) edges: Vec<HalfEdge>,
    at: Vec<Point>,
    /// The vertex in whose star the chain is, if it is closed.
    centre: Option<Point>,
    next: Vec<u32>,
    previous: Vec<u32>,
    /// The positions of ears. `ear_indices` has the index of each position in this list.
    ears: Vec<u32>,
    ear_indices: Vec<u32>,
    /// The ears that were cut off. Each stands between the two neighbours that it had then.
    cut: Vec<[u32; 3]>,
    stack: Vec<HalfEdge>,
    random: u64,
}

impl Cavity {
    /// Triangulates the polygon between a chain and the line from its first to its last point. The
    /// chain has at least three points and lies left of that line. Returns false if there is no
    /// such polygon.
    #[must_use]
    pub(crate) fn triangulate(&mut self, chain: impl ExactSizeIterator<Item = Point>) -> bool {
        self.centre = None;
        self.fill(chain)
    }

    /// Triangulates the link of a vertex without the vertex. The link has at least three points,
    /// clockwise around the vertex at `centre`, which sees all of them. Returns false if there is
    /// no such polygon.
    #[must_use]
    pub(crate) fn triangulate_star(&mut self, centre: Point, link: impl ExactSizeIterator<Item = Point>) -> bool {
        self.centre = Some(centre);
        self.fill(link)
    }

    fn fill(&mut self, chain: impl ExactSizeIterator<Item = Point>) -> bool {
        self.at.clear();
        self.at.extend(chain);
        let Some([first, middle, last]) = self.cut_ears() else {
            return false;
        };
        self.triangles.clear();
        self.neighbours.clear();
        self.triangles.push([first, last, middle]);
        self.neighbours.push([last, middle, first].map(PackedTwin::chain));
        self.edges.clear();
        self.edges.resize(self.at.len(), HalfEdge(0));
        let half_edges = HalfEdge::of_triangle(TriangleId(0));
        for (edge, position) in half_edges.into_iter().zip([last, middle, first]) {
            self.edges[position as usize] = edge;
        }
        while let Some(ear) = self.cut.pop() {
            self.put_back(ear);
        }
        true
    }

    /// Returns the twin of a half-edge, or `None` on the boundary of the polygon.
    pub(crate) fn twin(&self, edge: HalfEdge) -> Option<HalfEdge> {
        self.packed_twin(edge).get().ok()
    }

    fn packed_twin(&self, edge: HalfEdge) -> PackedTwin {
        self.neighbours.as_flattened()[edge.index()]
    }

    /// Cuts ears off in random order until three vertices are left, which it returns in the order
    /// of the chain: its first and its last one, and one between, if the chain is not closed.
    /// Returns `None` if there are too few ears.
    fn cut_ears(&mut self) -> Option<[u32; 3]> {
        let count = self.at.len() as u32;
        self.cut.clear();
        if count == 3 {
            // Most chains: a subsegment that crosses two triangles has one on either side.
            return self.if_clockwise([0, 1, 2]);
        }
        let last = count - 1;
        self.next.clear();
        self.next.extend((1..count).chain([0]));
        self.previous.clear();
        self.previous.extend([last].into_iter().chain(0..last));
        self.ears.clear();
        self.ear_indices.clear();
        self.ear_indices.resize(count as usize, NOT_AN_EAR);
        // The same numbers for the same cavity: files must not depend on what a thread triangulated
        // before.
        self.random = u64::from(count);
        for position in 0..count {
            self.update_ear(position);
        }
        let mut left = 0;
        for _ in 0..count.saturating_sub(3) {
            let index = self.choose();
            let ear = *self.ears.get(index)?;
            self.remove(index);
            let [before, after] = [self.previous[ear as usize], self.next[ear as usize]];
            self.cut.push([before, ear, after]);
            self.next[before as usize] = after;
            self.previous[after as usize] = before;
            self.update_ear(before);
            self.update_ear(after);
            left = if self.centre.is_some() { after } else { 0 };
        }
        let middle = self.next[left as usize];
        self.if_clockwise([left, middle, self.next[middle as usize]])
    }

    /// Returns three positions if their points are clockwise, as those of a chain are.
    fn if_clockwise(&self, three: [u32; 3]) -> Option<[u32; 3]> {
        let [a, b, c] = three.map(|position| self.at[position as usize]);
        (orient2d(a, b, c) == Orientation::Clockwise).then_some(three)
    }

    /// Updates the list of ears for one position.
    fn update_ear(&mut self, position: u32) {
        let around = [self.next[position as usize], position, self.previous[position as usize]];
        let [after, at, before] = around.map(|position| self.at[position as usize]);
        let is_cut_off = match self.centre {
            // Both ends of the constraint stay.
            None => position != 0 && position + 1 != self.at.len() as u32,
            Some(centre) => orient2d(after, before, centre) != Orientation::Clockwise,
        };
        let is_ear = is_cut_off && orient2d(after, at, before) == Orientation::CounterClockwise;
        let index = self.ear_indices[position as usize];
        if is_ear && index == NOT_AN_EAR {
            self.ear_indices[position as usize] = self.ears.len() as u32;
            self.ears.push(position);
        } else if !is_ear && index != NOT_AN_EAR {
            self.remove(index as usize);
        }
    }

    fn remove(&mut self, index: usize) {
        let position = self.ears.swap_remove(index);
        self.ear_indices[position as usize] = NOT_AN_EAR;
        if let Some(&moved) = self.ears.get(index) {
            self.ear_indices[moved as usize] = index as u32;
        }
    }

    /// Returns a random index into the list of ears. The multiplier is Knuth's. The numbers affect
    /// the running time alone.
    fn choose(&mut self) -> usize {
        self.random = self
            .random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (((self.random >> 32) * self.ears.len() as u64) >> 32) as usize
    }

    /// Puts an ear back, and flips the edges that are no longer Delaunay.
    ///
    /// ```text
    ///     ─ before ─── after ─          before ─ ear ─ after
    ///         inside                         ╲  inside ╱
    /// ```
    fn put_back(&mut self, [before, ear, after]: [u32; 3]) {
        let triangle = TriangleId(self.triangles.len() as u32);
        let inner = self.edges[before as usize];
        let [outer_after, outer_before, base] = HalfEdge::of_triangle(triangle);
        self.triangles.push([after, ear, before]);
        self.neighbours.push([
            PackedTwin::chain(ear),
            PackedTwin::chain(before),
            PackedTwin::half_edge(inner),
        ]);
        self.link(PackedTwin::half_edge(inner), base);
        self.edges[ear as usize] = outer_after;
        self.edges[before as usize] = outer_before;
        self.stack.push(base);
        while let Some(edge) = self.stack.pop() {
            self.legalise(edge);
        }
    }

    /// Flips an edge if the far corner of its twin's triangle lies in the circle of the triangle at
    /// `edge`, whose apex was just put back.
    ///
    /// ```text
    ///        ear                ear
    ///      ╱     ╲            ╱  │  ╲
    ///     a ─edge→ b    →    a   │   b
    ///      ╲     ╱            ╲  │  ╱
    ///         d                  d
    /// ```
    fn legalise(&mut self, edge: HalfEdge) {
        let Some(twin) = self.twin(edge) else { return };
        let corner = |edge: HalfEdge| self.triangles.as_flattened()[edge.index()];
        let [a, b, ear] = [edge, edge.next(), edge.prev()].map(corner);
        let d = corner(twin.prev());
        let [pa, pb, pear, pd] = [a, b, ear, d].map(|position| self.at[position as usize]);
        if !in_circle(pa, pb, pear, pd) {
            return;
        }
        let [b_ear, ear_a, a_d, d_b] =
            [edge.next(), edge.prev(), twin.next(), twin.prev()].map(|edge| self.packed_twin(edge));
        let [t, u] = [edge, twin].map(HalfEdge::triangle);
        let [of_d_b, of_b_ear, ear_d] = HalfEdge::of_triangle(t);
        let [of_a_d, d_ear, of_ear_a] = HalfEdge::of_triangle(u);
        self.triangles[t.index()] = [d, b, ear];
        self.triangles[u.index()] = [a, d, ear];
        self.neighbours[t.index()] = [d_b, b_ear, PackedTwin::half_edge(d_ear)];
        self.neighbours[u.index()] = [a_d, PackedTwin::half_edge(ear_d), ear_a];
        self.link(d_b, of_d_b);
        self.link(b_ear, of_b_ear);
        self.link(a_d, of_a_d);
        self.link(ear_a, of_ear_a);
        self.stack.extend([of_d_b, of_a_d]);
    }

    /// Makes `edge` the twin of a half-edge, or the half-edge at a position of the chain.
    fn link(&mut self, twin: PackedTwin, edge: HalfEdge) {
        match twin.get() {
            Ok(half_edge) => self.neighbours.as_flattened_mut()[half_edge.index()] = PackedTwin::half_edge(edge),
            Err(position) => self.edges[position as usize] = edge,
        }
    }
}
