//! Half-edges of triangles that are stored in arrays, and their arithmetic.

use std::fmt;

use super::ids::TriangleId;

/// A half-edge of a triangulation: `3 * triangle + corner`, where `corner` is the corner at which
/// it starts.
///
/// ```text
///          c            3t+0: a → b
///        /   \          3t+1: b → c
///     2 /  t  \ 1       3t+2: c → a
///      /       \
///     a ─────── b
///          0
/// ```
///
/// # Example
///
/// ```
/// use delaunay_tiles::geometry::{HalfEdge, TriangleId};
///
/// let triangle = TriangleId(7);
/// let edge = HalfEdge::new(triangle, 2);
/// assert_eq!((edge.triangle(), edge.corner()), (triangle, 2));
/// assert_eq!(edge.next(), HalfEdge::new(triangle, 0));
/// assert_eq!(edge.prev(), HalfEdge::new(triangle, 1));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct HalfEdge(pub u32);

impl HalfEdge {
    /// Creates the half-edge that starts at `corner` (0, 1 or 2) of `triangle`.
    #[inline]
    #[must_use]
    pub const fn new(triangle: TriangleId, corner: u32) -> Self {
        Self(3 * triangle.0 + corner)
    }

    /// Returns the three half-edges of a triangle, counter-clockwise.
    #[inline]
    #[must_use]
    pub const fn of_triangle(triangle: TriangleId) -> [Self; 3] {
        let first = 3 * triangle.0;
        [Self(first), Self(first + 1), Self(first + 2)]
    }

    /// Returns the triangle on the half-edge's left, to which it belongs.
    #[inline]
    #[must_use]
    pub const fn triangle(self) -> TriangleId {
        TriangleId(self.0 / 3)
    }

    /// Returns the corner of the triangle at which the half-edge starts: 0, 1 or 2.
    #[inline]
    #[must_use]
    pub const fn corner(self) -> u32 {
        self.0 % 3
    }

    /// Returns the next half-edge of the same triangle, counter-clockwise.
    #[inline]
    #[must_use]
    pub const fn next(self) -> Self {
        Self(if self.0 % 3 == 2 { self.0 - 2 } else { self.0 + 1 })
    }

    /// Returns the previous half-edge of the same triangle.
    #[inline]
    #[must_use]
    pub const fn prev(self) -> Self {
        Self(if self.0.is_multiple_of(3) {
            self.0 + 2
        } else {
            self.0 - 1
        })
    }

    /// Returns the half-edge's index in an array with an entry for each half-edge.
    #[inline]
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// An `Option<HalfEdge>` in four bytes instead of eight. Arrays of these take most of the memory of
/// an in-core triangulation.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
pub struct PackedHalfEdge(u32);

impl PackedHalfEdge {
    /// No half-edge.
    pub const NONE: Self = Self(u32::MAX);

    /// Returns the half-edge, if there is one.
    #[inline]
    #[must_use]
    pub const fn get(self) -> Option<HalfEdge> {
        if self.0 == Self::NONE.0 {
            None
        } else {
            Some(HalfEdge(self.0))
        }
    }
}

impl PackedHalfEdge {
    /// Returns the triangle of the half-edge, or a number larger than that of any triangle if there
    /// is no half-edge. Branch-free.
    #[inline]
    pub(crate) const fn triangle_or_more(self) -> u32 {
        self.0 / 3
    }
}

impl From<HalfEdge> for PackedHalfEdge {
    #[inline]
    fn from(half_edge: HalfEdge) -> Self {
        debug_assert!(half_edge.0 != u32::MAX);
        Self(half_edge.0)
    }
}

impl From<Option<HalfEdge>> for PackedHalfEdge {
    #[inline]
    fn from(half_edge: Option<HalfEdge>) -> Self {
        half_edge.map_or(Self::NONE, Self::from)
    }
}

impl fmt::Debug for PackedHalfEdge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.get().fmt(f)
    }
}
