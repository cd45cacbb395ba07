//! Triangles of several tiles that are taken out together, and others in their place.

use foldhash::HashMap;

use super::EditError;
use super::tile::Incoming;
use super::tiles::Tiles;
use crate::store::{TileId, Vertex, VertexId};

/// Triangles on their way out, their corners numbered through.
#[derive(Default)]
pub(super) struct Patch {
    pub(super) vertices: Vec<Vertex>,
    pub(super) places: HashMap<VertexId, u32>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) bits: Vec<u8>,
}

impl Patch {
    pub(super) fn clear(&mut self) {
        self.vertices.clear();
        self.places.clear();
        self.triangles.clear();
        self.bits.clear();
    }

    pub(super) fn push(&mut self, (corners, bits): Incoming) {
        let corners = corners.map(|vertex| {
            let next = self.vertices.len() as u32;
            *self.places.entry(vertex.id).or_insert_with(|| {
                self.vertices.push(vertex);
                next
            })
        });
        self.triangles.push(corners);
        self.bits.push(bits);
    }

    /// Puts others in their place, in all tiles that have some of them. These sides of theirs are new on the hull.
    pub(super) fn exchange(
        &self,
        tiles: &mut Tiles,
        new: &[Incoming],
        on_hull: &[[VertexId; 2]],
    ) -> Result<(), EditError> {
        let id = |place: u32| self.vertices[place as usize].id;
        let old: Vec<[VertexId; 3]> = self.triangles.iter().map(|corners| corners.map(id)).collect();
        let corners = new.iter().flat_map(|(corners, _)| corners.map(|vertex| vertex.id));
        let mut of_tiles: Vec<TileId> = old.iter().flatten().copied().chain(corners).map(|id| id.tile).collect();
        of_tiles.sort_unstable();
        of_tiles.dedup();
        let mut unlinked = Vec::new();
        for id in of_tiles {
            let removed: Vec<_> = old
                .iter()
                .filter(|ids| ids.iter().any(|v| v.tile == id))
                .copied()
                .collect();
            let added = new
                .iter()
                .filter(|(corners, _)| corners.iter().any(|v| v.id.tile == id));
            let added: Vec<Incoming> = added.copied().collect();
            let replaced = tiles.change(id)?.replace(&removed, &added, on_hull);
            let open = replaced.map_err(|reason| tiles.damaged(id, reason))?;
            unlinked.extend(open.into_iter().map(|open| (id, open)));
        }
        // Edges between two vertices of other tiles: these know what lies across.
        for (id, open) in unlinked {
            let [from, to, _] = open;
            let other = tiles.get(from.tile)?;
            let Some(side) = other.side_between(to, from) else {
                continue;
            };
            let apex = other.from(crate::mesh::prev_side(side)).id;
            drop(other);
            if apex.tile == id {
                let linked = tiles.change(id)?.link(open, apex);
                linked.map_err(|reason| tiles.damaged(id, reason))?;
            }
        }
        Ok(())
    }
}
