//! The changes of sites, tile by tile.

use std::collections::{BTreeMap, BTreeSet};

use crate::edit::error::EditError;
use crate::edit::held::GoingPoints;
use crate::edit::points::{CallInTile, tile_at};
use crate::edit::sites::call::{SiteCall, SiteCalls};
use crate::edit::summary::SiteCounts;
use crate::edit::tile::NewVertex;
use crate::edit::tiles::Tiles;
use crate::edit::vertex_z::give_z;
use crate::edit::vertices;
use crate::geometry::{Point, VertexIndex};
use crate::input::{MissingZ, SiteId};
use crate::mesh::point_table::PointTable;
use crate::store::{TileId, VertexId};

/// What came of calls.
#[derive(Debug, Default)]
pub(crate) struct ChangedSites {
    pub(crate) counts: SiteCounts,
    /// Number of vertices that were added.
    pub(crate) added_vertices: u64,
    /// The positions of deleted sites, by tile.
    pub(crate) freed: Vec<(TileId, Point)>,
}

/// Carries out the calls of sites. New vertices get record numbers from `first_record` on, by the
/// numbers of their calls. Vertices that nothing holds when a site comes take its z.
pub(crate) fn change(
    tiles: &mut Tiles,
    calls: &SiteCalls,
    missing_z: MissingZ,
    going: &GoingPoints,
    first_record: u64,
    is_stopped: &dyn Fn() -> bool,
) -> Result<ChangedSites, EditError> {
    let mut changed = ChangedSites::default();
    let numbers = calls.all.iter().zip(0u32..);
    let by_tile = numbers.map(|(call, number)| Ok((tile_at(tiles, call.point())?, number)));
    let mut by_tile: Vec<CallInTile> = by_tile.collect::<Result<_, EditError>>()?;
    by_tile.sort_unstable();
    let mut groups = by_tile.chunk_by(|a, b| a.0 == b.0);
    let mut missing: Option<u32> = None;
    let mut without_z: Vec<u32> = Vec::new();
    while let Some(group) = groups.next() {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        tiles.read_ahead(groups.clone().map(|group| group[0].0));
        let new = new_vertices(tiles, calls, group, first_record)?;
        changed.added_vertices += new.len() as u64;
        let needs_z = tiles.metadata().has_z && missing_z != MissingZ::Zero;
        let lacking = new.iter().filter(|(_, vertex)| needs_z && vertex.z.is_nan());
        without_z.extend(lacking.map(|(number, _)| *number));
        let new: Vec<NewVertex> = new.into_iter().map(|(_, vertex)| with_z(vertex)).collect();
        if !new.is_empty() {
            vertices::add(tiles, group[0].0, new)?;
        }
        let first_missing = carry_out(tiles, calls, going, group, &mut changed)?;
        missing = missing.into_iter().chain(first_missing).min();
    }
    if let Some(&number) = without_z.iter().min() {
        return Err(EditError::PointWithoutZ {
            point: calls.all[number as usize].point(),
            count: without_z.len() as u64,
        });
    }
    match missing.filter(|_| !calls.skip_missing) {
        Some(number) => Err(EditError::NoSite {
            point: calls.all[number as usize].point(),
            count: changed.counts.skipped,
        }),
        None => Ok(changed),
    }
}

fn with_z(vertex: NewVertex) -> NewVertex {
    let z = if vertex.z.is_nan() { 0.0 } else { vertex.z };
    NewVertex { z, ..vertex }
}

/// Returns the vertices that sites of a tile need, each with the number of its call. Of several
/// sites at a position, the first one that has z determines that of the vertex. Sites that are
/// deleted later need none.
fn new_vertices(
    tiles: &Tiles,
    calls: &SiteCalls,
    group: &[CallInTile],
    first_record: u64,
) -> Result<Vec<(u32, NewVertex)>, EditError> {
    let tile = tiles.get(group[0].0)?;
    let table = PointTable::for_searches(tile.points(), group.len());
    let mut new: BTreeMap<[u64; 2], (u32, NewVertex)> = BTreeMap::new();
    for &(_, number) in group {
        let call = &calls.all[number as usize];
        let point = call.point();
        let key = point.bits();
        let &SiteCall::Insert(_, z, _) = call else {
            new.remove(&key);
            continue;
        };
        if table.at(point).is_some() {
            continue;
        }
        let vertex = NewVertex {
            point,
            z,
            record: first_record.saturating_add(number.into()),
            is_input_point: false,
        };
        let (_, known) = new.entry(key).or_insert((number, vertex));
        if known.z.is_nan() {
            known.z = z;
        }
    }
    Ok(new.into_values().collect())
}

/// Carries out the calls of one tile, which has all vertices. Returns the first deletion of a site
/// that is not there.
fn carry_out(
    tiles: &mut Tiles,
    calls: &SiteCalls,
    going: &GoingPoints,
    group: &[CallInTile],
    changed: &mut ChangedSites,
) -> Result<Option<u32>, EditError> {
    let id = group[0].0;
    let first_site = tiles.metadata().next_site;
    let tile = tiles.get(id)?;
    let table = PointTable::for_searches(tile.points(), group.len());
    let found = group
        .iter()
        .map(|&(_, number)| table.at(calls.all[number as usize].point()).map(VertexIndex));
    let found: Vec<Option<VertexIndex>> = found.collect();
    drop(tile);
    let mut first_missing = None;
    // Sites that a later call deletes, at positions without a vertex.
    let mut brief: BTreeMap<[u64; 2], u64> = BTreeMap::new();
    let mut without_z: BTreeSet<VertexIndex> = BTreeSet::new();
    for (&(_, number), vertex) in group.iter().zip(found) {
        match (&calls.all[number as usize], vertex) {
            (SiteCall::Insert(_, z, site), Some(vertex)) => {
                renew(
                    tiles,
                    going,
                    VertexId {
                        tile: id,
                        index: vertex,
                    },
                    *z,
                    &mut without_z,
                )?;
                let (site, text) = match site {
                    SiteId::Number(site) => (*site, ""),
                    // As in builds, its place among all sites.
                    SiteId::Text(text) => (first_site.saturating_add(number.into()), text.as_str()),
                };
                tiles.change(id)?.add_site(vertex, site, text);
                changed.counts.inserted += 1;
            }
            (SiteCall::Insert(point, ..), None) => {
                *brief.entry(point.bits()).or_default() += 1;
                changed.counts.inserted += 1;
            }
            (&SiteCall::Delete(point), vertex) => {
                let deleted = match vertex {
                    Some(vertex) if tiles.get(id)?.has_site(vertex) => {
                        changed.freed.push((id, point));
                        tiles.change(id)?.remove_sites(vertex)
                    }
                    Some(_) => 0,
                    None => brief.remove(&point.bits()).unwrap_or(0),
                };
                changed.counts.deleted += deleted;
                if deleted == 0 {
                    changed.counts.skipped += 1;
                    first_missing = first_missing.or(Some(number));
                }
            }
        }
    }
    Ok(first_missing)
}

/// Gives a vertex that nothing holds the z of a new site, the first that has any. `without_z` has the
/// vertices of the tile that only sites without z hold so far.
fn renew(
    tiles: &mut Tiles,
    going: &GoingPoints,
    id: VertexId,
    z: f64,
    without_z: &mut BTreeSet<VertexIndex>,
) -> Result<(), EditError> {
    if !tiles.metadata().has_z {
        return Ok(());
    }
    let vertex = tiles.get(id.tile)?.vertex(id.index);
    if without_z.contains(&id.index) || !going.is_held(tiles, vertex)? {
        if z.is_nan() {
            without_z.insert(id.index);
        } else {
            without_z.remove(&id.index);
            give_z(tiles, id, z)?;
        }
    }
    Ok(())
}
