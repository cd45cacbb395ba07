//! What a file has at the positions that calls name.

use crate::edit::{Attributes, Positions};
use crate::geometry::VertexIndex;
use crate::store::Tile;

/// Finds out what lies at the positions that calls name, in a tile.
pub(super) fn look_up(tile: &Tile, positions: &mut Positions) {
    if positions.all.is_empty() {
        return;
    }
    for vertex in tile.vertex_indices().filter(|&vertex| tile.is_input_point(vertex)) {
        let attributes = |vertex: VertexIndex| Attributes {
            z: tile.z(vertex).unwrap_or_default(),
            record: tile.record(vertex),
        };
        if let Some(position) = positions.at(tile.point(vertex)) {
            position.before = Some(attributes(vertex));
            position.now = position.before;
        }
    }
}
