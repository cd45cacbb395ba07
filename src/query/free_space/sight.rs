//! Whether one place sees another one within a tile: then the straight way is the shortest, and needs no search.
//!
//! It is a quick look: where it says no, the way may be straight all the same, through other tiles or vertices.

use super::ground::Ground;
use super::passages::Passage;
use super::place::Place;
use super::spot::Spot;
use crate::geometry::{HalfEdge, Orientation, orient2d};
use crate::query::request::{QueryError, Tiles};

impl Ground<'_> {
    /// Whether the straight way between two places, each strictly within a free triangle of this tile, crosses nothing but sides within the
    /// tile that do not block.
    pub(crate) fn sees(self, from: &Place, to: &Place) -> bool {
        let (Spot::Triangle(start), Spot::Triangle(goal)) = (from.spot, to.spot) else {
            return false;
        };
        if [start, goal].iter().any(|end| end.tile != self.tile.id()) {
            return false;
        }
        let passages = self.passages();
        let turn = |side: HalfEdge| orient2d(from.point, to.point, self.point(passages.corner(side)));
        if start.triangle == goal.triangle {
            return true;
        }
        let mut sides = HalfEdge::of_triangle(start.triangle).into_iter();
        // It leaves between a corner on its right and one on its left.
        let exit = sides
            .find(|&side| turn(side) == Orientation::Clockwise && turn(side.next()) == Orientation::CounterClockwise);
        let Some(mut exit) = exit else { return false };
        // Whatever a damaged tile says, it does not take for ever.
        for _ in 0..self.tile.triangle_count() {
            let (Passage::Side(entered) | Passage::DeadEnd(entered)) = passages.beyond(exit) else {
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
    /// Whether one place sees another one, as far as a quick look at the last tile tells.
    pub(crate) async fn sees(&mut self, from: &Place, to: &Place) -> Result<bool, QueryError> {
        let tile = self.last().await?;
        Ok(Ground::of(self, &tile).sees(from, to))
    }
}
