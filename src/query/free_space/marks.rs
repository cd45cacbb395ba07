//! What is true of each vertex of a tile, noted for all searches when the first one asks.

use super::ground::Ground;
use crate::geometry::{HalfEdge, Orientation, Point, orient2d};
use crate::query::request::Contradiction;
use crate::store::{Across, Marks};

/// A vertex round which a path can bend, in one of its sectors.
pub(crate) const TURNING: u8 = 1;

/// A vertex with a site.
pub(crate) const SITE: u8 = 2;

/// A vertex with one free sector only.
pub(crate) const SINGLE: u8 = 4;

impl<'t> Ground<'t> {
    /// What is true of each vertex of the tile: [`TURNING`], [`SITE`], [`SINGLE`]; and the neighbours at the right and left end
    /// of the sector in which it turns. Where the tile contradicts itself, the star says so when it is walked round.
    pub(crate) fn marks(self) -> &'t Marks {
        self.tile.notes().marks(|| self.find_marks())
    }

    /// Whether a straight way from a point to a vertex of the tile that turns may go on round what is beside it. It may not if both ends
    /// of the sector face the point.
    pub(crate) fn can_turn(self, from: Point, vertex: u32) -> bool {
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
        for side in self.tile.constraint_sides().map(HalfEdge) {
            has_break_lines |= !self.tile.is_wall(side.0);
            let is_blocked = self.tile.is_wall(side.0)
                || match self.tile.across(side.0) {
                    Across::Side(other) => self.is_free(side.triangle()) != self.is_free(HalfEdge(other).triangle()),
                    Across::Hull | Across::Elsewhere => self.is_free(side.triangle()) != self.outside_is_free,
                };
            let ends = [side, side.next()].map(|side| self.tile.origin(side.0));
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
    fn sectors(self, vertex: u32) -> Result<(u32, Option<[u32; 2]>), Contradiction> {
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
}
