//! The points of a file with changes, tile by tile.

use futures::TryStreamExt;

use crate::edit::{Attributes, CallInTile, EditError, Missing, PointCalls, PointCounts, Positions};
use crate::editor::look_up::look_up;
use crate::editor::rebuild::error::edit_error;
use crate::geometry::Point;
use crate::input::PointBatch;
use crate::pipeline::Builder;
use crate::pipeline::draping::sample;
use crate::store::{Directory, Tile, TileId, TileReader};

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
    calls: &'a PointCalls,
    has_z: bool,
    /// The next record number of a vertex that is no point.
    next_end: u64,
    counts: PointCounts,
    missing: Missing,
}

impl<'a> ChangedPoints<'a> {
    /// Returns the changed points. Vertices that are no points get record numbers from `first_end` on.
    pub(super) fn of(reader: &'a TileReader, calls: &'a PointCalls, has_z: bool, first_end: u64) -> Self {
        Self {
            reader,
            calls,
            has_z,
            next_end: first_end,
            counts: PointCounts::default(),
            missing: Missing::default(),
        }
    }

    /// Pushes all vertices to a builder. Returns what the calls changed.
    ///
    /// # Errors
    /// Fails if a point is not there, unless such calls are to be left out.
    pub(super) async fn push(&mut self, builder: &mut Builder) -> Result<PointCounts, EditError> {
        let directory = self.reader.directory().await?;
        let tile_at = |point: Point| directory.tree.tile_at(point).unwrap_or(TileId(0));
        let numbers = self.calls.all.iter().zip(0u32..);
        let mut by_tile: Vec<CallInTile> = numbers
            .map(|(call, number)| (tile_at(call.position()), number))
            .collect();
        // Without moves, each call concerns one tile only.
        if self.calls.has_moves() || self.reader.metadata().tiles == 0 {
            self.push_at_once(&directory, &by_tile, builder).await?;
        } else {
            by_tile.sort_unstable();
            self.push_by_tile(&directory, &by_tile, builder).await?;
        }
        self.missing.check(self.calls)?;
        Ok(self.counts)
    }

    /// Reads each tile once, and carries out its calls.
    async fn push_by_tile(
        &mut self,
        directory: &Directory,
        by_tile: &[CallInTile],
        builder: &mut Builder,
    ) -> Result<(), EditError> {
        let mut tiles = self.reader.tiles();
        while let Some(tile) = tiles.try_next().await? {
            let first = by_tile.partition_point(|(id, _)| *id < tile.id());
            let count = by_tile[first..].partition_point(|(id, _)| *id == tile.id());
            let calls = &by_tile[first..first + count];
            let mut positions = Positions::named(&directory.tree, self.calls, calls);
            look_up(&tile, &mut positions);
            self.carry_out(&mut positions, calls);
            let mut batch = self.batch_of(&tile, &mut positions);
            self.put(&positions, &mut batch);
            builder.push(&batch).await.map_err(edit_error)?;
        }
        Ok(())
    }

    /// Reads all tiles twice: to find out what lies at the positions, and then to push the vertices.
    async fn push_at_once(
        &mut self,
        directory: &Directory,
        calls: &[CallInTile],
        builder: &mut Builder,
    ) -> Result<(), EditError> {
        let mut positions = Positions::named(&directory.tree, self.calls, calls);
        let mut tiles = self.reader.tiles();
        while let Some(tile) = tiles.try_next().await? {
            look_up(&tile, &mut positions);
        }
        self.carry_out(&mut positions, calls);
        let mut tiles = self.reader.tiles();
        while let Some(tile) = tiles.try_next().await? {
            let batch = self.batch_of(&tile, &mut positions);
            builder.push(&batch).await.map_err(edit_error)?;
        }
        let mut batch = PointBatch::default();
        self.put(&positions, &mut batch);
        builder.push(&batch).await.map_err(edit_error)
    }

    fn carry_out(&mut self, positions: &mut Positions, calls: &[CallInTile]) {
        positions.carry_out(self.calls, calls, self.has_z, &mut self.missing);
        self.counts += positions.counts;
    }

    /// Returns the vertices of a tile, without those that are points at positions which calls name.
    fn batch_of(&mut self, tile: &Tile, positions: &mut Positions) -> PointBatch {
        let mut batch = PointBatch::default();
        for vertex in tile.vertex_indices() {
            let point = tile.point(vertex);
            let now = positions.at(point).map(|position| position.now);
            let record = match (now, tile.is_input_point(vertex)) {
                (Some(Some(_)), _) => continue,
                (None, true) => tile.record(vertex),
                // Nothing else holds the vertex.
                (Some(None), true) if !tile.is_site(vertex) => continue,
                _ => {
                    let record = self.next_end;
                    // A hostile file may have used all numbers.
                    self.next_end = record.saturating_add(1);
                    record
                }
            };
            let z = tile.z(vertex).unwrap_or_default();
            self.add(point, Attributes { z, record }, &mut batch);
        }
        batch
    }

    /// Adds the points that lie at positions after the calls.
    fn put(&self, positions: &Positions, batch: &mut PointBatch) {
        for position in &positions.all {
            if let Some(now) = position.now {
                self.add(position.point, now, batch);
            }
        }
    }

    fn add(&self, point: Point, Attributes { z, record }: Attributes, batch: &mut PointBatch) {
        batch.points.push(point);
        batch.records.push(record);
        if self.has_z {
            batch.z.push(z);
        }
    }
}
