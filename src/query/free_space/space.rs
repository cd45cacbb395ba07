//! The free space of a tile: which triangles are free, and which edges block.

use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, VertexIndex, orient2d};
use crate::mesh::Twin;
use crate::query::request::{Contradiction, Tiles};
use crate::store::Tile;

/// The space beyond a half-edge of a free triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FreeTwin {
    /// The triangle of this half-edge, the twin, which is free.
    HalfEdge(HalfEdge),
    /// A triangle of another tile, or the hull.
    Elsewhere,
    /// The free outside of the hull.
    Outside,
    /// Nothing: the edge blocks, or the space beyond it is not free.
    Blocked,
}

/// A tile, as free and blocked space.
#[derive(Clone, Copy)]
pub(crate) struct FreeSpace<'t> {
    pub(crate) tile: &'t Tile,
    /// Whether the outside of the hull is free.
    pub(crate) outside_is_free: bool,
}

impl<'t> FreeSpace<'t> {
    /// Returns the free space of a tile of a query's file.
    pub(crate) fn of(tiles: &Tiles, tile: &'t Tile) -> Self {
        let outside_is_free = tiles.outside_is_free();
        Self { tile, outside_is_free }
    }

    /// Returns the position of a corner.
    #[inline]
    pub(crate) fn point(self, corner: VertexIndex) -> Point {
        self.tile.point(corner)
    }

    /// Returns whether a triangle is free.
    pub(crate) fn is_free(self, triangle: TriangleId) -> bool {
        !self.tile.is_hole(triangle)
    }

    /// Returns what is beyond a half-edge of a free triangle.
    #[inline]
    pub(crate) fn twin(self, half_edge: HalfEdge) -> FreeTwin {
        let is_constraint = self.tile.is_constraint(half_edge);
        if is_constraint && self.tile.is_wall(half_edge) {
            return FreeTwin::Blocked;
        }
        match self.tile.twin(half_edge) {
            // Only a constraint separates a hole from free space.
            Twin::HalfEdge(other) if !is_constraint || self.is_free(other.triangle()) => FreeTwin::HalfEdge(other),
            Twin::Elsewhere => FreeTwin::Elsewhere,
            Twin::Hull if self.outside_is_free => FreeTwin::Outside,
            Twin::HalfEdge(_) | Twin::Hull => FreeTwin::Blocked,
        }
    }

    /// Checks that a half-edge has these ends, which are those of its twin, and that its triangle
    /// is on its left.
    ///
    /// Damaged tiles may violate this. If it holds for each half-edge that a straight line crosses,
    /// the line passes the triangles in their order along it and no triangle twice, so the walk
    /// ends.
    #[inline]
    pub(crate) fn check_crossing(self, half_edge: HalfEdge, [from, to]: [Point; 2]) -> Result<(), Contradiction> {
        let [origin, end, apex] =
            [half_edge, half_edge.next(), half_edge.prev()].map(|half_edge| self.point(self.tile.origin(half_edge)));
        if origin == from && end == to && orient2d(from, to, apex) == Orientation::CounterClockwise {
            return Ok(());
        }
        Err(Contradiction::NotBeside(half_edge.triangle()))
    }
}
