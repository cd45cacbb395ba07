//! The sectors round a vertex.
//!
//! Round a vertex, the edges that [block](super) divide the plane into sectors. A path that arrives
//! at a vertex in one sector leaves it in the same sector. A **wedge** is the part of the plane
//! round a vertex that one triangle covers. At a hull vertex the outside is a wedge too.
//!
//! ```text
//!             left
//!          q ╱
//!           ╱ wedge      The blocked edges v–p and v–r divide the plane round v into two sectors:
//!        v ●──── s       the one drawn, with the two wedges (p s) and (s q), which continues to r,
//!           ╲ wedge      and the one below v.
//!          p ╲
//!             right
//! ```
//!
//! A shortest path bends only where the free side of its sector is wider than a half-turn. The
//! angles of all sectors of a vertex add up to a full turn, so at most one sector is that wide: a
//! vertex *turns* in one sector or in none.

use super::passages::Passage;
use super::space::FreeSpace;
use crate::geometry::{HalfEdge, Orientation, VertexIndex, orient2d};
use crate::mesh::{StarEnd, Topology};
use crate::query::request::{Contradiction, half_edge_towards};
use crate::store::VertexId;

/// A part of the plane round a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wedge {
    /// The wedge of the triangle of this half-edge, whose origin is the vertex.
    Triangle(HalfEdge),
    /// The outside of the hull.
    Outside,
}

impl<'t> FreeSpace<'t> {
    pub(super) fn is_free_wedge(self, wedge: Wedge) -> bool {
        match wedge {
            Wedge::Triangle(half_edge) => self.is_free(half_edge.triangle()),
            Wedge::Outside => self.outside_is_free,
        }
    }

    /// Returns the wedge on the left of a free wedge, if the edge between them does not block and
    /// the space there is free.
    pub(crate) fn left_of(self, vertex: VertexIndex, wedge: Wedge) -> Result<Option<Wedge>, Contradiction> {
        let half_edge = match wedge {
            Wedge::Triangle(half_edge) => half_edge.prev(),
            Wedge::Outside => {
                let first = self.first(vertex)?;
                let is_open = !self.tile.is_wall(first) && self.is_free(first.triangle());
                return Ok(is_open.then_some(Wedge::Triangle(first)));
            }
        };
        self.wedge_at_twin(vertex, half_edge, |there| there)
    }

    /// Returns the wedge on the right of a free wedge, if the edge between them does not block and
    /// the space there is free.
    pub(crate) fn right_of(self, vertex: VertexIndex, wedge: Wedge) -> Result<Option<Wedge>, Contradiction> {
        match wedge {
            Wedge::Triangle(half_edge) => self.wedge_at_twin(vertex, half_edge, HalfEdge::next),
            Wedge::Outside => {
                let last = self.last(vertex)?;
                let is_open = !self.tile.is_wall(last.prev()) && self.is_free(last.triangle());
                Ok(is_open.then_some(Wedge::Triangle(last)))
            }
        }
    }

    /// Returns the wedge on the left or right of a free wedge, if the edge between them does not
    /// block and the space there is free.
    pub(crate) fn beside(
        self,
        vertex: VertexIndex,
        wedge: Wedge,
        leftwards: bool,
    ) -> Result<Option<Wedge>, Contradiction> {
        if leftwards {
            self.left_of(vertex, wedge)
        } else {
            self.right_of(vertex, wedge)
        }
    }

    /// Returns the wedge of `vertex` beyond a half-edge of a free triangle, if it is free and the
    /// edge does not block. `leaving` maps the twin to the half-edge whose origin is the vertex.
    #[inline]
    fn wedge_at_twin(
        self,
        vertex: VertexIndex,
        half_edge: HalfEdge,
        leaving: impl FnOnce(HalfEdge) -> HalfEdge,
    ) -> Result<Option<Wedge>, Contradiction> {
        match self.passages().twin(half_edge) {
            Passage::HalfEdge(there) | Passage::DeadEnd(there) => Ok(Some(Wedge::Triangle(leaving(there)))),
            Passage::Outside => Ok(Some(Wedge::Outside)),
            Passage::Blocked => Ok(None),
            Passage::Elsewhere | Passage::Contradictory => Err(Contradiction::IncompleteStar(vertex)),
        }
    }

    /// Returns the two neighbours of a vertex that bound a wedge: the right one, then the left one.
    pub(crate) fn neighbours(self, vertex: VertexIndex, wedge: Wedge) -> Result<[VertexIndex; 2], Contradiction> {
        let (right, left) = match wedge {
            Wedge::Triangle(half_edge) => (half_edge.next(), half_edge.prev()),
            Wedge::Outside => (self.last(vertex)?.prev(), self.first(vertex)?.next()),
        };
        Ok([right, left].map(|half_edge| self.passages().corner(half_edge)))
    }

    /// Returns the half-edge along the hull whose origin is a hull vertex; the inside of the hull
    /// is on its left.
    pub(crate) fn first(self, vertex: VertexIndex) -> Result<HalfEdge, Contradiction> {
        match self.tile.rewind(self.leaving(vertex)?).1 {
            StarEnd::Hull(first) => Ok(first),
            StarEnd::Elsewhere(_) => Err(Contradiction::IncompleteStar(vertex)),
            StarEnd::Closed | StarEnd::Endless => Err(Contradiction::NotOnHull(vertex)),
        }
    }

    /// Returns the half-edge that leaves a hull vertex and whose previous half-edge arrives there
    /// along the hull.
    pub(crate) fn last(self, vertex: VertexIndex) -> Result<HalfEdge, Contradiction> {
        let mut star = self.tile.star(self.leaving(vertex)?);
        star.by_ref().for_each(drop);
        match star.end() {
            Some(StarEnd::Hull(arriving)) => Ok(arriving.next()),
            Some(StarEnd::Elsewhere(_)) => Err(Contradiction::IncompleteStar(vertex)),
            Some(StarEnd::Closed | StarEnd::Endless) | None => Err(Contradiction::NotOnHull(vertex)),
        }
    }

    /// Returns the hull edge that leaves a hull vertex (`forward`), or the one that arrives there.
    /// The hull is on its left.
    pub(crate) fn along_hull(self, vertex: VertexIndex, forward: bool) -> Result<HalfEdge, Contradiction> {
        if forward {
            self.first(vertex)
        } else {
            self.last(vertex).map(HalfEdge::prev)
        }
    }

    pub(super) fn leaving(self, vertex: VertexIndex) -> Result<HalfEdge, Contradiction> {
        if !self.tile.has_vertex(vertex) {
            return Err(Contradiction::NoVertex(vertex));
        }
        let half_edge = self.tile.leaving(vertex);
        half_edge.ok_or(Contradiction::NoTriangle(vertex))
    }

    /// Returns the free wedges round a vertex of the tile.
    pub(crate) fn free_wedges(self, vertex: VertexIndex) -> Result<Vec<Wedge>, Contradiction> {
        let mut wedges = self.wedges(vertex)?;
        wedges.retain(|&wedge| self.is_free_wedge(wedge));
        Ok(wedges)
    }

    /// Returns all wedges round a vertex of the tile, counter-clockwise.
    pub(crate) fn wedges(self, vertex: VertexIndex) -> Result<Vec<Wedge>, Contradiction> {
        let start = self.leaving(vertex)?;
        let mut star = self.tile.star(start);
        let mut wedges: Vec<Wedge> = star.by_ref().map(Wedge::Triangle).collect();
        match star.end() {
            Some(StarEnd::Closed) => {}
            Some(StarEnd::Hull(_)) => {
                wedges.push(Wedge::Outside);
                let rest = self.tile.star(self.first(vertex)?);
                wedges.extend(rest.take_while(|&half_edge| half_edge != start).map(Wedge::Triangle));
            }
            Some(StarEnd::Elsewhere(_)) => return Err(Contradiction::IncompleteStar(vertex)),
            Some(StarEnd::Endless) | None => return Err(Contradiction::EndlessStar(vertex)),
        }
        Ok(wedges)
    }

    /// Returns the wedge on the right of the edge from `vertex` to `to`; `None` if the outside is
    /// there.
    pub(crate) fn right_of_edge(self, vertex: VertexIndex, to: VertexId) -> Result<Option<Wedge>, Contradiction> {
        let back = half_edge_towards(self.tile, vertex, to)?;
        Ok(back.map(|back| Wedge::Triangle(back.next())))
    }

    /// Returns the wedges in the sector of a wedge, from right to left, and whether nothing blocks
    /// anywhere round the vertex.
    pub(crate) fn sector(self, vertex: VertexIndex, wedge: Wedge) -> Result<(Vec<Wedge>, bool), Contradiction> {
        let mut first = wedge;
        let mut is_whole = false;
        for _ in 0..=self.tile.triangle_count() {
            match self.right_of(vertex, first)? {
                Some(right) if right != wedge => first = right,
                right => {
                    is_whole = right.is_some();
                    break;
                }
            }
        }
        let mut wedges = vec![first];
        for _ in 0..=self.tile.triangle_count() {
            match self.left_of(vertex, wedges[wedges.len() - 1])? {
                Some(left) if left != first => wedges.push(left),
                _ => return Ok((wedges, is_whole)),
            }
        }
        Err(Contradiction::EndlessStar(vertex))
    }

    /// Returns whether a path may have to bend in the sector of a wedge: the sector is wider than a
    /// half-turn, or it contains the outside, where paths run along the hull from vertex to vertex.
    /// A sector without blocking edges does not count.
    pub(crate) fn sector_turns(self, vertex: VertexIndex, wedge: Wedge) -> Result<bool, Contradiction> {
        let mut start = wedge;
        for _ in 0..=self.tile.triangle_count() {
            match self.right_of(vertex, start)? {
                Some(right) if right == wedge => return Ok(false),
                Some(right) => start = right,
                None => return self.turns_from(vertex, start),
            }
        }
        Err(Contradiction::EndlessStar(vertex))
    }

    /// Returns whether a path may have to bend in the sector whose rightmost wedge is `start`.
    pub(super) fn turns_from(self, vertex: VertexIndex, start: Wedge) -> Result<bool, Contradiction> {
        let at = self.point(vertex);
        let from = self.neighbours(vertex, start)?[0];
        let from_point = self.point(from);
        let mut wedge = start;
        for _ in 0..=self.tile.triangle_count() {
            let left = self.neighbours(vertex, wedge)?[1];
            let is_wide = left == from || orient2d(at, from_point, self.point(left)) == Orientation::Clockwise;
            if wedge == Wedge::Outside || is_wide {
                return Ok(true);
            }
            match self.left_of(vertex, wedge)? {
                Some(left) if left != start => wedge = left,
                _ => return Ok(false),
            }
        }
        Err(Contradiction::EndlessStar(vertex))
    }

    /// Returns the rightmost wedge of the sector in which paths bend round a vertex, if there is
    /// one.
    pub(crate) fn turning_sector(self, vertex: VertexIndex) -> Result<Option<Wedge>, Contradiction> {
        for wedge in self.free_wedges(vertex)? {
            if self.right_of(vertex, wedge)?.is_none() && self.turns_from(vertex, wedge)? {
                return Ok(Some(wedge));
            }
        }
        Ok(None)
    }

    /// Returns the last wedge of a sector, leftwards or rightwards from one of its wedges.
    pub(crate) fn end_of_sector(
        self,
        vertex: VertexIndex,
        wedge: Wedge,
        leftwards: bool,
    ) -> Result<Wedge, Contradiction> {
        let mut wedge = wedge;
        for _ in 0..=self.tile.triangle_count() {
            match self.beside(vertex, wedge, leftwards)? {
                Some(there) => wedge = there,
                None => return Ok(wedge),
            }
        }
        Err(Contradiction::EndlessStar(vertex))
    }
}
