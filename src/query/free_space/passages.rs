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
//! ends examines all triangles of the tile. That pays off where many searches come, so searches do
//! without until they have passed about as many triangles as the tile has.

use std::sync::atomic::Ordering;

use super::space::{FreeSpace, FreeTwin};
use crate::geometry::{HalfEdge, Orientation, TriangleId, VertexIndex, orient2d};
use crate::mesh::Twin;
use crate::store::{HalfEdgeNote, HalfEdgeNotes};

/// The number of exits of a triangle that is not removed: it is not free, has a site, or was
/// removed before.
const STAYS: u8 = u8::MAX;

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
        let note = self.noted.get(half_edge);
        if note == HalfEdgeNote::Blocked {
            return Passage::Blocked;
        }
        match (note, self.space.tile.twin(half_edge)) {
            (HalfEdgeNote::Open, Twin::HalfEdge(other)) => Passage::HalfEdge(other),
            (HalfEdgeNote::DeadEnd, Twin::HalfEdge(other)) => Passage::DeadEnd(other),
            _ => self.examine(half_edge),
        }
    }

    /// Returns the origin of a half-edge.
    #[inline]
    pub(crate) fn corner(self, half_edge: HalfEdge) -> VertexIndex {
        self.space.tile.origin(half_edge)
    }

    /// Determines what is beyond a half-edge. Notes it if that is a triangle of this tile, or
    /// nothing; all else is rare.
    #[cold]
    fn examine(self, half_edge: HalfEdge) -> Passage {
        let (passage, note) = match self.space.twin(half_edge) {
            FreeTwin::HalfEdge(other) if self.agree(half_edge, other) => (Passage::HalfEdge(other), HalfEdgeNote::Open),
            FreeTwin::HalfEdge(_) => return Passage::Contradictory,
            FreeTwin::Elsewhere => return Passage::Elsewhere,
            FreeTwin::Outside => return Passage::Outside,
            FreeTwin::Blocked => (Passage::Blocked, HalfEdgeNote::Blocked),
        };
        self.noted.note(half_edge, note);
        passage
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

    /// Counts the triangles of the tile that a search passed.
    pub(crate) fn count_passed(self, triangles: u32) {
        self.noted.count_passed(triangles);
    }

    /// Returns whether the dead ends of the tile are known from now on. Finds them if searches have
    /// passed so many triangles that it is time.
    pub(crate) fn knows_dead_ends(self) -> bool {
        if self.noted.knows_dead_ends.load(Ordering::Acquire) {
            return true;
        }
        let triangles = u64::from(self.space.tile.triangle_count());
        let is_time = self.noted.is_time_for_dead_ends(triangles);
        if is_time {
            self.find_dead_ends();
        }
        is_time
    }

    /// Marks dead ends. Only one search may call this.
    fn find_dead_ends(self) {
        // Without blocked edges there are no dead ends.
        if self.space.may_block() {
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
        let core = self.space.tile.core_triangle_count() as usize;
        let is_site: Vec<bool> = self.space.site_marks();
        // The exits that each triangle has left, `None` until one of them is examined.
        let mut left: Vec<Option<u8>> = vec![None; core];
        let mut ends = Vec::new();
        for triangle in self.space.tile.triangle_ids().take(core) {
            let half_edges = HalfEdge::of_triangle(triangle).into_iter();
            // Only constraints block.
            let blocked = half_edges.filter(|&half_edge| self.space.tile.is_constraint(half_edge));
            if blocked.count() >= 2 {
                let exits = self.exits(triangle, &is_site);
                left[triangle.index()] = Some(exits);
                if exits <= 1 {
                    ends.push(triangle);
                }
            }
        }
        while let Some(triangle) = ends.pop() {
            left[triangle.index()] = Some(STAYS);
            let mut half_edges = HalfEdge::of_triangle(triangle).into_iter();
            let out = half_edges.find_map(|half_edge| match self.twin(half_edge) {
                Passage::HalfEdge(out) => Some(out),
                _ => None,
            });
            let Some(out) = out else { continue };
            if !matches!(self.twin(out), Passage::HalfEdge(_) | Passage::DeadEnd(_)) {
                continue;
            }
            self.noted.note(out, HalfEdgeNote::DeadEnd);
            let Some(left) = left.get_mut(out.triangle().index()) else {
                continue;
            };
            let exits = left.get_or_insert_with(|| self.exits(out.triangle(), &is_site));
            if *exits < STAYS {
                *exits = exits.saturating_sub(1);
                if *exits == 1 {
                    ends.push(out.triangle());
                }
            }
        }
    }

    /// Returns the number of exits of a triangle, including those that are marked as dead ends, or
    /// [`STAYS`].
    fn exits(self, triangle: TriangleId, is_site: &[bool]) -> u8 {
        let half_edges = HalfEdge::of_triangle(triangle);
        let has_site = |half_edge| is_site[self.corner(half_edge).index()];
        if !self.space.is_free(triangle) || half_edges.into_iter().any(has_site) {
            return STAYS;
        }
        // A half-edge that is not blocked and has no twin in the tile is an exit that stays.
        let count = half_edges.map(|half_edge| match self.twin(half_edge) {
            Passage::Blocked => 0,
            Passage::HalfEdge(_) | Passage::DeadEnd(_) => 1,
            Passage::Elsewhere | Passage::Outside | Passage::Contradictory => 2,
        });
        count.into_iter().sum()
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
