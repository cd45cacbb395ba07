//! Transactions that are in the log, and not yet in the file.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use foldhash::HashMap;

use crate::edit::{Attributes, EditError, EditSummary, Missing, PointCalls, Positions, Target};
use crate::editor::logged::{decode, encode};
use crate::editor::look_up::look_up;
use crate::editor::position_filters::PositionFilters;
use crate::geometry::Point;
use crate::store::{Directory, Log, LogError, Logged, TileId, TileReader};

/// The changes of a file of points that were not made in it yet.
pub(super) struct Pending {
    reader: TileReader,
    directory: Arc<Directory>,
    filters: PositionFilters,
    /// `None` until the first transaction comes.
    log: Option<Log>,
    calls: PointCalls,
    transactions: u64,
    /// What lies at each position that the calls name, after them.
    now: HashMap<[u64; 2], Option<Attributes>>,
    /// Number of vertices after the calls.
    vertices: u64,
}

impl Pending {
    /// The most changes of a transaction that goes to the log. With more of them, it would take longer
    /// to find out what lies at their positions, and then to make them, than to make them at once.
    pub(super) const MOST_CALLS: u64 = 4096;

    /// Prepares to take changes of a file. About a quarter of `memory` bytes is for its tiles, an eighth
    /// for what is remembered of them. Returns `None` if the file has more than points, or no triangles.
    pub(super) async fn of(target: &Target, memory: u64) -> Result<Option<Self>, EditError> {
        let reader = target.read_within(memory / 4).await?;
        let metadata = reader.metadata();
        let others = [metadata.ends, metadata.constraint_edges, metadata.sites];
        if others != [0; 3] || metadata.triangles == 0 {
            return Ok(None);
        }
        Ok(Some(Self {
            directory: reader.directory().await?,
            filters: PositionFilters::new(memory / 8),
            log: None,
            calls: PointCalls::checked(Vec::new()),
            transactions: 0,
            now: HashMap::default(),
            vertices: metadata.vertices,
            reader,
        }))
    }

    /// Returns the file, without the changes.
    pub(super) fn reader(&self) -> &TileReader {
        &self.reader
    }

    /// Returns the number of record numbers for points that were inserted.
    pub(super) fn records(&self) -> u64 {
        self.calls.records
    }

    /// Returns the bytes of memory that the changes take.
    pub(super) fn memory(&self) -> u64 {
        self.calls.memory()
    }

    /// Takes a transaction into the log of a file with this name. Hands it back if the changes must be
    /// made in the file: the log takes no more, or nothing would be left.
    ///
    /// # Errors
    /// Fails as an edit with these changes would, and then nothing is changed; and if the log cannot be
    /// written.
    pub(super) async fn take(
        &mut self,
        file: &Path,
        calls: PointCalls,
    ) -> Result<Result<EditSummary, PointCalls>, EditError> {
        let began = Instant::now();
        let metadata = self.reader.metadata();
        let has_z = metadata.has_z;
        calls.check_z(has_z)?;
        let mut positions = self.look_up(&calls).await?;
        let numbers: Vec<_> = (0..calls.all.len() as u32).map(|number| (TileId(0), number)).collect();
        let mut missing = Missing::default();
        positions.carry_out(&calls, &numbers, has_z, &mut missing);
        missing.check(&calls)?;
        let come = positions
            .all
            .iter()
            .filter(|at| at.before.is_none() && at.now.is_some());
        let go = positions
            .all
            .iter()
            .filter(|at| at.before.is_some() && at.now.is_none());
        let vertices = self.vertices + come.count() as u64 - go.count() as u64;
        if vertices == 0 || self.log.as_ref().is_some_and(Log::is_broken) {
            return Ok(Err(calls));
        }
        self.append(file, &calls).await?;
        let after = positions.all.iter().map(|at| (at.point.bits(), at.now));
        self.now.extend(after);
        self.calls.append(calls);
        self.vertices = vertices;
        self.transactions += 1;
        let metadata = self.reader.metadata();
        Ok(Ok(EditSummary {
            points: positions.counts,
            vertices,
            triangles: metadata.triangles,
            regions: metadata.regions,
            hole_regions: metadata.hole_regions,
            hole_triangles: metadata.hole_triangles,
            file_bytes: self.reader.file_length(),
            pending_transactions: self.transactions,
            seconds: began.elapsed().as_secs_f64(),
            ..EditSummary::default()
        }))
    }

    /// Writes a transaction to the log.
    async fn append(&mut self, file: &Path, calls: &PointCalls) -> Result<(), EditError> {
        let in_file = self.reader.metadata().last_transaction;
        let log = match &mut self.log {
            Some(log) => log,
            none => {
                let id = self.reader.in_force().superblock.file_id;
                none.insert(Log::create(file, id, in_file).await?)
            }
        };
        let number = in_file.saturating_add(self.transactions + 1);
        Ok(log.append(number, &encode(calls)).await?)
    }

    /// Finds out what lies at the positions that calls name, after the changes so far.
    async fn look_up(&mut self, calls: &PointCalls) -> Result<Positions, EditError> {
        let tree = &self.directory.tree;
        let numbers: Vec<_> = (0..calls.all.len() as u32).map(|number| (TileId(0), number)).collect();
        let mut positions = Positions::named(tree, calls, &numbers);
        let known = |point: Point| self.now.get(&point.bits()).copied();
        let unknown = positions.all.iter().filter(|at| known(at.point).is_none());
        let mut by_tile: HashMap<TileId, Vec<Point>> = HashMap::default();
        unknown.for_each(|at| by_tile.entry(at.tile).or_default().push(at.point));
        for (tile, points) in by_tile {
            if self.filters.may_have(tile, points.into_iter()) {
                let tile = self.reader.tile(tile).await?;
                look_up(&tile, &mut positions);
                self.filters.remember(&tile);
            }
        }
        for position in &mut positions.all {
            if let Some(now) = known(position.point) {
                position.before = now;
                position.now = now;
            }
        }
        Ok(positions)
    }

    /// Takes no more changes. Returns those that were taken, if there are any.
    pub(super) fn finish(self) -> Option<LoggedChanges> {
        let (calls, transactions) = (self.calls, self.transactions);
        self.log.map(|log| LoggedChanges {
            log,
            calls,
            transactions,
        })
    }
}

/// The changes in a log, to be made in the file.
pub(super) struct LoggedChanges {
    pub(super) log: Log,
    pub(super) calls: PointCalls,
    pub(super) transactions: u64,
}

impl LoggedChanges {
    /// Returns the changes of a log that was opened.
    pub(super) fn of(logged: Logged) -> Result<Self, LogError> {
        let mut calls = PointCalls::checked(Vec::new());
        for (transaction, number) in logged.transactions.iter().zip(1..) {
            let damaged = || {
                logged
                    .log
                    .damaged(format!("transaction {number} of the pending ones is none"))
            };
            calls.append(decode(transaction.clone()).ok_or_else(damaged)?);
        }
        Ok(Self {
            transactions: logged.transactions.len() as u64,
            log: logged.log,
            calls,
        })
    }
}
