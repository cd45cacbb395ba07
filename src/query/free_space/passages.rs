//! What lies beyond the sides of a tile's triangles, noted for all searches when the first one comes to a side, and where dead ends begin.
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
//! That sides agree with those beyond them is checked when they are noted, and not at each crossing. To look for dead ends takes all sides of
//! the tile, which pays where many searches come; the first ones do without.

use std::sync::atomic::Ordering;

use super::space::{FreeSpace, FreeTwin};
use crate::geometry::{HalfEdge, Orientation, TriangleId, VertexIndex, orient2d};
use crate::store::{HalfEdgeNote, HalfEdgeNotes, NoteKind};

/// What lies beyond a side, if it is no side: from here on, and [`HalfEdgeNote::NONE`].
const NO_SIDE: u32 = u32::MAX - 4;
const BLOCKED: u32 = NO_SIDE;
const ELSEWHERE: u32 = NO_SIDE + 1;
const OUTSIDE: u32 = NO_SIDE + 2;
const CONTRADICTORY: u32 = NO_SIDE + 3;
/// Of a side beyond which there is a dead end.
const DEAD_END: u32 = 1 << 31;

/// The search that comes to a tile as this one looks for its dead ends: to do that takes as long as some tens of ways across the tile.
const LOOKS_FOR_DEAD_ENDS: u32 = 16;

/// What lies beyond a side of a free triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Passage {
    /// A free triangle, with this side.
    HalfEdge(HalfEdge),
    /// The same, and it leads nowhere else.
    DeadEnd(HalfEdge),
    /// A triangle of another tile, or the hull.
    Elsewhere,
    /// The free outside.
    Outside,
    /// Nothing that one may enter.
    Blocked,
    /// A triangle that does not lie there: the tile is damaged.
    Contradictory,
}

/// The sides of a tile, and what is noted of them.
#[derive(Clone, Copy)]
pub(crate) struct Passages<'t> {
    space: FreeSpace<'t>,
    noted: &'t HalfEdgeNotes,
}

impl<'t> FreeSpace<'t> {
    /// What lies beyond the sides of the tile's triangles.
    #[inline]
    pub(crate) fn passages(self) -> Passages<'t> {
        Passages {
            space: self,
            noted: self.tile.notes().half_edges(3 * self.tile.triangle_count()),
        }
    }
}

impl<'t> Passages<'t> {
    /// The tile.
    #[inline]
    pub(crate) fn space(self) -> FreeSpace<'t> {
        self.space
    }

    /// What lies beyond a side.
    #[inline]
    pub(crate) fn twin(self, half_edge: HalfEdge) -> Passage {
        let noted = match self.noted.half_edges[half_edge.index()].get(NoteKind::Passage) {
            HalfEdgeNote::NONE => self.note(half_edge),
            noted => noted,
        };
        match noted {
            BLOCKED => Passage::Blocked,
            ELSEWHERE => Passage::Elsewhere,
            OUTSIDE => Passage::Outside,
            CONTRADICTORY => Passage::Contradictory,
            half_edge if half_edge & DEAD_END != 0 && self.may_mark() => {
                Passage::DeadEnd(HalfEdge(half_edge & !DEAD_END))
            }
            half_edge => Passage::HalfEdge(HalfEdge(half_edge)),
        }
    }

    /// Whether dead ends are marked: not where there are so many sides that the mark would be one's number.
    #[inline]
    fn may_mark(self) -> bool {
        self.noted.half_edges.len() <= DEAD_END as usize
    }

    /// The corner that a side starts at.
    #[inline]
    pub(crate) fn corner(self, half_edge: HalfEdge) -> VertexIndex {
        let noted = &self.noted.half_edges[half_edge.index()];
        VertexIndex(match noted.get(NoteKind::Origin) {
            HalfEdgeNote::NONE => noted.note(NoteKind::Origin, self.space.tile.origin(half_edge).0),
            corner => corner,
        })
    }

    /// Finds out what lies beyond a side.
    #[cold]
    fn note(self, half_edge: HalfEdge) -> u32 {
        let beyond = match self.space.twin(half_edge) {
            FreeTwin::HalfEdge(other) if self.agree(half_edge, other) => other.0,
            FreeTwin::HalfEdge(_) => CONTRADICTORY,
            FreeTwin::Elsewhere => ELSEWHERE,
            FreeTwin::Outside => OUTSIDE,
            FreeTwin::Blocked => BLOCKED,
        };
        self.noted.half_edges[half_edge.index()].note(NoteKind::Passage, beyond)
    }

    /// Whether two sides have the same ends, and the triangle of the other one lies on its left.
    fn agree(self, half_edge: HalfEdge, other: HalfEdge) -> bool {
        let [from, to] = [half_edge, half_edge.next()].map(|half_edge| self.corner(half_edge));
        let corners = HalfEdge::of_triangle(other.triangle()).map(|half_edge| self.corner(half_edge));
        let [to_there, from_there] = [other, other.next()].map(|half_edge| corners[half_edge.corner() as usize]);
        let is_same = |a: VertexIndex, b: VertexIndex| a == b || self.space.point(a) == self.space.point(b);
        let [a, b, c] = corners.map(|corner| self.space.point(corner));
        is_same(from, from_there) && is_same(to, to_there) && orient2d(a, b, c) == Orientation::CounterClockwise
    }

    /// A search comes to the tile: whether dead ends are known in it, from now on.
    pub(crate) fn visit(self) -> bool {
        if self.noted.knows_dead_ends.load(Ordering::Acquire) {
            return true;
        }
        let is_time = self.noted.visits.fetch_add(1, Ordering::Relaxed) + 1 == LOOKS_FOR_DEAD_ENDS;
        if is_time {
            self.find_dead_ends();
        }
        is_time
    }

    /// Marks dead ends. Only one search may do so.
    fn find_dead_ends(self) {
        // Where nothing is blocked, nothing is a dead end.
        if self.space.may_block() && self.may_mark() {
            self.mark_dead_ends();
        }
        self.noted.knows_dead_ends.store(true, Ordering::Release);
    }

    /// A triangle, and those by which one comes to it if it is in a dead end, up to the first one that is not.
    pub(crate) fn way_in(self, triangle: TriangleId) -> Vec<TriangleId> {
        let mut way = Vec::new();
        let mut triangle = triangle;
        for _ in 0..self.space.tile.triangle_count() {
            way.push(triangle);
            let half_edges = HalfEdge::of_triangle(triangle);
            // From inside, the only way out is not marked.
            let out = half_edges
                .into_iter()
                .map(|half_edge| self.twin(half_edge))
                .find_map(|beyond| match beyond {
                    Passage::HalfEdge(half_edge) => Some(half_edge),
                    _ => None,
                });
            match out {
                Some(out) if matches!(self.twin(out), Passage::DeadEnd(_)) => triangle = out.triangle(),
                _ => break,
            }
        }
        way
    }

    /// Takes away triangles that have one way out, and then those that have one way out without them, and so on.
    fn mark_dead_ends(self) {
        let is_site: Vec<bool> = self.space.site_marks();
        let ways = |triangle: TriangleId| -> u8 {
            let half_edges = HalfEdge::of_triangle(triangle);
            // What is not a side of the tile, nor blocked, is a way out that stays.
            let count = half_edges.map(|half_edge| match self.twin(half_edge) {
                Passage::Blocked => 0,
                Passage::HalfEdge(_) | Passage::DeadEnd(_) => 1,
                Passage::Elsewhere | Passage::Outside | Passage::Contradictory => 2,
            });
            count.into_iter().sum()
        };
        let core = self.space.tile.core_triangle_count() as usize;
        let core = self.space.tile.triangle_ids().take(core);
        let mut left: Vec<u8> = core
            .clone()
            .map(|triangle| {
                let mut corners = HalfEdge::of_triangle(triangle)
                    .into_iter()
                    .map(|half_edge| self.corner(half_edge));
                let stays = !self.space.is_free(triangle) || corners.any(|corner| is_site[corner.index()]);
                if stays { u8::MAX } else { ways(triangle) }
            })
            .collect();
        let mut ends: Vec<TriangleId> = core.filter(|triangle| left[triangle.index()] <= 1).collect();
        while let Some(triangle) = ends.pop() {
            left[triangle.index()] = u8::MAX;
            let mut half_edges = HalfEdge::of_triangle(triangle).into_iter();
            let out = half_edges.find_map(|half_edge| match self.twin(half_edge) {
                Passage::HalfEdge(out) => Some(out),
                _ => None,
            });
            let Some(out) = out else { continue };
            if !matches!(self.twin(out), Passage::HalfEdge(_) | Passage::DeadEnd(_)) {
                continue;
            }
            self.noted.half_edges[out.index()].set_bits(NoteKind::Passage, DEAD_END);
            if let Some(left) = left.get_mut(out.triangle().index()).filter(|left| **left < u8::MAX) {
                *left = left.saturating_sub(1);
                if *left == 1 {
                    ends.push(out.triangle());
                }
            }
        }
    }
}

impl FreeSpace<'_> {
    /// Whether a side may be blocked.
    fn may_block(self) -> bool {
        let mut components = 0..self.tile.component_count();
        !self.outside_is_free
            || components.any(|component| self.tile.component_at(component).is_hole)
            || self
                .tile
                .constraint_half_edges()
                .any(|half_edge| self.tile.is_wall(half_edge))
    }

    fn site_marks(self) -> Vec<bool> {
        let mut marks = vec![false; self.tile.vertex_count() as usize];
        for site in self.tile.sites() {
            marks[site.vertex.index()] = true;
        }
        marks
    }
}

#[cfg(test)]
mod tests;
