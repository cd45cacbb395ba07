//! The constraint edges of a tile, and their sources.

use crate::geometry::{HalfEdge, VertexIndex};
use crate::mesh::{Topology, Twin};
use crate::store::format::edge_source::EdgeSource;
use crate::store::format::line_part::LinePart;
use crate::store::format::tile::edge_bits::{EdgeSources, HalfEdgeBits};
use crate::store::format::tile::{Tile, Vertex};

/// An edge of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TileEdge {
    /// The edge of this half-edge, as seen in its direction.
    HalfEdge(HalfEdge),
    /// The constraint of this number, from 0 on, in a tile without triangles. All vertices of such
    /// a file are on one line.
    OnLine(u32),
}

impl From<HalfEdge> for TileEdge {
    #[inline]
    fn from(half_edge: HalfEdge) -> Self {
        Self::HalfEdge(half_edge)
    }
}

impl Tile {
    /// Returns whether an edge is a constraint.
    #[must_use]
    pub fn is_constraint(&self, edge: impl Into<TileEdge>) -> bool {
        match edge.into() {
            TileEdge::HalfEdge(half_edge) => {
                let (bits, index) = self.half_edge_bits(half_edge);
                bits.is_constraint(index)
            }
            TileEdge::OnLine(_) => true,
        }
    }

    /// Returns whether an edge is a wall: a constraint that paths must not cross.
    #[must_use]
    pub fn is_wall(&self, edge: impl Into<TileEdge>) -> bool {
        match edge.into() {
            TileEdge::HalfEdge(half_edge) => {
                let (bits, index) = self.half_edge_bits(half_edge);
                bits.is_wall(index)
            }
            edge @ TileEdge::OnLine(_) => self.edge_sources(edge).any(EdgeSource::is_wall),
        }
    }

    /// Returns the bits of the core or of the border, and the index of a half-edge in them.
    fn half_edge_bits(&self, half_edge: HalfEdge) -> (&HalfEdgeBits, usize) {
        let index = half_edge.index();
        assert!(
            index < 3 * self.triangle_count() as usize,
            "tile {} has no half-edge {index}",
            self.id
        );
        match index.checked_sub(self.triangles.len()) {
            None => (&self.half_edge_bits[0], index),
            Some(index) => (&self.half_edge_bits[1], index),
        }
    }

    /// Returns the sources of a constraint edge: the lines along it, as seen in its direction.
    ///
    /// Returns none if the edge is no constraint, or belongs to another tile. An edge belongs to
    /// the tile of its lexicographically smaller end.
    pub fn edge_sources(&self, edge: impl Into<TileEdge>) -> impl Iterator<Item = EdgeSource> {
        self.edge_parts(edge).map(LinePart::source)
    }

    /// Returns the sources of a constraint edge as [`edge_sources`](Self::edge_sources) does, each
    /// with the ends of the line's segments: whether a segment of the line begins where the edge
    /// starts, and whether one ends where it ends.
    pub fn edge_parts(&self, edge: impl Into<TileEdge>) -> impl Iterator<Item = LinePart> {
        let (in_core, key, is_reversed) = match edge.into() {
            TileEdge::OnLine(number) => (false, number, false),
            TileEdge::HalfEdge(half_edge) => {
                let twin = self.twin(half_edge).half_edge();
                let core = 3 * self.core_triangle_count();
                let in_core = twin.is_some_and(|twin| half_edge.max(twin).0 < core);
                let key = twin.map_or(half_edge, |twin| half_edge.min(twin));
                (in_core, key.0, key != half_edge)
            }
        };
        let sources = self.sources[usize::from(!in_core)].as_ref();
        let parts = sources.into_iter().flat_map(move |sources| sources.of(key));
        parts.map(move |part| if is_reversed { part.reversed() } else { part })
    }

    /// Returns the number of constraint edges of a tile without triangles.
    pub(crate) fn edge_count(&self) -> u32 {
        self.edges.as_ref().map_or(0, |edges| edges.len() as u32 / 2)
    }

    /// Returns the number of edges for which the tile has sources.
    pub(crate) fn edges_with_sources(&self) -> usize {
        self.sources.iter().flatten().map(EdgeSources::edge_count).sum()
    }

    /// Returns the constraint edges that belong to the tile, each once.
    pub fn owned_constraints(&self) -> impl Iterator<Item = TileEdge> {
        let is_first = |half_edge: HalfEdge| match self.twin(half_edge) {
            Twin::HalfEdge(twin) => half_edge < twin,
            Twin::Hull => true,
            // Other tiles own both ends.
            Twin::Elsewhere => false,
        };
        let owned = self.constraint_half_edges().filter(move |&half_edge| {
            is_first(half_edge) && {
                let [from, to] = self.ends(half_edge);
                let smallest = if from.point.lex_cmp(to.point).is_lt() { from } else { to };
                smallest.id.tile == self.id
            }
        });
        let on_line = (0..self.edge_count()).map(TileEdge::OnLine);
        owned.map(TileEdge::HalfEdge).chain(on_line)
    }

    /// Returns all half-edges on constraints.
    pub(crate) fn constraint_half_edges(&self) -> impl Iterator<Item = HalfEdge> {
        let any = self.half_edge_bits.iter().any(HalfEdgeBits::any);
        let all = self.half_edges().take_while(move |_| any);
        all.filter(|&half_edge| self.is_constraint(half_edge))
    }

    /// Returns the end vertices of an edge.
    #[must_use]
    pub fn ends(&self, edge: impl Into<TileEdge>) -> [Vertex; 2] {
        self.corners_of_edge(edge.into()).map(|corner| self.vertex(corner))
    }

    /// Returns the end corners of an edge.
    #[must_use]
    pub fn corners_of_edge(&self, edge: TileEdge) -> [VertexIndex; 2] {
        match (edge, &self.edges) {
            (TileEdge::HalfEdge(half_edge), _) => [self.origin(half_edge), self.destination(half_edge)],
            (TileEdge::OnLine(number), Some(edges)) => {
                let first = 2 * number as usize;
                [first, first + 1].map(|index| VertexIndex(edges.get(index) as u32))
            }
            (TileEdge::OnLine(number), None) => panic!("tile {} has no edge {number}", self.id),
        }
    }
}
