//! Properties of each vertex of a tile. The first search that needs those of a vertex computes them; all
//! later searches share them.

use super::space::FreeSpace;
use super::wedges::Wedge;
use crate::geometry::{HalfEdge, Orientation, Point, VertexIndex, orient2d};
use crate::mesh::{StarEnd, Topology, Twin};
use crate::query::request::Contradiction;
use crate::store::VertexNotes;

/// Properties of a vertex, in one byte, because each vertex of every cached tile has one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mark(u8);

const TURNING: u8 = 1;
const SITE: u8 = 2;
const SINGLE: u8 = 4;
/// Every mark has this bit; 0 stands for an absent mark.
const PRESENT: u8 = 8;

impl Mark {
    /// Returns whether a path can bend round the vertex in one of its sectors.
    #[inline]
    pub(crate) fn turns(self) -> bool {
        self.0 & TURNING != 0
    }

    /// Returns whether the vertex has a site.
    #[inline]
    pub(crate) fn has_site(self) -> bool {
        self.0 & SITE != 0
    }

    /// Returns whether the vertex has exactly one free sector.
    #[inline]
    pub(crate) fn is_single(self) -> bool {
        self.0 & SINGLE != 0
    }
}

/// What is known of the sectors of a vertex.
struct Sectors {
    /// The number of free sectors.
    count: u32,
    /// The neighbours at the right and left end of the sector in which it turns.
    turning: Option<[VertexIndex; 2]>,
}

impl<'t> FreeSpace<'t> {
    /// Returns the properties of a vertex, or `None` if the tile has no such vertex. Where the tile
    /// contradicts itself, the walk round the star reports it.
    #[inline]
    pub(crate) fn mark(self, vertex: VertexIndex) -> Option<Mark> {
        match self.vertex_notes().mark(vertex) {
            Some(0) => Some(self.find_mark(vertex)),
            mark => mark.map(Mark),
        }
    }

    /// Returns whether the tile has break lines.
    pub(crate) fn has_break_lines(self) -> bool {
        let is_break_line = |half_edge| !self.tile.is_wall(half_edge);
        let find = || self.tile.constraint_half_edges().any(is_break_line);
        self.tile.notes().has_break_lines(find)
    }

    /// Returns the notes on the vertices of the tile: the marks, and the neighbours at the right and
    /// left end of the sectors in which vertices turn.
    #[inline]
    fn vertex_notes(self) -> &'t VertexNotes {
        self.tile.notes().vertices(self.tile.vertex_count())
    }

    /// Returns whether a path that arrives straight from `from` at a turning vertex of the tile,
    /// whose mark was asked for, can bend round an edge there. It cannot if both ends of the sector
    /// face `from`.
    pub(crate) fn can_turn(self, from: Point, vertex: VertexIndex) -> bool {
        let Some(ends) = self.vertex_notes().ends(vertex) else {
            return true;
        };
        let at = self.point(vertex);
        let turn = |end| orient2d(from, at, self.point(end));
        turn(ends[1]) != Orientation::Clockwise || turn(ends[0]) != Orientation::CounterClockwise
    }

    /// Determines the properties of a vertex, and notes them.
    #[cold]
    fn find_mark(self, vertex: VertexIndex) -> Mark {
        let site = if self.tile.is_site(vertex) { SITE } else { 0 };
        let (of_sectors, ends) = match self.sectors(vertex) {
            Ok(sectors) => {
                let single = if sectors.count == 1 { SINGLE } else { 0 };
                let turning = if sectors.turning.is_some() { TURNING } else { 0 };
                (single | turning, sectors.turning)
            }
            Err(_) => (TURNING, None),
        };
        let mark = PRESENT | site | of_sectors;
        self.vertex_notes().note(vertex, mark, ends);
        Mark(mark)
    }

    /// Returns the sectors of a vertex. A vertex at which nothing blocks has one, and turns in none.
    fn sectors(self, vertex: VertexIndex) -> Result<Sectors, Contradiction> {
        if self.is_inside_without_constraints(vertex)? {
            return Ok(Sectors {
                count: 1,
                turning: None,
            });
        }
        let mut wedges = self.wedges(vertex)?;
        if !wedges.iter().any(|&wedge| self.is_beside_blocked(wedge)) {
            return Ok(Sectors {
                count: 1,
                turning: None,
            });
        }
        wedges.retain(|&wedge| self.is_free_wedge(wedge));
        let mut sectors = Sectors {
            count: 0,
            turning: None,
        };
        for wedge in wedges {
            if self.right_of(vertex, wedge)?.is_some() {
                continue;
            }
            sectors.count += 1;
            if self.turns_from(vertex, wedge)? {
                let last = self.end_of_sector(vertex, wedge, true)?;
                sectors.turning = Some([self.neighbours(vertex, wedge)?[0], self.neighbours(vertex, last)?[1]]);
            }
        }
        Ok(sectors)
    }

    /// Returns whether triangles lie all round a vertex, and none of its edges is a constraint.
    fn is_inside_without_constraints(self, vertex: VertexIndex) -> Result<bool, Contradiction> {
        let mut star = self.tile.star(self.leaving(vertex)?);
        let is_constraint = |half_edge: HalfEdge| self.tile.is_constraint(half_edge);
        let has_constraint = star.any(|half_edge| is_constraint(half_edge) || is_constraint(half_edge.prev()));
        Ok(!has_constraint && star.end() == Some(StarEnd::Closed))
    }

    /// Returns whether an edge blocks that bounds the wedge of a triangle.
    fn is_beside_blocked(self, wedge: Wedge) -> bool {
        match wedge {
            Wedge::Triangle(half_edge) => [half_edge, half_edge.prev()].into_iter().any(|edge| self.blocks(edge)),
            Wedge::Outside => false,
        }
    }

    /// Returns whether an edge is a constraint that separates free space from what is not free, or a
    /// wall.
    fn blocks(self, half_edge: HalfEdge) -> bool {
        self.tile.is_constraint(half_edge)
            && (self.tile.is_wall(half_edge)
                || match self.tile.twin(half_edge) {
                    Twin::HalfEdge(other) => self.is_free(half_edge.triangle()) != self.is_free(other.triangle()),
                    Twin::Hull | Twin::Elsewhere => self.is_free(half_edge.triangle()) != self.outside_is_free,
                })
    }
}
