//! The sources of a tile's constraint edges: the lines that run along them.

use crate::edit::tile::EditTile;
use crate::geometry::{HalfEdge, VertexIndex};
use crate::mesh::Topology;
use crate::store::format::line_part::join_equal;
use crate::store::{LinePart, Tile, VertexId};

impl EditTile {
    /// Copies the sources of a tile.
    pub(crate) fn load_sources(&mut self, tile: &Tile) {
        for edge in tile.owned_constraints() {
            let (ends, is_turned) = in_order(tile.corners_of_edge(edge));
            let seen = |part: LinePart| if is_turned { part.reversed() } else { part };
            let sources: Vec<LinePart> = tile.edge_parts(edge).map(seen).collect();
            self.source_count += sources.len();
            self.sources.insert(ends, sources);
        }
    }

    /// Adds a source of an edge of the tile, as seen from its first end, until the edge has it at
    /// least `times` times, and the ends of segments that come with it. Returns `None` if the tile
    /// does not have the ends.
    pub(crate) fn add_source(&mut self, ends: [VertexId; 2], part: LinePart, times: usize) -> Option<()> {
        let [from, to] = ends.map(|id| self.corner(id));
        let (ends, is_turned) = in_order([from?, to?]);
        let part = if is_turned { part.reversed() } else { part };
        let sources = self.sources.entry(ends).or_default();
        let is_same = |other: &&mut LinePart| other.source() == part.source();
        let mut there = 0;
        for other in sources.iter_mut().filter(is_same) {
            *other = other.joined(part);
            there += 1;
        }
        let missing = times.saturating_sub(there);
        sources.extend(std::iter::repeat_n(part, missing));
        self.source_count += missing;
        sources.sort_unstable();
        join_equal(sources);
        Some(())
    }

    /// Returns the sources of a half-edge's edge, as seen from its smaller corner; none if the edge
    /// belongs to another tile.
    pub(crate) fn sources_of(&self, half_edge: HalfEdge) -> &[LinePart] {
        let (ends, _) = in_order([self.origin(half_edge), self.destination(half_edge)]);
        self.sources.get(&ends).map_or(&[], Vec::as_slice)
    }

    /// Removes and returns the sources of an edge of the tile, as seen from its first end.
    pub(crate) fn take_sources(&mut self, ends: [VertexId; 2]) -> Option<Vec<LinePart>> {
        let [from, to] = ends.map(|id| self.corner(id));
        let (ends, is_turned) = in_order([from?, to?]);
        let sources = self.sources.remove(&ends)?;
        self.source_count -= sources.len();
        let sources = sources.into_iter();
        Some(match is_turned {
            true => sources.map(LinePart::reversed).collect(),
            false => sources.collect(),
        })
    }

    /// Adds sources of an edge of the tile, as seen from its first end.
    pub(crate) fn give_sources(&mut self, ends: [VertexId; 2], sources: &[LinePart]) -> Option<()> {
        let [from, to] = ends.map(|id| self.corner(id));
        let (ends, is_turned) = in_order([from?, to?]);
        let seen = |&part: &LinePart| if is_turned { part.reversed() } else { part };
        let all = self.sources.entry(ends).or_default();
        all.extend(sources.iter().map(seen));
        self.source_count += sources.len();
        all.sort_unstable();
        Some(())
    }

    /// Returns a half-edge of each constraint edge that belongs to the tile, and the edge's sources
    /// as seen from its smaller corner.
    pub(crate) fn owned_constraints(&self) -> impl Iterator<Item = (HalfEdge, &[LinePart])> {
        self.sources.iter().filter_map(|(&[from, to], sources)| {
            let half_edge = self
                .half_edge_along([from, to])
                .or_else(|| self.half_edge_along([to, from]))?;
            Some((half_edge, sources.as_slice()))
        })
    }
}

/// Returns the corners, the smaller one first, and whether they were swapped.
fn in_order([a, b]: [VertexIndex; 2]) -> ([VertexIndex; 2], bool) {
    if a <= b { ([a, b], false) } else { ([b, a], true) }
}
