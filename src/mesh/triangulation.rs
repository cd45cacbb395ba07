//! The arrays that an in-core triangulation consists of.

use crate::geometry::Point;

/// No triangle: the far side of a hull edge.
pub const NONE: u32 = u32::MAX;

/// The next side, counter-clockwise, of the same triangle. A side is `3 * triangle + corner it starts at`.
#[inline]
#[must_use]
pub const fn next_side(side: u32) -> u32 {
    if side % 3 == 2 { side - 2 } else { side + 1 }
}

/// The previous side of the same triangle.
#[inline]
#[must_use]
pub const fn prev_side(side: u32) -> u32 {
    if side.is_multiple_of(3) { side + 2 } else { side - 1 }
}

/// The same triangle, from its smallest corner on.
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

/// A Delaunay triangulation of an array of points, which it refers to by index.
///
/// ```text
///          c            side 3t+0: a → b
///        /   \          side 3t+1: b → c
///     2 /  t  \ 1       side 3t+2: c → a
///      /       \
///     a ─────── b       neighbours[t][s] is the side of the other triangle on the same edge,
///          0            which runs the other way, or NONE at the hull
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Triangulation {
    /// The corners of each triangle, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle and side the opposite side, or [`NONE`].
    pub neighbours: Vec<[u32; 3]>,
    /// All points on the hull, counter-clockwise, those within straight hull edges included. Without triangles
    /// (fewer than three points, or all on one line) all points in lexicographic order.
    pub hull: Vec<u32>,
}

impl Triangulation {
    /// Forgets everything, keeps the memory.
    pub fn clear(&mut self) {
        self.triangles.clear();
        self.neighbours.clear();
        self.hull.clear();
    }

    /// Fills the hull of a triangulation without triangles: all of `points`, in lexicographic order.
    pub(crate) fn set_collinear(&mut self, points: &[Point]) {
        self.clear();
        self.hull.extend(0..points.len() as u32);
        self.hull
            .sort_unstable_by(|&a, &b| points[a as usize].lex_cmp(points[b as usize]));
    }

    /// The corner that the side starts at.
    #[inline]
    #[must_use]
    pub fn origin(&self, side: u32) -> u32 {
        self.triangles[(side / 3) as usize][(side % 3) as usize]
    }

    /// The side on the other side of the same edge, or [`NONE`].
    #[inline]
    #[must_use]
    pub fn twin(&self, side: u32) -> u32 {
        self.neighbours[(side / 3) as usize][(side % 3) as usize]
    }
}
