//! The adjacency of a tile's triangles.

use crate::geometry::{HalfEdge, Point, VertexIndex};
use crate::mesh::{Embedded, Topology, Twin};
use crate::store::format::packed::{Packed, partition_point};
use crate::store::format::tile::Tile;

impl Tile {
    /// Returns the corner at which a half-edge starts.
    #[inline]
    #[must_use]
    pub fn origin(&self, half_edge: HalfEdge) -> VertexIndex {
        let index = half_edge.index();
        let corner = match index.checked_sub(self.triangles.len()) {
            None => self.triangles.get(index),
            Some(index) => self.border_triangles.get(index),
        };
        VertexIndex(corner as u32)
    }

    /// Returns the twin of a half-edge. [`Twin::Elsewhere`] means that the other triangle has no
    /// corner in this tile, or that the edge is on the hull; the tiles of the ends of the edge
    /// know.
    #[inline]
    #[must_use]
    pub fn twin(&self, half_edge: HalfEdge) -> Twin {
        let index = half_edge.index();
        let twin = |value: u64| Twin::HalfEdge(HalfEdge(value as u32));
        if let Some(index) = index.checked_sub(self.triangles.len()) {
            let value = self.border_neighbours.get(index);
            return match self.border_neighbours.largest() - value {
                0 => Twin::Hull,
                1 => Twin::Elsewhere,
                _ => twin(value),
            };
        }
        let value = self.neighbours.get(index);
        if value != self.neighbours.largest() {
            return twin(value);
        }
        find(&self.core_links, index as u64).map_or(Twin::Hull, Twin::HalfEdge)
    }

    /// Returns a half-edge that starts at a vertex of the tile, or `None` if the vertex has no
    /// triangles.
    #[must_use]
    pub fn leaving(&self, vertex: VertexIndex) -> Option<HalfEdge> {
        let half_edge = self.vertex_sides.get(vertex.index());
        if half_edge != self.vertex_sides.largest() {
            return Some(HalfEdge(half_edge as u32));
        }
        find(&self.border_vertex_sides, vertex.0.into())
    }
}

impl Topology for Tile {
    #[inline]
    fn triangle_count(&self) -> u32 {
        Self::triangle_count(self)
    }

    #[inline]
    fn origin(&self, half_edge: HalfEdge) -> VertexIndex {
        Self::origin(self, half_edge)
    }

    #[inline]
    fn twin(&self, half_edge: HalfEdge) -> Twin {
        Self::twin(self, half_edge)
    }
}

/// The vertices of this implementation are corners: vertices of other tiles have numbers too.
impl Embedded for Tile {
    #[inline]
    fn point(&self, corner: VertexIndex) -> Point {
        Self::point(self, corner)
    }
}

/// Looks up the half-edge of a key in sorted pairs.
fn find(pairs: &Packed, key: u64) -> Option<HalfEdge> {
    let index = partition_point(pairs.len() / 2, |index| pairs.get(2 * index) < key);
    let found = index < pairs.len() / 2 && pairs.get(2 * index) == key;
    found.then(|| HalfEdge(pairs.get(2 * index + 1) as u32))
}
