//! Puts a tile's border together from its late triangles and the open sides of its core.

use super::border_log::LateTriangle;
use super::leaf::OpenSide;
use super::node::SeamVertex;
use crate::geometry::Rect;
use crate::store::{BorderDraft, ELSEWHERE, HULL, TileId};

/// A border, and what it adds to the tile's entry.
#[derive(Debug)]
pub(super) struct Border {
    pub(super) draft: BorderDraft,
    /// Its triangles that belong to the tile.
    pub(super) owned: u32,
    /// Around the corners of these.
    pub(super) bounds: Rect,
    /// Constraint edges that belong to the tile, but for those between two triangles of the core.
    pub(super) constraint_edges: u64,
}

/// A side of a core or border triangle, by the edge it lies on.
struct EdgeSide {
    /// Corners, the smaller first.
    edge: (u32, u32),
    side: u32,
}

/// Joins the late triangles of a tile to each other and to its core.
///
/// The result does not depend on the order of the triangles.
pub(super) fn assemble(
    tile: TileId,
    vertices: u32,
    core_triangles: u32,
    open_sides: &[OpenSide],
    late: impl Iterator<Item = LateTriangle>,
) -> Border {
    let late: Vec<LateTriangle> = late.collect();
    let corners = late.iter().flat_map(|t| t.corners);
    let mut foreign: Vec<SeamVertex> = corners.filter(|v| v.id.tile != tile).collect();
    foreign.sort_unstable_by_key(|v| v.id);
    foreign.dedup_by_key(|v| v.id);
    let corner = |v: &SeamVertex| match foreign.binary_search_by_key(&v.id, |f| f.id) {
        Ok(place) => vertices + place as u32,
        Err(_) => v.id.index,
    };
    let (mut owned, mut bounds) = (0, Rect::EMPTY);
    let mut with_constraints = Vec::with_capacity(late.len());
    for LateTriangle { corners, constraints } in &late {
        let mut sides = [0, 1, 2].map(|s| {
            let [from, to] = [corners[s], corners[(s + 1) % 3]];
            let first = if from.point.lex_cmp(to.point).is_lt() { from } else { to };
            (corner(&from), constraints >> s & 1, first.id.tile == tile)
        });
        while sides[0].0 > sides[1].0 || sides[0].0 > sides[2].0 {
            sides.rotate_left(1);
        }
        with_constraints.push(sides);
        let smallest = corners.iter().min_by(|a, b| a.point.lex_cmp(b.point));
        if smallest.is_some_and(|v| v.id.tile == tile) {
            owned += 1;
            bounds = bounds.union(Rect::around(corners.map(|v| v.point)));
        }
    }
    with_constraints.sort_unstable();
    let triangles: Vec<[u32; 3]> = with_constraints.iter().map(|t| t.map(|(corner, ..)| corner)).collect();
    let bits = with_constraints.iter().map(|t| t[0].1 | t[1].1 << 1 | t[2].1 << 2);

    let own = open_sides.iter().filter(|side| side.is_constraint);
    let mut own_constraints: Vec<(u32, u32)> = own.map(|side| edge(side.from, side.to)).collect();
    for sides in &with_constraints {
        for (s, &(from, bit, is_own)) in sides.iter().enumerate() {
            if bit == 1 && is_own {
                own_constraints.push(edge(from, sides[(s + 1) % 3].0));
            }
        }
    }
    own_constraints.sort_unstable();
    own_constraints.dedup();

    let core_sides = 3 * core_triangles;
    let (neighbours, core_links) = link(&triangles, vertices, core_sides, open_sides);
    Border {
        draft: BorderDraft {
            vertices,
            core_triangles,
            vertex_sides: vertex_sides(&triangles, vertices, core_sides, open_sides),
            foreign: foreign.iter().map(|v| (v.id, v.point)).collect(),
            triangles,
            neighbours,
            core_links,
            constraints: bits.collect(),
        },
        owned,
        bounds,
        constraint_edges: own_constraints.len() as u64,
    }
}

/// The corners of an edge, the smaller first.
fn edge(from: u32, to: u32) -> (u32, u32) {
    (from.min(to), from.max(to))
}

/// The sides across those of the border's triangles, and the pairs of core and border sides.
fn link(
    triangles: &[[u32; 3]],
    vertices: u32,
    core_sides: u32,
    open_sides: &[OpenSide],
) -> (Vec<[u64; 3]>, Vec<(u32, u32)>) {
    let on = |from: u32, to: u32, side| EdgeSide {
        edge: edge(from, to),
        side,
    };
    let mut sides: Vec<EdgeSide> = open_sides.iter().map(|o| on(o.from, o.to, o.side)).collect();
    for (&[a, b, c], first) in triangles.iter().zip((core_sides..).step_by(3)) {
        sides.extend([on(a, b, first), on(b, c, first + 1), on(c, a, first + 2)]);
    }
    sides.sort_unstable_by_key(|s| (s.edge, s.side));
    let mut neighbours = vec![[HULL; 3]; triangles.len()];
    let mut core_links = Vec::new();
    let mut set = |side: u32, value: u64| {
        if let Some(side) = side.checked_sub(core_sides) {
            neighbours[(side / 3) as usize][(side % 3) as usize] = value;
        }
    };
    for pair in sides.chunk_by(|a, b| a.edge == b.edge) {
        match pair {
            [one, other] => {
                set(one.side, other.side.into());
                set(other.side, one.side.into());
                if one.side < core_sides {
                    core_links.push((one.side, other.side));
                }
            }
            // Both ends belong to other tiles, and so does the triangle across, if there is one.
            [one] if one.edge.0 >= vertices => set(one.side, ELSEWHERE),
            // An end is ours, so a triangle across would be here: the side is on the hull.
            _ => debug_assert_eq!(pair.len(), 1),
        }
    }
    core_links.sort_unstable();
    (neighbours, core_links)
}

/// A leaving side for each vertex of the tile that is a corner of the border but not of the core.
fn vertex_sides(triangles: &[[u32; 3]], vertices: u32, core_sides: u32, open_sides: &[OpenSide]) -> Vec<(u32, u32)> {
    // Where the star of a vertex lies partly in the core, an open side ends its core part.
    let mut in_core: Vec<u32> = open_sides.iter().flat_map(|o| [o.from, o.to]).collect();
    in_core.sort_unstable();
    let corners = triangles.as_flattened().iter().zip(core_sides..);
    let mut sides: Vec<(u32, u32)> = corners
        .filter(|(corner, _)| **corner < vertices && in_core.binary_search(corner).is_err())
        .map(|(&corner, side)| (corner, side))
        .collect();
    sides.sort_unstable();
    sides.dedup_by_key(|s| s.0);
    sides
}
