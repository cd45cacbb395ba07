//! Half-edges of triangles and ghosts, and their adjacency.

use std::hint::select_unpredictable;

use crate::geometry::{HalfEdge, PackedHalfEdge, Point, TriangleId};

/// The point at infinity, a corner of every ghost.
pub(super) const GHOST: u32 = u32::MAX;

/// A half-edge with its triangle and its corner in separate bits: `triangle << 2 | corner`, where
/// `corner` is its origin. Neither takes a division, unlike those of [`HalfEdge`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct BitHalfEdge(u32);

impl BitHalfEdge {
    pub(super) const UNSET: Self = Self(u32::MAX);

    #[inline]
    pub(super) const fn new(triangle: u32, corner: u32) -> Self {
        Self(triangle << 2 | corner)
    }

    #[inline]
    pub(super) fn triangle(self) -> usize {
        (self.0 >> 2) as usize
    }

    #[inline]
    pub(super) fn corner(self) -> usize {
        (self.0 & 3) as usize
    }

    /// Returns the half-edge at the same corner of the triangle that is `triangles` further on.
    #[inline]
    pub(super) fn plus(self, triangles: u32) -> Self {
        Self(self.0 + (triangles << 2))
    }

    /// Returns the position in arrays of three per triangle: `3 * triangle + corner`.
    #[inline]
    fn position(self) -> usize {
        (self.0 - (self.0 >> 2)) as usize
    }

    #[inline]
    pub(super) fn next(self) -> Self {
        Self(select_unpredictable(
            self.corner() == 2,
            self.0.wrapping_sub(2),
            self.0.wrapping_add(1),
        ))
    }

    #[inline]
    pub(super) fn packed(self) -> PackedHalfEdge {
        match self {
            Self::UNSET => PackedHalfEdge::NONE,
            Self(_) => HalfEdge::new(TriangleId(self.0 >> 2), self.0 & 3).into(),
        }
    }

    #[inline]
    pub(super) fn prev(self) -> Self {
        Self(select_unpredictable(
            self.corner() == 0,
            self.0.wrapping_add(2),
            self.0.wrapping_sub(1),
        ))
    }
}

/// The half-edges of all triangles and ghosts. The arrays are flat, so that an access takes one
/// check: with a check of the triangle and one of the corner, the engine takes 13 % longer.
pub(super) struct HalfEdges<'a> {
    pub(super) points: &'a [Point],
    /// The vertex where each half-edge starts.
    pub(super) origins: &'a mut [u32],
    pub(super) twins: &'a mut [BitHalfEdge],
}

impl HalfEdges<'_> {
    #[inline]
    pub(super) fn point(&self, vertex: u32) -> Point {
        self.points[vertex as usize]
    }

    #[inline]
    pub(super) fn origin(&self, edge: BitHalfEdge) -> u32 {
        self.origins[edge.position()]
    }

    #[inline]
    pub(super) fn dest(&self, edge: BitHalfEdge) -> u32 {
        self.origin(edge.next())
    }

    #[inline]
    pub(super) fn twin(&self, edge: BitHalfEdge) -> BitHalfEdge {
        self.twins[edge.position()]
    }

    #[inline]
    pub(super) fn link(&mut self, a: BitHalfEdge, b: BitHalfEdge) {
        self.twins[a.position()] = b;
        self.twins[b.position()] = a;
    }

    #[inline]
    pub(super) fn set_origin(&mut self, edge: BitHalfEdge, vertex: u32) {
        self.origins[edge.position()] = vertex;
    }

    #[inline]
    pub(super) fn set_apex(&mut self, edge: BitHalfEdge, vertex: u32) {
        self.set_origin(edge.prev(), vertex);
    }

    /// Sets the corners of a triangle. The first is the origin of `edge`.
    #[inline]
    pub(super) fn set_corners(&mut self, edge: BitHalfEdge, [a, b, c]: [u32; 3]) {
        self.set_origin(edge, a);
        self.set_origin(edge.next(), b);
        self.set_origin(edge.prev(), c);
    }

    /// Returns the ghost of the hull edge that follows that of `ghost`, counter-clockwise.
    #[inline]
    pub(super) fn hull_next(&self, ghost: BitHalfEdge) -> BitHalfEdge {
        self.twin(ghost.prev()).prev()
    }

    /// Returns the ghost of the hull edge that precedes that of `ghost`, counter-clockwise.
    #[inline]
    pub(super) fn hull_prev(&self, ghost: BitHalfEdge) -> BitHalfEdge {
        self.twin(ghost.next()).next()
    }
}
