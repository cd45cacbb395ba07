//! The corners of the hull, which stay in all levels: so all levels cover the same ground.

use foldhash::{HashMap, HashMapExt};

use crate::geometry::{HalfEdge, Orientation, VertexIndex, orient2d};
use crate::mesh::Twin;
use crate::store::Tile;

/// Returns the vertices of a tile at which the hull turns, in order. Vertices inside straight hull edges
/// are none.
pub(super) fn corners(tile: &Tile) -> Vec<VertexIndex> {
    let mut neighbours: HashMap<u32, [Option<VertexIndex>; 2]> = HashMap::new();
    for triangle in tile.triangle_ids() {
        for half_edge in HalfEdge::of_triangle(triangle) {
            if tile.twin(half_edge) != Twin::Hull {
                continue;
            }
            let [from, to] = [tile.origin(half_edge), tile.origin(half_edge.next())];
            // Only the tiles of the ends know which edges are on the hull.
            if tile.has_vertex(from) {
                neighbours.entry(from.0).or_default()[1] = Some(to);
            }
            if tile.has_vertex(to) {
                neighbours.entry(to.0).or_default()[0] = Some(from);
            }
        }
    }
    let turns = |(&vertex, [before, after]): (&u32, &[Option<VertexIndex>; 2])| {
        let [before, after] = [(*before)?, (*after)?].map(|end| tile.point(end));
        let vertex = VertexIndex(vertex);
        (orient2d(before, tile.point(vertex), after) != Orientation::Collinear).then_some(vertex)
    };
    let mut corners: Vec<VertexIndex> = neighbours.iter().filter_map(turns).collect();
    corners.sort_unstable_by_key(|vertex| vertex.0);
    corners
}
