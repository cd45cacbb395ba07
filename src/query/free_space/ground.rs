//! Where one may walk: what lies beyond a side.
//!
//! Walls, and what separates free triangles from holes, *block*.

use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, VertexIndex, orient2d};
use crate::mesh::Twin;
use crate::query::request::{Contradiction, Tiles};
use crate::store::Tile;

/// What lies beyond a side of a free triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Beyond {
    /// A free triangle, with this side.
    Side(HalfEdge),
    /// A triangle of another tile, or the hull.
    Elsewhere,
    /// The free outside.
    Outside,
    /// Nothing that one may enter.
    Blocked,
}

/// A tile to walk on.
#[derive(Clone, Copy)]
pub(crate) struct Ground<'t> {
    pub(crate) tile: &'t Tile,
    /// Whether the outside of the hull is free.
    pub(crate) outside_is_free: bool,
}

impl<'t> Ground<'t> {
    /// A tile of a query's file.
    pub(crate) fn of(tiles: &Tiles, tile: &'t Tile) -> Self {
        let outside_is_free = tiles.outside_is_free();
        Self { tile, outside_is_free }
    }

    /// Where a corner is.
    #[inline]
    pub(crate) fn point(self, corner: VertexIndex) -> Point {
        self.tile.point(corner)
    }

    /// Whether a triangle is free.
    pub(crate) fn is_free(self, triangle: TriangleId) -> bool {
        !self.tile.is_hole(triangle)
    }

    /// What lies beyond a side of a free triangle.
    #[inline]
    pub(crate) fn beyond(self, side: HalfEdge) -> Beyond {
        let is_constraint = self.tile.is_constraint(side);
        if is_constraint && self.tile.is_wall(side) {
            return Beyond::Blocked;
        }
        match self.tile.twin(side) {
            // Only a constraint separates a hole from what is free.
            Twin::HalfEdge(other) if !is_constraint || self.is_free(other.triangle()) => Beyond::Side(other),
            Twin::Elsewhere => Beyond::Elsewhere,
            Twin::Hull if self.outside_is_free => Beyond::Outside,
            Twin::HalfEdge(_) | Twin::Hull => Beyond::Blocked,
        }
    }

    /// Makes sure that a side has these ends, which are those of the side beyond it, and that its triangle lies on its left.
    ///
    /// Damaged tiles may contradict this. Where it holds for each side that is crossed, a straight way comes to the triangles that it passes in
    /// their order, and to none twice; so it ends.
    #[inline]
    pub(crate) fn check_crossing(self, side: HalfEdge, [from, to]: [Point; 2]) -> Result<(), Contradiction> {
        let [origin, end, apex] = [side, side.next(), side.prev()].map(|side| self.point(self.tile.origin(side)));
        if origin == from && end == to && orient2d(from, to, apex) == Orientation::CounterClockwise {
            return Ok(());
        }
        Err(Contradiction::NotBeside(side.triangle()))
    }
}
