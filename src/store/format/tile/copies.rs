//! Copies of what a tile says of all its triangles, which take less time than to ask for each. Each has
//! room for `more` triangles.

use crate::geometry::{HalfEdge, VertexIndex};
use crate::mesh::Twin;
use crate::store::format::tile::Tile;

impl Tile {
    /// Returns the corners of all triangles.
    pub(crate) fn all_corners(&self, more: usize) -> Vec<[VertexIndex; 3]> {
        let mut all = Vec::with_capacity(self.triangle_count() as usize + more);
        self.triangles.extend_triples(&mut all, VertexIndex);
        self.border_triangles.extend_triples(&mut all, VertexIndex);
        all
    }

    /// Returns the twins of all half-edges, by triangle.
    pub(crate) fn all_twins<T: From<Twin>>(&self, more: usize) -> Vec<[T; 3]> {
        let mut all: Vec<[T; 3]> = Vec::with_capacity(self.triangle_count() as usize + more);
        let half_edge = |value: u32| T::from(Twin::HalfEdge(HalfEdge(value)));
        // Marks are the largest values of a width, and half-edges have at most 32 bits.
        let mark = self.neighbours.largest() as u32;
        self.neighbours.extend_triples(&mut all, |value| match value == mark {
            true => Twin::Hull.into(),
            false => half_edge(value),
        });
        for link in 0..self.core_links.len() / 2 {
            let [from, to] = [2 * link, 2 * link + 1].map(|index| self.core_links.get(index));
            all.as_flattened_mut()[from as usize] = half_edge(to as u32);
        }
        let mark = self.border_neighbours.largest() as u32;
        self.border_neighbours
            .extend_triples(&mut all, |value| match mark - value {
                0 => Twin::Hull.into(),
                1 => Twin::Elsewhere.into(),
                _ => half_edge(value),
            });
        all
    }

    /// Returns three bits for each triangle that say which of its half-edges are on constraints, and from
    /// bit `walls` on three that say which are on walls.
    pub(crate) fn all_edge_bits(&self, walls: u32, more: usize) -> Vec<u8> {
        let core = self.core_triangle_count() as usize;
        let counts = [core, self.triangle_count() as usize - core];
        let parts = self.half_edge_bits.iter().zip(counts);
        let mut all = Vec::with_capacity(self.triangle_count() as usize + more);
        for (bits, count) in parts {
            all.extend(bits.of_triangles(count, walls));
        }
        all
    }
}
