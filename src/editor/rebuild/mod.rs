//! Builds all tiles of a file anew.
//!
//! In: the file, and changes of it. Out: the file with these changes, which takes its place as its next
//! state. Readers of the file keep it as it was.
//!
//! ```text
//!   lines, sites of the file ───────────────┐ (contents)
//!   tiles, read ahead ──▶ vertices, changed ┴──▶ build ──▶ edit, if need be ──▶ rename
//!   calls, by tile ──────────┘ (points)                     ▲
//!      └── calls at vertices of lines and sites; changes of these
//! ```
//!
//! The build makes all changes of points, except where lines and sites hold a vertex: what follows
//! there depends on the triangles around it.
//!
//! A file without triangles cannot be edited: an edit changes triangles. It is built with three
//! helpers, points around everything, which the edit deletes at its end.

mod contents;
mod error;
mod helpers;
mod points;
mod vertices;

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use crate::edit::{EditError, EditSummary, EditTotals, PointCounts, Target, Work, enter};
use crate::editor::rebuild::contents::push_contents;
use crate::editor::rebuild::error::edit_error;
use crate::editor::rebuild::helpers::Helpers;
use crate::editor::rebuild::points::{ChangedPoints, PointChanges, push_sample};
use crate::input::MissingZ;
use crate::io::folder_of;
use crate::pipeline::next_state::{NextState, NextStateSummary};
use crate::pipeline::{BuildOptions, Builder};
use crate::store::{Codec, Directory, Metadata, TileReader};

/// The reason why a file was not built anew.
pub(crate) enum NotBuilt {
    /// A build cannot begin, for want of memory, room or permission.
    NotBegun(EditError),
    Failed(EditError),
}

impl From<EditError> for NotBuilt {
    fn from(error: EditError) -> Self {
        Self::Failed(error)
    }
}

/// Builds a file anew with its lines and sites and with changes of points, and edits it if others
/// follow.
///
/// # Errors
/// Fails with [`EditError::NothingLeft`] if there are others, and the points make no triangles.
pub(crate) async fn rebuild(target: &mut Target, work: Arc<Work>, memory: u64) -> Result<EditSummary, NotBuilt> {
    let began = Instant::now();
    let source = Source::open(target, &work, memory).await?;
    work.points.check_z(source.has_z)?;
    let memory = source.rest(memory, &work);
    let first_end = source.first_end(&work);
    let begun = source.builder(&target.path, first_end, memory).and_then(|mut builder| {
        let expected = source.metadata().vertices.saturating_add(work.points.all.len() as u64);
        push_sample(&mut builder, &source.directory, expected)?;
        Ok(builder)
    });
    let mut builder = begun.map_err(NotBuilt::NotBegun)?;
    push_contents(&source.reader, &mut builder).await?;
    let points = ChangedPoints::of(&source.reader, Arc::clone(&work), source.has_z, first_end);
    let PointChanges { counts, left } = points.push(&mut builder).await?;
    let is_dry_run = work.is_dry_run;
    let next = match work.after_points(left) {
        None => source.next_state(work, None, is_dry_run),
        Some(rest) => source.next_state(Arc::new(work.of_records()), Some(Arc::new(rest)), is_dry_run),
    };
    let built = builder.finish_next(next).await.map_err(edit_error)??;
    let summary = source.summary(counts, &built, began);
    put(target, built.locked);
    Ok(summary)
}

/// Builds a file without triangles anew, with helpers that make triangles, and edits it.
pub(crate) async fn rebuild_with_helpers(
    target: &mut Target,
    work: Arc<Work>,
    memory: u64,
) -> Result<EditSummary, EditError> {
    let began = Instant::now();
    let source = Source::open(target, &work, memory).await?;
    let helpers = Helpers::around(source.metadata().bounds, &work)?;
    let without = helpers.deleted_in(&work);
    let is_dry_run = work.is_dry_run;
    let built = source.build_helped(&target.path, &helpers, without, memory, is_dry_run);
    match built.await {
        Err(EditError::NothingLeft) => rebuild_on_one_line(target, work, memory).await,
        Err(error) => Err(error),
        Ok(built) => {
            let points = built.edited.map(|edited| helpers.not_counted(edited.points));
            let summary = source.summary(points.unwrap_or_default(), &built, began);
            put(target, built.locked);
            Ok(summary)
        }
    }
}

/// Returns the summary of an edit that changes nothing.
pub(crate) async fn unchanged(target: &Target, memory: u64) -> Result<EditSummary, EditError> {
    let began = Instant::now();
    let source = Source::open(target, &Work::default(), memory).await?;
    let same = NextStateSummary {
        metadata: source.metadata().clone(),
        tiles: 0,
        file_bytes: source.reader.file_length(),
        edited: None,
        locked: None,
    };
    Ok(EditSummary {
        tile_reads: 0,
        ..source.summary(PointCounts::default(), &same, began)
    })
}

/// Builds a file anew whose vertices will lie on one line, with lines. It is built and edited with
/// helpers beside the file, and then built without them.
pub(crate) async fn rebuild_on_one_line(
    target: &mut Target,
    work: Arc<Work>,
    memory: u64,
) -> Result<EditSummary, EditError> {
    let began = Instant::now();
    let source = Source::open(target, &work, memory).await?;
    let helpers = Helpers::around(source.metadata().bounds, &work)?;
    let folder = folder_of(&target.path);
    let folder = tempfile::TempDir::with_prefix_in(".tiles-edit-", folder)
        .map_err(|error| EditError::io(folder, "make a folder in", error))?;
    let path = folder.path().join("tiles");
    let is_dry_run = work.is_dry_run;
    let edited = source.build_helped(&path, &helpers, Arc::new(work.for_draft()), memory, false);
    let edited = edited.await?.edited.unwrap_or_default();
    let helped = Source::open(&Target::lock(&path)?, &work, memory).await?;
    let first_end = helped.first_end(&Work::default());
    let mut builder = helped.builder(&target.path, first_end, helped.rest(memory, &work))?;
    push_contents(&helped.reader, &mut builder).await?;
    let deletions = Arc::new(helpers.deletions());
    let points = ChangedPoints::of(&helped.reader, deletions, helped.has_z, first_end);
    points.push(&mut builder).await?;
    let next = helped.next_state(Arc::default(), None, is_dry_run);
    let built = builder.finish_next(next).await.map_err(edit_error)??;
    let totals = source.summary(edited.points, &built, began);
    put(target, built.locked);
    Ok(EditSummary {
        lines: edited.lines,
        sites: edited.sites,
        segments: edited.segments,
        added_vertices: edited.added_vertices,
        inserted_edges: edited.inserted_edges,
        triangles_visited: edited.triangles_visited,
        ..totals
    })
}

/// Puts the file that was built, unless it was a dry run, in the place of the one that it replaced.
fn put(target: &mut Target, built: Option<Target>) {
    if let Some(Target { file, .. }) = built {
        target.file = file;
    }
}

/// The file that is built anew.
struct Source {
    reader: TileReader,
    directory: Arc<Directory>,
    /// Bytes of memory to read it.
    memory: u64,
    /// Whether vertices will have z.
    has_z: bool,
}

impl Source {
    async fn open(target: &Target, work: &Work, memory: u64) -> Result<Self, EditError> {
        let memory = memory / 8;
        let reader = target.read_within(memory).await?;
        let metadata = reader.metadata();
        Ok(Self {
            has_z: match metadata.vertices {
                // The first points decide.
                0 => work.points.have_z(),
                _ => metadata.has_z,
            },
            directory: reader.directory().await?,
            reader,
            memory,
        })
    }

    fn metadata(&self) -> &Metadata {
        self.reader.metadata()
    }

    /// Returns the bytes that are left for a build.
    fn rest(&self, memory: u64, work: &Work) -> u64 {
        memory.saturating_sub(work.points.memory() + work.sites.memory() + self.memory)
    }

    /// Builds the file with helpers under a name, and edits it.
    async fn build_helped(
        &self,
        output: &Path,
        helpers: &Helpers,
        work: Arc<Work>,
        memory: u64,
        is_dry_run: bool,
    ) -> Result<NextStateSummary, EditError> {
        let first_end = self.first_end(&work);
        let mut builder = self.builder(output, first_end, self.rest(memory, &work))?;
        push_contents(&self.reader, &mut builder).await?;
        let points = ChangedPoints::of(&self.reader, Arc::default(), self.has_z, first_end);
        points.push(&mut builder).await?;
        let helpers = helpers.points(self.has_z, first_end.saturating_sub(Helpers::COUNT));
        builder.push(&helpers).await.map_err(edit_error)?;
        let next = self.next_state(Arc::default(), Some(work), is_dry_run);
        builder.finish_next(next).await.map_err(edit_error)?
    }

    /// Returns a builder that makes its next state under a name, within `memory` bytes. Vertices that
    /// are no points have record numbers from `first_end` on.
    fn builder(&self, output: &Path, first_end: u64, memory: u64) -> Result<Builder, EditError> {
        let metadata = self.metadata();
        // A hostile file may say anything.
        let tile_vertices = metadata.tile_vertices as usize;
        let options = BuildOptions::default()
            .tile_vertices(tile_vertices.clamp(BuildOptions::MIN_TILE_VERTICES, BuildOptions::MAX_TILE_VERTICES))
            .memory(memory)
            .compress(self.directory.codec() == Codec::Zstandard)
            .missing_z(MissingZ::Zero)
            .exterior_is_hole(metadata.exterior_is_hole);
        let builder = Builder::for_next_state(output, options, first_end);
        let mut builder = builder.map_err(edit_error)?;
        builder
            .push_seeds(&self.directory.lists.hole_points)
            .map_err(edit_error)?;
        Ok(builder)
    }

    /// Returns the first record number of vertices that are no points, after those of points that
    /// come.
    fn first_end(&self, work: &Work) -> u64 {
        let records = self.metadata().next_record.saturating_add(work.new_records);
        records.saturating_add(Helpers::COUNT)
    }

    /// Returns what makes a build the next state of the file, with changes that were made in it, and an
    /// edit that follows.
    fn next_state(&self, work: Arc<Work>, then: Option<Arc<Work>>, is_dry_run: bool) -> NextState {
        let metadata = Metadata {
            has_z: self.has_z,
            ..self.directory.metadata.clone()
        };
        let lists = self.directory.lists.clone();
        NextState {
            before: *self.reader.in_force(),
            directory: Box::new(move |built| {
                let totals = EditTotals {
                    ends: built.metadata.ends,
                    sites: built.metadata.sites,
                    removes_lines: false,
                    regions: built.metadata.regions,
                    spanning_regions: built.metadata.spanning_regions,
                    hole_regions: built.metadata.hole_regions,
                    digest: built.metadata.digest,
                };
                let mut directory = Directory::new(metadata, lists, built.tree, built.tiles);
                directory.renew_bounds();
                enter(&mut directory, &work, totals);
                directory
            }),
            work: then,
            is_dry_run,
        }
    }

    /// Returns the summary of what changed `points`. The rest is what the file has now, after the edit
    /// of what was built, if there was one.
    fn summary(&self, points: PointCounts, built: &NextStateSummary, began: Instant) -> EditSummary {
        if let Some(edited) = built.edited {
            return EditSummary {
                points,
                bytes_appended: edited.file_bytes.saturating_sub(self.reader.file_length()),
                seconds: began.elapsed().as_secs_f64(),
                ..edited
            };
        }
        let metadata = &built.metadata;
        EditSummary {
            points,
            constraint_edges: metadata.constraint_edges,
            vertices: metadata.vertices,
            triangles: metadata.triangles,
            tiles_written: built.tiles,
            tile_reads: self.metadata().tiles.into(),
            regions: metadata.regions,
            hole_regions: metadata.hole_regions,
            hole_triangles: metadata.hole_triangles,
            bytes_appended: built.file_bytes.saturating_sub(self.reader.file_length()),
            file_bytes: built.file_bytes,
            seconds: began.elapsed().as_secs_f64(),
            ..EditSummary::default()
        }
    }
}
