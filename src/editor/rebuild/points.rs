//! The vertices of a file, tile by tile, with changes of its points.

use std::pin::pin;
use std::sync::Arc;

use futures::{TryFutureExt, TryStreamExt};

use crate::edit::{CallInTile, EditError, Missing, PointCall, PointCounts, Positions, Work};
use crate::editor::look_up::look_up;
use crate::editor::rebuild::error::edit_error;
use crate::editor::rebuild::vertices::{NewVertices, changed_tile};
use crate::geometry::Point;
use crate::io::blocking;
use crate::pipeline::Builder;
use crate::pipeline::draping::sample;
use crate::store::{Directory, TileId, TileReader};

/// The number of tiles whose calls are carried out at a time.
const TILES_AT_ONCE: usize = 2;

/// Announces about how many points will come, and where.
pub(super) fn push_sample(builder: &mut Builder, directory: &Directory, points: u64) -> Result<(), EditError> {
    let bounds = directory
        .tile_ids()
        .filter_map(|id| directory.entry(id))
        .map(|tile| tile.bounds);
    let bounds: Vec<_> = bounds.collect();
    builder.expect(points, sample(bounds.into_iter())).map_err(edit_error)
}

/// The vertices of a file, with changes of its points.
pub(super) struct ChangedPoints<'a> {
    reader: &'a TileReader,
    /// What changes; only its calls that concern points count.
    work: Arc<Work>,
    has_z: bool,
    /// The next record number of a vertex that is no point.
    next_end: u64,
    missing: Missing,
    changes: PointChanges,
}

/// What came of calls.
#[derive(Default)]
pub(super) struct PointChanges {
    pub(super) counts: PointCounts,
    /// Calls that are left to an edit of what is built, in order: those that concern vertices of
    /// lines and sites.
    pub(super) left: Vec<PointCall>,
}

impl<'a> ChangedPoints<'a> {
    /// Returns the changed points. Vertices that are no points get record numbers from `first_end` on.
    pub(super) fn of(reader: &'a TileReader, work: Arc<Work>, has_z: bool, first_end: u64) -> Self {
        Self {
            reader,
            work,
            has_z,
            next_end: first_end,
            missing: Missing::default(),
            changes: PointChanges::default(),
        }
    }

    /// Pushes all vertices to a builder. Returns what the calls changed.
    ///
    /// # Errors
    /// Fails if a point is not there, unless such calls are to be left out.
    pub(super) async fn push(mut self, builder: &mut Builder) -> Result<PointChanges, EditError> {
        let directory = self.reader.directory().await?;
        let tile_at = |point: Point| directory.tree.tile_at(point).unwrap_or(TileId(0));
        let work = Arc::clone(&self.work);
        let numbers = work.points.all.iter().zip(0u32..);
        let mut by_tile: Vec<CallInTile> = numbers
            .map(|(call, number)| (tile_at(call.position()), number))
            .collect();
        // Without moves, each call concerns one tile only.
        if work.points.has_moves() || self.reader.metadata().tiles == 0 {
            self.push_at_once(&directory, &by_tile, builder).await?;
        } else {
            by_tile.sort_unstable();
            self.push_by_tile(directory, by_tile, builder).await?;
        }
        self.missing.check(&work.points)?;
        Ok(self.changes)
    }

    /// Reads each tile once, and carries out its calls, while the vertices of the one before are pushed.
    async fn push_by_tile(
        &mut self,
        directory: Arc<Directory>,
        by_tile: Vec<CallInTile>,
        builder: &mut Builder,
    ) -> Result<(), EditError> {
        let by_tile: Arc<[CallInTile]> = by_tile.into();
        let (work, has_z) = (Arc::clone(&self.work), self.has_z);
        let changed = self.reader.tiles().map_ok(move |tile| {
            let (work, directory, by_tile) = (Arc::clone(&work), Arc::clone(&directory), Arc::clone(&by_tile));
            let change = move || changed_tile(&tile, &directory.tree, &work.points, &by_tile, has_z);
            blocking(change).map_err(|error| EditError::Internal(format!("cannot start a thread: {error}")))
        });
        let mut changed = pin!(changed.map_err(EditError::from).try_buffered(TILES_AT_ONCE));
        while let Some((vertices, counts, missing)) = changed.try_next().await? {
            self.changes.counts += counts;
            self.missing.add(missing);
            self.push_vertices(vertices, builder).await?;
        }
        Ok(())
    }

    /// Reads all tiles twice: to find out what lies at the positions, and then to push the vertices.
    async fn push_at_once(
        &mut self,
        directory: &Directory,
        numbers: &[CallInTile],
        builder: &mut Builder,
    ) -> Result<(), EditError> {
        let (work, has_z) = (Arc::clone(&self.work), self.has_z);
        let mut positions = Positions::named(&directory.tree, &work.points, numbers);
        let mut tiles = self.reader.tiles();
        while let Some(tile) = tiles.try_next().await? {
            look_up(&tile, &mut positions);
        }
        positions.carry_out(&work.points, numbers, has_z, &mut self.missing);
        self.changes.counts += positions.counts;
        let mut tiles = self.reader.tiles();
        while let Some(tile) = tiles.try_next().await? {
            let vertices = NewVertices::of(&tile, &mut positions, has_z);
            self.push_vertices(vertices, builder).await?;
        }
        let mut others = NewVertices::default();
        others.take_those_at(&positions, has_z);
        self.push_vertices(others, builder).await
    }

    /// Numbers the vertices that are no points, and pushes all.
    async fn push_vertices(&mut self, vertices: NewVertices, builder: &mut Builder) -> Result<(), EditError> {
        let NewVertices {
            mut batch,
            ends,
            mut left,
        } = vertices;
        for place in ends {
            batch.records[place] = self.next_end;
            // A hostile file may have used all numbers.
            self.next_end = self.next_end.saturating_add(1);
        }
        self.changes.left.append(&mut left);
        builder.push(&batch).await.map_err(edit_error)
    }
}
