//! The twins of a tile's half-edges, noted for all searches when the first one reaches a half-edge,
//! and where dead ends start.
//!
//! A triangle with only one exit is a *dead end*, and so is one whose other exits all lead to dead
//! ends. No shortest path that starts and ends elsewhere runs through a dead end: it would return
//! to the half-edge by which it entered, and could run along that half-edge instead. Triangles with
//! a site at a corner count as exits, and so do triangles of the border, which other tiles have
//! too.
//!
//! ```text
//!     ──────────┬───────    t has one half-edge that is not blocked. Without t, so has u: both are
//!       ╲   u  ╱ ╲          dead ends. A search that reaches the edge between v and u stops there,
//!     ═══╲    ╱ t ║         unless a goal lies in u or t. A search that starts inside leaves as if
//!         ╲  ╱    ║         nothing were noted, because only the half-edges that lead into a dead
//!       v  ╲╱═════╝         end are marked.
//! ```
//!
//! Noting a half-edge checks that it agrees with its twin, so crossings need no check. Finding dead
//! ends examines all half-edges of the tile, which takes some milliseconds for 65,536 vertices.
//! That pays off where many searches come, so the first searches do without. The notes take 24
//! bytes of memory per triangle.

use std::sync::atomic::Ordering;

use super::space::{FreeSpace, FreeTwin};
use crate::geometry::{HalfEdge, Orientation, TriangleId, VertexIndex, orient2d};
use crate::store::{HalfEdgeNote, HalfEdgeNotes, NoteKind};

/// The lowest noted value that is not a half-edge. The values from here on are the cases below, and
/// [`HalfEdgeNote::NONE`].
const NO_SIDE: u32 = u32::MAX - 4;
const BLOCKED: u32 = NO_SIDE;
const ELSEWHERE: u32 = NO_SIDE + 1;
const OUTSIDE: u32 = NO_SIDE + 2;
const CONTRADICTORY: u32 = NO_SIDE + 3;
/// The bit that marks a half-edge whose twin belongs to a dead end.
const DEAD_END: u32 = 1 << 31;

/// The number of visits to a tile after which its dead ends are computed. The computation takes as
/// long as some tens of paths across the tile.
const LOOKS_FOR_DEAD_ENDS: u32 = 16;

/// The space beyond a half-edge of a free triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Passage {
    /// The triangle of this half-edge, the twin, which is free.
    HalfEdge(HalfEdge),
    /// The triangle of this half-edge, which is free and a dead end.
    DeadEnd(HalfEdge),
    /// A triangle of another tile, or the hull.
    Elsewhere,
    /// The free outside of the hull.
    Outside,
    /// Nothing: the edge blocks, or the space beyond it is not free.
    Blocked,
    /// A triangle whose corners contradict the edge: the tile is damaged.
    Contradictory,
}

/// The half-edges of a tile, and the notes about them.
#[derive(Clone, Copy)]
pub(crate) struct Passages<'t> {
    space: FreeSpace<'t>,
    noted: &'t HalfEdgeNotes,
}

impl<'t> FreeSpace<'t> {
    /// Returns the passages of the tile's half-edges.
    #[inline]
    pub(crate) fn passages(self) -> Passages<'t> {
        Passages {
            space: self,
            noted: self.tile.notes().half_edges(3 * self.tile.triangle_count()),
        }
    }
}

impl<'t> Passages<'t> {
    /// Returns the free space of the tile.
    #[inline]
    pub(crate) fn space(self) -> FreeSpace<'t> {
        self.space
    }

    /// Returns what is beyond a half-edge.
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

    /// Returns whether dead ends can be marked: not if the tile has so many half-edges that the
    /// mark would be part of an index.
    #[inline]
    fn may_mark(self) -> bool {
        self.noted.half_edges.len() <= DEAD_END as usize
    }

    /// Returns the origin of a half-edge.
    #[inline]
    pub(crate) fn corner(self, half_edge: HalfEdge) -> VertexIndex {
        let noted = &self.noted.half_edges[half_edge.index()];
        VertexIndex(match noted.get(NoteKind::Origin) {
            HalfEdgeNote::NONE => noted.note(NoteKind::Origin, self.space.tile.origin(half_edge).0),
            corner => corner,
        })
    }

    /// Determines what is beyond a half-edge, and notes it.
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

    /// Returns whether two half-edges have the same ends, and the triangle of `other` is
    /// counter-clockwise.
    fn agree(self, half_edge: HalfEdge, other: HalfEdge) -> bool {
        let [from, to] = [half_edge, half_edge.next()].map(|half_edge| self.corner(half_edge));
        let corners = HalfEdge::of_triangle(other.triangle()).map(|half_edge| self.corner(half_edge));
        let [to_there, from_there] = [other, other.next()].map(|half_edge| corners[half_edge.corner() as usize]);
        let is_same = |a: VertexIndex, b: VertexIndex| a == b || self.space.point(a) == self.space.point(b);
        let [a, b, c] = corners.map(|corner| self.space.point(corner));
        is_same(from, from_there) && is_same(to, to_there) && orient2d(a, b, c) == Orientation::CounterClockwise
    }

    /// Counts the visit of a search to the tile. Returns whether the dead ends of the tile are
    /// known from now on.
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

    /// Marks dead ends. Only one search may call this.
    fn find_dead_ends(self) {
        // Without blocked edges there are no dead ends.
        if self.space.may_block() && self.may_mark() {
            self.mark_dead_ends();
        }
        self.noted.knows_dead_ends.store(true, Ordering::Release);
    }

    /// Returns `triangle`, followed by the triangles that lead out of its dead end, if it lies in
    /// one, up to the first that is not in the dead end.
    pub(crate) fn way_in(self, triangle: TriangleId) -> Vec<TriangleId> {
        let mut way = Vec::new();
        let mut triangle = triangle;
        for _ in 0..self.space.tile.triangle_count() {
            way.push(triangle);
            let half_edges = HalfEdge::of_triangle(triangle);
            // The only exit from inside a dead end is not marked.
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

    /// Removes triangles with one exit, then those with one exit left, and so on.
    fn mark_dead_ends(self) {
        let is_site: Vec<bool> = self.space.site_marks();
        let ways = |triangle: TriangleId| -> u8 {
            let half_edges = HalfEdge::of_triangle(triangle);
            // A half-edge that is not blocked and has no twin in the tile is an exit that stays.
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
    /// Returns whether any edge of the tile may block.
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
