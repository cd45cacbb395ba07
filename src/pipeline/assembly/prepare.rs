//! Prepare: divides the memory, finds the work that is left to do, and distributes segments to
//! blocks.

use std::sync::Arc;

use crate::constraints::segments::blocks::BlockSegments;
use crate::constraints::segments::spool::SegmentSpool;
use crate::io::blocking;
use crate::memory::{Load, SEGMENT_BYTES, Shares};
use crate::pipeline::assembly::Assembly;
use crate::pipeline::conquer::leaf::LeafRules;
use crate::pipeline::disk::{DiskLoad, check_disk};
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::drape::PointSurface;
use crate::pipeline::ingest::intake::Points;
use crate::pipeline::ingest::point_store::PointStore;
use crate::pipeline::plan::{BlockPlan, HeldLimits, NodeLimits};
use crate::pipeline::records::FinishedBlocks;
use crate::pipeline::resume::plan::{SavedSettings, save};

/// The parts of a build, once all points have arrived.
pub(crate) struct PreparedBuild {
    pub(crate) plan: BlockPlan,
    pub(crate) store: Option<PointStore>,
    pub(crate) segments: Arc<BlockSegments>,
    pub(crate) rules: LeafRules,
    pub(crate) shares: Shares,
    pub(crate) limits: NodeLimits,
    pub(crate) finished: FinishedBlocks,
    pub(crate) has_journal: bool,
}

impl Assembly {
    /// Divides the memory, finds the blocks that an interrupted build left to do, and distributes
    /// segments to blocks.
    pub(crate) async fn prepare(
        &mut self,
        points: Points,
        segments: SegmentSpool,
    ) -> Result<PreparedBuild, BuildError> {
        let (plan, store, finished) = match points {
            Points::Memory(store) => (
                BlockPlan::in_memory(store.items.len() as u64, store.attributes.has_z()),
                Some(store),
                None,
            ),
            Points::Runs(plan) => (plan, None, None),
            Points::Resumed(plan, finished) => (plan, None, Some(finished)),
        };
        let is_resumed = finished.is_some();
        let finished = finished.unwrap_or_default();
        if self.options.progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        let shares = self.shares(&plan, store.as_ref(), segments.len(), is_resumed)?;
        tracing::info!(plan = %self.memory, %shares, "memory");
        let limits = self.limits.unwrap_or_else(|| self.node_limits(&shares));
        let has_journal = store.is_none() && self.options.resumable.is_some();
        let unfinished = plan.blocks[finished.blocks as usize..].iter();
        let run_bytes: u64 = unfinished.flat_map(|block| &block.runs).map(|run| run.length).sum();
        let is_to_save = has_journal && !is_resumed;
        let load = DiskLoad {
            points: plan.points - finished.points,
            has_z: plan.has_z,
            segments: segments.len(),
            segment_bytes: segments.disk_bytes() + if is_to_save { segments.saved_bytes() } else { 0 },
            spilled_bytes: run_bytes + segments.spilled_bytes(),
        };
        check_disk(&self.folder, load)?;
        let has_lines = !segments.is_empty();
        let saved = (is_to_save && has_lines).then(|| self.folder.lines());
        let (tree, memory, threads) = (plan.tree.clone(), self.memory.for_waiting_segments(), shares.threads);
        let distributed = blocking(move || segments.distribute(&tree, memory, saved.as_deref(), threads)).await;
        let cannot = |error| BuildError::io(self.folder.spill(), "distribute segments in", error);
        let distributed = distributed.map_err(cannot)??;
        if is_to_save {
            self.save(&plan, limits, distributed.saved)?;
        }
        let segments = Arc::new(distributed.blocks?);
        let rules = LeafRules::of(&mut self.given, &self.options, self.first_end, has_lines);
        Ok(PreparedBuild {
            plan,
            store,
            segments,
            rules,
            shares,
            limits,
            finished,
            has_journal,
        })
    }

    fn shares(
        &self,
        plan: &BlockPlan,
        store: Option<&PointStore>,
        segments: u64,
        is_resumed: bool,
    ) -> Result<Shares, BuildError> {
        match store {
            Some(store) => {
                let of_segments = segments * SEGMENT_BYTES;
                Ok(self.memory.shares_in_memory(store.byte_size() + of_segments))
            }
            None => {
                let load = Load {
                    points: plan.points,
                    segments,
                    has_z: plan.has_z,
                };
                let shares = match is_resumed {
                    true => {
                        let largest = plan.blocks.iter().map(|block| block.points).max();
                        self.memory.resumed_shares(load, largest.unwrap_or(0))
                    }
                    false => self.memory.shares(load),
                };
                shares.map_err(BuildError::from)
            }
        }
    }

    /// Returns the limits of nodes, which do not change when the build is resumed.
    fn node_limits(&self, shares: &Shares) -> NodeLimits {
        let [in_leaf, in_node] = self.memory.most_held();
        NodeLimits {
            merge_vertices: shares.merge_vertices,
            held: HeldLimits { in_leaf, in_node },
        }
    }

    /// Saves the plan, once `segments` segments are saved, so that the build can be resumed.
    fn save(&self, plan: &BlockPlan, limits: NodeLimits, segments: u64) -> Result<(), BuildError> {
        let settings = SavedSettings {
            identity: self.options.identity(),
            memory: self.memory.total(),
            arrivals: self.memory.arrivals(),
            limits,
            first_end: self.first_end,
            segments,
        };
        let path = self.folder.plan();
        let draping = self.surface.as_deref().map(PointSurface::rules);
        let saved = save(&path, &settings, &self.given, plan, draping);
        saved.map_err(|error| BuildError::io(&path, "write", error))?;
        self.folder.keep(true);
        Ok(())
    }
}
