//! Triangles with ghosts, and how they lie beside each other.

use crate::geometry::{HalfEdge, Orientation, PackedHalfEdge, Point, TriangleId, orient2d};

/// The corner of ghosts: the point at infinity.
pub(super) const GHOST: u32 = u32::MAX;

/// A directed side of a triangle: `triangle << 2 | corner that it starts at`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Side(u32);

impl Side {
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

/// The hull of a part: the ghosts of the hull edges that leave its lexicographically smallest and largest vertex.
///
/// A ghost is named by its real side, which runs against the hull edge.
#[derive(Clone, Copy)]
pub(super) struct Hull {
    pub(super) min: Side,
    pub(super) max: Side,
}

/// The triangles and ghosts of all parts.
#[derive(Default)]
pub(super) struct Arrays {
    /// The points in the order of the cuts; vertices are positions in it.
    pub(super) points: Vec<Point>,
    /// The corners of each triangle. While it works, the kernel holds the arrays of the result, and makes it in place.
    pub(super) corners: Vec<[u32; 3]>,
    /// For each triangle and corner the [`Side`] on the other side.
    pub(super) twins: Vec<[Side; 3]>,
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
        self.twins.push([Side::UNSET; 3]);
        number
    }

    #[inline]
    pub(super) fn origin(&self, side: Side) -> u32 {
        self.corners[side.triangle()][side.corner()]
    }

    #[inline]
    pub(super) fn dest(&self, side: Side) -> u32 {
        self.origin(side.next())
    }

    #[inline]
    pub(super) fn twin(&self, side: Side) -> Side {
        self.twins[side.triangle()][side.corner()]
    }

    #[inline]
    pub(super) fn link(&mut self, a: Side, b: Side) {
        self.twins[a.triangle()][a.corner()] = b;
        self.twins[b.triangle()][b.corner()] = a;
    }

    #[inline]
    pub(super) fn set_origin(&mut self, side: Side, vertex: u32) {
        self.corners[side.triangle()][side.corner()] = vertex;
    }

    #[inline]
    pub(super) fn set_apex(&mut self, side: Side, vertex: u32) {
        self.set_origin(side.prev(), vertex);
    }

    /// Sets the corners of a triangle, the first one where `side` starts.
    #[inline]
    pub(super) fn set_corners(&mut self, side: Side, [a, b, c]: [u32; 3]) {
        self.set_origin(side, a);
        self.set_origin(side.next(), b);
        self.set_origin(side.prev(), c);
    }

    /// The ghost of the hull edge after that of `ghost`, counter-clockwise.
    #[inline]
    pub(super) fn hull_next(&self, ghost: Side) -> Side {
        self.twin(ghost.prev()).prev()
    }

    /// The ghost of the hull edge before that of `ghost`.
    #[inline]
    pub(super) fn hull_prev(&self, ghost: Side) -> Side {
        self.twin(ghost.next()).next()
    }
    /// Makes a ring of ghosts, one for each hull edge, and returns the first; they follow each other.
    #[inline(always)]
    pub(super) fn ring(&mut self, hull_edges: &[(u32, u32)]) -> u32 {
        let first = self.corners.len() as u32;
        for &(u, v) in hull_edges {
            self.new_triangle([v, u, GHOST]);
        }
        let last = first + hull_edges.len() as u32 - 1;
        for ghost in first..=last {
            let following = if ghost == last { first } else { ghost + 1 };
            self.link(Side::new(ghost, 2), Side::new(following, 1));
        }
        first
    }

    /// Two points, in lexicographic order: an edge with a ghost on either side.
    pub(super) fn edge(&mut self, a: u32) -> Hull {
        let b = a + 1;
        let ghosts = self.ring(&[(a, b), (b, a)]);
        self.link(Side::new(ghosts, 0), Side::new(ghosts + 1, 0));
        Hull {
            min: Side::new(ghosts, 0),
            max: Side::new(ghosts + 1, 0),
        }
    }

    /// Three points, in lexicographic order: a triangle, or a chain.
    pub(super) fn three(&mut self, a: u32) -> Hull {
        let (b, c) = (a + 1, a + 2);
        match orient2d(self.point(a), self.point(b), self.point(c)) {
            Orientation::CounterClockwise => self.triangle([a, b, c], 2),
            Orientation::Clockwise => self.triangle([a, c, b], 1),
            Orientation::Collinear => {
                let ghosts = self.ring(&[(a, b), (b, c), (c, b), (b, a)]);
                self.link(Side::new(ghosts, 0), Side::new(ghosts + 3, 0));
                self.link(Side::new(ghosts + 1, 0), Side::new(ghosts + 2, 0));
                Hull {
                    min: Side::new(ghosts, 0),
                    max: Side::new(ghosts + 2, 0),
                }
            }
        }
    }

    /// One triangle with its three ghosts; its first corner is the smallest vertex, corner `max` the largest.
    fn triangle(&mut self, corners: [u32; 3], max: u32) -> Hull {
        let inner = self.new_triangle(corners);
        let [a, b, c] = corners;
        let ghosts = self.ring(&[(a, b), (b, c), (c, a)]);
        for side in 0..3 {
            self.link(Side::new(inner, side), Side::new(ghosts + side, 0));
        }
        Hull {
            min: Side::new(ghosts, 0),
            max: Side::new(ghosts + max, 0),
        }
    }
}
