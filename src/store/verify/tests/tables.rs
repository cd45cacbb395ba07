//! The components of a model's tiles, and their tables, as they should be for the sets of triangles
//! and the labels that the tiles have.

use std::collections::HashMap;

use crate::geometry::{Orientation, Point, orient2d};
use crate::store::format::component_table::{ComponentId, ComponentRecord};
use crate::store::format::digest::triangle_hash;
use crate::store::format::ids::{TileId, VertexId};
use crate::store::verify::tests::model::{Model, ModelTile, Named, pair};

/// The components of a tile.
#[derive(Clone, Default)]
pub(super) struct ModelTable {
    pub(super) of_triangles: HashMap<Named, u32>,
    pub(super) records: Vec<ComponentRecord>,
}

/// Returns the components of each tile.
pub(super) fn tables(model: &Model) -> Vec<ModelTable> {
    let has_regions = model.directory.metadata.regions > 0;
    let of_tile = |tile| {
        if has_regions {
            components(tile)
        } else {
            one_component(tile)
        }
    };
    let mut tables: Vec<ModelTable> = model.tiles.iter().map(of_tile).collect();
    for id in (0..model.tiles.len() as u32).map(TileId) {
        let tile = &model.tiles[id.0 as usize];
        let on_the_left = on_the_left(tile);
        for t in tile.core.iter().chain(&tile.border) {
            let corners = t.map(|v| (point(model, tile, v), v.tile));
            let owner = corners.iter().min_by(|a, b| a.0.lex_cmp(b.0)).unwrap().1;
            let number = tables[id.0 as usize].of_triangles[t];
            let at_owner = tables.get(owner.0 as usize);
            let at_owner = at_owner.and_then(|table| table.of_triangles.get(t).copied());
            let record = &mut tables[id.0 as usize].records[number as usize];
            let points = corners.map(|(point, _)| point);
            if owner == id {
                record.triangles.add_hash(triangle_hash(points));
            } else {
                let number = at_owner.unwrap_or(0);
                record.links.push(ComponentId { tile: owner, number });
            }
            describe(model, id, &on_the_left, (t, points), record);
        }
    }
    for record in tables.iter_mut().flat_map(|table| &mut table.records) {
        record.links.sort_unstable();
        record.links.dedup();
    }
    tables
}

/// Returns the point at which a tile stores a vertex.
fn point(model: &Model, tile: &ModelTile, v: VertexId) -> Point {
    let owner = model.tiles.get(v.tile.0 as usize);
    let right = owner.and_then(|owner| owner.points.get(v.index.index()));
    let stored = tile.beliefs.get(&v).or(right);
    stored.copied().unwrap_or(Point::new(0.0, 0.0))
}

/// Returns the component of all triangles of a tile in a file without regions.
fn one_component(tile: &ModelTile) -> ModelTable {
    let record = ComponentRecord {
        component: tile.labels.values().next().copied().unwrap_or_default(),
        ..ComponentRecord::default()
    };
    ModelTable {
        of_triangles: tile.core.iter().chain(&tile.border).map(|t| (*t, 0)).collect(),
        records: vec![record],
    }
}

fn half_edges(t: &Named) -> [[VertexId; 2]; 3] {
    [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]
}

/// Returns the triangle on the left of each half-edge of a tile.
fn on_the_left(tile: &ModelTile) -> HashMap<[VertexId; 2], Named> {
    let all = tile.core.iter().chain(&tile.border);
    all.flat_map(|t| half_edges(t).map(|half_edge| (half_edge, *t)))
        .collect()
}

/// Numbers the components: triangles that are connected without crossing a constraint, and have the
/// same label.
fn components(tile: &ModelTile) -> ModelTable {
    let on_the_left = on_the_left(tile);
    let mut table = ModelTable::default();
    let label = |t: &Named| tile.labels.get(t).copied().unwrap_or_default();
    for first in tile.core.iter().chain(&tile.border) {
        if table.of_triangles.contains_key(first) {
            continue;
        }
        let number = table.records.len() as u32;
        table.records.push(ComponentRecord {
            component: label(first),
            ..ComponentRecord::default()
        });
        let mut left = vec![*first];
        while let Some(t) = left.pop() {
            if table.of_triangles.insert(t, number).is_some() {
                continue;
            }
            for [a, b] in half_edges(&t)
                .into_iter()
                .filter(|&[a, b]| !tile.constraints.contains(&pair(a, b)))
            {
                let other = on_the_left.get(&[b, a]);
                left.extend(
                    other.filter(|other| label(other) == label(first) && !table.of_triangles.contains_key(*other)),
                );
            }
        }
    }
    if table.records.is_empty() {
        table.records.push(ComponentRecord::default());
    }
    table
}

/// Adds what a triangle says of its component. `on_the_left` has the triangles of the tile.
fn describe(
    model: &Model,
    id: TileId,
    on_the_left: &HashMap<[VertexId; 2], Named>,
    (t, [a, b, c]): (&Named, [Point; 3]),
    record: &mut ComponentRecord,
) {
    let has_seed = |seed: &Point| {
        let is_beside = |[from, to]: [Point; 2]| orient2d(from, to, seed.normalized()) == Orientation::Clockwise;
        ![[a, b], [b, c], [c, a]].into_iter().any(is_beside)
    };
    record.is_seeded |= model.directory.lists.hole_points.iter().any(has_seed);
    for [a, b] in half_edges(t) {
        // The other triangle at an edge of a vertex of the tile is in the tile.
        let is_hull = !on_the_left.contains_key(&[b, a]) && (a.tile == id || b.tile == id);
        if is_hull {
            record.is_at_hull = true;
            record.is_open |= !model.tiles[id.0 as usize].constraints.contains(&pair(a, b));
        }
    }
}
