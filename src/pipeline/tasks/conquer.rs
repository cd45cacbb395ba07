//! Conquers one block by itself.

use std::fs::File;
use std::io;
use std::num::NonZero;
use std::sync::Arc;
use std::thread::available_parallelism;
use std::time::Instant;

use futures::future::FutureExt;
use parking_lot::Mutex;
use tokio::sync::{mpsc, oneshot};

use crate::constraints::seeds::HoleRules;
use crate::edit::EditError;
use crate::io::{Buffers, ThreadsFile, blocking, start_thread};
use crate::memory::available_memory;
use crate::pipeline::conquer::conquest::{Conquest, ConquestLimits};
use crate::pipeline::conquer::prefetch::load;
use crate::pipeline::conquer::schedule::{BlockPoints, Board};
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::drape::PointSurface;
use crate::pipeline::output::border_log::BorderLog;
use crate::pipeline::output::ordered::{Closed, Ordered};
use crate::pipeline::output::writer::{Sender, ToWrite};
use crate::pipeline::records::{Draped, Seam};
use crate::pipeline::resume::journal::FinishedBlock;
use crate::pipeline::tasks::block_file::{BlockFile, UnfinishedBlockFile};
use crate::pipeline::tasks::block_tasks::BlockTasks;
use crate::pipeline::tasks::saved::segments_of;
use crate::pipeline::threads::on_threads;
use crate::store::{Extent, TileWriter};

/// What a task may take.
#[derive(Clone, Copy, Debug)]
pub struct TaskOptions {
    /// Bytes of memory. A task needs [those of the plan](BlockTasks::memory).
    pub memory: u64,
    /// Number of threads that compute. No more are used than the plan has memory for.
    pub threads: usize,
}

impl Default for TaskOptions {
    /// The memory that is available, and a thread for each processor.
    fn default() -> Self {
        Self {
            memory: available_memory(),
            threads: available_parallelism().map_or(1, NonZero::get),
        }
    }
}

/// What a task did.
#[derive(Clone, Copy, Debug)]
pub struct ConqueredBlock {
    /// The number of the block.
    pub block: u32,
    /// Number of its points, with ends of lines and sites.
    pub points: u64,
    /// Number of its tiles.
    pub tiles: u32,
    /// Whether it was conquered before, so that nothing was done.
    pub was_done: bool,
    /// Bytes of the points that were read.
    pub bytes_read: u64,
    /// Bytes of the file that was written.
    pub bytes_written: u64,
    /// Seconds that this took.
    pub seconds: f64,
}

impl BlockTasks {
    /// Conquers a block: triangulates its points, with its lines, and writes its tiles into the work
    /// folder, under their name once they are complete. If that was done before, it does nothing. Must be
    /// awaited within a tokio runtime; computing runs on threads of its own.
    ///
    /// # Errors
    /// Returns [`BuildError::NoBlock`] if there is no such block, [`BuildError::TaskMemory`] if the
    /// options do not allow the memory that the plan has for it, and the errors of
    /// [`Builder::finish`](crate::Builder::finish).
    pub fn conquer(
        &self,
        block: u32,
        options: TaskOptions,
    ) -> impl Future<Output = Result<ConqueredBlock, BuildError>> + Send {
        self.conquer_block(block, options).boxed()
    }

    async fn conquer_block(&self, number: u32, options: TaskOptions) -> Result<ConqueredBlock, BuildError> {
        let began = Instant::now();
        let cannot = self.cannot("conquer a block in");
        let Some(block) = self.plan.blocks.get(number as usize) else {
            let blocks = self.blocks();
            return Err(BuildError::NoBlock { block: number, blocks });
        };
        let open = || BlockFile::open(&self.folder, number, self.id).map_err(&cannot);
        let before = open()?;
        let was_done = before.is_some();
        let done = match before {
            Some(before) => before,
            None if options.memory < self.memory() => {
                return Err(BuildError::TaskMemory {
                    needed: self.memory(),
                    given: options.memory,
                });
            }
            None => {
                self.conquer_anew(number, options.threads).await?;
                open()?.ok_or_else(|| cannot(io::ErrorKind::InvalidData.into()))?
            }
        };
        let runs = block.runs.iter().map(|run| run.length);
        Ok(ConqueredBlock {
            block: number,
            points: block.points,
            tiles: done
                .finished
                .state
                .tiles
                .iter()
                .filter(|tile| tile.vertices > 0)
                .count() as u32,
            was_done,
            bytes_read: if was_done { 0 } else { runs.sum() },
            bytes_written: if was_done { 0 } else { done.length() },
            seconds: began.elapsed().as_secs_f64(),
        })
    }

    async fn conquer_anew(&self, number: u32, threads: usize) -> Result<(), BuildError> {
        let cannot = self.cannot("conquer a block in");
        let threads = threads.clamp(1, self.shares.threads);
        let points = self.block_points(number).await?;
        let file = UnfinishedBlockFile::create(&self.folder, number).map_err(&cannot)?;
        let log = Arc::new(file.log().map_err(&cannot)?);
        let conquest = Arc::new(self.conquest(number, threads, log));
        conquest.board.add(points);
        let first_tile = self.tiles[number as usize].start;
        let (sender, parts) = mpsc::channel(threads);
        let computed = start(Arc::clone(&conquest), first_tile, threads, sender).map_err(&cannot)?;
        let written = write(file.cores().map_err(&cannot)?, parts).await;
        if written.is_err() {
            conquest.board.stop();
        }
        let gone = |_| BuildError::Internal("the thread that conquers a block is gone".to_owned());
        let computed = computed.await.map_err(gone)?;
        let (extents, block) = written.map_err(&cannot)?;
        computed?;
        let (mut finished, seam) = block.ok_or(BuildError::Cancelled)?;
        finished.number = number;
        finished.cores = extents;
        self.fill(&mut finished)?;
        let (folder, id) = (Arc::clone(&self.folder), self.id);
        let completed = blocking(move || file.finish(&folder, &finished, &seam, id)).await;
        completed.flatten().map_err(cannot)
    }

    /// Reads the points and the segments of a block.
    async fn block_points(&self, number: u32) -> Result<BlockPoints, BuildError> {
        let cannot = self.cannot("read segments in");
        let mut store = load(&self.plan.blocks[number as usize], self.folder.spill(), self.plan.has_z).await?;
        let mut draped = Draped::default();
        if let Some(rules) = &self.draping {
            let (memory, progress) = (self.memory.for_surface(), Arc::clone(&self.options.progress));
            let surface = PointSurface::open(&self.folder.surface(), rules.clone(), memory, progress).await;
            draped = surface.map_err(EditError::Read)?.drape(&mut store).await?;
        }
        Ok(BlockPoints {
            number: 0,
            store,
            segments: segments_of(&self.folder, number).map_err(cannot)?,
            of_leaves: Vec::new(),
            draped,
            _permit: None,
        })
    }

    /// Adds the tiles that a block does not use.
    fn fill(&self, block: &mut FinishedBlock) -> Result<(), BuildError> {
        let room = self.tiles[block.number as usize].len();
        if block.state.tiles.len() > room {
            return Err(BuildError::Internal(format!(
                "block {} has {} tiles, more than the {room} of its range",
                block.number,
                block.state.tiles.len()
            )));
        }
        let end = block.cores.last().map_or(0, |core| core.range().end);
        block.cores.resize(room, Extent::raw(end, 0, 0));
        block.state.tiles.resize_with(room, Default::default);
        Ok(())
    }

    fn conquest(&self, number: u32, threads: usize, log: Arc<File>) -> Conquest {
        let first_tile = self.tiles[number as usize].start;
        let tile_vertices = self.options.tile_vertices;
        let log = BorderLog::new(log, 0, self.shares.border_log, tile_vertices, self.plan.has_z);
        Conquest {
            board: Board::new(&self.plan.tree, self.limits.merge_vertices, threads).only(number, first_tile),
            options: Arc::clone(&self.options),
            memory: self.memory,
            spill: self.folder.spill().to_owned(),
            log: Mutex::new(log.starting_at(first_tile)),
            state: Mutex::default(),
            limits: ConquestLimits {
                points: self.points(number),
                block_bytes: self.shares.blocks,
                has_journal: true,
            },
            buffers: Buffers::keeping(threads.div_ceil(2)),
            holes: HoleRules {
                has_holes: self.rules.has_holes,
                exterior: self.options.exterior_is_hole,
            },
            rules: self.rules.clone(),
            held_limits: self.limits.held,
        }
    }
}

/// Starts the thread that starts the computing threads. The receiver gets the result once all have
/// ended.
fn start(
    conquest: Arc<Conquest>,
    first_tile: u32,
    threads: usize,
    sender: Sender,
) -> io::Result<oneshot::Receiver<Result<(), BuildError>>> {
    let (reply, computed) = oneshot::channel();
    start_thread("tile-block", move || {
        let cores = Ordered::new(first_tile, 2 * threads as u32, |_, core| {
            sender.blocking_send(ToWrite::Core(core)).map_err(|_| Closed)
        });
        let abort = || {
            conquest.board.stop();
            cores.close();
        };
        let done = on_threads(threads, || conquest.work(&cores, &sender), abort);
        let done = done.and_then(|()| conquest.outcome());
        drop(cores);
        drop((conquest, sender));
        // The receiver may have been dropped.
        let _ = reply.send(done);
    })?;
    Ok(computed)
}

/// Writes the cores that arrive. Returns their extents, and the block once it is done.
async fn write(
    file: ThreadsFile,
    mut parts: mpsc::Receiver<ToWrite>,
) -> io::Result<(Vec<Extent>, Option<(FinishedBlock, Seam)>)> {
    let mut writer = TileWriter::behind(file, 0);
    let (mut cores, mut block) = (Vec::new(), None);
    while let Some(part) = parts.recv().await {
        match part {
            ToWrite::Core(core) => cores.push(writer.append_core(core).await?),
            ToWrite::Finished(finished) => block = Some(*finished),
            // Borders come after all blocks.
            ToWrite::Border(_) => {}
        }
    }
    writer.flush().await?;
    Ok((cores, block))
}
