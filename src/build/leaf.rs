//! Conquers a leaf: its points become the core of a tile and a seam.

use super::constrain::{Crossed, Pending, constrain_leaf};
use super::node::{Fate, Seam, SeamVertex, Workspace};
use super::options::DuplicateRule;
use super::point_store::{Attributes, Item};
use crate::geometry::{MortonSquare, Point, Rect};
use crate::mesh::NONE;
use crate::store::{CoreDraft, TileId, VertexId};

/// A side of a core triangle without another core triangle across: the border may have one.
#[derive(Clone, Copy, Debug)]
pub(super) struct OpenSide {
    pub(super) from: u32,
    pub(super) to: u32,
    pub(super) side: u32,
    pub(super) is_constraint: bool,
}

/// The segments of a build, and those of a leaf among them.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeafSegments<'a> {
    pub(super) all: &'a [[Point; 2]],
    pub(super) its: &'a [u32],
}

/// What a leaf gives beside its core.
#[derive(Debug)]
pub(super) struct Leaf {
    pub(super) open_sides: Vec<OpenSide>,
    pub(super) bounds: Rect,
    pub(super) seam: Seam,
    /// Points that lay on another.
    pub(super) duplicates: u64,
    /// Vertices that are ends of segments only.
    pub(super) ends: u64,
    /// Constraint edges between two triangles of the core.
    pub(super) constraint_edges: u64,
}

/// Of all records of a leaf that lie on an earlier one, the first, and where: its earliest fellow, it, the place.
pub(super) fn first_duplicate(items: &[Item], attributes: &Attributes, first_end: u64) -> Option<([u64; 2], Point)> {
    let places = items.iter().map(|i| (i.point, attributes.record(i.position)));
    let mut places: Vec<(Point, u64)> = places.filter(|(_, record)| *record < first_end).collect();
    places.sort_unstable_by(|a, b| a.0.lex_cmp(b.0).then(a.1.cmp(&b.1)));
    let groups = places.chunk_by(|a, b| a.0 == b.0);
    let second = groups.filter_map(|group| Some(([group[0].1, group.get(1)?.1], group[0].0)));
    second.min_by_key(|(records, _)| (records[1], records[0]))
}

/// Triangulates the points of a leaf. Its core is left in the workspace.
pub(super) fn conquer(
    workspace: &mut Workspace,
    items: &[Item],
    attributes: &Attributes,
    rule: DuplicateRule,
    tile: TileId,
    cell: Rect,
    segments: LeafSegments<'_>,
) -> Result<Leaf, Crossed> {
    let kept = match items {
        // More points at one place than a tile may have vertices: there need not be memory to sort them.
        [first, rest @ ..] if rest.iter().all(|item| { item.point } == { first.point }) => {
            let best = rest.iter().fold(first, |best, item| {
                if precedes(item, best, attributes, rule) {
                    item
                } else {
                    best
                }
            });
            vec![*best]
        }
        _ => merge_duplicates(in_spatial_order(items), attributes, rule),
    };
    let mut core = std::mem::take(&mut workspace.core);
    core.clear();
    core.points.extend(kept.iter().map(|item| item.point));
    core.records
        .extend(kept.iter().map(|item| attributes.record(item.position)));
    if attributes.has_z() {
        core.z.extend(kept.iter().map(|item| attributes.z(item.position)));
    }
    let points = &core.points;
    let (seam_vertices, unsettled) = workspace.run(points, cell, |_| true);
    workspace.constraints.clear();
    let pending = if segments.its.is_empty() {
        Pending::default()
    } else {
        constrain_leaf(workspace, points, segments.all, segments.its, tile, cell == Rect::PLANE)?
    };
    let seam_vertex = |index: u32| SeamVertex {
        id: VertexId { tile, index },
        point: points[index as usize],
    };
    let seam = Seam {
        level: 1,
        below: points.len() as u64,
        unsettled,
        pending,
        vertices: seam_vertices.into_iter().map(seam_vertex).collect(),
    };
    let bounds = Rect::around(points.iter().copied());
    let open_sides = core_triangles(workspace, &mut core);
    let leaf = Leaf {
        bounds,
        open_sides,
        seam,
        duplicates: (items.len() - kept.len()) as u64,
        ends: core.records.iter().filter(|&&record| record >= rule.first_end).count() as u64,
        constraint_edges: constraints_within(&core),
    };
    workspace.core = core;
    Ok(leaf)
}

/// Copies the settled triangles and their adjacency, and notes the sides where it ends.
fn core_triangles(workspace: &Workspace, core: &mut CoreDraft) -> Vec<OpenSide> {
    let (mesh, fates) = (&workspace.mesh, &workspace.fates);
    let mut settled = 0;
    let renumbered: Vec<u32> = fates
        .iter()
        .map(|&fate| {
            let mine = settled;
            settled += u32::from(fate == Fate::Settled);
            if fate == Fate::Settled { mine } else { NONE }
        })
        .collect();
    let mut open_sides = Vec::new();
    for (triangle, fate) in (0u32..).zip(fates) {
        if *fate != Fate::Settled {
            continue;
        }
        let corners = mesh.triangles[triangle as usize];
        let bits = workspace.constraints.get(triangle as usize).copied().unwrap_or(0);
        let sides = [0, 1, 2].map(|s| 3 * triangle + s);
        let neighbours = sides.map(|side| match mesh.twin(side) {
            NONE => NONE,
            twin => match renumbered[(twin / 3) as usize] {
                NONE => NONE,
                other => 3 * other + twin % 3,
            },
        });
        for (s, _) in neighbours.iter().enumerate().filter(|(_, side)| **side == NONE) {
            open_sides.push(OpenSide {
                from: corners[s],
                to: corners[(s + 1) % 3],
                side: 3 * core.triangles.len() as u32 + s as u32,
                is_constraint: bits >> s & 1 == 1,
            });
        }
        if !workspace.constraints.is_empty() {
            core.constraints.push(bits);
        }
        core.triangles.push(corners);
        core.neighbours.push(neighbours);
    }
    open_sides
}

/// Constraint edges with triangles of the core on both sides.
fn constraints_within(core: &CoreDraft) -> u64 {
    let sides = core.neighbours.iter().zip(&core.constraints).zip((0u32..).step_by(3));
    let edges = sides.map(|((neighbours, bits), first)| {
        let twins = (first..).zip(neighbours).zip(0..);
        twins
            .filter(|&((side, &twin), s)| bits >> s & 1 == 1 && twin != NONE && side < twin)
            .count() as u64
    });
    edges.sum()
}

/// The items along a space-filling curve, so that what lies close together stands close together in the tile; items at one
/// place stand side by side.
fn in_spatial_order(items: &[Item]) -> Vec<Item> {
    let square = MortonSquare::around(Rect::around(items.iter().map(|item| item.point)));
    let mask = (items.len() as u64).next_power_of_two() - 1;
    let mut keyed: Vec<u64> = items
        .iter()
        .zip(0u64..)
        .map(|(item, place)| square.key(item.point) & !mask | place)
        .collect();
    keyed.sort_unstable();
    let mut ordered: Vec<Item> = keyed.iter().map(|key| items[(key & mask) as usize]).collect();
    // A cell of the curve may hold several places.
    let mut start = 0;
    for cell in keyed.chunk_by(|a, b| (a ^ b) <= mask) {
        let end = start + cell.len();
        if cell.len() > 1 {
            ordered[start..end].sort_unstable_by(|a, b| { a.point }.lex_cmp(b.point));
        }
        start = end;
    }
    ordered
}

/// One item for each place; items at one place must stand side by side.
fn merge_duplicates(mut items: Vec<Item>, attributes: &Attributes, rule: DuplicateRule) -> Vec<Item> {
    items.dedup_by(|next, kept| {
        let equal = { next.point } == { kept.point };
        if equal && precedes(next, kept, attributes, rule) {
            *kept = *next;
        }
        equal
    });
    items
}

/// Whether `a` is kept rather than `b`.
fn precedes(a: &Item, b: &Item, attributes: &Attributes, rule: DuplicateRule) -> bool {
    let of = |item: &Item| (attributes.z(item.position), attributes.record(item.position));
    rule.prefers(of(a), of(b))
}
