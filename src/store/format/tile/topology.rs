//! How the triangles of a tile lie beside each other.

use crate::geometry::{HalfEdge, Point, VertexIndex};
use crate::mesh::{Embedded, Topology, Twin};
use crate::store::format::packed::{Packed, partition_point};
use crate::store::format::tile::Tile;

impl Tile {
    /// The corner that a half-edge starts at.
    #[inline]
    #[must_use]
    pub fn origin(&self, half_edge: HalfEdge) -> VertexIndex {
        let side = half_edge.index();
        let corner = match side.checked_sub(self.triangles.len()) {
            None => self.triangles.get(side),
            Some(side) => self.border_triangles.get(side),
        };
        VertexIndex(corner as u32)
    }

    /// What lies on the other side of the edge of a half-edge. [`Twin::Elsewhere`] is a triangle that no vertex of this
    /// tile is a corner of: the tiles of the ends of the edge have it, unless it is the hull.
    #[inline]
    #[must_use]
    pub fn twin(&self, half_edge: HalfEdge) -> Twin {
        let side = half_edge.index();
        let twin = |value: u64| Twin::HalfEdge(HalfEdge(value as u32));
        if let Some(side) = side.checked_sub(self.triangles.len()) {
            let value = self.border_neighbours.get(side);
            return match self.border_neighbours.largest() - value {
                0 => Twin::Hull,
                1 => Twin::Elsewhere,
                _ => twin(value),
            };
        }
        let value = self.neighbours.get(side);
        if value != self.neighbours.largest() {
            return twin(value);
        }
        find(&self.core_links, side as u64).map_or(Twin::Hull, Twin::HalfEdge)
    }

    /// A half-edge that leaves a vertex of the tile, if it has any triangles.
    #[must_use]
    pub fn leaving(&self, vertex: VertexIndex) -> Option<HalfEdge> {
        let side = self.vertex_sides.get(vertex.index());
        if side != self.vertex_sides.largest() {
            return Some(HalfEdge(side as u32));
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

/// Vertices are corners: those of other tiles have numbers too.
impl Embedded for Tile {
    #[inline]
    fn point(&self, corner: VertexIndex) -> Point {
        Self::point(self, corner)
    }
}

/// Looks up the half-edge of a key in sorted pairs.
fn find(pairs: &Packed, key: u64) -> Option<HalfEdge> {
    let place = partition_point(pairs.len() / 2, |place| pairs.get(2 * place) < key);
    let found = place < pairs.len() / 2 && pairs.get(2 * place) == key;
    found.then(|| HalfEdge(pairs.get(2 * place + 1) as u32))
}
