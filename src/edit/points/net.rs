//! The net effect of calls: the point at each position, before and after.

use foldhash::HashMap;

use crate::edit::error::EditError;
use crate::edit::points::call::{CallInTile, PointCall};
use crate::edit::points::calls::PointCalls;
use crate::edit::summary::PointCounts;
use crate::edit::tiles::Tiles;
use crate::geometry::{Point, VertexIndex};
use crate::mesh::point_table::PointTable;
use crate::store::{KdTree, TileId};

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
    pub(crate) missing: Missing,
}

/// A position that calls name.
pub(crate) struct Position {
    pub(crate) tile: TileId,
    pub(crate) point: Point,
    /// What lay there before the calls.
    pub(crate) before: Option<Attributes>,
    /// What lies there after those that were carried out.
    pub(crate) now: Option<Attributes>,
}

/// Returns what some calls change, given their numbers in order. No other call concerns the same
/// positions.
pub(crate) fn net_changes(tiles: &Tiles, calls: &PointCalls, numbers: &[CallInTile]) -> Result<NetChanges, EditError> {
    let mut positions = Positions::named(&tiles.directory().tree, calls, numbers);
    look_up(tiles, &mut positions)?;
    let mut net = NetChanges::default();
    positions.carry_out(calls, numbers, tiles.metadata().has_z, &mut net.missing);
    net.counts = positions.counts;
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

/// All positions that some calls name, by tile, and the place of each in the list.
#[derive(Default)]
pub(crate) struct Positions {
    pub(crate) all: Vec<Position>,
    pub(crate) counts: PointCounts,
    places: HashMap<[u64; 2], u32>,
}

impl Positions {
    /// Returns the positions that calls name, given their numbers. Nothing is known of what lies there.
    pub(crate) fn named(tree: &KdTree, calls: &PointCalls, numbers: &[CallInTile]) -> Self {
        let some = numbers.iter().map(|&(_, number)| calls.all[number as usize]);
        let named = some.flat_map(PointCall::positions).flatten();
        let mut named: Vec<(TileId, Point)> = named
            // In a file without tiles, all lie in the first one.
            .map(|point| (tree.tile_at(point).unwrap_or(TileId(0)), point))
            .collect();
        named.sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| a.1.lex_cmp(b.1)));
        named.dedup();
        let places = named
            .iter()
            .zip(0u32..)
            .map(|((_, point), place)| (point.bits(), place));
        let places = places.collect();
        let new = |(tile, point)| Position {
            tile,
            point,
            before: None,
            now: None,
        };
        Self {
            all: named.into_iter().map(new).collect(),
            places,
            ..Self::default()
        }
    }

    /// Returns the position at a point, if a call names it.
    pub(crate) fn at(&mut self, point: Point) -> Option<&mut Position> {
        let place = *self.places.get(&point.bits())?;
        Some(&mut self.all[place as usize])
    }

    fn now(&mut self, point: Point) -> &mut Option<Attributes> {
        &mut self.all[self.places[&point.bits()] as usize].now
    }

    /// Carries out the calls that name the positions, given their numbers in order.
    pub(crate) fn carry_out(&mut self, calls: &PointCalls, numbers: &[CallInTile], has_z: bool, missing: &mut Missing) {
        for &(_, number) in numbers {
            if !self.carry_out_one(calls.all[number as usize], has_z) {
                self.counts.skipped += 1;
                missing.note(calls.number(number), calls.all[number as usize].position());
            }
        }
    }

    /// Carries out a call. Returns false if the point is not there.
    fn carry_out_one(&mut self, call: PointCall, has_z: bool) -> bool {
        let stored = |z: f64| if has_z && !z.is_nan() { z } else { 0.0 };
        match call {
            PointCall::Insert(point, z, record) => match self.now(point) {
                Some(_) => self.counts.duplicates += 1,
                now => {
                    *now = Some(Attributes { z: stored(z), record });
                    self.counts.inserted += 1;
                }
            },
            PointCall::Delete(point) => {
                if self.now(point).take().is_none() {
                    return false;
                }
                self.counts.deleted += 1;
            }
            PointCall::Move([from, to]) => {
                let Some(moved) = self.now(from).take() else {
                    return false;
                };
                match self.now(to) {
                    // It is a duplicate of the other.
                    Some(_) => self.counts.duplicates += 1,
                    now => *now = Some(moved),
                }
                self.counts.moved += 1;
            }
            PointCall::SetZ(point, z) => {
                let Some(now) = self.now(point) else { return false };
                now.z = stored(z);
                self.counts.z_set += 1;
            }
        }
        true
    }
}

/// The calls whose points are not there.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Missing {
    /// The number of the first one, and its position.
    first: Option<(u64, Point)>,
    count: u64,
}

impl Missing {
    fn note(&mut self, number: u64, point: Point) {
        self.add(Self {
            first: Some((number, point)),
            count: 1,
        });
    }

    /// Adds those of other calls.
    pub(crate) fn add(&mut self, other: Self) {
        let both = self.first.into_iter().chain(other.first);
        self.first = both.min_by_key(|(number, _)| *number);
        self.count += other.count;
    }

    /// Returns an error if there are any, and they are not to be left out.
    pub(crate) fn check(self, calls: &PointCalls) -> Result<(), EditError> {
        match self.first.filter(|_| !calls.skip_missing) {
            Some((_, point)) => Err(EditError::NoPoint {
                point,
                count: self.count,
            }),
            None => Ok(()),
        }
    }
}

/// Returns the tile in whose cell a position is.
pub(crate) fn tile_at(tiles: &Tiles, point: Point) -> Result<TileId, EditError> {
    let tile = tiles.directory().tree.tile_at(point);
    tile.ok_or_else(|| EditError::Internal("the file has no tiles".to_owned()))
}

/// Finds out what lies at each position.
fn look_up(tiles: &Tiles, positions: &mut Positions) -> Result<(), EditError> {
    for group in positions.all.chunk_by_mut(|a, b| a.tile == b.tile) {
        let tile = tiles.get(group[0].tile)?;
        let table = PointTable::for_searches(tile.points(), group.len());
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
