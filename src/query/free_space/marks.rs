//! Properties of each vertex of a tile. The first search that needs them computes them; all later
//! searches share them.

use super::space::FreeSpace;
use crate::geometry::{Orientation, Point, VertexIndex, orient2d};
use crate::mesh::Twin;
use crate::query::request::Contradiction;
use crate::store::VertexNotes;

/// Properties of a vertex, in one byte, because each vertex of every cached tile has one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mark(u8);

const TURNING: u8 = 1;
const SITE: u8 = 2;
const SINGLE: u8 = 4;

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

impl<'t> FreeSpace<'t> {
    /// Returns the properties of a vertex, or `None` if the tile has no such vertex. Where the tile
    /// contradicts itself, the walk round the star reports it.
    #[inline]
    pub(crate) fn mark(self, vertex: VertexIndex) -> Option<Mark> {
        self.marks().marks.get(vertex.index()).copied().map(Mark)
    }

    /// Returns whether the tile has break lines.
    pub(crate) fn has_break_lines(self) -> bool {
        self.marks().has_break_lines
    }

    /// Returns the properties of each vertex of the tile, with the neighbours at the right and left
    /// end of the sector in which it turns.
    fn marks(self) -> &'t VertexNotes {
        self.tile.notes().vertices(|| self.find_marks())
    }

    /// Returns whether a path that arrives straight from `from` at a turning vertex of the tile can
    /// bend round an edge there. It cannot if both ends of the sector face `from`.
    pub(crate) fn can_turn(self, from: Point, vertex: VertexIndex) -> bool {
        let marks = self.marks();
        let Some(ends) = marks.ends.get(marks.ends_index[vertex.index()] as usize) else {
            return true;
        };
        let at = self.point(vertex);
        let turn = |end| orient2d(from, at, self.point(end));
        turn(ends[1]) != Orientation::Clockwise || turn(ends[0]) != Orientation::CounterClockwise
    }

    fn find_marks(self) -> VertexNotes {
        const TOUCHED: u8 = 128;
        let vertices = self.tile.vertex_count() as usize;
        let mut marks = vec![SINGLE; vertices];
        for site in self.tile.sites() {
            marks[site.vertex.index()] |= SITE;
        }
        let mut has_break_lines = false;
        for half_edge in self.tile.constraint_half_edges() {
            has_break_lines |= !self.tile.is_wall(half_edge);
            let is_blocked = self.tile.is_wall(half_edge)
                || match self.tile.twin(half_edge) {
                    Twin::HalfEdge(other) => self.is_free(half_edge.triangle()) != self.is_free(other.triangle()),
                    Twin::Hull | Twin::Elsewhere => self.is_free(half_edge.triangle()) != self.outside_is_free,
                };
            let ends = [half_edge, half_edge.next()].map(|half_edge| self.tile.origin(half_edge));
            for end in ends.into_iter().filter(|&end| is_blocked && self.tile.has_vertex(end)) {
                marks[end.index()] |= TOUCHED;
            }
        }
        let mut ends = Vec::new();
        let mut ends_index = vec![u32::MAX; vertices];
        for (vertex, mark) in self.tile.vertex_indices().zip(&mut marks) {
            if *mark & TOUCHED == 0 {
                continue;
            }
            *mark &= !(TOUCHED | SINGLE);
            match self.sectors(vertex) {
                Ok((sectors, turning)) => {
                    *mark |= if sectors == 1 { SINGLE } else { 0 };
                    if let Some(of_turning) = turning {
                        *mark |= TURNING;
                        ends_index[vertex.index()] = ends.len() as u32;
                        ends.push(of_turning);
                    }
                }
                Err(_) => *mark |= TURNING,
            }
        }
        VertexNotes {
            marks,
            ends_index,
            ends,
            has_break_lines,
        }
    }

    /// Returns the number of free sectors of a vertex, and the neighbours at the right and left end
    /// of the sector in which it turns.
    fn sectors(self, vertex: VertexIndex) -> Result<(u32, Option<[VertexIndex; 2]>), Contradiction> {
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
