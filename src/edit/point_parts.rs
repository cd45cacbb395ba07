//! Changes of points, first those that do not fit into memory, part by part.
//!
//! In each part, points come, and those that go stay as vertices without a point, as the ends of lines
//! do: what follows may need them, and an edit never makes the triangulation smaller than it will be.
//! They go at the end, in parts, too.

use std::collections::BTreeMap;
use std::io;

use crate::edit::error::EditError;
use crate::edit::points::{self, Gone, Inserted, PointCall, SpilledCalls, tile_at};
use crate::edit::sizes::cut_tiles;
use crate::edit::tiles::Tiles;
use crate::edit::work::Work;
use crate::geometry::{Point, VertexIndex};
use crate::io::folder_of;
use crate::mesh::point_table::PointTable;
use crate::store::TileId;

/// The points that parts took from their vertices. Some of these may have others by now.
#[derive(Default)]
pub(crate) struct FormerPoints {
    pub(crate) count: u64,
    /// Their positions, as calls.
    positions: Option<SpilledCalls>,
}

/// Makes points come, and cuts the tiles that become too large. Those that go stay for now.
pub(crate) fn insert(
    tiles: &mut Tiles,
    work: &Work,
    is_stopped: &dyn Fn() -> bool,
) -> Result<(Inserted, FormerPoints), EditError> {
    work.points.check_z(tiles.metadata().has_z)?;
    let mut former = FormerPoints::default();
    let mut all = Inserted::default();
    let spilled = work.points.spilled.as_ref();
    for part in 0..spilled.map_or(0, SpilledCalls::parts) {
        let part = Work {
            points: work.points.part(part).map_err(|error| not_read(tiles, error))?,
            ..Work::default()
        };
        cut_tiles(tiles, &part, is_stopped)?;
        all += points::insert(tiles, &part.points, is_stopped)?;
        former.take(tiles, std::mem::take(&mut all.delete))?;
    }
    cut_tiles(tiles, work, is_stopped)?;
    all += points::insert(tiles, &work.points, is_stopped)?;
    all.missing.check(&work.points)?;
    Ok((all, former))
}

impl FormerPoints {
    /// Takes points from their vertices, given by tile.
    fn take(&mut self, tiles: &mut Tiles, positions: Vec<(TileId, Point)>) -> Result<(), EditError> {
        if positions.is_empty() {
            return Ok(());
        }
        for group in positions.chunk_by(|a, b| a.0 == b.0) {
            let mut tile = tiles.change(group[0].0)?;
            let table = PointTable::new(tile.points());
            let vertices: Vec<_> = group.iter().filter_map(|&(_, point)| table.at(point)).collect();
            for vertex in vertices {
                tile.set_input_point(VertexIndex(vertex), false);
            }
        }
        self.count += positions.len() as u64;
        let calls: Vec<PointCall> = positions
            .into_iter()
            .map(|(_, point)| PointCall::Delete(point))
            .collect();
        let written = match &mut self.positions {
            Some(positions) => positions.push(&calls),
            none => SpilledCalls::in_folder(folder_of(tiles.path())).and_then(|new| none.insert(new).push(&calls)),
        };
        written.map_err(|error| EditError::io(tiles.path(), "write changes to disk beside", error))
    }

    /// Removes the vertices that have no point yet, unless something else holds them. Returns how many
    /// are removed, and the number of vertices that are left in each tile that lost any.
    pub(crate) fn delete(
        self,
        tiles: &mut Tiles,
        has_lines: bool,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<(u64, BTreeMap<TileId, usize>), EditError> {
        let (mut removed, mut left) = (0, BTreeMap::new());
        let Some(all) = self.positions else {
            return Ok((removed, left));
        };
        for part in 0..all.parts() {
            let calls = all.part(part).map_err(|error| not_read(tiles, error))?;
            let positions = calls.into_iter().map(PointCall::position);
            let positions = positions.map(|point| Ok((tile_at(tiles, point)?, point, Gone::FormerPoint)));
            let positions = positions.collect::<Result<_, EditError>>()?;
            let deleted = points::delete(tiles, positions, has_lines, is_stopped)?;
            removed += deleted.former;
            left.extend(deleted.left);
        }
        Ok((removed, left))
    }
}

fn not_read(tiles: &Tiles, error: io::Error) -> EditError {
    EditError::io(tiles.path(), "read changes on disk beside", error)
}
