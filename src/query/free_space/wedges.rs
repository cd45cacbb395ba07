//! The sectors round a vertex.
//!
//! Round a vertex, the edges that [block](super::ground) part the plane into
//! sectors; whoever arrives at a vertex in one sector leaves it in the same. A **wedge** is what one triangle has of the plane
//! round its corner; at a hull vertex the outside is a wedge too.
//!
//! ```text
//!            left
//!         q ╱
//!          ╱ wedge      the blocked edges v–p and v–r part the plane round v into two sectors: the one drawn, of the two wedges
//!       v ●──── s       (p s) and (s q), which goes on to r, and that below v
//!          ╲ wedge
//!         p ╲
//!            right
//! ```
//!
//! A shortest path bends only where the free side of its sector is wider than a half-turn. The angles of all sectors of a vertex
//! make a full turn, so at most one of them is so wide: a vertex *turns* in one sector or in none.

use super::ground::Ground;
use super::passages::Passage;
use crate::geometry::{HalfEdge, Orientation, VertexIndex, orient2d};
use crate::mesh::{StarEnd, Topology};
use crate::query::request::{Contradiction, side_towards};
use crate::store::VertexId;

/// A part of the plane round a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wedge {
    /// That of the triangle of this side, which leaves the vertex.
    Triangle(HalfEdge),
    /// What lies outside the hull.
    Outside,
}

impl<'t> Ground<'t> {
    fn is_free_wedge(self, wedge: Wedge) -> bool {
        match wedge {
            Wedge::Triangle(side) => self.is_free(side.triangle()),
            Wedge::Outside => self.outside_is_free,
        }
    }

    /// The wedge beyond the left edge of a free one, if one may go there.
    pub(crate) fn left_of(self, vertex: VertexIndex, wedge: Wedge) -> Result<Option<Wedge>, Contradiction> {
        let side = match wedge {
            Wedge::Triangle(side) => side.prev(),
            Wedge::Outside => {
                let first = self.first(vertex)?;
                let is_open = !self.tile.is_wall(first) && self.is_free(first.triangle());
                return Ok(is_open.then_some(Wedge::Triangle(first)));
            }
        };
        self.wedge_beyond(vertex, side, |there| there)
    }

    /// The wedge beyond the right edge of a free one, if one may go there.
    pub(crate) fn right_of(self, vertex: VertexIndex, wedge: Wedge) -> Result<Option<Wedge>, Contradiction> {
        match wedge {
            Wedge::Triangle(side) => self.wedge_beyond(vertex, side, HalfEdge::next),
            Wedge::Outside => {
                let last = self.last(vertex)?;
                let is_open = !self.tile.is_wall(last.prev()) && self.is_free(last.triangle());
                Ok(is_open.then_some(Wedge::Triangle(last)))
            }
        }
    }

    /// The wedge beyond the left or the right edge of a free one, if one may go there.
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

    /// The wedge beyond a side of a free triangle at one of its ends, if one may go there, given the side that leaves the vertex there.
    #[inline]
    fn wedge_beyond(
        self,
        vertex: VertexIndex,
        side: HalfEdge,
        leaving: impl FnOnce(HalfEdge) -> HalfEdge,
    ) -> Result<Option<Wedge>, Contradiction> {
        match self.passages().beyond(side) {
            Passage::Side(there) | Passage::DeadEnd(there) => Ok(Some(Wedge::Triangle(leaving(there)))),
            Passage::Outside => Ok(Some(Wedge::Outside)),
            Passage::Blocked => Ok(None),
            Passage::Elsewhere | Passage::AtOdds => Err(Contradiction::IncompleteStar(vertex)),
        }
    }

    /// The neighbours of a vertex between which a wedge lies: that on its right, and that on its left.
    pub(crate) fn neighbours(self, vertex: VertexIndex, wedge: Wedge) -> Result<[VertexIndex; 2], Contradiction> {
        let (right, left) = match wedge {
            Wedge::Triangle(side) => (side.next(), side.prev()),
            Wedge::Outside => (self.last(vertex)?.prev(), self.first(vertex)?.next()),
        };
        Ok([right, left].map(|side| self.passages().corner(side)))
    }

    /// The side that leaves a hull vertex along the hull, with the hull's inside on its left.
    pub(crate) fn first(self, vertex: VertexIndex) -> Result<HalfEdge, Contradiction> {
        match self.tile.rewind(self.leaving(vertex)?).1 {
            StarEnd::Hull(first) => Ok(first),
            StarEnd::Elsewhere(_) => Err(Contradiction::IncompleteStar(vertex)),
            StarEnd::Closed | StarEnd::Endless => Err(Contradiction::NotOnHull(vertex)),
        }
    }

    /// The side that leaves a hull vertex, of the triangle whose side before it comes in along the hull.
    pub(crate) fn last(self, vertex: VertexIndex) -> Result<HalfEdge, Contradiction> {
        let mut star = self.tile.star(self.leaving(vertex)?);
        star.by_ref().for_each(drop);
        match star.end() {
            Some(StarEnd::Hull(arriving)) => Ok(arriving.next()),
            Some(StarEnd::Elsewhere(_)) => Err(Contradiction::IncompleteStar(vertex)),
            Some(StarEnd::Closed | StarEnd::Endless) | None => Err(Contradiction::NotOnHull(vertex)),
        }
    }

    /// The hull edge that leaves a hull vertex, or the one that comes in; the hull is on its left.
    pub(crate) fn along_hull(self, vertex: VertexIndex, forward: bool) -> Result<HalfEdge, Contradiction> {
        if forward {
            self.first(vertex)
        } else {
            self.last(vertex).map(HalfEdge::prev)
        }
    }

    fn leaving(self, vertex: VertexIndex) -> Result<HalfEdge, Contradiction> {
        if !self.tile.has_vertex(vertex) {
            return Err(Contradiction::NoVertex(vertex));
        }
        let side = self.tile.leaving(vertex);
        side.ok_or(Contradiction::NoTriangle(vertex))
    }

    /// The wedges round a vertex of the tile that are free.
    pub(crate) fn free_wedges(self, vertex: VertexIndex) -> Result<Vec<Wedge>, Contradiction> {
        let mut wedges = self.wedges(vertex)?;
        wedges.retain(|&wedge| self.is_free_wedge(wedge));
        Ok(wedges)
    }

    /// All wedges round a vertex of the tile, counter-clockwise.
    pub(crate) fn wedges(self, vertex: VertexIndex) -> Result<Vec<Wedge>, Contradiction> {
        let start = self.leaving(vertex)?;
        let mut star = self.tile.star(start);
        let mut wedges: Vec<Wedge> = star.by_ref().map(Wedge::Triangle).collect();
        match star.end() {
            Some(StarEnd::Closed) => {}
            Some(StarEnd::Hull(_)) => {
                wedges.push(Wedge::Outside);
                let rest = self.tile.star(self.first(vertex)?);
                wedges.extend(rest.take_while(|&side| side != start).map(Wedge::Triangle));
            }
            Some(StarEnd::Elsewhere(_)) => return Err(Contradiction::IncompleteStar(vertex)),
            Some(StarEnd::Endless) | None => return Err(Contradiction::EndlessStar(vertex)),
        }
        Ok(wedges)
    }

    /// The wedge on the right of the edge to another vertex; `None` if that is the outside.
    pub(crate) fn right_of_edge(self, vertex: VertexIndex, to: VertexId) -> Result<Option<Wedge>, Contradiction> {
        let back = side_towards(self.tile, vertex, to)?;
        Ok(back.map(|back| Wedge::Triangle(back.next())))
    }

    /// The wedges of the sector of a wedge, from the right to the left, and whether nothing blocks anywhere round the vertex.
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

    /// Whether a path may have to bend in the sector of a wedge: it is wider than a half-turn, or holds the outside,
    /// along whose edges one walks from vertex to vertex. A sector that nothing blocks does not count.
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

    /// The same for the rightmost wedge of a sector.
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

    /// The rightmost wedge of the sector in which paths bend round a vertex, if there is one.
    pub(crate) fn turning_sector(self, vertex: VertexIndex) -> Result<Option<Wedge>, Contradiction> {
        for wedge in self.free_wedges(vertex)? {
            if self.right_of(vertex, wedge)?.is_none() && self.turns_from(vertex, wedge)? {
                return Ok(Some(wedge));
            }
        }
        Ok(None)
    }

    /// The last wedge of a sector, from one of its wedges on leftwards or rightwards.
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
