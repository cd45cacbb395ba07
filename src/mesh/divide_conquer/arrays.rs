//! The triangles and ghosts of all parts.

use super::half_edges::{BitHalfEdge, GHOST, HalfEdges};
use crate::geometry::Point;

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
    /// Returns the half-edges, for merges.
    #[inline]
    pub(super) fn half_edges(&mut self) -> HalfEdges<'_> {
        HalfEdges {
            points: &self.points,
            origins: self.corners.as_flattened_mut(),
            twins: self.twins.as_flattened_mut(),
        }
    }

    /// Moves triangles to the slots of `ghosts` until the first `count` slots hold no ghosts. The
    /// ghosts are lost.
    pub(super) fn move_behind(&mut self, ghosts: &[BitHalfEdge], count: usize) {
        let mut behind = count;
        for &ghost in ghosts {
            let inner = self.twins[ghost.triangle()][ghost.corner()];
            // A chain has ghosts on both sides. Then the other ghost may have unset this twin
            // before.
            if inner != BitHalfEdge::UNSET {
                self.twins[inner.triangle()][inner.corner()] = BitHalfEdge::UNSET;
            }
            if ghost.triangle() >= count {
                continue;
            }
            while self.corners[behind].contains(&GHOST) {
                behind += 1;
            }
            let slot = ghost.triangle();
            self.corners[slot] = self.corners[behind];
            self.twins[slot] = self.twins[behind];
            for (corner, twin) in (0..).zip(self.twins[slot]) {
                if twin != BitHalfEdge::UNSET {
                    self.twins[twin.triangle()][twin.corner()] = BitHalfEdge::new(slot as u32, corner);
                }
            }
            behind += 1;
        }
    }
}
