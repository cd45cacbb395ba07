//! What lies beyond each side of a tile's triangles, found once for all searches in the tile, and where dead ends begin.
//!
//! A triangle that one can leave by one side only is a *dead end*, and so is one that besides leads to dead ends only. No shortest way
//! goes through it that has neither of its ends there: it would come back to the side by which it entered, and could go along that.
//! Triangles at whose corners there are sites count as ways out, and so do those of the border, which other tiles have too.
//!
//! ```text
//!     ──────────┬───────       t has one side that is not blocked, and with t left out, so has u: both are dead ends. Who comes to
//!       ╲   u  ╱ ╲             the side between v and u need not go on, but for a goal in u or t. Whoever starts there goes out
//!     ═══╲    ╱ t ║            as if nothing was noted: the sides are noted as seen from outside
//!         ╲  ╱    ║
//!       v  ╲╱═════╝
//! ```
//!
//! That sides agree with those beyond them is checked here too, and not at each crossing.

use super::ground::{Beyond, Ground};
use super::star::next;
use crate::geometry::{Orientation, orient2d};
use crate::store::Passages;

/// What lies beyond a side, if it is no side: from here on.
const NO_SIDE: u32 = u32::MAX - 3;
const BLOCKED: u32 = NO_SIDE;
const ELSEWHERE: u32 = NO_SIDE + 1;
const OUTSIDE: u32 = NO_SIDE + 2;
const AT_ODDS: u32 = NO_SIDE + 3;
/// Of a side beyond which there is a dead end.
const DEAD_END: u32 = 1 << 31;

/// What lies beyond a side of a free triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Passage {
    /// A free triangle, with this side.
    Side(u32),
    /// The same, and it leads nowhere else.
    DeadEnd(u32),
    /// A triangle of another tile, or the hull.
    Elsewhere,
    /// The free outside.
    Outside,
    /// Nothing that one may enter.
    Blocked,
    /// A triangle that does not lie there: the tile is damaged.
    AtOdds,
}

impl Passages {
    /// What lies beyond a side.
    #[inline]
    pub(super) fn beyond(&self, side: u32) -> Passage {
        match self.beyond[side as usize] {
            BLOCKED => Passage::Blocked,
            ELSEWHERE => Passage::Elsewhere,
            OUTSIDE => Passage::Outside,
            AT_ODDS => Passage::AtOdds,
            // Where there are so many sides, none is marked.
            side if side & DEAD_END != 0 && self.beyond.len() <= DEAD_END as usize => {
                Passage::DeadEnd(side & !DEAD_END)
            }
            side => Passage::Side(side),
        }
    }

    /// The corner that a side starts at.
    #[inline]
    pub(super) fn corner(&self, side: u32) -> u32 {
        self.corners[side as usize]
    }

    /// A triangle, and those by which one comes to it if it is in a dead end, up to the first one that is not.
    pub(super) fn way_in(&self, triangle: u32) -> Vec<u32> {
        let mut way = Vec::new();
        let mut triangle = triangle;
        for _ in 0..self.beyond.len() / 3 {
            way.push(triangle);
            let sides = 3 * triangle..3 * triangle + 3;
            // From inside, the only way out is not marked.
            let out = sides.map(|side| self.beyond(side)).find_map(|beyond| match beyond {
                Passage::Side(side) => Some(side),
                _ => None,
            });
            match out {
                Some(out) if matches!(self.beyond(out), Passage::DeadEnd(_)) => triangle = out / 3,
                _ => break,
            }
        }
        way
    }
}

impl<'t> Ground<'t> {
    /// What lies beyond the sides of the tile's triangles.
    #[inline]
    pub(super) fn passages(self) -> &'t Passages {
        self.tile.passages(|| self.find_passages())
    }

    fn find_passages(self) -> Passages {
        let triangles = self.tile.triangle_count();
        let corners: Vec<u32> = (0..3 * triangles).map(|side| self.tile.origin(side)).collect();
        let of = |triangle: u32| [0, 1, 2].map(|s| corners[(3 * triangle + s) as usize]);
        let is_upright: Vec<bool> = (0..triangles)
            .map(|triangle| {
                let [a, b, c] = of(triangle).map(|corner| self.point(corner));
                orient2d(a, b, c) == Orientation::CounterClockwise
            })
            .collect();
        let agree = |side: u32, other: u32| {
            let [from, to] = [side, next(side)].map(|side| corners[side as usize]);
            let [to_there, from_there] = [other, next(other)].map(|side| corners[side as usize]);
            let is_same = |a: u32, b: u32| a == b || self.point(a) == self.point(b);
            is_upright[other as usize / 3] && is_same(from, from_there) && is_same(to, to_there)
        };
        let beyond = (0..3 * triangles).map(|side| match self.beyond(side) {
            Beyond::Side(other) if agree(side, other) => other,
            Beyond::Side(_) => AT_ODDS,
            Beyond::Elsewhere => ELSEWHERE,
            Beyond::Outside => OUTSIDE,
            Beyond::Blocked => BLOCKED,
        });
        let beyond = beyond.collect();
        let mut this = Passages { corners, beyond };
        // Where nothing is blocked, nothing is a dead end.
        if this.beyond.len() <= DEAD_END as usize && this.beyond.contains(&BLOCKED) {
            self.mark_dead_ends(&mut this);
        }
        this
    }

    /// Takes away triangles that have one way out, and then those that have one way out without them, and so on.
    fn mark_dead_ends(self, passages: &mut Passages) {
        let is_site: Vec<bool> = self.site_marks();
        let ways = |triangle: u32| -> u8 {
            let sides = 3 * triangle..3 * triangle + 3;
            // What is not a side of the tile, nor blocked, is a way out that stays.
            let count = sides.map(|side| match passages.beyond[side as usize] {
                BLOCKED => 0,
                other if other < NO_SIDE => 1,
                _ => 2,
            });
            count.sum()
        };
        let core = self.tile.core_triangle_count();
        let mut left: Vec<u8> = (0..core)
            .map(|triangle| {
                let mut corners = (3 * triangle..3 * triangle + 3).map(|side| passages.corner(side));
                let stays = !self.is_free(triangle) || corners.any(|corner| is_site[corner as usize]);
                if stays { u8::MAX } else { ways(triangle) }
            })
            .collect();
        let mut ends: Vec<u32> = (0..core).filter(|&triangle| left[triangle as usize] <= 1).collect();
        while let Some(triangle) = ends.pop() {
            left[triangle as usize] = u8::MAX;
            let mut sides = 3 * triangle..3 * triangle + 3;
            let out = sides.find_map(|side| match passages.beyond(side) {
                Passage::Side(out) => Some(out),
                _ => None,
            });
            let Some(out) = out else { continue };
            let back = &mut passages.beyond[out as usize];
            if *back >= NO_SIDE {
                continue;
            }
            *back |= DEAD_END;
            if let Some(left) = left.get_mut(out as usize / 3).filter(|left| **left < u8::MAX) {
                *left = left.saturating_sub(1);
                if *left == 1 {
                    ends.push(out / 3);
                }
            }
        }
    }

    fn site_marks(self) -> Vec<bool> {
        let mut marks = vec![false; self.tile.vertex_count() as usize];
        for site in self.tile.sites() {
            marks[site.vertex as usize] = true;
        }
        marks
    }
}

#[cfg(test)]
mod tests;
