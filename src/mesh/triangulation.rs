//! The arrays of an in-core triangulation.

use super::topology::{Embedded, Topology, Twin};
use crate::geometry::{HalfEdge, PackedHalfEdge, Point, VertexIndex};

/// Returns the same triangle, from its smallest corner on.
#[inline]
#[must_use]
pub(crate) const fn smallest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// A Delaunay triangulation of an array of points. It refers to points by index.
///
/// ```text
///          c            half-edge 3t+0: a → b
///        /   \          half-edge 3t+1: b → c
///     2 /  t  \ 1       half-edge 3t+2: c → a
///      /       \
///     a ─────── b       neighbours[t][s] is the twin of half-edge 3t+s: that of the
///          0            other triangle on the same edge, which runs the other way.
///                       At the hull there is none.
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Triangulation {
    /// The corners of each triangle, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// The twin of each half-edge, if it has one.
    pub neighbours: Vec<[PackedHalfEdge; 3]>,
    /// All points on the hull, counter-clockwise, including those in the interior of straight hull
    /// edges. Without triangles (fewer than three points, or collinear input), all points in
    /// lexicographic order.
    pub hull: Vec<u32>,
}

impl Triangulation {
    /// Removes all triangles and the hull, and keeps the memory.
    pub fn clear(&mut self) {
        self.triangles.clear();
        self.neighbours.clear();
        self.hull.clear();
    }

    /// Sets the hull of a triangulation without triangles: all of `points`, in lexicographic order.
    pub(crate) fn set_collinear(&mut self, points: &[Point]) {
        self.clear();
        self.hull.extend(0..points.len() as u32);
        self.hull
            .sort_unstable_by(|&a, &b| points[a as usize].lex_cmp(points[b as usize]));
    }

    /// Returns the twin of a half-edge.
    #[inline]
    pub(crate) fn packed_twin(&self, half_edge: HalfEdge) -> PackedHalfEdge {
        self.neighbours.as_flattened()[half_edge.index()]
    }

    #[inline]
    pub(crate) fn set_twin(&mut self, half_edge: HalfEdge, twin: PackedHalfEdge) {
        self.neighbours.as_flattened_mut()[half_edge.index()] = twin;
    }
}

impl Topology for Triangulation {
    #[inline]
    fn triangle_count(&self) -> u32 {
        self.triangles.len() as u32
    }

    #[inline]
    fn origin(&self, half_edge: HalfEdge) -> VertexIndex {
        VertexIndex(self.triangles.as_flattened()[half_edge.index()])
    }

    #[inline]
    fn twin(&self, half_edge: HalfEdge) -> Twin {
        self.packed_twin(half_edge).get().map_or(Twin::Hull, Twin::HalfEdge)
    }
}

/// A triangulation with its points.
#[derive(Clone, Copy, Debug)]
pub struct Mesh<'a> {
    /// The triangles.
    pub triangulation: &'a Triangulation,
    /// The points that the triangles refer to.
    pub points: &'a [Point],
}

impl Topology for Mesh<'_> {
    #[inline]
    fn triangle_count(&self) -> u32 {
        self.triangulation.triangle_count()
    }

    #[inline]
    fn origin(&self, half_edge: HalfEdge) -> VertexIndex {
        self.triangulation.origin(half_edge)
    }

    #[inline]
    fn twin(&self, half_edge: HalfEdge) -> Twin {
        self.triangulation.twin(half_edge)
    }
}

impl Embedded for Mesh<'_> {
    #[inline]
    fn point(&self, vertex: VertexIndex) -> Point {
        self.points[vertex.index()]
    }
}
