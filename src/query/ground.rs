//! Where one may walk: what lies beyond a side, and the sectors round a vertex.
//!
//! Walls, and what separates free triangles from holes, *block*. Round a vertex, the blocked edges part the plane into
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

use super::passages::Passage;
use super::star::{next, previous};
use crate::geometry::{Orientation, Point, orient2d};
use crate::store::{Across, Marks, Tile};

/// A vertex round which a path can bend, in one of its sectors.
pub(super) const TURNING: u8 = 1;
/// A vertex with a site.
pub(super) const SITE: u8 = 2;
/// A vertex with one free sector only.
pub(super) const SINGLE: u8 = 4;

/// A part of the plane round a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wedge {
    /// That of the triangle of this side, which leaves the vertex.
    Triangle(u32),
    /// What lies outside the hull.
    Outside,
}

/// What lies beyond a side of a free triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Beyond {
    /// A free triangle, with this side.
    Side(u32),
    /// A triangle of another tile, or the hull.
    Elsewhere,
    /// The free outside.
    Outside,
    /// Nothing that one may enter.
    Blocked,
}

/// A tile to walk on.
#[derive(Clone, Copy)]
pub(super) struct Ground<'t> {
    pub(super) tile: &'t Tile,
    /// Whether the outside of the hull is free.
    pub(super) outside_is_free: bool,
}

impl<'t> Ground<'t> {
    /// Where a corner is.
    #[inline]
    pub(super) fn point(self, corner: u32) -> Point {
        self.tile.corner(corner)
    }

    /// Whether a triangle is free.
    pub(super) fn is_free(self, triangle: u32) -> bool {
        !self.tile.is_hole(triangle)
    }

    /// What lies beyond a side of a free triangle.
    #[inline]
    pub(super) fn beyond(self, side: u32) -> Beyond {
        let is_constraint = self.tile.is_constraint(side);
        if is_constraint && self.tile.is_wall(side) {
            return Beyond::Blocked;
        }
        match self.tile.across(side) {
            // Only a constraint separates a hole from what is free.
            Across::Side(other) if !is_constraint || self.is_free(other / 3) => Beyond::Side(other),
            Across::Elsewhere => Beyond::Elsewhere,
            Across::Hull if self.outside_is_free => Beyond::Outside,
            Across::Side(_) | Across::Hull => Beyond::Blocked,
        }
    }

    /// Makes sure that a side has these ends, which are those of the side beyond it, and that its triangle lies on its left.
    ///
    /// Damaged tiles may contradict this. Where it holds for each side that is crossed, a straight way comes to the triangles that it passes in
    /// their order, and to none twice; so it ends.
    #[inline]
    pub(super) fn check_crossing(self, side: u32, [from, to]: [Point; 2]) -> Result<(), String> {
        let [origin, end, apex] = [side, next(side), previous(side)].map(|side| self.point(self.tile.origin(side)));
        if origin == from && end == to && orient2d(from, to, apex) == Orientation::CounterClockwise {
            return Ok(());
        }
        Err(format!(
            "triangle {} does not lie beside the one that it is said to lie beside",
            side / 3
        ))
    }

    fn is_free_wedge(self, wedge: Wedge) -> bool {
        match wedge {
            Wedge::Triangle(side) => self.is_free(side / 3),
            Wedge::Outside => self.outside_is_free,
        }
    }

    /// The wedge beyond the left edge of one, whatever separates them.
    fn any_left(self, vertex: u32, wedge: Wedge) -> Result<Wedge, String> {
        match wedge {
            Wedge::Triangle(side) => match self.tile.across(previous(side)) {
                Across::Side(other) => Ok(Wedge::Triangle(other)),
                Across::Hull => Ok(Wedge::Outside),
                Across::Elsewhere => Err(incomplete(vertex)),
            },
            Wedge::Outside => self.first(vertex).map(Wedge::Triangle),
        }
    }

    /// The wedge beyond the left edge of a free one, if one may go there.
    pub(super) fn left_of(self, vertex: u32, wedge: Wedge) -> Result<Option<Wedge>, String> {
        let side = match wedge {
            Wedge::Triangle(side) => previous(side),
            Wedge::Outside => {
                let first = self.first(vertex)?;
                let is_open = !self.tile.is_wall(first) && self.is_free(first / 3);
                return Ok(is_open.then_some(Wedge::Triangle(first)));
            }
        };
        self.wedge_beyond(vertex, side, |there| there)
    }

    /// The wedge beyond the right edge of a free one, if one may go there.
    pub(super) fn right_of(self, vertex: u32, wedge: Wedge) -> Result<Option<Wedge>, String> {
        match wedge {
            Wedge::Triangle(side) => self.wedge_beyond(vertex, side, next),
            Wedge::Outside => {
                let last = self.last(vertex)?;
                let is_open = !self.tile.is_wall(previous(last)) && self.is_free(last / 3);
                Ok(is_open.then_some(Wedge::Triangle(last)))
            }
        }
    }

    /// The wedge beyond a side of a free triangle at one of its ends, if one may go there, given the side that leaves the vertex there.
    #[inline]
    fn wedge_beyond(self, vertex: u32, side: u32, leaving: impl FnOnce(u32) -> u32) -> Result<Option<Wedge>, String> {
        match self.passages().beyond(side) {
            Passage::Side(there) | Passage::DeadEnd(there) => Ok(Some(Wedge::Triangle(leaving(there)))),
            Passage::Outside => Ok(Some(Wedge::Outside)),
            Passage::Blocked => Ok(None),
            Passage::Elsewhere | Passage::AtOdds => Err(incomplete(vertex)),
        }
    }

    /// The neighbours of a vertex between which a wedge lies: that on its right, and that on its left.
    pub(super) fn neighbours(self, vertex: u32, wedge: Wedge) -> Result<[u32; 2], String> {
        let (right, left) = match wedge {
            Wedge::Triangle(side) => (next(side), previous(side)),
            Wedge::Outside => (previous(self.last(vertex)?), next(self.first(vertex)?)),
        };
        Ok([right, left].map(|side| self.passages().corner(side)))
    }

    /// The side that leaves a hull vertex along the hull, with the hull's inside on its left.
    pub(super) fn first(self, vertex: u32) -> Result<u32, String> {
        let mut side = self.leaving(vertex)?;
        for _ in 0..self.tile.triangle_count() {
            match self.tile.across(side) {
                Across::Side(other) => side = next(other),
                Across::Hull => return Ok(side),
                Across::Elsewhere => return Err(incomplete(vertex)),
            }
        }
        Err(format!("vertex {vertex} is not on the hull"))
    }

    /// The side that leaves a hull vertex, of the triangle whose side before it comes in along the hull.
    pub(super) fn last(self, vertex: u32) -> Result<u32, String> {
        let mut side = self.leaving(vertex)?;
        for _ in 0..self.tile.triangle_count() {
            match self.tile.across(previous(side)) {
                Across::Side(other) => side = other,
                Across::Hull => return Ok(side),
                Across::Elsewhere => return Err(incomplete(vertex)),
            }
        }
        Err(format!("vertex {vertex} is not on the hull"))
    }

    /// The hull edge that leaves a hull vertex, or the one that comes in; the hull is on its left.
    pub(super) fn along_hull(self, vertex: u32, forward: bool) -> Result<u32, String> {
        if forward {
            self.first(vertex)
        } else {
            self.last(vertex).map(previous)
        }
    }

    fn leaving(self, vertex: u32) -> Result<u32, String> {
        if vertex >= self.tile.vertex_count() {
            return Err(format!("there is no vertex {vertex}, but other tiles have it"));
        }
        let side = self.tile.side_leaving(vertex);
        side.ok_or_else(|| format!("vertex {vertex} has no triangle, but is a corner of one elsewhere"))
    }

    /// The wedges round a vertex of the tile that are free.
    pub(super) fn free_wedges(self, vertex: u32) -> Result<Vec<Wedge>, String> {
        let mut wedges = self.wedges(vertex)?;
        wedges.retain(|&wedge| self.is_free_wedge(wedge));
        Ok(wedges)
    }

    /// All wedges round a vertex of the tile, counter-clockwise.
    pub(super) fn wedges(self, vertex: u32) -> Result<Vec<Wedge>, String> {
        let mut wedges = Vec::new();
        let start = Wedge::Triangle(self.leaving(vertex)?);
        let mut wedge = start;
        for _ in 0..=self.tile.triangle_count() {
            wedges.push(wedge);
            wedge = self.any_left(vertex, wedge)?;
            if wedge == start {
                return Ok(wedges);
            }
        }
        Err(endless(vertex))
    }

    /// Whether a path may have to bend in the sector of a wedge: it is wider than a half-turn, or holds the outside,
    /// along whose edges one walks from vertex to vertex. A sector that nothing blocks does not count.
    pub(super) fn sector_turns(self, vertex: u32, wedge: Wedge) -> Result<bool, String> {
        let mut start = wedge;
        for _ in 0..=self.tile.triangle_count() {
            match self.right_of(vertex, start)? {
                Some(right) if right == wedge => return Ok(false),
                Some(right) => start = right,
                None => return self.turns_from(vertex, start),
            }
        }
        Err(endless(vertex))
    }

    /// The same for the rightmost wedge of a sector.
    fn turns_from(self, vertex: u32, start: Wedge) -> Result<bool, String> {
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
        Err(endless(vertex))
    }

    /// The rightmost wedge of the sector in which paths bend round a vertex, if there is one.
    pub(super) fn turning_sector(self, vertex: u32) -> Result<Option<Wedge>, String> {
        for wedge in self.free_wedges(vertex)? {
            if self.right_of(vertex, wedge)?.is_none() && self.turns_from(vertex, wedge)? {
                return Ok(Some(wedge));
            }
        }
        Ok(None)
    }

    /// What is true of each vertex of the tile: [`TURNING`], [`SITE`], [`SINGLE`]; and the neighbours at the right and left end
    /// of the sector in which it turns. Where the tile contradicts itself, the star says so when it is walked round.
    pub(super) fn marks(self) -> &'t Marks {
        self.tile.notes().marks(|| self.find_marks())
    }

    /// Whether a straight way from a point to a vertex of the tile that turns may go on round what is beside it. It may not if both ends
    /// of the sector face the point.
    pub(super) fn can_turn(self, from: Point, vertex: u32) -> bool {
        let marks = self.marks();
        let Some(ends) = marks.ends.get(marks.place[vertex as usize] as usize) else {
            return true;
        };
        let at = self.point(vertex);
        let turn = |end| orient2d(from, at, self.point(end));
        turn(ends[1]) != Orientation::Clockwise || turn(ends[0]) != Orientation::CounterClockwise
    }

    fn find_marks(self) -> Marks {
        const TOUCHED: u8 = 128;
        let vertices = self.tile.vertex_count();
        let mut marks = vec![SINGLE; vertices as usize];
        for site in self.tile.sites() {
            marks[site.vertex as usize] |= SITE;
        }
        let mut has_break_lines = false;
        for side in self.tile.constraint_sides() {
            has_break_lines |= !self.tile.is_wall(side);
            let is_blocked = self.tile.is_wall(side)
                || match self.tile.across(side) {
                    Across::Side(other) => self.is_free(side / 3) != self.is_free(other / 3),
                    Across::Hull | Across::Elsewhere => self.is_free(side / 3) != self.outside_is_free,
                };
            let ends = [side, next(side)].map(|side| self.tile.origin(side));
            for end in ends.into_iter().filter(|&end| is_blocked && end < vertices) {
                marks[end as usize] |= TOUCHED;
            }
        }
        let mut ends = Vec::new();
        let mut place = vec![u32::MAX; vertices as usize];
        for (vertex, mark) in (0..).zip(&mut marks) {
            if *mark & TOUCHED == 0 {
                continue;
            }
            *mark &= !(TOUCHED | SINGLE);
            match self.sectors(vertex) {
                Ok((sectors, turning)) => {
                    *mark |= if sectors == 1 { SINGLE } else { 0 };
                    if let Some(of_turning) = turning {
                        *mark |= TURNING;
                        place[vertex as usize] = ends.len() as u32;
                        ends.push(of_turning);
                    }
                }
                Err(_) => *mark |= TURNING,
            }
        }
        Marks {
            of_vertices: marks,
            place,
            ends,
            has_break_lines,
        }
    }

    /// How many free sectors a vertex has, and the neighbours at the right and left end of that in which it turns.
    fn sectors(self, vertex: u32) -> Result<(u32, Option<[u32; 2]>), String> {
        let (mut sectors, mut turning) = (0, None);
        for wedge in self.free_wedges(vertex)? {
            if self.right_of(vertex, wedge)?.is_some() {
                continue;
            }
            sectors += 1;
            if self.turns_from(vertex, wedge)? {
                let last = self.end_of_sector(vertex, wedge, true)?;
                turning = Some([self.neighbours(vertex, wedge)?[0], self.neighbours(vertex, last)?[1]]);
            }
        }
        Ok((sectors, turning))
    }

    /// The last wedge of a sector, from one of its wedges on leftwards or rightwards.
    pub(super) fn end_of_sector(self, vertex: u32, wedge: Wedge, leftwards: bool) -> Result<Wedge, String> {
        let mut wedge = wedge;
        for _ in 0..=self.tile.triangle_count() {
            let there = if leftwards {
                self.left_of(vertex, wedge)?
            } else {
                self.right_of(vertex, wedge)?
            };
            match there {
                Some(there) => wedge = there,
                None => return Ok(wedge),
            }
        }
        Err(endless(vertex))
    }
}

fn incomplete(vertex: u32) -> String {
    format!("the star of vertex {vertex} is not complete")
}

fn endless(vertex: u32) -> String {
    format!("the star of vertex {vertex} does not close")
}
