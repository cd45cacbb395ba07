//! Open: creates the files that a build writes and the state that its threads share.

use std::fs::File;
use std::path::PathBuf;
use std::sync::Arc;

use parking_lot::Mutex;

use crate::constraints::seeds::HoleRules;
use crate::constraints::segments::blocks::BlockSegments;
use crate::io::{Buffers, ThreadsFile};
use crate::memory::Shares;
use crate::pipeline::assembly::Assembly;
use crate::pipeline::assembly::prepare::PreparedBuild;
pub(crate) use crate::pipeline::conquer::conquest::{Conquest, ConquestLimits};
use crate::pipeline::conquer::leaf::LeafRules;
use crate::pipeline::conquer::schedule::Board;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::point_store::PointStore;
use crate::pipeline::output::border_log::BorderLog;
use crate::pipeline::output::writer::{Journal, Output};
use crate::pipeline::plan::{Block, NodeLimits};
use crate::pipeline::records::{FinishedBlocks, LeftCores};
use crate::pipeline::work_folder::open_at;
use crate::store::KdTree;

/// A build whose files are open.
pub(crate) struct OpenedBuild {
    pub(crate) conquest: Arc<Conquest>,
    pub(crate) output: Output,
    /// Path of the file in the work folder. It has not been given its name yet.
    pub(crate) path: PathBuf,
    pub(crate) blocks: Arc<Vec<Block>>,
    pub(crate) segments: Arc<BlockSegments>,
    /// All points, if they fit in memory.
    pub(crate) store: Option<PointStore>,
    pub(crate) has_z: bool,
    pub(crate) shares: Shares,
    /// The cuts above the blocks.
    pub(crate) tree: KdTree,
    /// The cores that are not in the file.
    pub(crate) left: Vec<LeftCores>,
    /// The first unfinished tile and the first unfinished block.
    pub(crate) first_tile: u32,
    pub(crate) first_block: u32,
    /// Bytes of runs: written, rewritten, and read for rewriting.
    pub(crate) spilled: [u64; 3],
    /// Stops the threads on drop.
    pub(crate) stop: StopOnDrop,
}

/// Stops computing when it is dropped.
pub(crate) struct StopOnDrop(Arc<Conquest>);

impl Drop for StopOnDrop {
    fn drop(&mut self) {
        self.0.board.stop();
    }
}

impl Assembly {
    /// Opens all files, positioned after the data of an earlier build's finished blocks.
    pub(crate) fn open(&self, prepared: PreparedBuild) -> Result<OpenedBuild, BuildError> {
        let PreparedBuild {
            plan,
            store,
            segments,
            rules,
            shares,
            limits: of_nodes,
            finished,
            has_journal,
        } = prepared;
        let path = self.folder.file();
        let file = ThreadsFile::from(Arc::new(open_at(&path, finished.file_length, "make the file")?));
        let log_file = open_at(&self.folder.borders(), finished.log_length, "make the border log")?;
        let log_file = Arc::new(log_file);
        let mut log = BorderLog::new(
            Arc::clone(&log_file),
            finished.log_length,
            shares.border_log,
            self.options.tile_vertices,
            plan.has_z,
        );
        log.number_from(finished.next_number);
        let front_end = plan.front_end(self.options.tile_vertices);
        let blocks = Arc::new(plan.blocks);
        let journal = has_journal
            .then(|| self.journal(&finished, log_file, &blocks))
            .transpose()?;
        let limits = ConquestLimits {
            points: plan.points,
            block_bytes: shares.blocks,
            has_journal,
        };
        let conquest = Arc::new(self.conquest(&plan.tree, (limits, of_nodes), shares.threads, rules, log));
        let (first_tile, first_block) = (finished.cores.len() as u32, finished.blocks);
        Ok(OpenedBuild {
            stop: StopOnDrop(Arc::clone(&conquest)),
            conquest,
            left: finished.left,
            output: Output::new(file, path.clone(), front_end, finished.cores, journal, first_block),
            path,
            blocks,
            segments,
            store,
            has_z: plan.has_z,
            shares,
            tree: plan.tree,
            first_tile,
            first_block,
            spilled: [plan.bytes_written, plan.bytes_rewritten, plan.bytes_read],
        })
    }

    /// Creates the state that the threads share.
    fn conquest(
        &self,
        tree: &KdTree,
        (limits, of_nodes): (ConquestLimits, NodeLimits),
        threads: usize,
        rules: LeafRules,
        log: BorderLog,
    ) -> Conquest {
        Conquest {
            board: Board::new(tree, of_nodes.merge_vertices, threads),
            options: Arc::clone(&self.options),
            memory: self.memory,
            spill: self.folder.spill().to_owned(),
            log: Mutex::new(log),
            state: Mutex::default(),
            limits,
            buffers: Buffers::keeping(threads.div_ceil(2)),
            holes: HoleRules {
                has_holes: rules.has_holes,
                exterior: self.options.exterior_is_hole,
            },
            rules,
            held_limits: of_nodes.held,
        }
    }

    fn journal(
        &self,
        finished: &FinishedBlocks,
        border_log: Arc<File>,
        blocks: &Arc<Vec<Block>>,
    ) -> Result<Journal, BuildError> {
        let path = self.folder.journal();
        let file = open_at(&path, finished.journal_length, "make the journal")?;
        Ok(Journal {
            file: Arc::new(file),
            length: finished.journal_length,
            border_log,
            blocks: Arc::clone(blocks),
            folder: Arc::clone(&self.folder),
        })
    }
}
