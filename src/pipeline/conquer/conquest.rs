//! Conquer and merge: runs the board's tasks on threads, and collects the results of tiles.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use parking_lot::Mutex;

use crate::constraints::seeds::HoleRules;
use crate::geometry::Rect;
use crate::io::Buffers;
use crate::memory::{HELD_WORK_BYTES, MemoryPlan, MemoryUse, SEAM_WORK_BYTES};
pub(crate) use crate::pipeline::conquer::conquest_state::{ConquestLimits, ConquestState};
use crate::pipeline::conquer::constrain::FinalOutput;
use crate::pipeline::conquer::constrain::refusal::{Crossed, Overlaps, Refusal};
use crate::pipeline::conquer::leaf::{Leaf, LeafError, LeafInput, LeafRules, conquer};
use crate::pipeline::conquer::merge::merge;
use crate::pipeline::conquer::node::Workspace;
use crate::pipeline::conquer::schedule::{BlockPoints, Board, NodeScope, Task};
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::missing_z::FirstRecords;
use crate::pipeline::options::{BuildOptions, Phase};
use crate::pipeline::output::border_log::BorderLog;
use crate::pipeline::output::ordered::{Closed, Ordered};
use crate::pipeline::output::writer::{Sender, ToWrite};
use crate::pipeline::plan::HeldLimits;
use crate::pipeline::records::{BlockState, DoneEdge, GENERATION, Pending, Seam, TileState};
use crate::pipeline::resume::journal::FinishedBlock;
use crate::pipeline::summary::LevelSummary;
use crate::store::{Part, StoredPart, TileId};

/// Conquers leaves and merges seams.
pub(crate) struct Conquest {
    pub(crate) board: Board,
    pub(crate) options: Arc<BuildOptions>,
    pub(crate) memory: MemoryPlan,
    /// The folder that the border log is spilled to.
    pub(crate) spill: PathBuf,
    pub(crate) log: Mutex<BorderLog>,
    pub(crate) state: Mutex<ConquestState>,
    pub(crate) limits: ConquestLimits,
    /// Buffers for the cores on their way to the file.
    pub(crate) buffers: Buffers,
    pub(crate) rules: LeafRules,
    pub(crate) holes: HoleRules,
    pub(crate) held_limits: HeldLimits,
}

impl Conquest {
    /// Runs one thread's work: tasks until there are no more.
    pub(crate) fn work<F>(&self, cores: &Ordered<StoredPart, F>, sender: &Sender)
    where
        F: FnMut(u32, StoredPart) -> Result<(), Closed>,
    {
        let mut workspace = Workspace::new(
            self.options.engine.create(),
            self.buffers.clone(),
            self.held_limits,
            self.memory.most_sources(),
        );
        while let Some(task) = self.board.take() {
            let done = match task {
                Task::Divide { block, threads } => self.divide(block, threads),
                Task::Leaf {
                    node,
                    tile,
                    block,
                    points,
                } => self.leaf(&mut workspace, node, tile, &block, points, cores, sender),
                Task::Merge { node, seams } => self.merge(&mut workspace, node, seams, sender),
            };
            if done.is_err() {
                self.board.abandon();
            }
            if self.options.progress.is_cancelled() {
                self.fail(BuildError::Cancelled);
            }
            let state = self.state.lock();
            if state.failed.is_some() || done.is_err() && !state.has_refused() {
                self.board.stop();
                cores.close();
            } else if state.has_refused() {
                // Leaves in work would wait for others that will not come.
                cores.close();
            }
        }
    }

    /// Stops the work. The first error is kept.
    pub(crate) fn fail(&self, error: BuildError) {
        self.state.lock().failed.get_or_insert(error);
        self.board.stop();
    }

    pub(crate) fn add_block(&self, block: BlockState) {
        self.log.lock().add_tiles(block.tiles.len() as u32);
        self.note_block(&mut self.state.lock(), block);
    }

    fn note_block(&self, state: &mut ConquestState, block: BlockState) {
        state.blocks.push(block);
        if state.conquer_began.is_none() {
            state.conquer_began = Some(Instant::now());
            self.options.progress.start(Phase::Conquer, self.limits.points);
        }
    }

    /// Restores a block that an earlier build finished.
    pub(crate) fn restore(&self, block: FinishedBlock, seam: Seam) {
        let FinishedBlock {
            number,
            state: block,
            chunks,
            ..
        } = block;
        let tiles = block.tiles.len() as u32;
        let points = seam.below + block.duplicates;
        if self.board.block_cell(number) == Rect::PLANE {
            // The log has its edges already.
            self.note_root(&seam.pending);
        }
        self.log.lock().restore(tiles, chunks, block.late_triangles);
        let mut state = self.state.lock();
        state.points_done += points;
        state.growth.observe(seam.below, seam.vertices.len() as u64);
        self.note_block(&mut state, block);
        drop(state);
        self.options.progress.advance(points, 0);
        self.board.restore(number, tiles, seam);
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "a leaf is what a task says of it, and where its results go"
    )]
    fn leaf<F: FnMut(u32, StoredPart) -> Result<(), Closed>>(
        &self,
        workspace: &mut Workspace,
        node: u32,
        tile: TileId,
        block: &BlockPoints,
        points: Range<usize>,
        cores: &Ordered<StoredPart, F>,
        sender: &Sender,
    ) -> Result<(), Closed> {
        let began = Instant::now();
        cores.begin(tile.0)?;
        let waited = began.elapsed();
        let _span = tracing::debug_span!("leaf", tile = tile.0).entered();
        let items = &block.store.items[points];
        let scope = self.board.scope(node);
        let of_block = tile.0 - self.state.lock().blocks[block.number as usize].first_tile;
        let input = LeafInput {
            tile,
            cell: scope.cell,
            items,
            attributes: &block.store.attributes,
            segments: &block.segments,
            segment_indices: block
                .of_leaves
                .get(of_block as usize)
                .map_or(&[], |segment_indices| segment_indices),
        };
        let leaf = match conquer(workspace, input, &self.rules) {
            Ok(leaf) => leaf,
            Err(error) => return self.refuse(error),
        };
        if scope.cell == Rect::PLANE {
            self.take_root(&leaf.seam.pending)?;
        }
        let core = workspace.core.encode(tile, GENERATION, &workspace.buffers);
        let core = self.options.codec().store(core, Part::Core);
        let counts = [workspace.core.points.len(), workspace.core.triangles.len()];
        self.state.lock().waited_to_write += waited;
        self.note_leaf(tile, block.number, items.len(), counts, &leaf);
        let mut log = self.log.lock();
        let appended = log
            .append_boundary_edges(tile, &leaf.boundary_edges)
            .and_then(|()| log.append_edges(&leaf.edges))
            .and_then(|()| log.append_anchors(tile, &leaf.components.anchors));
        drop(log);
        self.logged(appended)?;
        let began = Instant::now();
        cores.put(tile.0, core)?;
        self.state.lock().waited_to_write += began.elapsed();
        let count = items.len() as u64;
        self.options.progress.advance(count, count);
        self.pass_up(node, scope, leaf.seam, 0, sender)
    }

    /// Records the results of a leaf: its vertices and the triangles that it settled.
    fn note_leaf(&self, tile: TileId, block: u32, points: usize, [vertices, settled]: [usize; 2], leaf: &Leaf) {
        let mut state = self.state.lock();
        state.points_done += points as u64;
        let of_block = &mut state.blocks[block as usize];
        of_block.duplicates += leaf.duplicates;
        of_block.ends += leaf.ends;
        of_block.without_z += leaf.without_z;
        of_block.digest += leaf.digest;
        of_block.held_triangles += leaf.seam.pending.held.len() as u64;
        count(&mut of_block.levels, vertices, settled, &leaf.seam);
        of_block.tiles[(tile.0 - of_block.first_tile) as usize] = TileState {
            vertices: vertices as u32,
            core_triangles: settled as u32,
            bounds: leaf.bounds,
            constraint_edges: leaf.constraint_edges,
            components: leaf.components.count,
            open_components: leaf.components.open,
            core_sum: leaf.digest.triangles,
            // Set when its border is assembled.
            border_triangles: 0,
            owned_triangles: 0,
        };
        let seeded = leaf.seeded.iter().map(|&component| (tile.0, component));
        of_block.seeded.extend(seeded);
        of_block.with_sites.extend(leaf.has_sites.then_some(tile.0));
    }

    fn merge(&self, workspace: &mut Workspace, node: u32, seams: Vec<Seam>, sender: &Sender) -> Result<(), Closed> {
        let _span = tracing::debug_span!("merge", node, seams = seams.len()).entered();
        let scope = self.board.scope(node);
        let vertices = seams.iter().map(|seam| seam.vertices.len()).sum();
        let bytes = seams.iter().map(Seam::byte_size).sum();
        let merged = merge(workspace, seams, scope.cell);
        let (FinalOutput { triangles: late, edges }, seam) = match merged {
            Ok(merged) => merged,
            Err(refusal) => return self.refuse(refusal.into()),
        };
        if scope.cell == Rect::PLANE {
            self.take_root(&seam.pending)?;
        }
        let mut log = self.log.lock();
        let appended = log.append_triangles(&late).and_then(|()| log.append_edges(&edges));
        drop(log);
        self.logged(appended)?;
        {
            let mut state = self.state.lock();
            match scope.block {
                Some(block) => {
                    let block = &mut state.blocks[block as usize];
                    block.late_triangles += late.len() as u64;
                    count(&mut block.levels, vertices, late.len(), &seam);
                }
                None => count(&mut state.levels, vertices, late.len(), &seam),
            }
        }
        self.pass_up(node, scope, seam, bytes, sender)
    }

    /// Stops the work because the segments cannot all become edges.
    fn refuse(&self, error: LeafError) -> Result<(), Closed> {
        match error {
            // The leaves that own the crossing points report them.
            LeafError::Refused(Refusal::Crossed(crossed)) => {
                self.state.lock().crossed = Some(crossed);
                self.board.only_divide();
            }
            LeafError::Refused(Refusal::Overlaps(Overlaps { sources, point })) => {
                let needed = self.memory.sources_memory(sources);
                let overlaps = MemoryUse::Overlaps { point };
                self.fail(self.memory.shortage(overlaps, needed).into());
            }
            LeafError::OpenRing(source) => {
                self.fail(BuildError::OpenRing {
                    obstacle: source.number(),
                });
            }
        }
        Err(Closed)
    }

    /// Takes what is left at the root, and logs its edges.
    fn take_root(&self, pending: &Pending) -> Result<(), Closed> {
        let edges = self.note_root(pending);
        let appended = self.log.lock().append_edges(&edges);
        self.logged(appended)
    }

    /// Takes what is left at the root: the deferred segments, and pending subsegments. There are
    /// none of these unless the input is collinear: without triangles, the subsegments themselves
    /// become edges, which are returned.
    fn note_root(&self, pending: &Pending) -> Vec<DoneEdge> {
        let edges = pending.subsegments.iter().map(|subsegment| DoneEdge {
            ends: subsegment.ends.map(|index| pending.vertices[index as usize]),
            source: subsegment.source,
        });
        let edges: Vec<DoneEdge> = edges.collect();
        let mut state = self.state.lock();
        state.deferred = pending.deferred.clone();
        let next_on_line = edges.iter().filter_map(|edge| edge.end_elsewhere());
        state.next_on_line.extend(next_on_line);
        edges
    }

    fn logged(&self, appended: std::io::Result<()>) -> Result<(), Closed> {
        appended.map_err(|error| {
            self.fail(BuildError::io(&self.spill, "spill the border log in", error));
            Closed
        })
    }

    /// Passes the seam of a node to the board, and that of a whole block to the journal as well.
    fn pass_up(
        &self,
        node: u32,
        scope: NodeScope,
        seam: Seam,
        merged_bytes: u64,
        sender: &Sender,
    ) -> Result<(), Closed> {
        if let Some(block) = scope.block.filter(|_| scope.is_block && self.limits.has_journal) {
            let tiles = self.state.lock().blocks[block as usize].tile_range();
            let (chunks, next_number) = {
                let mut log = self.log.lock();
                (log.finish_block(tiles), log.next_number())
            };
            let chunks = match chunks {
                Ok(chunks) => chunks,
                Err(error) => return self.logged(Err(error)),
            };
            let finished = FinishedBlock {
                number: block,
                state: self.state.lock().blocks[block as usize].clone(),
                cores: Vec::new(),
                chunks,
                next_number,
            };
            let finished = ToWrite::Finished(Box::new((finished, seam.clone())));
            sender.blocking_send(finished).map_err(|_| Closed)?;
        }
        let below = seam.below;
        let seam_vertices = seam.vertices.len() as u64;
        let load = self.board.done(node, seam, merged_bytes);
        let mut state = self.state.lock();
        if seam_vertices > 0 {
            state.growth.observe(below, seam_vertices);
        }
        let budget = self.memory.rest();
        let blocks = if load.blocks_in_memory {
            self.limits.block_bytes
        } else {
            0
        };
        let held = load.next_held * HELD_WORK_BYTES;
        let now = blocks + load.bytes + load.next_vertices * SEAM_WORK_BYTES + held;
        // A fortieth of the points, and cells eight times as large as others, suffice to
        // extrapolate. If the build fails anyway, less suffices to estimate the memory that it
        // would take.
        let is_over = now > budget;
        let enough = is_over || state.points_done * 40 >= self.limits.points;
        let root = state
            .growth
            .root_bytes(self.limits.points, if is_over { 1.5 } else { 7.0 });
        let needed = now.max(root.filter(|_| enough).unwrap_or(0));
        let points_done = state.points_done;
        drop(state);
        if needed > budget {
            self.fail(if held > now / 2 {
                // Assumes that all cells will hold as many triangles as those that are done.
                let share = self.limits.points as f64 / points_done.max(1) as f64;
                let needed = ((now as f64 * share) as u64).max(now);
                self.memory.shortage(MemoryUse::Held, needed).into()
            } else {
                self.memory.shortage(MemoryUse::Seams, needed).into()
            });
        }
        Ok(())
    }

    /// Returns the error of the build, if there is one.
    pub(crate) fn outcome(&self) -> Result<(), BuildError> {
        let mut state = self.state.lock();
        if let Some(error) = state.failed.take() {
            return Err(error);
        }
        if state.crossings.count() > 0 {
            return Err(BuildError::Crossings {
                first: state.crossings.first().to_vec(),
                count: state.crossings.count(),
            });
        }
        let firsts = FirstRecords {
            end: self.rules.duplicates.first_end,
            crossing: self.rules.first_crossing,
            site: self.rules.first_site,
        };
        if let Some(first) = state.without_z.first(firsts) {
            let count = state.without_z.count;
            return Err(BuildError::NoZ { first, count });
        }
        match (state.first_duplicate, state.crossed) {
            (Some((records, point)), _) => Err(BuildError::Duplicate { records, point }),
            (_, Some(Crossed { subsegment, edge })) => Err(BuildError::Internal(format!(
                "a subsegment from {:?} to {:?} crosses the constraint from {:?} to {:?}, and no segments cross there",
                subsegment[0], subsegment[1], edge[0], edge[1]
            ))),
            (None, None) => Ok(()),
        }
    }
}

/// Adds a node to the counts of its level.
fn count(levels: &mut Vec<LevelSummary>, vertices: usize, settled: usize, seam: &Seam) {
    let level = seam.level - 1;
    if levels.len() <= level {
        levels.resize_with(level + 1, LevelSummary::default);
    }
    levels[level].add(LevelSummary {
        nodes: 1,
        vertices: vertices as u64,
        settled: settled as u64,
        seam_vertices: seam.vertices.len() as u64,
    });
}
