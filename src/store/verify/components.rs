//! Checks of component tables.
//!
//! In each tile, triangles that no constraint separates must be of one component, or of linked
//! ones. If the tile has constraints, the triangles of a component must be connected with each
//! other within the tile, and so must linked components. The flags and the sums must be those of
//! the component's triangles; what makes a region a hole is checked by `regions`.
//!
//! A component's links to other tiles say which components of these have its triangles. For each
//! pair of tiles, one adds up hashes of what it has, and the other of what it expects, and both
//! sums must be equal. A component that is linked to several components of one tile does not say
//! which of its triangles each has. Such pairs are returned, to be compared triangle by triangle.

use std::collections::{BTreeSet, HashMap};

use xxhash_rust::xxh3::xxh3_128;

use crate::collections::union_find::UnionFind;
use crate::geometry::{HalfEdge, TriangleId};
use crate::mesh::{Topology, Twin};
use crate::store::format::component_table::{ComponentId, ComponentRecord};
use crate::store::format::digest::triangle_hash;
use crate::store::format::ids::TileId;
use crate::store::format::tile::Tile;
use crate::store::verify::error::Fault;
use crate::store::verify::tile::{others_with, owner};

/// A tile that owns triangles, and another one that shares them.
pub(super) type Pair = (TileId, TileId);

/// Bytes that the check takes per vertex of its tile: a set for each triangle.
pub(super) const BYTES_PER_VERTEX: u64 = 8 + size_of::<ComponentRecord>() as u64;

/// The contribution of a tile to the checks of links between tiles.
#[derive(Default)]
pub(super) struct LinkReport {
    /// For each pair of tiles, the sum of hashes of the triangles owned less those shared, with the
    /// component of each in the tile that owns it.
    pub(super) sums: HashMap<Pair, u128>,
    /// Pairs that the sums do not check.
    pub(super) ambiguous: Vec<Pair>,
}

/// Checks the component table of a tile. Without regions, there are no constraints, or they are not
/// known to separate anything.
pub(super) fn check(tile: &Tile, has_regions: bool) -> Result<LinkReport, Fault> {
    let records = tile.component_records();
    if records.is_empty() {
        return match tile.triangle_count() {
            0 => Ok(LinkReport::default()),
            _ => Err(Fault::new("it has no component table")),
        };
    }
    for (record, number) in records.iter().zip(0u32..) {
        let is_self = |link: &ComponentId| link.tile == tile.id() && link.number >= number;
        if !record.links.is_sorted_by(|a, b| a < b) || record.links.iter().any(is_self) {
            return Err(Fault::new(format!(
                "the links of component {number} are not in order, or not to an earlier one"
            )));
        }
    }
    check_content(tile, &records)?;
    if has_regions {
        check_connections(tile, &records)?;
    }
    links(tile, &records)
}

/// Checks the sums of the triangles, and whether components are at the hull.
fn check_content(tile: &Tile, records: &[ComponentRecord]) -> Result<(), Fault> {
    let mut found = vec![ComponentRecord::default(); records.len()];
    for triangle in tile.triangle_ids() {
        let record = &mut found[tile.component_number(triangle) as usize];
        if tile.owns(triangle) {
            record.triangles.add_hash(triangle_hash(tile.triangle_points(triangle)));
        }
        for half_edge in HalfEdge::of_triangle(triangle) {
            if tile.twin(half_edge) == Twin::Hull {
                record.is_at_hull = true;
                record.is_open |= !tile.is_constraint(half_edge);
            }
        }
    }
    for ((found, stored), number) in found.iter().zip(records).zip(0u32..) {
        let of = |record: &ComponentRecord| (record.triangles, record.is_open, record.is_at_hull);
        if of(found) != of(stored) {
            return Err(Fault::new(format!(
                "the component table says that component {number} has {} triangles, sum {:032x}, open: {}, at the hull: {}; but these are {}, {:032x}, {}, {}",
                stored.triangles.count,
                stored.triangles.sum,
                stored.is_open,
                stored.is_at_hull,
                found.triangles.count,
                found.triangles.sum,
                found.is_open,
                found.is_at_hull,
            )));
        }
    }
    Ok(())
}

/// Checks that components, and links within the tile, are what is connected within the tile.
fn check_connections(tile: &Tile, records: &[ComponentRecord]) -> Result<(), Fault> {
    let mut linked = UnionFind::new(records.len() as u32);
    for (record, number) in records.iter().zip(0..) {
        for link in record.links.iter().filter(|link| link.tile == tile.id()) {
            linked.union(number, link.number);
        }
    }
    check_first(tile, records, &mut linked)?;
    let mut connected = UnionFind::new(tile.triangle_count());
    let mut has_constraints = false;
    for half_edge in tile.half_edges() {
        has_constraints |= tile.is_constraint(half_edge);
        let Twin::HalfEdge(twin) = tile.twin(half_edge) else {
            continue;
        };
        if half_edge > twin || tile.is_constraint(half_edge) {
            continue;
        }
        let triangles = [half_edge, twin].map(HalfEdge::triangle);
        connected.union(triangles[0].0, triangles[1].0);
        let components = triangles.map(|triangle| tile.component_number(triangle));
        if linked.find(components[0]) != linked.find(components[1]) {
            let [triangle, other] = triangles;
            return Err(Fault::at(
                triangle,
                format!(
                    "no constraint separates it from triangle {other}, but their components {} and {} are not linked",
                    components[0], components[1]
                ),
            ));
        }
    }
    if !has_constraints {
        return Ok(());
    }
    let mut set_of: HashMap<u32, u32> = HashMap::new();
    for triangle in tile.triangle_ids() {
        let set = connected.find(triangle.0);
        let of_linked = linked.find(tile.component_number(triangle));
        if *set_of.entry(of_linked).or_insert(set) != set {
            return Err(Fault::at(
                triangle,
                format!(
                    "it is not connected within the tile with others of its component {}, or of one that this is linked with",
                    tile.component_number(triangle)
                ),
            ));
        }
    }
    Ok(())
}

/// Checks that each component has a link within the tile to the first of those that it is `linked`
/// with, unless it is that one.
fn check_first(tile: &Tile, records: &[ComponentRecord], linked: &mut UnionFind) -> Result<(), Fault> {
    let mut first_of: HashMap<u32, u32> = HashMap::new();
    for (record, number) in records.iter().zip(0..) {
        let first = *first_of.entry(linked.find(number)).or_insert(number);
        let within = record.links.iter().filter(|link| link.tile == tile.id());
        let expected = (first != number).then_some(first);
        if !within.map(|link| link.number).eq(expected) {
            return Err(Fault::new(format!(
                "component {number} is not linked to the first one that it is connected with within the tile, or to others too"
            )));
        }
    }
    Ok(())
}

/// Returns the sums over the triangles that the tile shares with others.
fn links(tile: &Tile, records: &[ComponentRecord]) -> Result<LinkReport, Fault> {
    let mut report = LinkReport::default();
    let mut is_used: BTreeSet<(u32, TileId)> = BTreeSet::new();
    let mut ambiguous: BTreeSet<Pair> = BTreeSet::new();
    for triangle in tile.border_triangle_ids() {
        let (component, owner) = (tile.component_number(triangle), owner(tile, triangle));
        if owner == tile.id() {
            let hash = hash(tile, triangle, component);
            for other in others_with(tile, triangle) {
                let sum = report.sums.entry((owner, other)).or_default();
                *sum = sum.wrapping_add(hash);
            }
            continue;
        }
        let links = &records[component as usize].links;
        let mut to_owner = links.iter().filter(|link| link.tile == owner);
        let Some(link) = to_owner.next() else {
            let reason = format!("its component {component} is not linked to tile {owner}, which owns it");
            return Err(Fault::at(triangle, reason));
        };
        is_used.insert((component, owner));
        if to_owner.next().is_some() {
            ambiguous.insert((owner, tile.id()));
            continue;
        }
        let sum = report.sums.entry((owner, tile.id())).or_default();
        *sum = sum.wrapping_sub(hash(tile, triangle, link.number));
    }
    for (record, number) in records.iter().zip(0..) {
        let unused = |link: &&ComponentId| link.tile != tile.id() && !is_used.contains(&(number, link.tile));
        if let Some(link) = record.links.iter().find(unused) {
            return Err(Fault::new(format!(
                "component {number} is linked to tile {}, which owns none of its triangles",
                link.tile
            )));
        }
    }
    report.ambiguous = ambiguous.into_iter().collect();
    Ok(report)
}

/// Checks the links of a tile to one that owns triangles of it, triangle by triangle.
pub(super) fn check_pair(owning: &Tile, sharing: &Tile) -> Result<(), Fault> {
    let shared = |tile: &Tile| -> Vec<TriangleId> {
        let all = tile.border_triangle_ids();
        all.filter(|&triangle| owner(tile, triangle) == owning.id()).collect()
    };
    let number_of = |tile: &Tile, triangle| (hash(tile, triangle, 0), tile.component_number(triangle));
    let of_owner: HashMap<u128, u32> = shared(owning).into_iter().map(|t| number_of(owning, t)).collect();
    let mut found: BTreeSet<(u32, u32)> = BTreeSet::new();
    for triangle in shared(sharing) {
        let (key, component) = number_of(sharing, triangle);
        // A triangle that the owner lacks is reported elsewhere.
        if let Some(&at_owner) = of_owner.get(&key) {
            found.insert((component, at_owner));
        }
    }
    let records = sharing.component_records();
    let stored = records.iter().zip(0..).flat_map(|(record, number)| {
        let links = record.links.iter().filter(|link| link.tile == owning.id());
        links.map(move |link| (number, link.number))
    });
    let stored: BTreeSet<(u32, u32)> = stored.collect();
    match found.symmetric_difference(&stored).next() {
        None => Ok(()),
        Some((component, other)) => Err(Fault::new(format!(
            "its component {component} and component {other} of tile {} are linked, but share no triangle, or the other way round",
            owning.id()
        ))),
    }
}

/// Returns a hash of the points of a triangle, and of a component.
fn hash(tile: &Tile, triangle: TriangleId, component: u32) -> u128 {
    let of_points = triangle_hash(tile.triangle_points(triangle));
    let mut bytes = [0; 20];
    bytes[..16].copy_from_slice(&of_points.to_le_bytes());
    bytes[16..].copy_from_slice(&component.to_le_bytes());
    xxh3_128(&bytes)
}
