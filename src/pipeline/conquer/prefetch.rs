//! Reads blocks ahead of those in work.
//!
//! In: the plan and the journal. Out: the board gets the blocks one by one, in order. A block is
//! read once there is memory for it: permits are counted in bytes, and a block returns its permit
//! on drop. So as many blocks are read ahead as fit, and computing waits for a block only if
//! reading is slower. Several reads are in progress at a time. Chunks are checked and decoded on
//! threads that may block.

use std::collections::VecDeque;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use bytes::Bytes;
use tokio::sync::Semaphore;
use tokio::task::JoinHandle;
use tracing::Instrument;

use crate::constraints::segments::blocks::BlockSegments;
use crate::io::{ReadAt, ThreadsFile, blocking};
use crate::memory::{SEGMENT_BYTES, point_bytes};
use crate::pipeline::conquer::schedule::{BlockPoints, Board};
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::drape::PointSurface;
use crate::pipeline::ingest::point_store::PointStore;
use crate::pipeline::ingest::spill;
use crate::pipeline::ingest::spill::run::{HEADER, chunk_length, decode_chunk};
use crate::pipeline::plan::Block;
use crate::pipeline::records::Draped;

/// Bytes of one read.
const READ_BYTES: u64 = 1 << 20;
/// Number of reads in progress.
const AHEAD: usize = 4;
/// Bytes per permit.
const UNIT: u64 = 1 << 10;

/// Statistics of reading ahead.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Prefetched {
    pub(crate) bytes: u64,
    /// Time that a block could not be read because earlier blocks took all memory.
    pub(crate) waited: Duration,
}

/// The blocks of a build. Those from `first` on must still be read.
#[derive(Clone, Copy)]
pub(crate) struct UnreadBlocks<'a> {
    pub(crate) blocks: &'a [Block],
    pub(crate) segments: &'a Arc<BlockSegments>,
    pub(crate) first: usize,
    pub(crate) has_z: bool,
    /// The surface from which points without z take it.
    pub(crate) surface: Option<&'a PointSurface>,
}

/// Gives the board the blocks from `first` on. Deletes the runs that were read, unless the journal
/// needs them.
pub(crate) async fn feed(
    board: &Board,
    UnreadBlocks {
        blocks,
        segments,
        first,
        has_z,
        surface,
    }: UnreadBlocks<'_>,
    folder: &Path,
    memory: u64,
    has_journal: bool,
) -> Result<Prefetched, BuildError> {
    let permits = (memory / UNIT)
        .clamp(1, Semaphore::MAX_PERMITS as u64)
        .min(u64::from(u32::MAX)) as u32;
    let semaphore = Arc::new(Semaphore::new(permits as usize));
    let mut done = Prefetched::default();
    for (number, block) in blocks.iter().enumerate().skip(first) {
        let bytes = block.points * point_bytes(has_z) + segments.count(number as u32) * SEGMENT_BYTES;
        let wanted = bytes.div_ceil(UNIT).min(permits.into()) as u32;
        let began = Instant::now();
        let permit = Arc::clone(&semaphore).acquire_many_owned(wanted).await;
        done.waited += began.elapsed();
        let span = tracing::debug_span!("prefetch", block = number, points = block.points);
        let mut store = load(block, folder, has_z).instrument(span).await?;
        let draped = match surface {
            Some(surface) => surface.drape(&mut store).await?,
            None => Draped::default(),
        };
        done.bytes += block.runs.iter().map(|run| run.length).sum::<u64>();
        if !has_journal {
            let paths: Vec<PathBuf> = block.runs.iter().map(|run| run.path(folder)).collect();
            // A run that cannot be deleted is deleted with the folder.
            drop(blocking(move || {
                paths.iter().map(std::fs::remove_file).filter(Result::is_err).count()
            }));
        }
        let all = Arc::clone(segments);
        let taken = blocking(move || all.take(number as u32)).await;
        let its_segments = taken
            .flatten()
            .map_err(|error| BuildError::io(folder, "read segments in", error))?;
        let is_wanted = board.add(BlockPoints {
            number: number as u32,
            store,
            segments: its_segments,
            of_leaves: Vec::new(),
            draped,
            _permit: permit.ok(),
        });
        if !is_wanted {
            break;
        }
    }
    Ok(done)
}

/// A block that is being read: its points so far, and the bytes of an incomplete chunk.
struct Loading {
    store: PointStore,
    rest: Vec<u8>,
    path: PathBuf,
    has_z: bool,
}

/// Reads the points of a block.
pub(crate) async fn load(block: &Block, folder: &Path, has_z: bool) -> Result<PointStore, BuildError> {
    let mut loading = Loading {
        store: PointStore::with_capacity(block.points as usize, has_z),
        rest: Vec::new(),
        path: PathBuf::new(),
        has_z,
    };
    for run in &block.runs {
        loading.path = run.path(folder);
        let path = loading.path.clone();
        let cannot = |error| BuildError::io(&path, "read", error);
        let file = ThreadsFile::open(&path).map_err(cannot)?;
        let mut starts = (0..run.length).step_by(READ_BYTES as usize);
        let mut reads: VecDeque<JoinHandle<io::Result<Bytes>>> = VecDeque::new();
        loop {
            let more = starts.by_ref().take(AHEAD - reads.len());
            reads.extend(more.map(|at| tokio::spawn(file.read_at(at..run.length.min(at + READ_BYTES)))));
            let Some(read) = reads.pop_front() else { break };
            let bytes = read
                .await
                .map_err(io::Error::other)
                .and_then(|read| read)
                .map_err(cannot)?;
            let taken = blocking(move || loading.take(&bytes)).await;
            loading = taken.flatten().map_err(cannot)?;
        }
        if !loading.rest.is_empty() {
            return Err(cannot(spill::damaged(&path, "the last chunk is cut short")));
        }
    }
    if loading.store.items.len() as u64 != block.points {
        return Err(BuildError::io(
            folder,
            "read the runs in",
            spill::damaged(folder, "points are missing"),
        ));
    }
    Ok(loading.store)
}

impl Loading {
    /// Appends bytes, and takes the points of all complete chunks.
    fn take(mut self, bytes: &[u8]) -> io::Result<Self> {
        self.rest.extend_from_slice(bytes);
        let mut at = 0;
        while let Some(header) = self.rest[at..].first_chunk::<HEADER>() {
            let length = chunk_length(header, u64::MAX).map_err(|problem| spill::damaged(&self.path, problem))?;
            let Some(chunk) = self.rest[at..].get(..length) else {
                break;
            };
            let take = |record| self.store.push_record(record, self.has_z);
            decode_chunk(chunk, take).map_err(|problem| spill::damaged(&self.path, problem))?;
            at += length;
        }
        self.rest.drain(..at);
        Ok(self)
    }
}
