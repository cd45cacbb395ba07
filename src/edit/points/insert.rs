//! Points that come to be, and points that get other attributes.

use std::ops::AddAssign;

use crate::edit::error::EditError;
use crate::edit::points::call::CallInTile;
use crate::edit::points::calls::PointCalls;
use crate::edit::points::net::{Attributes, Change, Missing, net_changes, tile_at};
use crate::edit::summary::PointCounts;
use crate::edit::tile::NewVertex;
use crate::edit::tiles::Tiles;
use crate::edit::vertex_z::give_z;
use crate::edit::vertices;
use crate::geometry::{Point, VertexIndex};
use crate::mesh::point_table::PointTable;
use crate::store::{TileId, VertexId};

/// What came of calls.
#[derive(Debug, Default)]
pub(crate) struct Inserted {
    pub(crate) counts: PointCounts,
    /// Number of vertices that had no point before.
    pub(crate) taken_over: u64,
    /// Number of constraint edges that new vertices split.
    pub(crate) split: u64,
    /// The points that go, by tile.
    pub(crate) delete: Vec<(TileId, Point)>,
    /// The calls whose points are not there.
    pub(crate) missing: Missing,
}

impl AddAssign for Inserted {
    fn add_assign(&mut self, other: Self) {
        self.counts += other.counts;
        self.taken_over += other.taken_over;
        self.split += other.split;
        self.delete.extend(other.delete);
        self.missing.add(other.missing);
    }
}

/// Carries out the calls in memory, except that points which go stay for now.
pub(crate) fn insert(
    tiles: &mut Tiles,
    calls: &PointCalls,
    is_stopped: &dyn Fn() -> bool,
) -> Result<Inserted, EditError> {
    let numbers = calls.all.iter().zip(0u32..);
    let by_tile = numbers.map(|(call, number)| Ok((tile_at(tiles, call.position())?, number)));
    let mut by_tile: Vec<CallInTile> = by_tile.collect::<Result<_, EditError>>()?;
    // Without moves, each call concerns one tile only. Moves lead from one to another in their order.
    let is_apart = !calls.has_moves();
    if is_apart {
        by_tile.sort_unstable();
    }
    let mut done = Inserted::default();
    let mut groups = by_tile.chunk_by(|a, b| !is_apart || a.0 == b.0);
    while let Some(group) = groups.next() {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        tiles.read_ahead(groups.clone().map(|group| group[0].0).filter(|_| is_apart));
        let net = net_changes(tiles, calls, group)?;
        done.counts += net.counts;
        done.delete.extend(net.delete);
        done.missing.add(net.missing);
        for changes in net.put.chunk_by(|a, b| a.tile == b.tile) {
            let (taken_over, split) = put(tiles, changes)?;
            done.taken_over += taken_over;
            done.split += split;
        }
    }
    Ok(done)
}

/// Makes points lie at positions in one tile. Returns the number of vertices that had no point
/// before, and the number of constraint edges that were split.
fn put(tiles: &mut Tiles, changes: &[Change]) -> Result<(u64, u64), EditError> {
    let id = changes[0].tile;
    let tile = tiles.get(id)?;
    let table = PointTable::for_searches(tile.points(), changes.len());
    let (mut new, mut there) = (Vec::new(), Vec::new());
    for &Change { point, after, .. } in changes {
        match table.at(point).map(VertexIndex) {
            Some(index) => there.push((index, after, tile.is_input_point(index))),
            None => new.push(NewVertex {
                point,
                z: after.z,
                record: after.record,
                is_input_point: true,
            }),
        }
    }
    drop(tile);
    let mut taken_over = 0;
    for (index, after, is_input_point) in there {
        taken_over += u64::from(!is_input_point);
        give(tiles, VertexId { tile: id, index }, after)?;
    }
    let split = match new.is_empty() {
        true => 0,
        false => vertices::add(tiles, id, new)?,
    };
    Ok((taken_over, split))
}

/// Makes a point with these attributes lie at a vertex.
fn give(tiles: &mut Tiles, id: VertexId, Attributes { z, record }: Attributes) -> Result<(), EditError> {
    let mut tile = tiles.change(id.tile)?;
    tile.set_input_point(id.index, true);
    tile.set_record(id.index, record);
    drop(tile);
    give_z(tiles, id, z)
}
