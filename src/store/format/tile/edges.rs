//! The edges of a tile that are constraints, and why they are.

use crate::geometry::{HalfEdge, VertexIndex};
use crate::mesh::{Topology, Twin};
use crate::store::format::edge_source::EdgeSource;
use crate::store::format::tile::sides::{SideBits, Sources};
use crate::store::format::tile::{Tile, Vertex};

/// An edge of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TileEdge {
    /// The edge of this half-edge, seen in its direction.
    HalfEdge(HalfEdge),
    /// The constraint of this number, from 0 on, of a tile without triangles: all vertices of its file lie on one line.
    OnLine(u32),
}

impl From<HalfEdge> for TileEdge {
    #[inline]
    fn from(half_edge: HalfEdge) -> Self {
        Self::HalfEdge(half_edge)
    }
}

impl Tile {
    /// Whether an edge is a constraint.
    #[must_use]
    pub fn is_constraint(&self, edge: impl Into<TileEdge>) -> bool {
        match edge.into() {
            TileEdge::HalfEdge(half_edge) => {
                let (bits, side) = self.side_bits(half_edge);
                bits.is_constraint(side)
            }
            TileEdge::OnLine(_) => true,
        }
    }

    /// Whether an edge is a wall: a constraint that blocks the way.
    #[must_use]
    pub fn is_wall(&self, edge: impl Into<TileEdge>) -> bool {
        match edge.into() {
            TileEdge::HalfEdge(half_edge) => {
                let (bits, side) = self.side_bits(half_edge);
                bits.is_wall(side)
            }
            edge @ TileEdge::OnLine(_) => self.edge_sources(edge).any(EdgeSource::is_wall),
        }
    }

    /// The bits of the core or of the border, and the place of a half-edge in them.
    fn side_bits(&self, half_edge: HalfEdge) -> (&SideBits, usize) {
        let side = half_edge.index();
        assert!(
            side < 3 * self.triangle_count() as usize,
            "tile {} has no side {side}",
            self.id
        );
        match side.checked_sub(self.triangles.len()) {
            None => (&self.side_bits[0], side),
            Some(side) => (&self.side_bits[1], side),
        }
    }

    /// Why an edge is a constraint: the lines along it, as seen in its direction.
    ///
    /// None if it is no constraint, or belongs to another tile: to that of its lexicographically smaller end.
    pub fn edge_sources(&self, edge: impl Into<TileEdge>) -> impl Iterator<Item = EdgeSource> {
        let (in_core, entered, is_turned) = match edge.into() {
            TileEdge::OnLine(number) => (false, number, false),
            TileEdge::HalfEdge(side) => {
                let twin = self.twin(side).half_edge();
                let core = 3 * self.core_triangle_count();
                let in_core = twin.is_some_and(|twin| side.max(twin).0 < core);
                let entered = twin.map_or(side, |twin| side.min(twin));
                (in_core, entered.0, entered != side)
            }
        };
        let sources = self.sources[usize::from(!in_core)].as_ref();
        let sources = sources.into_iter().flat_map(move |sources| sources.of(entered));
        sources.map(move |source| if is_turned { source.reversed() } else { source })
    }

    /// How many constraint edges a tile without triangles has.
    pub(crate) fn edge_count(&self) -> u32 {
        self.edges.as_ref().map_or(0, |edges| edges.len() as u32 / 2)
    }

    /// How many edges the tile has sources for.
    pub(crate) fn edges_with_sources(&self) -> usize {
        self.sources.iter().flatten().map(Sources::edge_count).sum()
    }

    /// The constraint edges that belong to the tile, each once.
    pub fn owned_constraints(&self) -> impl Iterator<Item = TileEdge> {
        let is_first = |side: HalfEdge| match self.twin(side) {
            Twin::HalfEdge(twin) => side < twin,
            Twin::Hull => true,
            // Both ends are other tiles'.
            Twin::Elsewhere => false,
        };
        let owned = self.constraint_half_edges().filter(move |&side| {
            is_first(side) && {
                let [from, to] = self.ends(side);
                let smallest = if from.point.lex_cmp(to.point).is_lt() { from } else { to };
                smallest.id.tile == self.id
            }
        });
        let on_line = (0..self.edge_count()).map(TileEdge::OnLine);
        owned.map(TileEdge::HalfEdge).chain(on_line)
    }

    /// All half-edges that are on constraints.
    pub(crate) fn constraint_half_edges(&self) -> impl Iterator<Item = HalfEdge> {
        let any = self.side_bits.iter().any(SideBits::any);
        let all = self.half_edges().take_while(move |_| any);
        all.filter(|&side| self.is_constraint(side))
    }

    /// The vertices of an edge.
    #[must_use]
    pub fn ends(&self, edge: impl Into<TileEdge>) -> [Vertex; 2] {
        self.corners_of_edge(edge.into()).map(|corner| self.vertex(corner))
    }

    /// The corners of an edge.
    pub(crate) fn corners_of_edge(&self, edge: TileEdge) -> [VertexIndex; 2] {
        match (edge, &self.edges) {
            (TileEdge::HalfEdge(side), _) => [self.origin(side), self.destination(side)],
            (TileEdge::OnLine(number), Some(edges)) => {
                let first = 2 * number as usize;
                [first, first + 1].map(|place| VertexIndex(edges.get(place) as u32))
            }
            (TileEdge::OnLine(number), None) => panic!("tile {} has no edge {number}", self.id),
        }
    }
}
