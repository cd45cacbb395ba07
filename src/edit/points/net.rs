//! The net effect of calls: the point at each position, before and after.

use foldhash::HashMap;

use crate::edit::error::EditError;
use crate::edit::points::call::{CallInTile, PointCall, PointCalls};
use crate::edit::summary::PointCounts;
use crate::edit::tiles::Tiles;
use crate::geometry::{Point, VertexIndex};
use crate::mesh::point_table::PointTable;
use crate::store::TileId;

/// What a file says of a point, besides its position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attributes {
    /// 0 if the file has no z.
    pub(crate) z: f64,
    pub(crate) record: u64,
}

impl PartialEq for Attributes {
    fn eq(&self, other: &Self) -> bool {
        self.z.to_bits() == other.z.to_bits() && self.record == other.record
    }
}

/// A position, in the cell of a tile, and what lies there after the calls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub(crate) tile: TileId,
    pub(crate) point: Point,
    pub(crate) after: Attributes,
}

/// What calls change, each by tile and position.
#[derive(Debug, Default)]
pub(crate) struct NetChanges {
    /// Positions that get a point, or whose point gets other attributes.
    pub(crate) put: Vec<Change>,
    /// Positions whose point goes.
    pub(crate) delete: Vec<(TileId, Point)>,
    pub(crate) counts: PointCounts,
    /// The first call whose point is not there.
    pub(crate) first_missing: Option<u32>,
}

/// A position that calls name.
struct Position {
    tile: TileId,
    point: Point,
    before: Option<Attributes>,
    now: Option<Attributes>,
}

/// Returns what some calls change, given their numbers in order. No other call concerns the same
/// positions.
pub(crate) fn net_changes(tiles: &Tiles, calls: &PointCalls, numbers: &[CallInTile]) -> Result<NetChanges, EditError> {
    let has_z = tiles.metadata().has_z;
    let numbers = numbers.iter().map(|(_, number)| *number);
    let some = || numbers.clone().map(|number| calls.all[number as usize]);
    let mut positions = Positions::of(tiles, some())?;
    let mut net = NetChanges::default();
    for (call, number) in some().zip(numbers.clone()) {
        if !positions.carry_out(call, has_z, &mut net.counts) {
            net.counts.skipped += 1;
            net.first_missing = Some(net.first_missing.map_or(number, |first| first.min(number)));
        }
    }
    for Position {
        tile,
        point,
        before,
        now,
    } in positions.all
    {
        match now {
            Some(after) if before != now => net.put.push(Change { tile, point, after }),
            None if before.is_some() => net.delete.push((tile, point)),
            _ => {}
        }
    }
    Ok(net)
}

/// All positions that calls name, and the place of each in the list.
struct Positions {
    all: Vec<Position>,
    places: HashMap<[u64; 2], u32>,
}

impl Positions {
    fn of(tiles: &Tiles, calls: impl Iterator<Item = PointCall>) -> Result<Self, EditError> {
        let mut all = named(tiles, calls)?;
        look_up(tiles, &mut all)?;
        let places = all.iter().zip(0u32..).map(|(at, place)| (at.point.bits(), place));
        Ok(Self {
            places: places.collect(),
            all,
        })
    }

    /// Returns what lies at a position that the calls name.
    fn at(&mut self, point: Point) -> &mut Option<Attributes> {
        &mut self.all[self.places[&point.bits()] as usize].now
    }

    /// Carries out a call. Returns false if the point is not there.
    fn carry_out(&mut self, call: PointCall, has_z: bool, counts: &mut PointCounts) -> bool {
        let stored = |z: f64| if has_z && !z.is_nan() { z } else { 0.0 };
        match call {
            PointCall::Insert(point, z, record) => match self.at(point) {
                Some(_) => counts.duplicates += 1,
                now => {
                    *now = Some(Attributes { z: stored(z), record });
                    counts.inserted += 1;
                }
            },
            PointCall::Delete(point) => {
                if self.at(point).take().is_none() {
                    return false;
                }
                counts.deleted += 1;
            }
            PointCall::Move([from, to]) => {
                let Some(moved) = self.at(from).take() else {
                    return false;
                };
                match self.at(to) {
                    // It is a duplicate of the other.
                    Some(_) => counts.duplicates += 1,
                    now => *now = Some(moved),
                }
                counts.moved += 1;
            }
            PointCall::SetZ(point, z) => {
                let Some(now) = self.at(point) else { return false };
                now.z = stored(z);
                counts.z_set += 1;
            }
        }
        true
    }
}

/// Returns the positions that calls name, by tile.
fn named(tiles: &Tiles, calls: impl Iterator<Item = PointCall>) -> Result<Vec<Position>, EditError> {
    let mut named = Vec::with_capacity(calls.size_hint().0);
    for point in calls.flat_map(PointCall::positions).flatten() {
        named.push((tile_at(tiles, point)?, point));
    }
    named.sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| a.1.lex_cmp(b.1)));
    named.dedup();
    let new = |(tile, point)| Position {
        tile,
        point,
        before: None,
        now: None,
    };
    Ok(named.into_iter().map(new).collect())
}

/// Returns the tile in whose cell a position is.
pub(crate) fn tile_at(tiles: &Tiles, point: Point) -> Result<TileId, EditError> {
    let tile = tiles.directory().tree.tile_at(point);
    tile.ok_or_else(|| EditError::Internal("the file has no tiles".to_owned()))
}

/// Finds out what lies at each position.
fn look_up(tiles: &Tiles, positions: &mut [Position]) -> Result<(), EditError> {
    for group in positions.chunk_by_mut(|a, b| a.tile == b.tile) {
        let tile = tiles.get(group[0].tile)?;
        let table = PointTable::new(tile.points());
        for position in group {
            let vertex = table.at(position.point).map(VertexIndex);
            position.before = vertex
                .filter(|&vertex| tile.is_input_point(vertex))
                .map(|vertex| Attributes {
                    z: tile.vertex(vertex).z,
                    record: tile.record(vertex),
                });
            position.now = position.before;
        }
    }
    Ok(())
}
