//! The file of an editor: locked, with its log.

use std::num::NonZero;
use std::path::Path;
use std::thread;

use futures::future::FutureExt;

use crate::edit::{EditError, EditSummary, PointCalls, Target, Work};
use crate::editor::options::{Durability, EditOptions};
use crate::editor::pending::{LoggedChanges, Pending};
use crate::editor::ways::make;
use crate::store::{Log, Metadata};

/// A file that is locked, and the changes that wait in its log.
pub(super) struct LockedFile {
    pub(super) target: Target,
    pub(super) memory: u64,
    durability: Durability,
    /// Takes changes into the log; `None` if none may come.
    pending: Option<Pending>,
    /// Changes in the log that must be made before others.
    unmade: Option<LoggedChanges>,
}

impl LockedFile {
    /// Locks a file, and makes the changes that are in its log.
    pub(super) fn open(path: &Path, options: EditOptions) -> impl Future<Output = Result<Self, EditError>> + Send {
        async move {
            let target = Target::lock(path)?;
            // Whether it is a tile file is to be known at once.
            let reader = target.read().await?;
            let last = reader.metadata().last_transaction;
            let logged = Log::open(&target.path, reader.file_id(), last).await?;
            let mut this = Self {
                target,
                memory: options.memory,
                durability: options.durability,
                pending: None,
                unmade: logged.map(LoggedChanges::of).transpose()?,
            };
            drop(reader);
            this.checkpoint().await?;
            Ok(this)
        }
        .boxed()
    }

    /// Returns what a transaction must know of the file: the metadata with the pending changes, the
    /// number of the next edit with lines, and the reference system.
    pub(super) async fn state(&mut self) -> Result<(Metadata, u32, Option<String>), EditError> {
        if self.unmade.is_some() {
            self.checkpoint().await?;
        }
        self.target.renew();
        if self.pending.is_none() && self.durability == Durability::Log {
            self.pending = Pending::of(&self.target, self.memory).await?;
        }
        let reader = match &self.pending {
            Some(pending) => pending.reader(),
            None => &self.target.read_and_keep().await?,
        };
        let lists = reader.lists().await?;
        let number = lists.lines.last().map_or(0, |last| last.edit).saturating_add(1);
        let mut metadata = reader.metadata().clone();
        let records = self.pending.as_ref().map_or(0, Pending::records);
        metadata.next_record = metadata.next_record.saturating_add(records);
        Ok((metadata, number, lists.crs.clone()))
    }

    /// Takes changes of points into the log. Hands them back if they must be made in the file.
    pub(super) async fn log(&mut self, calls: PointCalls) -> Result<Result<EditSummary, PointCalls>, EditError> {
        match &mut self.pending {
            Some(pending) if calls.len() <= Pending::MOST_CALLS && pending.memory() <= self.memory / 4 => {
                pending.take(&self.target.path, calls).await
            }
            _ => Ok(Err(calls)),
        }
    }

    /// Makes the changes that are in the log before others, which were to be made in a file with the
    /// metadata `before`. Returns how many record numbers these left unused: a checkpoint that came to
    /// nothing has used none.
    pub(super) async fn settle(&mut self, before: &mut Metadata) -> Result<u64, EditError> {
        if self.checkpoint().await?.is_none() {
            return Ok(0);
        }
        self.target.renew();
        let expected = before.next_record;
        *before = self.target.read().await?.metadata().clone();
        Ok(expected.saturating_sub(before.next_record))
    }

    /// Makes all changes in the file, which has nothing in its log.
    pub(super) async fn make(
        &mut self,
        before: &Metadata,
        work: Work,
        prefers_build: bool,
    ) -> Result<EditSummary, EditError> {
        make(&mut self.target, before, work, prefers_build, self.memory).await
    }

    /// Makes the changes that are in the log. Returns `None` if there are none.
    pub(super) fn checkpoint(&mut self) -> impl Future<Output = Result<Option<EditSummary>, EditError>> + Send {
        async move {
            if let Some(pending) = self.pending.take() {
                self.unmade = pending.finish();
            }
            let Some(unmade) = &self.unmade else { return Ok(None) };
            self.target.renew();
            let before = self.target.read().await?.metadata().clone();
            let made = match unmade.transactions {
                0 => None,
                transactions => {
                    let work = Work {
                        new_records: unmade.calls.records,
                        earlier_transactions: transactions - 1,
                        points: unmade.calls.clone(),
                        threads: thread::available_parallelism().map_or(1, NonZero::get),
                        ..Work::default()
                    };
                    Some(make(&mut self.target, &before, work, false, self.memory).await?)
                }
            };
            if let Some(LoggedChanges { log, .. }) = self.unmade.take() {
                log.remove().await?;
            }
            Ok(made)
        }
        .boxed()
    }
}
