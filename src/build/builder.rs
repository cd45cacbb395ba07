//! The builder: takes points, and makes a file of them.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

use futures::future;
use parking_lot::Mutex;
use tokio::sync::{mpsc, oneshot};

use super::border_log::BorderLog;
use super::budget::{self, Shares};
use super::conquest::{Conquest, ConquestLimits};
use super::constrain::segments_of_leaves;
use super::intake::{Intake, Points};
use super::journal::{FinishedBlocks, JournalReader, SavedPlan};
use super::output::{Journal, Output};
use super::pipeline;
use super::point_store::PointStore;
use super::prefetch::{self, Prefetched};
use super::schedule::{BlockPoints, Board};
use super::segments::Segments;
use super::spill::{self, Block, Plan};
use super::summary::{LevelSummary, Waits, phases};
use super::work_folder::WorkFolder;
use super::{BuildError, BuildOptions, BuildSummary, Description, GENERATION, Phase, TileState, peak_memory};
use crate::geometry::{Point, Rect};
use crate::input::PointBatch;
use crate::io::{Buffers, ThreadsFile};
use crate::store::{Directory, Extent, KdTree, Metadata, TileEntry};

/// Builds a tile file from batches of points.
///
/// Until [`finish`](Self::finish) has succeeded, nothing stands under the output's name; work lies in `OUT.partial/`,
/// which goes away with the builder, unless the build can be [resumed](BuildOptions::resumable).
#[derive(Debug)]
pub struct Builder {
    options: Arc<BuildOptions>,
    folder: Arc<WorkFolder>,
    output: PathBuf,
    intake: Intake,
    /// All memory, of which segments take a part.
    memory: u64,
    points: u64,
    has_z: bool,
    /// One more than the largest record number so far.
    next_record: u64,
    /// From this record number on points are ends of segments.
    first_end: Arc<AtomicU64>,
    segments: Segments,
    description: Description,
    began: Instant,
}

impl Builder {
    /// Starts a build, or goes on with one.
    ///
    /// # Errors
    /// If an option is out of range, the output exists and is not to be replaced, its folder cannot be written, or what is to
    /// be resumed was another build's.
    pub fn new(output: impl AsRef<Path>, options: BuildOptions) -> Result<Self, BuildError> {
        options.check()?;
        let output = output.as_ref().to_owned();
        let tmp = options.work_folder.as_deref();
        let folder = WorkFolder::create(&output, tmp, options.force, options.resume)?;
        let mut this = Self {
            memory: options.memory,
            options: Arc::new(options),
            folder: Arc::new(folder),
            output,
            intake: Intake::new(),
            points: 0,
            has_z: false,
            next_record: 0,
            first_end: Arc::new(AtomicU64::new(u64::MAX)),
            segments: Segments::default(),
            description: Description::default(),
            began: Instant::now(),
        };
        if this.options.resume {
            // The folder is kept until this is done: whatever is wrong with what is there, it stays.
            this.resume()?;
            this.folder.keep(!this.needs_points());
        }
        this.options.progress.start(Phase::Read, 0);
        Ok(this)
    }

    /// Takes up what a build before has left; if that is nothing to go on from, it goes away.
    fn resume(&mut self) -> Result<(), BuildError> {
        let folder = &self.folder;
        let cannot = |error| BuildError::io(folder.path(), "resume the work in", error);
        match SavedPlan::load(&folder.plan()).map_err(cannot)? {
            Some(saved) if !folder.was_published() => {
                let mine = self.options.identity();
                if let Some((left, _)) = saved.identity.lines().zip(mine.lines()).find(|(a, b)| a != b) {
                    return Err(BuildError::OtherBuild {
                        path: folder.path().to_owned(),
                        what: left.to_owned(),
                    });
                }
                self.points = saved.plan.points;
                self.has_z = saved.plan.has_z;
                self.description = saved.description.clone();
                self.intake = Intake::Resumed(Box::new(saved));
                Ok(())
            }
            _ => folder.empty().map_err(cannot),
        }
    }

    /// Whether points are to be pushed; not if a build goes on that had them all.
    #[must_use]
    pub fn needs_points(&self) -> bool {
        !matches!(self.intake, Intake::Resumed(_))
    }

    /// What [`describe`](Self::describe) noted, perhaps in the build before.
    #[must_use]
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Notes where the points come from and in which coordinate reference system, as metadata.
    pub fn describe(&mut self, description: Description) {
        self.description = description;
    }

    /// Tells about how many points will come, and of some of them where they lie, before the first one is pushed. It need not
    /// be right: it saves work where it is.
    ///
    /// # Errors
    /// If there is not enough room on the disk for so many points, or the memory is too small for any work.
    pub fn expect(&mut self, points: u64, mut sample: Vec<Point>) -> Result<(), BuildError> {
        sample.retain(|point| point.is_valid());
        budget::check_disk(&self.folder, points, 0, false)?;
        self.intake
            .expect(points, sample, &self.options, &self.folder, &self.first_end)
    }

    /// Takes a batch of points.
    ///
    /// # Errors
    /// If a point is [not valid](crate::geometry::Point::is_valid) or a z not finite, the batch's arrays are not equally
    /// long, points cannot be spilled, or the build was cancelled.
    pub async fn push(&mut self, batch: &PointBatch) -> Result<(), BuildError> {
        let pushed = self.try_push(batch).await;
        self.keep_after(pushed)
    }

    async fn try_push(&mut self, batch: &PointBatch) -> Result<(), BuildError> {
        if self.options.progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        let (points, z, records) = (batch.points.len(), batch.z.len(), batch.records.len());
        if records != points || !(z == points || z == 0) {
            return Err(BuildError::Batch { points, z, records });
        }
        if let Some((&z, &record)) = batch.z.iter().zip(&batch.records).find(|(z, _)| !z.is_finite()) {
            return Err(BuildError::InvalidZ { record, z });
        }
        let invalid = batch.points.iter().zip(&batch.records).find(|(p, _)| !p.is_valid());
        if let Some((&point, &record)) = invalid {
            return Err(BuildError::InvalidPoint { record, point });
        }
        self.intake
            .push(batch, &self.options, &self.folder, &self.first_end)
            .await?;
        self.segments.resolve(batch);
        self.has_z |= !batch.z.is_empty();
        let last = batch.records.iter().copied().max();
        self.next_record = self.next_record.max(last.map_or(0, |last| last.saturating_add(1)));
        let points = points as u64;
        self.points += points;
        self.options.progress.advance(points, points);
        Ok(())
    }

    /// Takes segments: lines between two places that become chains of edges. Their ends join the vertices; where a point lies
    /// at the same place, that is kept.
    ///
    /// Segments may meet in ends, in points and along each other, but not cross. All are kept in memory, and a build with
    /// segments cannot be resumed.
    ///
    /// # Errors
    /// If an end is not [valid](crate::geometry::Point::is_valid), or they take more than half of the memory.
    pub fn push_segments(&mut self, segments: &[[Point; 2]]) -> Result<(), BuildError> {
        self.segments.push(segments)?;
        self.reserve()
    }

    /// Takes segments by the record numbers of the points that they join, before these are pushed.
    ///
    /// # Errors
    /// If they take more than half of the memory.
    pub fn push_segments_between(&mut self, records: &[[u64; 2]]) -> Result<(), BuildError> {
        self.segments.push_between(records);
        self.reserve()
    }

    /// Leaves the memory that segments do not take for everything else.
    fn reserve(&mut self) -> Result<(), BuildError> {
        self.segments.check_memory(self.memory)?;
        Arc::make_mut(&mut self.options).memory = self.memory - self.segments.byte_size();
        Ok(())
    }

    /// Pushes the ends of segments as points, which give way to others.
    async fn push_ends(&mut self) -> Result<(), BuildError> {
        if self.segments.by_ends().is_empty() {
            return Ok(());
        }
        self.first_end.store(self.next_record, Ordering::Relaxed);
        let mut record = self.next_record;
        for segments in self.segments.by_ends().chunks(4096) {
            let ends = segments.as_flattened();
            let batch = PointBatch {
                points: ends.to_vec(),
                z: Vec::new(),
                records: (record..record + ends.len() as u64).collect(),
            };
            record += ends.len() as u64;
            self.intake
                .push(&batch, &self.options, &self.folder, &self.first_end)
                .await?;
        }
        Ok(())
    }

    /// Builds the file and gives it its name. Must be awaited within a tokio runtime; computing happens on threads of its
    /// own.
    ///
    /// # Errors
    /// If something cannot be written, duplicates were to be an error, there is too little memory or room on the disk, or the
    /// build was cancelled.
    pub async fn finish(mut self) -> Result<BuildSummary, BuildError> {
        let built = self.build().await;
        self.keep_after(built)
    }

    /// What was done stays where a build that can be resumed was stopped from without; once the plan is saved it stays
    /// anyway, unless going on would end in the same way.
    fn keep_after<T>(&self, result: Result<T, BuildError>) -> Result<T, BuildError> {
        match result {
            Err(BuildError::Cancelled | BuildError::Io { .. } | BuildError::Disk { .. }) => {
                self.folder.keep(self.options.resumable.is_some());
            }
            Err(BuildError::Duplicate { .. } | BuildError::TooManyTiles { .. }) => self.folder.keep(false),
            _ => {}
        }
        result
    }

    async fn build(&mut self) -> Result<BuildSummary, BuildError> {
        let is_resumed = !self.needs_points();
        self.push_ends().await?;
        let intake = std::mem::replace(&mut self.intake, Intake::new());
        let (plan, store) = match intake.finish().await? {
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
            Some(store) => budget::shares_in_memory(&self.options, store.byte_size()),
            None if is_resumed => budget::resumed_shares(&self.options, &plan)?,
            None => budget::shares(&self.options, plan.points, plan.has_z)?,
        };
        let has_journal = store.is_none() && self.options.resumable.is_some() && self.segments.is_empty();
        let mut finished = FinishedBlocks::default();
        if is_resumed {
            finished = FinishedBlocks::read(&self.folder)?;
            spill::check_runs(&plan.blocks[finished.blocks as usize..], self.folder.spill())?;
        }
        let unfinished = plan.blocks[finished.blocks as usize..].iter();
        let run_bytes = unfinished.flat_map(|block| &block.runs).map(|run| run.length).sum();
        budget::check_disk(&self.folder, plan.points - finished.points, run_bytes, plan.has_z)?;
        if has_journal && !is_resumed {
            let saved = SavedPlan {
                identity: self.options.identity(),
                description: self.description.clone(),
                plan: plan.clone(),
            };
            let path = self.folder.plan();
            saved
                .save(&path)
                .map_err(|error| BuildError::io(&path, "write", error))?;
            self.folder.keep(true);
        }
        let parts = Parts {
            plan,
            store,
            shares,
            finished,
            has_journal,
        };
        self.build_parts(parts).await
    }

    async fn build_parts(&mut self, parts: Parts) -> Result<BuildSummary, BuildError> {
        let Parts {
            plan,
            store,
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
        let merge_vertices = self.options.merge_vertices.min(shares.merge_vertices);
        let segments = std::mem::take(&mut self.segments).finish()?;
        let numbers = 0..segments.len() as u32;
        let of_blocks = segments_of_leaves(&plan.tree, Rect::PLANE, &segments, numbers);
        let conquest = Arc::new(Conquest {
            board: Board::new(&plan.tree, merge_vertices, shares.threads),
            options: (*self.options).clone(),
            spill: self.folder.spill().to_owned(),
            log: Mutex::new(log),
            found: Mutex::default(),
            limits,
            buffers: Buffers::keeping(shares.threads.div_ceil(2)),
            segments,
            of_blocks: Mutex::new(of_blocks),
            first_end: self.first_end.load(Ordering::Relaxed),
            of_tiles: Mutex::default(),
        });
        // Whoever drops this future stops the threads too.
        let _stop = StopOnDrop(&conquest.board);
        let first_tile = finished.cores.len() as u32;
        let resumed_blocks = finished.blocks;
        let mut output = Output::new(file, path.clone(), finished.cores, journal, resumed_blocks);

        let (sender, extents) = mpsc::channel(shares.threads);
        let (reply, computed) = oneshot::channel();
        // The thread holds the folder's lock too: it may outlive this future.
        let (theirs, folder) = (Arc::clone(&conquest), Arc::clone(&self.folder));
        let compute = move || {
            let computed = pipeline::run(&theirs, first_tile, shares.threads, &sender);
            drop((sender, folder));
            // If nobody waits for the answer any more, nobody needs it.
            let _ = reply.send(computed);
        };
        let thread = thread::Builder::new().name("tile-build".to_owned());
        thread
            .spawn(compute)
            .map_err(|error| BuildError::io(&path, "start a thread to build", error))?;

        let feed = async {
            let fed = self
                .feed(&conquest, store, &blocks, resumed_blocks, shares, plan.has_z)
                .await;
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
        let (tiles, began) = computed?;

        let found = std::mem::take(&mut *conquest.found.lock());
        let trees: Vec<KdTree> = found.blocks.iter().map(|block| block.tree.clone()).collect();
        let tree = plan.tree.with_leaves_cut(&trees);
        let ends = found.blocks.iter().map(|block| block.ends).sum::<u64>();
        let (cores, borders) = output.extents();
        let directory = self.directory(tree, &tiles, cores, borders, ends);
        let bytes = |extents: &[Extent]| extents.iter().map(|e| u64::from(e.length)).sum::<u64>();
        let [log_read, log_written] = conquest.log.lock().traffic();
        let core_bytes = bytes(&cores[first_tile as usize..]) + output.journal_bytes() + log_written;
        let border_bytes = bytes(borders);
        let (file_bytes, finish_bytes) = output.finish(&directory).await?;
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
        let metadata = &directory.metadata;
        Ok(BuildSummary {
            points: metadata.points,
            duplicates: metadata.duplicates,
            vertices: metadata.vertices,
            triangles: metadata.triangles,
            border_triangles: conquest.log.lock().triangle_count(),
            hull_edges: metadata.hull_edges,
            ends: metadata.ends,
            constraint_edges: metadata.constraint_edges,
            held_triangles: found.blocks.iter().map(|block| block.held_triangles).sum(),
            tiles: directory.tiles.len() as u64,
            file_bytes,
            blocks: blocks.len() as u64,
            resumed_blocks: resumed_blocks.into(),
            waits: Waits {
                computing_for_blocks: conquest.board.starved(),
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
        blocks: &[Block],
        finished: u32,
        shares: Shares,
        has_z: bool,
    ) -> Result<Prefetched, BuildError> {
        if let Some(store) = store {
            if !store.items.is_empty() {
                conquest.board.add(BlockPoints {
                    number: 0,
                    store,
                    _permit: None,
                });
            }
            return Ok(Prefetched::default());
        }
        if finished > 0 {
            let path = self.folder.journal();
            let cannot = |error| BuildError::io(&path, "read", error);
            let mut reader = JournalReader::open(&path).map_err(cannot)?;
            for _ in 0..finished {
                let entry = reader.next().map_err(cannot)?;
                let (block, seam) = entry.ok_or_else(|| cannot(io::ErrorKind::InvalidData.into()))?;
                conquest.restore(block, seam);
            }
        }
        prefetch::feed(
            &conquest.board,
            blocks,
            finished as usize,
            self.folder.spill(),
            shares.blocks,
            has_z,
            conquest.limits.has_journal,
        )
        .await
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
        &self,
        tree: KdTree,
        states: &[TileState],
        cores: &[Extent],
        borders: &[Extent],
        ends: u64,
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
            points: self.points,
            has_z: self.has_z,
            sources: self.description.sources.clone(),
            crs: self.description.crs.clone(),
            tile_vertices: self.options.tile_vertices as u32,
            vertices,
            triangles,
            bounds: tiles.iter().fold(Rect::EMPTY, |all, t| all.union(t.bounds)),
            duplicates: (self.points + ends).saturating_sub(vertices),
            ends,
            constraint_edges: states.iter().map(|state| state.constraint_edges).sum(),
            // Euler's formula for a triangulated disc.
            hull_edges: match triangles {
                0 => 0,
                triangles => (2 * vertices - 2).saturating_sub(triangles),
            },
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
