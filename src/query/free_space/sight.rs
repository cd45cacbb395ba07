//! Line of sight within a tile. If one point sees another, the straight line is the shortest path,
//! and no search is needed.
//!
//! The test is quick and one-sided: if it fails, the path may still be straight, through other
//! tiles or through vertices.

use super::passages::Passage;
use super::position::Position;
use super::query_point::QueryPoint;
use super::space::FreeSpace;
use crate::geometry::{HalfEdge, Orientation, orient2d};
use crate::query::request::{QueryError, Tiles};

impl FreeSpace<'_> {
    /// Returns whether both points are strictly inside free triangles of this tile, and the segment
    /// between them crosses only half-edges with a free twin in this tile.
    pub(crate) fn sees(self, from: &QueryPoint, to: &QueryPoint) -> bool {
        let (Position::Triangle(start), Position::Triangle(goal)) = (from.position, to.position) else {
            return false;
        };
        if [start, goal].iter().any(|end| end.tile != self.tile.id()) {
            return false;
        }
        let passages = self.passages();
        let turn = |half_edge: HalfEdge| orient2d(from.point, to.point, self.point(passages.corner(half_edge)));
        if start.triangle == goal.triangle {
            return true;
        }
        let mut half_edges = HalfEdge::of_triangle(start.triangle).into_iter();
        // The segment leaves between a corner on its right and a corner on its left.
        let exit = half_edges.find(|&half_edge| {
            turn(half_edge) == Orientation::Clockwise && turn(half_edge.next()) == Orientation::CounterClockwise
        });
        let Some(mut exit) = exit else { return false };
        // The bound ends the loop in damaged tiles.
        for _ in 0..self.tile.triangle_count() {
            let (Passage::HalfEdge(entered) | Passage::DeadEnd(entered)) = passages.twin(exit) else {
                return false;
            };
            if entered.triangle() == goal.triangle {
                return true;
            }
            exit = match turn(entered.prev()) {
                Orientation::CounterClockwise => entered.next(),
                Orientation::Clockwise => entered.prev(),
                Orientation::Collinear => return false,
            };
        }
        false
    }
}

impl Tiles {
    /// Returns whether `from` sees `to` within the tile that was read last. May return `false`
    /// although it does.
    pub(crate) async fn sees(&mut self, from: &QueryPoint, to: &QueryPoint) -> Result<bool, QueryError> {
        let tile = self.last().await?;
        Ok(FreeSpace::of(self, &tile).sees(from, to))
    }
}
