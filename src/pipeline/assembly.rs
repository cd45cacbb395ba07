//! From all points and segments to the file: conquest, borders, directory, and the file gets its name.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use futures::future;
use parking_lot::Mutex;
use tokio::sync::{mpsc, oneshot};

use crate::constraints::seeds::{HoleRules, Seeds};
use crate::constraints::segment::Segment;
use crate::constraints::segments::blocks::BlockSegments;
use crate::constraints::segments::spool::SegmentSpool;
use crate::edit::error::EditError;
use crate::edit::tiles::Target;
use crate::edit::{EditSummary, Work, edit};
use crate::geometry::Rect;
use crate::input::MissingZ;
use crate::io::{Backend, Buffers, ThreadsFile, WriteAt, blocking, start_thread};
use crate::memory::{Load, MemoryPlan, SEGMENT_BYTES, Shares, peak_memory};
use crate::pipeline::conquer::conquest::{Conquest, ConquestLimits};
use crate::pipeline::conquer::deferral::Deferral;
use crate::pipeline::conquer::leaf::LeafRules;
use crate::pipeline::conquer::prefetch;
use crate::pipeline::conquer::prefetch::{Coming, Prefetched};
use crate::pipeline::conquer::schedule::{BlockPoints, Board};
use crate::pipeline::disk::{DiskLoad, check_disk};
use crate::pipeline::error::BuildError;
use crate::pipeline::finish::borders::RegionTotals;
use crate::pipeline::ingest::intake::Points;
use crate::pipeline::ingest::point_store::PointStore;
use crate::pipeline::ingest::spill;
use crate::pipeline::options::{BuildOptions, DuplicateRule};
use crate::pipeline::output::border_log::BorderLog;
use crate::pipeline::output::writer::{Journal, Output};
use crate::pipeline::plan::{Block, Plan};
use crate::pipeline::records::{GENERATION, TileState};
use crate::pipeline::resume::journal::{FinishedBlocks, JournalReader, SavedPlan};
use crate::pipeline::run;
use crate::pipeline::summary::{BuildSummary, LevelSummary, Waits, phases};
use crate::pipeline::terms::{Given, Terms};
use crate::pipeline::work_folder::WorkFolder;
use crate::store::{CompactError, Directory, Extent, KdTree, Metadata, OpenOptions, TileEntry, TileReader, hull_edges};

/// A file is written anew if more than one of so many parts of it was, for segments that were put off.
const UNUSED_SHARE: u64 = 8;

/// Makes a file of what came.
pub(crate) struct Assembly {
    options: Arc<BuildOptions>,
    folder: Arc<WorkFolder>,
    output: PathBuf,
    given: Given,
    first_end: u64,
    memory: MemoryPlan,
    began: Instant,
}

impl Assembly {
    /// Of what a build was told, and what came.
    pub(crate) fn new(terms: &Terms, output: &Path, mut given: Given, began: Instant) -> Self {
        given.site_count = given.site_ids.len() as u64;
        Self {
            memory: terms.memory,
            options: Arc::clone(&terms.options),
            folder: Arc::clone(&terms.folder),
            output: output.to_owned(),
            first_end: terms.first_end.load(Ordering::Relaxed),
            given,
            began,
        }
    }

    /// What leaves go by.
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

    /// Builds the file.
    pub(crate) async fn build(
        mut self,
        points: Points,
        segments: SegmentSpool,
        is_resumed: bool,
    ) -> Result<BuildSummary, BuildError> {
        let (plan, store) = match points {
            Points::Memory(store) => (
                Plan::in_memory(store.items.len() as u64, store.attributes.has_z()),
                Some(store),
            ),
            Points::Runs(plan) => (plan, None),
        };
        if self.options.progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        let shares = match &store {
            Some(store) => {
                let of_segments = segments.len() * SEGMENT_BYTES;
                self.memory.shares_in_memory(store.byte_size() + of_segments)
            }
            None => {
                let load = Load {
                    points: plan.points,
                    segments: segments.len(),
                    has_z: plan.has_z,
                };
                match is_resumed {
                    true => {
                        let largest = plan.blocks.iter().map(|block| block.points).max();
                        self.memory.resumed_shares(load, largest.unwrap_or(0))?
                    }
                    false => self.memory.shares(load)?,
                }
            }
        };
        tracing::info!(plan = %self.memory, %shares, "memory");
        let rules = self.leaf_rules(!segments.is_empty());
        // What regions are made of stands in no journal, nor do segments.
        let has_journal = store.is_none() && self.options.resumable.is_some() && !rules.has_regions;
        let mut finished = FinishedBlocks::default();
        if is_resumed {
            finished = FinishedBlocks::read(&self.folder)?;
            spill::check_runs(&plan.blocks[finished.blocks as usize..], self.folder.spill())?;
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
        }
        let (tree, memory) = (plan.tree.clone(), self.memory.for_waiting_segments());
        let distributed = blocking(move || segments.distribute(&tree, memory)).await;
        let cannot = |error| BuildError::io(self.folder.spill(), "distribute segments in", error);
        let segments = Arc::new(distributed.map_err(cannot)??);
        let parts = Parts {
            plan,
            store,
            segments,
            rules,
            shares,
            finished,
            has_journal,
        };
        self.build_parts(parts).await
    }

    async fn build_parts(mut self, parts: Parts) -> Result<BuildSummary, BuildError> {
        let Parts {
            plan,
            store,
            segments,
            rules,
            shares,
            finished,
            has_journal,
        } = parts;
        let path = self.folder.file();
        let cannot = |error| BuildError::io(&path, "make the file", error);
        let file = ThreadsFile::from(Arc::new(open(&path, finished.file_length).map_err(cannot)?));
        let log_path = self.folder.borders();
        let log_file = open(&log_path, finished.log_length);
        let log_file = Arc::new(log_file.map_err(|error| BuildError::io(&log_path, "make the border log", error))?);
        let log = BorderLog::new(
            Arc::clone(&log_file),
            finished.log_length,
            shares.border_log,
            self.options.tile_vertices,
        );
        let blocks = Arc::new(plan.blocks);
        let journal = has_journal
            .then(|| self.journal(&finished, log_file, &blocks))
            .transpose()?;
        let limits = ConquestLimits {
            points: plan.points,
            block_bytes: shares.blocks,
            has_journal,
        };
        let conquest = Arc::new(Conquest {
            board: Board::new(&plan.tree, shares.merge_vertices, shares.threads),
            options: Arc::clone(&self.options),
            memory: self.memory,
            spill: self.folder.spill().to_owned(),
            log: Mutex::new(log),
            found: Mutex::default(),
            limits,
            buffers: Buffers::keeping(shares.threads.div_ceil(2)),
            holes: HoleRules {
                has_holes: rules.has_holes,
                exterior: self.options.exterior_is_hole,
            },
            rules,
            deferral: Arc::new(Deferral::new(self.memory.most_held())),
        });
        // Whoever drops this future stops the threads too.
        let stop = StopOnDrop(&conquest.board);
        let first_tile = finished.cores.len() as u32;
        let resumed_blocks = finished.blocks;
        let mut output = Output::new(file, path.clone(), finished.cores, journal, resumed_blocks);

        let (sender, extents) = mpsc::channel(shares.threads);
        let (reply, computed) = oneshot::channel();
        // The thread holds the folder's lock too: it may outlive this future.
        let (theirs, folder) = (Arc::clone(&conquest), Arc::clone(&self.folder));
        let compute = move || {
            let computed = run::run(&theirs, first_tile, shares.threads, &sender);
            drop((sender, folder));
            // If nobody waits for the answer any more, nobody needs it.
            let _ = reply.send(computed);
        };
        start_thread("tile-build", compute).map_err(|error| BuildError::io(&path, "start a thread to build", error))?;

        let coming = Coming {
            blocks: &blocks,
            segments: &segments,
            first: resumed_blocks as usize,
            has_z: plan.has_z,
        };
        let feed = async {
            let fed = self.feed(&conquest, store, coming, shares).await;
            fed.unwrap_or_else(|error| {
                conquest.fail(error);
                Prefetched::default()
            })
        };
        let write = async {
            let written = output.write_all(extents).await;
            if written.is_err() {
                // The channel is closed now, which stops the threads that send. The others, and the feeding, stop here.
                conquest.board.stop();
            }
            written
        };
        let (prefetched, written) = future::join(feed, write).await;
        let gone = || BuildError::Internal("the building thread is gone".to_owned());
        let computed = computed.await.unwrap_or_else(|_| Err(gone()));
        // If nothing can be written, computing stops for that reason.
        written?;
        let (tiles, regions, began) = computed?;

        let found = std::mem::take(&mut *conquest.found.lock());
        let trees: Vec<KdTree> = found.blocks.iter().map(|block| block.tree.clone()).collect();
        let tree = plan.tree.with_leaves_cut(&trees);
        let ends = found.blocks.iter().map(|block| block.ends).sum();
        let (cores, borders) = output.extents();
        let directory = self.directory(tree, &tiles, cores, borders, ends, &regions);
        let bytes = |extents: &[Extent]| extents.iter().map(|e| u64::from(e.length)).sum::<u64>();
        let [log_read, log_written] = conquest.log.lock().traffic();
        let core_bytes = bytes(&cores[first_tile as usize..]) + output.journal_bytes() + log_written;
        let border_bytes = bytes(borders);
        let deferred = conquest.deferral.take();
        let (mut file_bytes, finish_bytes) = output.finish(&directory, !deferred.is_empty()).await?;
        let border_triangles = conquest.log.lock().triangle_count();
        let starved = conquest.board.starved();
        drop(stop);
        // An edit needs all the memory.
        drop((conquest, segments));
        let edited = match deferred.is_empty() {
            true => EditSummary::default(),
            false => {
                let edited = self.insert(&path, deferred.clone()).await?;
                file_bytes = edited.file_bytes;
                edited
            }
        };
        if let Some(inverted) = self.given.inverted_if_uncrossed {
            return Err(BuildError::Inverted(inverted));
        }
        if self.options.progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        if !self.options.force && self.output.exists() {
            return Err(BuildError::OutputExists(self.output.clone()));
        }
        self.folder.publish()?;

        let mut levels: Vec<LevelSummary> = Vec::new();
        for of_part in found.blocks.iter().map(|block| &block.levels).chain([&found.levels]) {
            levels.resize_with(levels.len().max(of_part.len()), LevelSummary::default);
            levels
                .iter_mut()
                .zip(of_part)
                .for_each(|(level, part)| level.add(*part));
        }
        let mut metadata = directory.metadata.clone();
        if !deferred.is_empty() {
            metadata.constraint_edges = edited.constraint_edges;
            metadata.regions = edited.regions;
            metadata.hole_regions = edited.hole_regions;
            metadata.hole_triangles = edited.hole_triangles;
        }
        Ok(BuildSummary {
            points: metadata.points,
            duplicates: metadata.duplicates,
            vertices: metadata.vertices,
            triangles: metadata.triangles,
            border_triangles,
            hull_edges: metadata.hull_edges,
            ends: metadata.ends,
            constraint_edges: metadata.constraint_edges,
            crossings: metadata.crossings,
            split_points: self.given.split_points,
            sites: metadata.sites,
            regions: metadata.regions,
            hole_regions: metadata.hole_regions,
            hole_triangles: metadata.hole_triangles,
            inverted_regions: self.given.put_right.parts,
            first_inverted: self.given.put_right.inverted.map(|inverted| inverted.first),
            held_triangles: found.blocks.iter().map(|block| block.held_triangles).sum(),
            deferred_segments: deferred.len() as u64,
            without_z: found.without_z.count,
            tiles: directory.tiles.len() as u64,
            file_bytes,
            blocks: blocks.len() as u64,
            resumed_blocks: resumed_blocks.into(),
            waits: Waits {
                computing_for_blocks: starved,
                computing_for_writing: found.waited_to_write,
                blocks_for_computing: prefetched.waited,
            },
            phases: phases(
                self.began,
                &began,
                [0, plan.bytes_read, prefetched.bytes, log_read, 0],
                [
                    plan.bytes_written,
                    plan.bytes_rewritten,
                    core_bytes,
                    border_bytes,
                    finish_bytes,
                ],
            ),
            levels,
            peak_memory: peak_memory(),
        })
    }

    /// Gives the board its blocks: that in memory, those that were finished before, those that must be read.
    async fn feed(
        &self,
        conquest: &Arc<Conquest>,
        store: Option<PointStore>,
        coming: Coming<'_>,
        shares: Shares,
    ) -> Result<Prefetched, BuildError> {
        if let Some(store) = store {
            if !store.items.is_empty() {
                conquest.board.add(BlockPoints {
                    number: 0,
                    store,
                    segments: coming
                        .segments
                        .take(0)
                        .map_err(|error| BuildError::io(self.folder.spill(), "read segments in", error))?,
                    of_leaves: Vec::new(),
                    _permit: None,
                });
            }
            return Ok(Prefetched::default());
        }
        if coming.first > 0 {
            let path = self.folder.journal();
            let cannot = |error| BuildError::io(&path, "read", error);
            let mut reader = JournalReader::open(&path).map_err(cannot)?;
            for _ in 0..coming.first {
                let entry = reader.next().map_err(cannot)?;
                let (block, seam) = entry.ok_or_else(|| cannot(io::ErrorKind::InvalidData.into()))?;
                conquest.restore(block, seam);
            }
        }
        prefetch::feed(
            &conquest.board,
            coming,
            self.folder.spill(),
            shares.blocks,
            conquest.limits.has_journal,
        )
        .await
    }

    /// Inserts the segments that were put off into the file, which has no name yet.
    async fn insert(&self, path: &Path, segments: Vec<Segment>) -> Result<EditSummary, BuildError> {
        let _span = tracing::debug_span!("insert", segments = segments.len()).entered();
        let (progress, folder) = (Arc::clone(&self.options.progress), Arc::clone(&self.folder));
        // The thread holds the folder's lock too: it may outlive this future.
        let is_cancelled = move || {
            let _ = &folder;
            progress.is_cancelled()
        };
        let work = Work {
            segments,
            z: Vec::new(),
            lines: Vec::new(),
            new_records: 0,
            missing_z: MissingZ::Zero,
            inverted: None,
            is_draft: true,
            threads: self.options.threads,
        };
        let mut edited = edit(Target::lock(path)?, work, self.memory.total(), is_cancelled).await?;
        if edited.bytes_appended > edited.file_bytes / UNUSED_SHARE {
            // What was just written is in the page cache, which a ring may read past.
            let options = OpenOptions::default()
                .memory(self.memory.rest())
                .backend(Backend::Threads);
            let reader = TileReader::open(path, options).await;
            let reader = reader.map_err(EditError::Read)?;
            let compacted = reader.compact(path).await;
            edited.file_bytes = compacted.map_err(|error| match error {
                CompactError::Read(error) => EditError::Read(error).into(),
                CompactError::Io { what, source, .. } => BuildError::io(path, what, source),
            })?;
        } else {
            let file = File::options().write(true).open(path);
            let file = file.map_err(|error| BuildError::io(path, "open", error))?;
            let synced = ThreadsFile::from(Arc::new(file)).sync().await;
            synced.map_err(|error| BuildError::io(path, "sync", error))?;
        }
        Ok(edited)
    }

    fn journal(
        &self,
        finished: &FinishedBlocks,
        border_log: Arc<File>,
        blocks: &Arc<Vec<Block>>,
    ) -> Result<Journal, BuildError> {
        let path = self.folder.journal();
        let file = open(&path, finished.journal_length);
        Ok(Journal {
            file: Arc::new(file.map_err(|error| BuildError::io(&path, "make the journal", error))?),
            length: finished.journal_length,
            border_log,
            blocks: Arc::clone(blocks),
            folder: Arc::clone(&self.folder),
        })
    }

    /// The directory of a file whose extents are all written.
    fn directory(
        &mut self,
        tree: KdTree,
        states: &[TileState],
        cores: &[Extent],
        borders: &[Extent],
        ends: u64,
        regions: &RegionTotals,
    ) -> Directory {
        let extents = cores.iter().zip(borders);
        let entry = |(tile, (&core, &border)): (&TileState, (&Extent, &Extent))| TileEntry {
            core,
            border,
            generation: GENERATION,
            vertices: tile.vertices,
            core_triangles: tile.core_triangles,
            border_triangles: tile.border_triangles,
            owned_triangles: tile.owned_triangles,
            bounds: tile.bounds,
        };
        let tiles: Vec<TileEntry> = states.iter().zip(extents).map(entry).collect();
        let vertices = tiles.iter().map(|t| u64::from(t.vertices)).sum();
        let triangles = tiles.iter().map(|t| u64::from(t.owned_triangles)).sum();
        let metadata = Metadata {
            points: self.given.points,
            has_z: self.given.has_z,
            sources: self.given.description.sources.clone(),
            crs: self.given.description.crs.clone(),
            tile_vertices: self.options.tile_vertices as u32,
            vertices,
            triangles,
            bounds: tiles.iter().fold(Rect::EMPTY, |all, t| all.union(t.bounds)),
            duplicates: (self.given.points + ends).saturating_sub(vertices),
            ends,
            sites: self.given.site_count,
            crossings: self.given.crossings,
            borders: std::mem::take(&mut self.given.borders),
            lines: self.given.description.lines.clone(),
            next_record: self.given.next_record,
            exterior_is_hole: self.options.exterior_is_hole,
            seeds: std::mem::take(&mut self.given.seeds),
            constraint_edges: states.iter().map(|state| state.constraint_edges).sum(),
            regions: regions.regions,
            spanning_regions: regions.spanning,
            hole_regions: regions.hole_regions,
            hole_triangles: regions.hole_triangles,
            hull_edges: hull_edges(vertices, triangles),
            ..Metadata::default()
        };
        Directory { metadata, tree, tiles }
    }
}

/// Stops computing when it is dropped.
struct StopOnDrop<'a>(&'a Board);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.stop();
    }
}

/// What a build is made of, once all points are there.
struct Parts {
    plan: Plan,
    store: Option<PointStore>,
    segments: Arc<BlockSegments>,
    rules: LeafRules,
    shares: Shares,
    finished: FinishedBlocks,
    has_journal: bool,
}

/// Opens a file to write behind its first `length` bytes, and to read; what comes after those goes away.
fn open(path: &Path, length: u64) -> io::Result<File> {
    let file = File::options()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(path)?;
    file.set_len(length)?;
    Ok(file)
}
