//! Prepare: divides the memory, finds the work that is left to do, and distributes segments to
//! blocks.

use std::sync::Arc;

use crate::constraints::seeds::Seeds;
use crate::constraints::segments::blocks::BlockSegments;
use crate::constraints::segments::spool::SegmentSpool;
use crate::io::blocking;
use crate::memory::{Load, SEGMENT_BYTES, Shares};
use crate::pipeline::assembly::Assembly;
use crate::pipeline::conquer::leaf::LeafRules;
use crate::pipeline::disk::{DiskLoad, check_disk};
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::intake::Points;
use crate::pipeline::ingest::point_store::PointStore;
use crate::pipeline::ingest::spill::resplit::check_runs;
use crate::pipeline::options::DuplicateRule;
use crate::pipeline::plan::BlockPlan;
use crate::pipeline::resume::journal::{FinishedBlocks, SavedPlan};

/// The parts of a build, once all points have arrived.
pub(crate) struct PreparedBuild {
    pub(crate) plan: BlockPlan,
    pub(crate) store: Option<PointStore>,
    pub(crate) segments: Arc<BlockSegments>,
    pub(crate) rules: LeafRules,
    pub(crate) shares: Shares,
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
        is_resumed: bool,
    ) -> Result<PreparedBuild, BuildError> {
        let (plan, store) = match points {
            Points::Memory(store) => (
                BlockPlan::in_memory(store.items.len() as u64, store.attributes.has_z()),
                Some(store),
            ),
            Points::Runs(plan) => (plan, None),
        };
        if self.options.progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        let shares = self.shares(&plan, store.as_ref(), segments.len(), is_resumed)?;
        tracing::info!(plan = %self.memory, %shares, "memory");
        let rules = self.leaf_rules(!segments.is_empty());
        // The journal holds neither segments nor the data that regions are computed from.
        // Nor does it hold the surface.
        let can_journal = !rules.has_regions && self.surface.is_none();
        let has_journal = store.is_none() && self.options.resumable.is_some() && can_journal;
        let mut finished = FinishedBlocks::default();
        if is_resumed {
            finished = FinishedBlocks::read(&self.folder)?;
            check_runs(&plan.blocks[finished.blocks as usize..], self.folder.spill())?;
        }
        let unfinished = plan.blocks[finished.blocks as usize..].iter();
        let run_bytes: u64 = unfinished.flat_map(|block| &block.runs).map(|run| run.length).sum();
        let load = DiskLoad {
            points: plan.points - finished.points,
            has_z: plan.has_z,
            segments: segments.len(),
            segment_bytes: segments.disk_bytes(),
            spilled_bytes: run_bytes + segments.spilled_bytes(),
        };
        check_disk(&self.folder, load)?;
        if has_journal && !is_resumed {
            self.save_plan(&plan)?;
        }
        let (tree, memory) = (plan.tree.clone(), self.memory.for_waiting_segments());
        let distributed = blocking(move || segments.distribute(&tree, memory)).await;
        let cannot = |error| BuildError::io(self.folder.spill(), "distribute segments in", error);
        let segments = Arc::new(distributed.map_err(cannot)??);
        Ok(PreparedBuild {
            plan,
            store,
            segments,
            rules,
            shares,
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

    /// Saves the plan of blocks, so that the build can be resumed.
    fn save_plan(&self, plan: &BlockPlan) -> Result<(), BuildError> {
        let saved = SavedPlan {
            identity: self.options.identity(),
            description: self.given.description.clone(),
            next_record: self.given.next_record,
            plan: plan.clone(),
        };
        let path = self.folder.plan();
        saved
            .save(&path)
            .map_err(|error| BuildError::io(&path, "write", error))?;
        self.folder.keep(true);
        Ok(())
    }

    /// Returns the rules for leaves.
    fn leaf_rules(&mut self, has_regions: bool) -> LeafRules {
        LeafRules {
            duplicates: DuplicateRule {
                duplicates: self.options.duplicates,
                first_end: self.first_end,
            },
            has_regions: has_regions || !self.given.seeds.is_empty() || self.options.exterior_is_hole,
            has_holes: self.given.has_obstacles || !self.given.seeds.is_empty() || self.options.exterior_is_hole,
            seeds: Seeds::new(self.given.seeds.clone()),
            first_site: if self.given.site_count > 0 {
                self.given.first_site
            } else {
                u64::MAX
            },
            site_ids: std::mem::take(&mut self.given.site_ids),
            first_crossing: self.given.first_crossing,
        }
    }
}
