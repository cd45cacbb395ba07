//! Publish: writes the directory, inserts deferred segments, gives the file its name, and
//! summarises. If segments were deferred, only the last version of the file is synced.

use std::fs::File;
use std::hash::{BuildHasher, RandomState};
use std::mem::take;
use std::path::Path;
use std::sync::Arc;

use tracing::Instrument;

use crate::constraints::segment::Segment;
use crate::edit::{EditError, EditSummary, Target, Work, edit};
use crate::geometry::Rect;
use crate::input::MissingZ;
use crate::io::{Backend, ThreadsFile, WriteAt, blocking};
use crate::memory::peak_memory;
use crate::pipeline::assembly::Assembly;
use crate::pipeline::assembly::open::OpenedBuild;
use crate::pipeline::assembly::run::RunResult;
pub(crate) use crate::pipeline::conquer::conquest::ConquestState;
use crate::pipeline::error::BuildError;
use crate::pipeline::finish::enclosed_sites::sites_in_holes;
use crate::pipeline::ingest::drape::PointSurface;
use crate::pipeline::output::in_parts;
use crate::pipeline::records::{BlockState, GENERATION, LeftCores, TileState};
use crate::pipeline::summary::{BuildSummary, LevelSummary, Waits, phases};
use crate::pipeline::tasks::left::fill;
use crate::pipeline::tasks::saved::SavedTasks;
use crate::pipeline::tasks::stored::{fetch_cores, put_finished};
use crate::store::{
    CompactError, Directory, Extent, InForce, KdTree, Lists, Metadata, OpenOptions, ReadError, TablePlace, TileEntry,
    TileReader, hull_edges, polygon_lines_in_order, remove_log,
};

/// Deferred segments: the file is compacted if more than 1/`UNUSED_SHARE` of it was rewritten to
/// insert them.
const UNUSED_SHARE: u64 = 8;

/// A file that was written, and the counts for the summary.
pub(crate) struct Published {
    pub(crate) metadata: Metadata,
    pub(crate) tiles: u64,
    pub(crate) file_bytes: u64,
    border_triangles: u64,
    deferred: u64,
    sites_in_holes: u64,
    state: ConquestState,
    waits: Waits,
    blocks: u64,
    resumed_blocks: u64,
    /// Bytes read and written, by phase.
    bytes_read: [u64; 5],
    bytes_written: [u64; 5],
    /// The cores that are not in the file.
    left: Vec<LeftCores>,
}

impl Assembly {
    /// Completes the file and gives it its name.
    pub(crate) async fn publish(&mut self, work: OpenedBuild, ran: &RunResult) -> Result<Published, BuildError> {
        let published = self.complete(work, ran).await?;
        self.check_output()?;
        self.give_name(&published).await?;
        Ok(published)
    }

    /// Completes the file in the work folder.
    pub(crate) async fn complete(&mut self, work: OpenedBuild, ran: &RunResult) -> Result<Published, BuildError> {
        let OpenedBuild {
            conquest,
            output,
            path,
            blocks,
            segments,
            tree,
            first_tile,
            first_block,
            spilled,
            stop,
            mut left,
            ..
        } = work;
        let mut state = take(&mut *conquest.state.lock());
        let (cores, borders) = output.extents();
        let directory = self.directory(&tree, &state, ran, cores, borders);
        let (directory, replaced) = self.of_next_state(directory);
        let [core_bytes, border_bytes] = extent_bytes(&cores[first_tile as usize..], borders);
        let [log_read, log_written] = conquest.log.lock().traffic();
        let core_bytes = core_bytes + output.journal_bytes() + log_written;
        let deferred = take(&mut state.deferred).into_segments();
        let is_draft = self.options.is_draft || !deferred.is_empty();
        let (mut file_bytes, finish_bytes) = output.finish(&directory, replaced.as_ref(), is_draft).await?;
        let border_triangles = conquest.log.lock().triangle_count();
        let waits = Waits {
            computing_for_blocks: conquest.board.starved(),
            computing_for_writing: state.waited_to_write,
            blocks_for_computing: ran.prefetched.waited,
        };
        // An edit needs all the memory.
        drop((stop, conquest, segments));
        let (deferred_count, mut metadata) = (deferred.len() as u64, directory.metadata);
        let is_read = !deferred.is_empty() || has_sites_in_holes(&metadata, &state);
        if is_read && !left.is_empty() {
            self.fill(take(&mut left)).await?;
        }
        if !deferred.is_empty() {
            file_bytes = self.insert(&path, deferred, &mut metadata).await?;
        }
        let sites_in_holes = self.sites_in_holes(&path, &metadata, &state).await?;
        let [written, rewritten, reread] = spilled;
        Ok(Published {
            metadata,
            tiles: directory.tiles.len() as u64,
            file_bytes,
            border_triangles,
            deferred: deferred_count,
            sites_in_holes,
            state,
            waits,
            blocks: blocks.len() as u64,
            resumed_blocks: first_block.into(),
            bytes_read: [0, reread, ran.prefetched.bytes, log_read, 0],
            bytes_written: [written, rewritten, core_bytes, border_bytes, finish_bytes],
            left,
        })
    }

    /// Copies cores that are not in the file into it.
    async fn fill(&self, left: Vec<LeftCores>) -> Result<(), BuildError> {
        let folder = Arc::clone(&self.folder);
        let filled = async {
            if let (Some(store), Some(tasks)) = (&self.options.store, SavedTasks::load(&folder)?) {
                fetch_cores(store, &folder, tasks.id(), &left).await?;
            }
            blocking(move || fill(&folder, &left)).await.flatten()
        };
        let cannot = |error| BuildError::io(self.folder.path(), "gather tiles in", error);
        filled.await.map_err(cannot)
    }

    /// Fails if the build was cancelled, an obstacle is inside out, or the output has come into
    /// existence.
    fn check_output(&self) -> Result<(), BuildError> {
        if let Some(inverted) = self.given.inverted_if_uncrossed {
            return Err(BuildError::Inverted(inverted));
        }
        if let Some(overlapping) = self.given.overlapping_if_uncrossed {
            return Err(BuildError::Overlapping(overlapping));
        }
        if self.options.progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        if !self.options.force && self.output.exists() {
            return Err(BuildError::OutputExists(self.output.clone()));
        }
        Ok(())
    }

    /// Gives the file its name.
    async fn give_name(&self, published: &Published) -> Result<(), BuildError> {
        if self.folder.is_in_parts() {
            let (folder, left, length) = (Arc::clone(&self.folder), published.left.clone(), published.file_bytes);
            let store = self.options.store.clone();
            let named = async {
                let tasks = SavedTasks::load(&folder)?;
                let id = tasks.map_or_else(|| RandomState::new().hash_one(length), |tasks| tasks.id());
                let linked = Arc::clone(&folder);
                let manifest = blocking(move || in_parts::link_parts(&linked, &left, length, id))
                    .await
                    .flatten()?;
                match store {
                    Some(store) => put_finished(&store, manifest, &self.output, id).await,
                    None => blocking(move || in_parts::give_name(&folder, &manifest, id))
                        .await
                        .flatten(),
                }
            };
            let cannot = |error| BuildError::io(&self.output, "give the finished file its name", error);
            named.await.map_err(cannot)?;
            self.folder.set_published();
        } else {
            self.folder.publish(!self.options.is_draft)?;
        }
        // If there is one, it belongs to a file that had the name before.
        if let Err(error) = remove_log(&self.output) {
            tracing::warn!(%error, "cannot remove the log of an earlier file");
        }
        Ok(())
    }

    /// Returns the summary of a build.
    pub(crate) fn summarise(&self, written: Published, ran: &RunResult) -> BuildSummary {
        let Published { metadata, state, .. } = written;
        let sum = |of_block: fn(&BlockState) -> u64| state.blocks.iter().map(of_block).sum();
        BuildSummary {
            points: metadata.points,
            duplicates: metadata.duplicates,
            vertices: metadata.vertices,
            triangles: metadata.triangles,
            border_triangles: written.border_triangles,
            hull_edges: metadata.hull_edges,
            added_vertices: metadata.ends,
            constraint_edges: metadata.constraint_edges,
            crossings: metadata.crossings,
            split_points: self.given.split_points,
            sites: metadata.sites,
            sites_in_holes: written.sites_in_holes,
            regions: metadata.regions,
            hole_regions: metadata.hole_regions,
            hole_triangles: metadata.hole_triangles,
            inverted_parts: self.given.repair.parts,
            first_inverted: self.given.repair.inverted.map(|inverted| inverted.first),
            held_triangles: sum(|block| block.held_triangles),
            deferred_segments: written.deferred,
            without_z: sum(|block| block.without_z),
            ponds: self.surface.as_deref().map_or(0, PointSurface::pond_count),
            flattened: sum(|block| block.draped.flattened),
            draped: sum(|block| block.draped.vertices),
            draped_outside: sum(|block| block.draped.outside),
            tiles: written.tiles,
            file_bytes: written.file_bytes,
            blocks: written.blocks,
            resumed_blocks: written.resumed_blocks,
            waits: written.waits,
            phases: phases(self.began, &ran.began, written.bytes_read, written.bytes_written),
            levels: levels(&state),
            peak_memory: peak_memory(),
        }
    }

    /// Returns the directory of the file, as it is if the file is the next state of another one, and
    /// the superblock of that one.
    fn of_next_state(&mut self, directory: Directory) -> (Directory, Option<InForce>) {
        match self.next.take() {
            None => (directory, None),
            Some(next) => ((next.directory)(directory), Some(next.before)),
        }
    }

    /// Inserts the deferred segments into the file, which has not been given its name yet. Returns the
    /// length of the file.
    async fn insert(&self, path: &Path, segments: Vec<Segment>, metadata: &mut Metadata) -> Result<u64, BuildError> {
        let work = Work {
            segments: Arc::new(segments),
            missing_z: MissingZ::Zero,
            is_draft: true,
            threads: self.options.threads,
            ..Work::default()
        };
        let edited = self.edit_draft(path, Arc::new(work)).await?;
        metadata.constraint_edges = edited.constraint_edges;
        metadata.regions = edited.regions;
        metadata.hole_regions = edited.hole_regions;
        metadata.hole_triangles = edited.hole_triangles;
        Ok(self.settle(path, edited).await?.file_bytes)
    }

    /// Edits the file, which has not been given its name yet, as a draft.
    pub(crate) async fn edit_draft(&self, path: &Path, work: Arc<Work>) -> Result<EditSummary, EditError> {
        let span = tracing::debug_span!("insert", segments = work.segments.len());
        let (progress, folder) = (Arc::clone(&self.options.progress), Arc::clone(&self.folder));
        // The thread holds the folder's lock too: it may outlive this future.
        let is_cancelled = move || {
            let _ = &folder;
            progress.is_cancelled()
        };
        let edited = edit(Target::lock(path)?, work, self.memory.total(), is_cancelled);
        edited.instrument(span).await
    }

    /// Brings an edited draft onto the medium, compacted if that is worth it.
    pub(crate) async fn settle(&self, path: &Path, mut edited: EditSummary) -> Result<EditSummary, BuildError> {
        if edited.bytes_appended > edited.file_bytes / UNUSED_SHARE {
            let reader = self.read_back(path).await.map_err(EditError::Read)?;
            let compacted = reader.compact(path).instrument(tracing::debug_span!("compact")).await;
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

    /// Returns the number of sites in holes of the complete file.
    async fn sites_in_holes(&self, path: &Path, metadata: &Metadata, state: &ConquestState) -> Result<u64, BuildError> {
        if !has_sites_in_holes(metadata, state) {
            return Ok(0);
        }
        let with_sites = state.blocks.iter().flat_map(|block| &block.with_sites);
        let with_sites: Vec<u32> = with_sites.copied().collect();
        let span = tracing::debug_span!("sites in holes", tiles = with_sites.len());
        let reader = self.read_back(path).await.map_err(EditError::Read)?;
        let counted = sites_in_holes(&reader, with_sites).instrument(span).await;
        Ok(counted.map_err(EditError::Read)?)
    }

    /// Opens the file that was just written. It is in the page cache, which a ring may bypass.
    async fn read_back(&self, path: &Path) -> Result<TileReader, ReadError> {
        let options = OpenOptions::default()
            .memory(self.memory.total())
            .backend(Backend::Threads);
        TileReader::open(path, options).await
    }

    /// Returns the directory of a file whose extents are all written.
    fn directory(
        &mut self,
        tree: &KdTree,
        state: &ConquestState,
        ran: &RunResult,
        cores: &[Extent],
        borders: &[(Extent, TablePlace)],
    ) -> Directory {
        let trees = state.blocks.iter().map(|block| (block.first_tile, block.tree.clone()));
        let trees: Vec<(u32, KdTree)> = trees.collect();
        let tree = tree.with_leaves_cut(&trees);
        let ends: u64 = state.blocks.iter().map(|block| block.ends).sum();
        let mut regions = ran.regions.clone();
        state.blocks.iter().for_each(|block| regions.digest += block.digest);
        let states = &ran.tiles;
        let extents = cores.iter().zip(borders);
        let tiles: Vec<TileEntry> = states
            .iter()
            .zip(extents)
            .map(|(tile, (&core, &border))| entry(tile, core, border))
            .collect();
        let vertices = tiles.iter().map(|t| u64::from(t.vertices)).sum();
        let triangles = tiles.iter().map(|t| u64::from(t.owned_triangles)).sum();
        let metadata = Metadata {
            points: self.given.points,
            has_z: self.given.has_z,
            tile_vertices: self.options.tile_vertices as u32,
            vertices,
            triangles,
            bounds: tiles.iter().fold(Rect::EMPTY, |all, t| all.union(t.bounds)),
            duplicates: (self.given.points + ends).saturating_sub(vertices),
            ends,
            sites: self.given.site_count,
            crossings: self.given.crossings,
            next_record: self.given.next_record,
            next_line: self
                .given
                .description
                .lines
                .last()
                .map_or(0, |last| last.first + last.lines),
            next_site: self.given.site_count,
            exterior_is_hole: self.options.exterior_is_hole,
            constraint_edges: states.iter().map(|state| state.constraint_edges).sum(),
            regions: regions.regions,
            spanning_regions: regions.spanning,
            hole_regions: regions.hole_regions,
            hole_triangles: regions.digest.holes.count,
            hull_edges: hull_edges(vertices, triangles),
            digest: regions.digest,
            ..Metadata::default()
        };
        let lists = Lists {
            sources: self.given.description.sources.clone(),
            crs: self.given.description.crs.clone(),
            lines: self.given.description.lines.clone(),
            hole_points: take(&mut self.given.seeds),
            cell_borders: take(&mut self.given.borders),
            polygon_lines: polygon_lines_in_order(take(&mut self.given.polygon_lines), &self.given.description.lines),
        };
        Directory::new(metadata, lists, tree, tiles)
    }
}

/// Returns the bytes of cores, and those of borders with the component tables that lie apart.
fn extent_bytes(cores: &[Extent], borders: &[(Extent, TablePlace)]) -> [u64; 2] {
    let tables = borders.iter().filter_map(|(_, table)| table.apart());
    let of_borders = borders.iter().map(|(border, _)| *border).chain(tables);
    let length = |extent: Extent| u64::from(extent.length);
    [cores.iter().copied().map(length).sum(), of_borders.map(length).sum()]
}

/// Returns whether sites may be in holes.
fn has_sites_in_holes(metadata: &Metadata, state: &ConquestState) -> bool {
    metadata.hole_triangles > 0 && state.blocks.iter().any(|block| !block.with_sites.is_empty())
}

/// Returns the entry of a tile whose core and border were written to these extents.
fn entry(tile: &TileState, core: Extent, (border, table): (Extent, TablePlace)) -> TileEntry {
    // A number that a task did not use.
    if tile.vertices == 0 {
        return TileEntry::UNUSED;
    }
    TileEntry {
        core,
        border,
        generation: GENERATION,
        vertices: tile.vertices,
        core_triangles: tile.core_triangles,
        border_triangles: tile.border_triangles,
        owned_triangles: tile.owned_triangles,
        bounds: tile.bounds,
        table,
    }
}

/// Returns the levels of the merge tree: those of all blocks summed, and those above the blocks.
fn levels(state: &ConquestState) -> Vec<LevelSummary> {
    let mut levels: Vec<LevelSummary> = Vec::new();
    for of_part in state.blocks.iter().map(|block| &block.levels).chain([&state.levels]) {
        levels.resize_with(levels.len().max(of_part.len()), LevelSummary::default);
        let pairs = levels.iter_mut().zip(of_part);
        pairs.for_each(|(level, part)| level.add(*part));
    }
    levels
}
