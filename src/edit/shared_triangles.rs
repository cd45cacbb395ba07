//! Triangles that several tiles store: they link components of these tiles.

use foldhash::HashMap;

use crate::edit::survey::SharedTriangle;
use crate::store::{ComponentId, TileId, VertexId};

/// Triangles of several tiles some of which have not come.
#[derive(Default)]
pub(crate) struct SharedTriangles {
    /// By the first half-edge of the triangle, from its smallest corner on.
    waiting: HashMap<[VertexId; 2], Waiting>,
}

/// The components that have a triangle, in the tiles that have come.
struct Waiting {
    components: [ComponentId; 2],
    /// The number of these that there are, and the number of tiles that are left.
    came: u8,
    left: u8,
}

impl SharedTriangles {
    /// Takes a triangle that a tile stores. If it is the last one of its tiles, returns pairs of
    /// components: one of another tile, and the one of the tile that owns the triangle.
    pub(crate) fn take(
        &mut self,
        tile: TileId,
        triangle: SharedTriangle,
    ) -> impl Iterator<Item = [ComponentId; 2]> + use<> {
        let SharedTriangle {
            key,
            owner,
            tiles,
            part,
        } = triangle;
        let component = ComponentId { tile, number: part };
        let waiting = self.waiting.entry(key).or_insert(Waiting {
            components: [component; 2],
            came: 0,
            left: tiles,
        });
        let mut all = [None; 3];
        waiting.left = waiting.left.saturating_sub(1);
        if waiting.left > 0 {
            if let Some(place) = waiting.components.get_mut(usize::from(waiting.came)) {
                *place = component;
            }
            waiting.came += 1;
        } else {
            let others = waiting.components.iter().take(waiting.came.into());
            let came = others.copied().chain([component]);
            came.zip(&mut all)
                .for_each(|(component, place)| *place = Some(component));
            self.waiting.remove(&key);
        }
        let at_owner = all.into_iter().flatten().find(|component| component.tile == owner);
        let others = all
            .into_iter()
            .flatten()
            .filter(move |component| component.tile != owner);
        others.filter_map(move |component| Some([component, at_owner?]))
    }

    /// Returns a tile that lacks a triangle that it should have, if there is one.
    pub(crate) fn incomplete(&self) -> Option<TileId> {
        self.waiting.keys().map(|ids| ids[0].tile).min()
    }

    /// Returns the bytes of memory that it takes.
    pub(crate) fn byte_size(&self) -> u64 {
        56 * self.waiting.len() as u64
    }
}
