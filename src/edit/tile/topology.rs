//! The adjacency of a tile's triangles, and the search for its edges.

use std::iter;

use crate::edit::tile::EditTile;
use crate::geometry::{HalfEdge, Point, VertexIndex};
use crate::mesh::{Embedded, Topology, Twin};
use crate::store::VertexId;

/// Positions of removed triangles count too.
impl Topology for EditTile {
    #[inline]
    fn triangle_count(&self) -> u32 {
        self.triangles.len() as u32
    }

    #[inline]
    fn origin(&self, half_edge: HalfEdge) -> VertexIndex {
        self.triangles.as_flattened()[half_edge.index()]
    }

    #[inline]
    fn twin(&self, half_edge: HalfEdge) -> Twin {
        self.twins.as_flattened()[half_edge.index()].get()
    }
}

/// Vertices are corners: those of other tiles have indices too.
impl Embedded for EditTile {
    #[inline]
    fn point(&self, corner: VertexIndex) -> Point {
        self.vertex(corner).point
    }
}

impl EditTile {
    /// Returns the corner of a vertex, if the tile has it.
    pub(super) fn corner(&self, id: VertexId) -> Option<VertexIndex> {
        if id.tile == self.id {
            (id.index.index() < self.points.len()).then_some(id.index)
        } else {
            self.foreign_corners.get(&id).copied()
        }
    }

    /// Returns a half-edge that leaves a vertex of the tile, if the vertex has any triangles.
    pub(crate) fn leaving(&self, vertex: VertexIndex) -> Option<HalfEdge> {
        self.leaving[vertex.index()].get()
    }

    /// Returns the half-edges that leave a vertex of the tile, each once: counter-clockwise from
    /// one of them to the hull, and then those before it.
    pub(crate) fn around(&self, vertex: VertexIndex) -> impl Iterator<Item = HalfEdge> {
        self.leaving(vertex).into_iter().flat_map(move |first| {
            // If the star is closed, there are none before it.
            let before = iter::once_with(move || self.rewind(first).0).flat_map(move |start| self.star(start));
            self.star(first)
                .chain(before.take_while(move |&half_edge| half_edge != first))
        })
    }

    /// Returns the half-edge from one vertex to another, one of which is the tile's own.
    pub(crate) fn half_edge_between(&self, from: VertexId, to: VertexId) -> Option<HalfEdge> {
        self.half_edge_along([self.corner(from)?, self.corner(to)?])
    }

    /// Returns the half-edge from one corner to another, one of which is the tile's own.
    pub(super) fn half_edge_along(&self, [from, to]: [VertexIndex; 2]) -> Option<HalfEdge> {
        if self.hubs.has(from) || self.hubs.has(to) {
            self.hubs.half_edge([from, to])
        } else if from.index() < self.points.len() {
            self.around(from).find(|&half_edge| self.destination(half_edge) == to)
        } else {
            let mut arriving = self.around(to).map(HalfEdge::prev);
            arriving.find(|&half_edge| self.origin(half_edge) == from)
        }
    }

    /// Returns the first half-edge of the triangle with these corners, one of which is the tile's
    /// own.
    pub(crate) fn half_edge_of(&self, corners: [VertexId; 3]) -> Option<HalfEdge> {
        let own = corners.iter().position(|id| id.tile == self.id)?;
        let at = |index: usize| corners[(own + index) % 3];
        let half_edge = self.half_edge_between(at(0), at(1))?;
        (self.origin_vertex(half_edge.prev()).id == at(2)).then(|| match own {
            0 => half_edge,
            1 => half_edge.prev(),
            _ => half_edge.next(),
        })
    }
}
