//! Run: reads, conquers and writes blocks at the same time.

use std::io;
use std::sync::Arc;

use futures::future;
use tokio::sync::{mpsc, oneshot};

use crate::io::start_thread;
use crate::memory::Shares;
use crate::pipeline::assembly::Assembly;
use crate::pipeline::assembly::open::OpenedBuild;
use crate::pipeline::conquer::conquest::Conquest;
use crate::pipeline::conquer::prefetch;
use crate::pipeline::conquer::prefetch::{Prefetched, UnreadBlocks};
use crate::pipeline::conquer::schedule::BlockPoints;
use crate::pipeline::error::BuildError;
use crate::pipeline::finish::borders::RegionTotals;
use crate::pipeline::ingest::point_store::PointStore;
use crate::pipeline::output::writer::Sender;
use crate::pipeline::records::{Draped, TileState};
use crate::pipeline::resume::journal::JournalReader;
use crate::pipeline::run::{Began, Computed, run};

/// The result of running.
pub(crate) struct RunResult {
    pub(crate) tiles: Vec<TileState>,
    pub(crate) regions: RegionTotals,
    pub(crate) began: Began,
    pub(crate) prefetched: Prefetched,
}

impl Assembly {
    /// Conquers all blocks and writes cores and borders.
    pub(crate) async fn run(&self, work: &mut OpenedBuild) -> Result<RunResult, BuildError> {
        let (sender, extents) = mpsc::channel(work.shares.threads);
        let computed = self.start_computing(work, sender)?;
        let unread = UnreadBlocks {
            blocks: &work.blocks,
            segments: &work.segments,
            first: work.first_block as usize,
            has_z: work.has_z,
            surface: self.surface.as_deref(),
        };
        let (conquest, output) = (&work.conquest, &mut work.output);
        let feed = async {
            let fed = self.feed(conquest, work.store.take(), unread, work.shares).await;
            fed.unwrap_or_else(|error| {
                conquest.fail(error);
                Prefetched::default()
            })
        };
        let write = async {
            let written = output.write_all(extents).await;
            if written.is_err() {
                // The channel is closed now, which stops the threads that send. The others, and the
                // feeding, stop here.
                conquest.board.stop();
            }
            written
        };
        let (prefetched, written) = future::join(feed, write).await;
        let gone = || BuildError::Internal("the building thread is gone".to_owned());
        let computed = computed.await.unwrap_or_else(|_| Err(gone()));
        // If writing failed, computing was stopped because of it, so the write error is the cause.
        written?;
        let (tiles, regions, began) = computed?;
        Ok(RunResult {
            tiles,
            regions,
            began,
            prefetched,
        })
    }

    /// Starts the thread that starts the computing threads. The receiver gets the result once all
    /// have ended.
    fn start_computing(&self, work: &OpenedBuild, sender: Sender) -> Result<oneshot::Receiver<Computed>, BuildError> {
        let (reply, computed) = oneshot::channel();
        // The thread holds the folder's lock too: it may outlive this future.
        let (theirs, folder) = (Arc::clone(&work.conquest), Arc::clone(&self.folder));
        let (first_tile, threads) = (work.first_tile, work.shares.threads);
        let compute = move || {
            let computed = run(&theirs, first_tile, threads, &sender);
            drop((theirs, sender, folder));
            // The receiver may have been dropped.
            let _ = reply.send(computed);
        };
        let started = start_thread("tile-build", compute);
        started.map_err(|error| BuildError::io(&work.path, "start a thread to build", error))?;
        Ok(computed)
    }

    /// Gives the board its blocks: the block in memory, or the seams of blocks finished earlier and
    /// then the blocks that must be read.
    async fn feed(
        &self,
        conquest: &Arc<Conquest>,
        store: Option<PointStore>,
        unread: UnreadBlocks<'_>,
        shares: Shares,
    ) -> Result<Prefetched, BuildError> {
        if let Some(mut store) = store {
            if !store.items.is_empty() {
                let draped = match unread.surface {
                    Some(surface) => surface.drape(&mut store).await?,
                    None => Draped::default(),
                };
                conquest.board.add(BlockPoints {
                    number: 0,
                    store,
                    segments: unread
                        .segments
                        .take(0)
                        .map_err(|error| BuildError::io(self.folder.spill(), "read segments in", error))?,
                    of_leaves: Vec::new(),
                    draped,
                    _permit: None,
                });
            }
            return Ok(Prefetched::default());
        }
        if unread.first > 0 {
            let path = self.folder.journal();
            let cannot = |error| BuildError::io(&path, "read", error);
            let mut reader = JournalReader::open(&path).map_err(cannot)?;
            for _ in 0..unread.first {
                let entry = reader.next().map_err(cannot)?;
                let (block, seam) = entry.ok_or_else(|| cannot(io::ErrorKind::InvalidData.into()))?;
                conquest.restore(block, seam);
            }
        }
        prefetch::feed(
            &conquest.board,
            unread,
            self.folder.spill(),
            shares.blocks,
            conquest.limits.has_journal,
        )
        .await
    }
}
