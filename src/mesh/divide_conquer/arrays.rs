//! Triangles with ghosts, and their adjacency.

use crate::geometry::{HalfEdge, Orientation, PackedHalfEdge, Point, TriangleId, orient2d};

/// The point at infinity, a corner of every ghost.
pub(super) const GHOST: u32 = u32::MAX;

/// A half-edge with its triangle and its corner in separate bits: `triangle << 2 | corner`, where
/// `corner` is its origin. Neither takes a division, unlike those of [`HalfEdge`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct BitHalfEdge(u32);

impl BitHalfEdge {
    pub(super) const UNSET: Self = Self(u32::MAX);

    #[inline]
    pub(super) fn new(triangle: u32, corner: u32) -> Self {
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

    #[inline]
    pub(super) fn next(self) -> Self {
        Self(if self.corner() == 2 { self.0 - 2 } else { self.0 + 1 })
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
        Self(if self.corner() == 0 { self.0 + 2 } else { self.0 - 1 })
    }
}

/// The hull of a part: the ghosts of the hull edges that leave the part's lexicographically
/// smallest and largest vertex.
///
/// A ghost is named by its real half-edge, which runs against the hull edge.
#[derive(Clone, Copy)]
pub(super) struct Hull {
    pub(super) min: BitHalfEdge,
    pub(super) max: BitHalfEdge,
}

/// The triangles and ghosts of all parts.
#[derive(Default)]
pub(super) struct Arrays {
    /// The points in the order of the cuts. Vertices are positions in this order.
    pub(super) points: Vec<Point>,
    /// The corners of each triangle. While the kernel works, it owns the arrays of the result, and
    /// builds the result in place.
    pub(super) corners: Vec<[u32; 3]>,
    /// For each triangle and corner, the twin of the half-edge that starts there.
    pub(super) twins: Vec<[BitHalfEdge; 3]>,
}

impl Arrays {
    #[inline]
    pub(super) fn point(&self, vertex: u32) -> Point {
        self.points[vertex as usize]
    }

    #[inline]
    pub(super) fn is_above(&self, l: Point, r: Point, vertex: u32) -> bool {
        orient2d(l, r, self.point(vertex)) == Orientation::CounterClockwise
    }

    #[inline]
    pub(super) fn is_below(&self, l: Point, r: Point, vertex: u32) -> bool {
        orient2d(l, r, self.point(vertex)) == Orientation::Clockwise
    }

    #[inline]
    pub(super) fn new_triangle(&mut self, corners: [u32; 3]) -> u32 {
        let number = self.corners.len() as u32;
        self.corners.push(corners);
        self.twins.push([BitHalfEdge::UNSET; 3]);
        number
    }

    #[inline]
    pub(super) fn origin(&self, edge: BitHalfEdge) -> u32 {
        self.corners[edge.triangle()][edge.corner()]
    }

    #[inline]
    pub(super) fn dest(&self, edge: BitHalfEdge) -> u32 {
        self.origin(edge.next())
    }

    #[inline]
    pub(super) fn twin(&self, edge: BitHalfEdge) -> BitHalfEdge {
        self.twins[edge.triangle()][edge.corner()]
    }

    #[inline]
    pub(super) fn link(&mut self, a: BitHalfEdge, b: BitHalfEdge) {
        self.twins[a.triangle()][a.corner()] = b;
        self.twins[b.triangle()][b.corner()] = a;
    }

    #[inline]
    pub(super) fn set_origin(&mut self, edge: BitHalfEdge, vertex: u32) {
        self.corners[edge.triangle()][edge.corner()] = vertex;
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

    /// Creates a ring of ghosts, one for each hull edge, with consecutive numbers. Returns the
    /// first.
    #[inline(always)]
    pub(super) fn ring(&mut self, hull_edges: &[(u32, u32)]) -> u32 {
        let first = self.corners.len() as u32;
        for &(u, v) in hull_edges {
            self.new_triangle([v, u, GHOST]);
        }
        let last = first + hull_edges.len() as u32 - 1;
        for ghost in first..=last {
            let following = if ghost == last { first } else { ghost + 1 };
            self.link(BitHalfEdge::new(ghost, 2), BitHalfEdge::new(following, 1));
        }
        first
    }

    /// Creates an edge with a ghost on either side, from `a` and the vertex after it. They are in
    /// lexicographic order.
    pub(super) fn edge(&mut self, a: u32) -> Hull {
        let b = a + 1;
        let ghosts = self.ring(&[(a, b), (b, a)]);
        self.link(BitHalfEdge::new(ghosts, 0), BitHalfEdge::new(ghosts + 1, 0));
        Hull {
            min: BitHalfEdge::new(ghosts, 0),
            max: BitHalfEdge::new(ghosts + 1, 0),
        }
    }

    /// Creates a triangle, or a chain, from `a` and the two vertices after it. They are in
    /// lexicographic order.
    pub(super) fn three(&mut self, a: u32) -> Hull {
        let (b, c) = (a + 1, a + 2);
        match orient2d(self.point(a), self.point(b), self.point(c)) {
            Orientation::CounterClockwise => self.triangle([a, b, c], 2),
            Orientation::Clockwise => self.triangle([a, c, b], 1),
            Orientation::Collinear => {
                let ghosts = self.ring(&[(a, b), (b, c), (c, b), (b, a)]);
                self.link(BitHalfEdge::new(ghosts, 0), BitHalfEdge::new(ghosts + 3, 0));
                self.link(BitHalfEdge::new(ghosts + 1, 0), BitHalfEdge::new(ghosts + 2, 0));
                Hull {
                    min: BitHalfEdge::new(ghosts, 0),
                    max: BitHalfEdge::new(ghosts + 2, 0),
                }
            }
        }
    }

    /// Creates one triangle with its three ghosts. Its first corner is the smallest vertex, and
    /// corner `max` is the largest.
    fn triangle(&mut self, corners: [u32; 3], max: u32) -> Hull {
        let inner = self.new_triangle(corners);
        let [a, b, c] = corners;
        let ghosts = self.ring(&[(a, b), (b, c), (c, a)]);
        for corner in 0..3 {
            self.link(BitHalfEdge::new(inner, corner), BitHalfEdge::new(ghosts + corner, 0));
        }
        Hull {
            min: BitHalfEdge::new(ghosts, 0),
            max: BitHalfEdge::new(ghosts + max, 0),
        }
    }
}
