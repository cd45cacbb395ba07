//! Checks of the triangles around a vertex.

use crate::geometry::{HalfEdge, Orientation, VertexIndex, orient2d};
use crate::mesh::{StarEnd, Topology, Twin};
use crate::store::format::tile::Tile;
use crate::store::verify::error::Fault;

/// For each vertex of a tile, the first half-edge of its fan, counter-clockwise. If the vertex is
/// on the hull, this is the half-edge after the hull.
pub(super) struct Fans {
    first: Vec<Option<HalfEdge>>,
}

impl Fans {
    /// Returns the first half-edge of the fan of a vertex.
    pub(super) fn first(&self, vertex: VertexIndex) -> Option<HalfEdge> {
        self.first[vertex.index()]
    }
}

/// The contribution of a hull vertex to the checks of the whole file.
pub(super) struct HullVertex {
    /// Whether the vertex is lexicographically smaller than both its neighbours on the hull.
    pub(super) is_minimum: bool,
}

/// Checks that the triangles at each vertex of a tile form a single fan, the vertex's complete
/// star.
pub(super) fn fans(tile: &Tile, has_triangles: bool) -> Result<Fans, Fault> {
    let mut at_vertex = vec![0u32; tile.vertex_count() as usize];
    for corner in tile.triangle_ids().flat_map(|t| tile.corners(t)) {
        if let Some(count) = at_vertex.get_mut(corner.index()) {
            *count += 1;
        }
    }
    let mut first = Vec::with_capacity(at_vertex.len());
    for (vertex, &count) in tile.vertex_indices().zip(&at_vertex) {
        let half_edge = match tile.leaving(vertex) {
            Some(half_edge) if tile.origin(half_edge) == vertex => half_edge,
            None if count == 0 && !has_triangles => {
                first.push(None);
                continue;
            }
            _ => {
                return Err(Fault::new(format!(
                    "the half-edge stored for vertex {vertex} is missing or does not start there"
                )));
            }
        };
        let (start, end) = tile.rewind(half_edge);
        if !matches!(end, StarEnd::Hull(_) | StarEnd::Closed) {
            let reason = format!("triangles at vertex {vertex} are missing");
            return Err(Fault::new(reason));
        }
        let length = tile.star(start).count();
        if length != count as usize {
            let reason = format!("the {count} triangles at vertex {vertex} do not form one fan: its star has {length}");
            return Err(Fault::at(half_edge.triangle(), reason));
        }
        first.push(Some(start));
    }
    Ok(Fans { first })
}

/// Checks that the triangles at a vertex go round once, or on the hull through a half-turn at most.
pub(super) fn check_turn(tile: &Tile, vertex: VertexIndex, fans: &Fans) -> Result<Option<HullVertex>, Fault> {
    let Some(first) = fans.first[vertex.index()] else {
        return Ok(None);
    };
    let centre = tile.point(vertex);
    // The neighbours of the vertex.
    let mut star = tile.star(first);
    let mut ring: Vec<_> = star.by_ref().map(|leaving| tile.destination(leaving)).collect();
    if let Some(StarEnd::Hull(arriving)) = star.end() {
        ring.push(tile.origin(arriving));
    }
    let ring: Vec<_> = ring.into_iter().map(|corner| tile.point(corner)).collect();
    if tile.twin(first) != Twin::Hull {
        // Each step turns left by less than a half-turn, so a full turn passes the direction of the
        // x axis once.
        let above = |i: usize| ring[i].y > centre.y || (ring[i].y == centre.y && ring[i].x > centre.x);
        let turns = (0..ring.len())
            .filter(|&i| !above(i) && above((i + 1) % ring.len()))
            .count();
        if turns != 1 {
            return Err(Fault::at(
                first.triangle(),
                format!("the triangles at vertex {vertex} go round {turns} times"),
            ));
        }
        return Ok(None);
    }
    let (start, end) = (ring[0], ring[ring.len() - 1]);
    let convex = ring[1..]
        .iter()
        .enumerate()
        .all(|(i, &p)| match orient2d(centre, start, p) {
            Orientation::CounterClockwise => true,
            // The last neighbour may be straight ahead, on the other side of the vertex.
            Orientation::Collinear => i + 2 == ring.len() && start.lex_cmp(centre) == centre.lex_cmp(p),
            Orientation::Clockwise => false,
        });
    if !convex {
        return Err(Fault::at(
            first.triangle(),
            format!("the hull is not convex at vertex {vertex}"),
        ));
    }
    Ok(Some(HullVertex {
        is_minimum: centre.lex_cmp(start).is_lt() && centre.lex_cmp(end).is_lt(),
    }))
}
