//! What the component table of a tile says of each of its components.

use std::collections::HashMap;

use crate::pipeline::finish::border_mesh::BorderMesh;
use crate::pipeline::finish::regions::Regions;
use crate::pipeline::finish::tile_components::TileComponents;
use crate::pipeline::output::border_log::GroupBorders;
use crate::store::{Component, ComponentId, ComponentRecord, DigestSum, TileId, triangle_hash};

/// The components of a core: their regions, and their triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CoreRecords<'a> {
    pub(crate) regions: &'a [Component],
    pub(crate) triangles: &'a [DigestSum],
}

/// Returns the records of a tile's components. Without `regions`, the tile is one component of
/// region 0.
pub(crate) fn component_records(
    tile: TileId,
    components: &TileComponents,
    mesh: &BorderMesh,
    group: &GroupBorders,
    regions: Option<&Regions>,
    core: CoreRecords<'_>,
) -> Vec<ComponentRecord> {
    let mut records = vec![ComponentRecord::default(); components.count()];
    for (record, &component) in records.iter_mut().zip(core.regions) {
        record.component = component;
    }
    for (record, &triangles) in records.iter_mut().zip(core.triangles) {
        record.triangles = triangles;
    }
    for (late, &component) in mesh.late.iter().zip(&components.of_late) {
        let record = &mut records[component as usize];
        if let Some(regions) = regions {
            record.component = regions.of_late(late.number);
            record.is_seeded |= regions.is_seeded(late.number);
        }
        let number = regions.map_or(0, |regions| regions.component_at_owner(late.number));
        let link = ComponentId {
            tile: late.owner,
            number,
        };
        // Adjacent triangles mostly have the same link.
        if late.owner != tile && record.links.last() != Some(&link) {
            record.links.push(link);
        }
    }
    add_late_sums(tile, components, mesh, group, &mut records);
    for on_edge in mesh.edges() {
        if let [one] = on_edge
            && mesh.is_hull(one)
        {
            let component = mesh
                .late_within(one)
                .map_or_else(|core| core, |late| components.of_late[late]);
            let record = &mut records[component as usize];
            record.is_at_hull = true;
            record.is_open |= !mesh.is_constraint(one);
        }
    }
    for (record, (&number, own)) in records.iter_mut().zip(components.first.iter().zip(0..)) {
        if number != own {
            record.links.push(ComponentId { tile, number });
        }
        record.links.sort_unstable();
        record.links.dedup();
    }
    records
}

/// Adds the late triangles that belong to the tile to the sums of their components.
fn add_late_sums(
    tile: TileId,
    components: &TileComponents,
    mesh: &BorderMesh,
    group: &GroupBorders,
    records: &mut [ComponentRecord],
) {
    if let [record] = records {
        record.triangles += mesh.owned;
        return;
    }
    let owned = mesh.late.iter().zip(&components.of_late);
    let owned = owned.filter(|(late, _)| mesh.owns(late));
    let components: HashMap<u32, u32> = owned.map(|(late, &component)| (late.number, component)).collect();
    for late in group.triangles_of(tile) {
        if let Some(&component) = components.get(&late.number) {
            let hash = triangle_hash(late.corners.map(|corner| corner.point));
            records[component as usize].triangles.add_hash(hash);
        }
    }
}
