//! The triangles around a vertex.

use super::error::Fault;
use crate::geometry::{Orientation, orient2d};
use crate::mesh::{next_side, prev_side};
use crate::store::{Across, Tile};

/// For each vertex of a tile the first side of its fan, counter-clockwise: after the hull, if it is on it.
pub(super) struct Fans {
    first: Vec<Option<u32>>,
}

/// What a vertex on the hull adds to the whole.
pub(super) struct HullVertex {
    /// Whether it is lexicographically smaller than both its neighbours on the hull.
    pub(super) is_minimum: bool,
}

/// Checks that the triangles at each vertex of a tile make a single fan, which is all of its star.
pub(super) fn fans(tile: &Tile, has_triangles: bool) -> Result<Fans, Fault> {
    let mut at_vertex = vec![0u32; tile.vertex_count() as usize];
    for corner in (0..tile.triangle_count()).flat_map(|t| tile.corners(t)) {
        if let Some(count) = at_vertex.get_mut(corner as usize) {
            *count += 1;
        }
    }
    let mut first = Vec::with_capacity(at_vertex.len());
    for (vertex, &count) in (0u32..).zip(&at_vertex) {
        let side = match tile.side_leaving(vertex) {
            Some(side) if tile.origin(side) == vertex => side,
            None if count == 0 && !has_triangles => {
                first.push(None);
                continue;
            }
            _ => return Err(Fault::new(format!("vertex {vertex} does not know its triangles"))),
        };
        let start = rewind(tile, side, count)
            .ok_or_else(|| Fault::new(format!("the triangles at vertex {vertex} are not complete")))?;
        let length = neighbours(tile, start)
            .take(count as usize + 1)
            .filter(|n| n.side.is_some())
            .count();
        if length != count as usize {
            let reason = format!("{length} of the {count} triangles at vertex {vertex} make a fan");
            return Err(Fault::at(side / 3, reason));
        }
        first.push(Some(start));
    }
    Ok(Fans { first })
}

/// Clockwise to the hull, or all round. None if the star is not all in the tile.
fn rewind(tile: &Tile, start: u32, count: u32) -> Option<u32> {
    let mut side = start;
    for _ in 0..count {
        match tile.across(side) {
            Across::Hull => return Some(side),
            Across::Elsewhere => return None,
            Across::Side(other) => side = next_side(other),
        }
        if side == start {
            return Some(start);
        }
    }
    None
}

/// A neighbour of the vertex in the middle of a fan.
struct Neighbour {
    corner: u32,
    /// The side that leads to it, unless it comes after the last triangle of a fan on the hull.
    side: Option<u32>,
}

/// The neighbours of the vertex that `first` leaves, counter-clockwise, once round.
fn neighbours(tile: &Tile, first: u32) -> impl Iterator<Item = Neighbour> + '_ {
    let mut next = Some(Ok(first));
    std::iter::from_fn(move || match next? {
        Ok(side) => {
            let arriving = prev_side(side);
            next = match tile.across(arriving) {
                Across::Side(other) if other == first => None,
                Across::Side(other) => Some(Ok(other)),
                Across::Hull | Across::Elsewhere => Some(Err(tile.origin(arriving))),
            };
            Some(Neighbour {
                corner: tile.origin(next_side(side)),
                side: Some(side),
            })
        }
        Err(corner) => {
            next = None;
            Some(Neighbour { corner, side: None })
        }
    })
}

/// Checks that the triangles at a vertex go round once, or on the hull through a half-turn at most.
pub(super) fn check_turn(tile: &Tile, vertex: u32, fans: &Fans) -> Result<Option<HullVertex>, Fault> {
    let Some(first) = fans.first[vertex as usize] else {
        return Ok(None);
    };
    let centre = tile.point(vertex);
    let ring: Vec<_> = neighbours(tile, first).map(|n| tile.vertex(n.corner).point).collect();
    if tile.across(first) != Across::Hull {
        // Each step turns left by less than a half-turn, so a full turn passes the direction of x once.
        let above = |i: usize| ring[i].y > centre.y || (ring[i].y == centre.y && ring[i].x > centre.x);
        let turns = (0..ring.len())
            .filter(|&i| !above(i) && above((i + 1) % ring.len()))
            .count();
        if turns != 1 {
            return Err(Fault::at(
                first / 3,
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
            // The last may lie straight on, on the other side of the vertex.
            Orientation::Collinear => i + 2 == ring.len() && start.lex_cmp(centre) == centre.lex_cmp(p),
            Orientation::Clockwise => false,
        });
    if !convex {
        return Err(Fault::at(
            first / 3,
            format!("the hull is not convex at vertex {vertex}"),
        ));
    }
    Ok(Some(HullVertex {
        is_minimum: centre.lex_cmp(start).is_lt() && centre.lex_cmp(end).is_lt(),
    }))
}
