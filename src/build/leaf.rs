//! Conquers a leaf: its points become the core of a tile and a seam.

use super::node::{Fate, Seam, SeamVertex, Workspace};
use super::options::{BuildOptions, Duplicates};
use super::point_store::{Attributes, Item};
use crate::geometry::{Point, Rect};
use crate::mesh::{NONE, next_side};
use crate::store::{CoreDraft, TileId, VertexId};

/// A side of a core triangle without another core triangle across: the border may have one.
#[derive(Clone, Copy, Debug)]
pub(super) struct OpenSide {
    pub(super) from: u32,
    pub(super) to: u32,
    pub(super) side: u32,
}

/// What a leaf gives.
#[derive(Debug)]
pub(super) struct Leaf {
    pub(super) core: CoreDraft,
    pub(super) open_sides: Vec<OpenSide>,
    pub(super) bounds: Rect,
    pub(super) seam: Seam,
    /// Points that lay on another.
    pub(super) duplicates: u64,
}

/// There are two records at one place, where that is an error.
#[derive(Clone, Copy, Debug)]
pub(super) struct DuplicateFound;

/// Of all records of a leaf that lie on an earlier one, the first, and where: its earliest fellow, it, the place.
pub(super) fn first_duplicate(items: &[Item], attributes: &Attributes) -> Option<([u64; 2], Point)> {
    let mut places: Vec<(Point, u64)> = items.iter().map(|i| (i.point, attributes.record(i.position))).collect();
    places.sort_unstable_by(|a, b| a.0.lex_cmp(b.0).then(a.1.cmp(&b.1)));
    let groups = places.chunk_by(|a, b| a.0 == b.0);
    let second = groups.filter_map(|group| Some(([group[0].1, group.get(1)?.1], group[0].0)));
    second.min_by_key(|(records, _)| (records[1], records[0]))
}

/// Triangulates the points of a leaf.
pub(super) fn conquer(
    workspace: &mut Workspace,
    items: &[Item],
    attributes: &Attributes,
    duplicates: Duplicates,
    tile: TileId,
    cell: Rect,
) -> Result<Leaf, DuplicateFound> {
    let kept = merge_duplicates(items, attributes, duplicates)?;
    let points: Vec<Point> = kept.iter().map(|item| item.point).collect();
    let (seam_vertices, unsettled) = workspace.run(&points, cell, |_| true);
    let number = numbered_by_appearance(&workspace.mesh.triangles, points.len());

    let mut core = CoreDraft {
        points: vec![Point::default(); points.len()],
        z: vec![0.0; if attributes.has_z() { points.len() } else { 0 }],
        records: vec![0; points.len()],
        ..CoreDraft::default()
    };
    for (item, &number) in kept.iter().zip(&number) {
        let number = number as usize;
        core.points[number] = item.point;
        core.records[number] = attributes.record(item.position);
        if attributes.has_z() {
            core.z[number] = attributes.z(item.position);
        }
    }
    let open_sides = core_triangles(workspace, &number, &mut core);

    let mut seam = Seam {
        level: 1,
        unsettled,
        vertices: seam_vertices
            .iter()
            .map(|&v| SeamVertex {
                id: VertexId {
                    tile,
                    index: number[v as usize],
                },
                point: points[v as usize],
            })
            .collect(),
    };
    seam.sort();
    Ok(Leaf {
        bounds: Rect::around(points),
        core,
        open_sides,
        seam,
        duplicates: (items.len() - kept.len()) as u64,
    })
}

/// Copies the settled triangles and their adjacency, and notes the sides where it ends.
fn core_triangles(workspace: &Workspace, number: &[u32], core: &mut CoreDraft) -> Vec<OpenSide> {
    let (mesh, fates) = (&workspace.mesh, &workspace.settled);
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
        let corners = mesh.triangles[triangle as usize].map(|v| number[v as usize]);
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
                to: number[mesh.origin(next_side(sides[s])) as usize],
                side: 3 * core.triangles.len() as u32 + s as u32,
            });
        }
        core.triangles.push(corners);
        core.neighbours.push(neighbours);
    }
    open_sides
}

/// Numbers vertices as the triangles mention them: engines emit neighbours together, so the numbers keep them together.
fn numbered_by_appearance(triangles: &[[u32; 3]], vertices: usize) -> Vec<u32> {
    let mut number = vec![NONE; vertices];
    let mut next = 0;
    let mut name = |vertex: usize| {
        if number[vertex] == NONE {
            number[vertex] = next;
            next += 1;
        }
    };
    triangles
        .as_flattened()
        .iter()
        .for_each(|&vertex| name(vertex as usize));
    // Without triangles, all are left.
    (0..vertices).for_each(name);
    number
}

/// One item for each place, in the order in which places come first.
fn merge_duplicates(items: &[Item], attributes: &Attributes, rule: Duplicates) -> Result<Vec<Item>, DuplicateFound> {
    const EMPTY: u32 = u32::MAX;
    // A leaf that is fuller than the largest tile has all its points at one place.
    let places = items.len().min(BuildOptions::MAX_TILE_VERTICES);
    let mut kept: Vec<Item> = Vec::with_capacity(places);
    let mut table = vec![EMPTY; (2 * places).next_power_of_two().max(2)];
    let shift = 64 - table.len().trailing_zeros();
    let mask = table.len() - 1;
    for item in items {
        // Fibonacci hashing of both coordinates' bits.
        let bits = item.point.x.to_bits().rotate_left(32) ^ item.point.y.to_bits().wrapping_mul(0xff51_afd7_ed55_8ccd);
        let mut slot = (bits.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> shift) as usize;
        loop {
            match table[slot] {
                EMPTY => {
                    table[slot] = kept.len() as u32;
                    kept.push(*item);
                    break;
                }
                found if { kept[found as usize].point } == { item.point } => {
                    let known = &mut kept[found as usize];
                    if rule == Duplicates::Error {
                        return Err(DuplicateFound);
                    }
                    if precedes(item, known, attributes, rule) {
                        *known = *item;
                    }
                    break;
                }
                _ => slot = (slot + 1) & mask,
            }
        }
    }
    Ok(kept)
}

/// Whether `a` is kept rather than `b`.
fn precedes(a: &Item, b: &Item, attributes: &Attributes, rule: Duplicates) -> bool {
    let z = |item: &Item| attributes.z(item.position);
    let by_z = match rule {
        Duplicates::First | Duplicates::Error => std::cmp::Ordering::Equal,
        Duplicates::Lowest => z(a).total_cmp(&z(b)),
        Duplicates::Highest => z(b).total_cmp(&z(a)),
    };
    by_z.then_with(|| attributes.record(a.position).cmp(&attributes.record(b.position)))
        .is_lt()
}

impl Seam {
    /// Brings the vertices into the order of their numbers.
    fn sort(&mut self) {
        let mut order: Vec<u32> = (0..self.vertices.len() as u32).collect();
        order.sort_unstable_by_key(|&v| self.vertices[v as usize].id);
        let mut place = vec![0; order.len()];
        for (&vertex, new) in order.iter().zip(0..) {
            place[vertex as usize] = new;
        }
        self.vertices = order.iter().map(|&v| self.vertices[v as usize]).collect();
        for triangle in &mut self.unsettled {
            *triangle = crate::mesh::smallest_first(triangle.map(|v| place[v as usize]));
        }
        self.unsettled.sort_unstable();
    }
}
