//! The builder takes points and lines, and makes a file from them.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::Instant;

use futures::future::FutureExt;

use crate::constraints::polygons::arrivals::Arrivals;
use crate::constraints::segments::spool::SegmentSpool;
use crate::geometry::Point;
use crate::input::{MissingZ, PointBatch, SegmentBatch, SiteBatch};
use crate::io::new_output;
use crate::pipeline::assembly::Assembly;
use crate::pipeline::context::{BuildContext, Given};
use crate::pipeline::disk::{DiskLoad, check_disk};
use crate::pipeline::draping::surface_of;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::batch::check_batch;
use crate::pipeline::ingest::drape::{Draping, PointSurface};
use crate::pipeline::ingest::intake::{Intake, Points};
use crate::pipeline::ingest::ponds::PondInput;
use crate::pipeline::ingest::sites::Sites;
use crate::pipeline::options::{BuildOptions, Crossings, Phase, Steiner};
use crate::pipeline::records::Description;
use crate::pipeline::summary::BuildSummary;
use crate::pipeline::tasks::inputs::SavedInputs;
use crate::pipeline::work_folder::WorkFolder;
use crate::store::LineKind;

mod ends;
mod inputs;
mod next;
mod resume;
mod tasks;

pub use tasks::Planned;

/// Builds a tile file from batches of points.
///
/// If the output's name is a symbolic link, its target is the output. Until
/// [`finish`](Self::finish) succeeds, the output is not touched. Work is in `OUT.partial/`, which
/// is removed when the builder is dropped, unless the build can be
/// [resumed](BuildOptions::resumable).
///
/// Lines, sites and hole points must come before points; otherwise the build fails with
/// [`BuildError::Order`].
#[derive(Debug)]
pub struct Builder {
    context: BuildContext,
    output: PathBuf,
    intake: Intake,
    /// One more than the largest record number so far.
    next_record: u64,
    segments: SegmentSpool,
    polygons: Arrivals,
    sites: Sites,
    ponds: PondInput,
    given: Given,
    /// The surface from which vertices without z take it, once all points have arrived.
    surface: Option<Arc<PointSurface>>,
    /// If the build is resumed: the plan of the tasks that distribute its inputs, until their points are
    /// taken.
    inputs: Option<SavedInputs>,
    /// If the build is resumed: how vertices take their z from the surface.
    draping: Option<Draping>,
    began: Instant,
}

impl Builder {
    /// Starts a build, or resumes one.
    ///
    /// # Errors
    /// Returns an error if an option is out of range, the output exists and is not to be replaced,
    /// its folder does not exist or cannot be written, an interrupted build of this output could be
    /// resumed and is not to be discarded, or the build to be resumed had other inputs or options.
    pub fn new(output: impl AsRef<Path>, options: BuildOptions) -> Result<Self, BuildError> {
        options.check()?;
        let output = target(output.as_ref())?;
        if !options.force && output.exists() {
            return Err(BuildError::OutputExists(output));
        }
        if let Some(store) = &options.store
            && output.file_name() != Some(store.file_name().as_ref())
        {
            let name = store.file_name().to_owned();
            return Err(BuildError::StoreName { output, name });
        }
        let mut this = Self::start(output, options)?;
        if this.context.options.resume {
            // `WorkFolder` keeps the folder until this has succeeded, so an error leaves its
            // content in place.
            this.resume()?;
            this.context.folder.keep(!this.needs_points() || this.inputs.is_some());
        }
        this.context.options.progress.start(Phase::Read, 0);
        Ok(this)
    }

    fn start(output: PathBuf, options: BuildOptions) -> Result<Self, BuildError> {
        let tmp = options.work_folder.as_deref();
        let folder = WorkFolder::create(&output, tmp, options.force, options.resume)?;
        let memory = options.memory_plan();
        Ok(Self {
            output,
            intake: Intake::new(),
            next_record: 0,
            segments: SegmentSpool::new(folder.spill(), memory.for_segments()),
            polygons: Arrivals::new(
                (
                    options.crossings == Crossings::Error,
                    options.crossings == Crossings::Split || options.steiner == Steiner::Borders,
                ),
                folder.spill(),
                memory.for_polygons(),
            ),
            sites: Sites::default(),
            ponds: PondInput::default(),
            given: Given::default(),
            surface: None,
            inputs: None,
            draping: None,
            began: Instant::now(),
            context: BuildContext {
                options: Arc::new(options),
                folder: Arc::new(folder),
                first_end: Arc::new(AtomicU64::new(u64::MAX)),
                first_run: 0,
                segments: 0,
                memory,
                limits: None,
            },
        })
    }

    /// Returns whether points must be pushed. A resumed build has all its points.
    #[must_use]
    pub fn needs_points(&self) -> bool {
        !matches!(self.intake, Intake::Resumed(..))
    }

    /// Returns the description set by [`describe`](Self::describe), in the interrupted build if
    /// this build was resumed.
    #[must_use]
    pub fn description(&self) -> &Description {
        &self.given.description
    }

    /// Sets the metadata: the sources of the points and the coordinate reference system.
    pub fn describe(&mut self, description: Description) {
        self.given.description = description;
    }

    /// Announces about how many points will come, and a sample of their positions. Must be called
    /// before the first point is pushed. The values may be wrong; accurate values save work.
    ///
    /// # Errors
    /// Returns an error if the disk has not enough room for `points` points, the memory is too
    /// small for any work, the obstacles pushed so far are invalid, or points were pushed already.
    pub fn expect(&mut self, points: u64, mut sample: Vec<Point>) -> Result<(), BuildError> {
        self.before_points("expect")?;
        self.check_obstacles()?;
        sample.retain(|point| point.is_valid());
        let [by_ends, _] = self.segments.counts();
        // Ends become points. In a chain two of them are one vertex.
        let load = DiskLoad {
            points: points.saturating_add(by_ends).saturating_add(self.sites.count()),
            segments: self.segments.len(),
            segment_bytes: self.segments.disk_bytes(),
            spilled_bytes: self.segments.spilled_bytes(),
            has_z: false,
        };
        check_disk(&self.context.folder, load)?;
        self.intake.expect(points, sample, &self.context)
    }

    /// Pushes a batch of points.
    ///
    /// # Errors
    /// Returns an error if a point is [not valid](crate::geometry::Point::is_valid), a z is not
    /// finite, the batch's arrays differ in length, points cannot be spilled, or the build was
    /// cancelled.
    pub fn push<'a>(&'a mut self, batch: &'a PointBatch) -> impl Future<Output = Result<(), BuildError>> + Send + 'a {
        async move {
            let pushed = self.try_push(batch).await;
            self.keep_after(pushed)
        }
        .boxed()
    }

    async fn try_push(&mut self, batch: &PointBatch) -> Result<(), BuildError> {
        let progress = &self.context.options.progress;
        if progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        check_batch(batch)?;
        self.intake.push(batch, &self.context).await?;
        self.segments.resolve(batch)?;
        self.given.has_z |= !batch.z.is_empty();
        let last = batch.records.iter().copied().max();
        self.next_record = self.next_record.max(last.map_or(0, |last| last.saturating_add(1)));
        let points = batch.points.len() as u64;
        self.given.points += points;
        self.context.options.progress.advance(points, points);
        Ok(())
    }

    /// Pushes segments: lines between two positions, or between the points of two records that are
    /// pushed later. Segments become chains of edges. The ends given by positions become vertices;
    /// a point at the same position replaces an end. A segment of no length has no vertices.
    ///
    /// The lines of the batch are numbered from `first_line` on: over all inputs, segments first,
    /// then walls, then obstacles. An obstacle's interior is on the left of its segments, which
    /// form closed rings. The segments of one polygon must come one after another, in one batch or
    /// several; each polygon is [checked](BuildError::Inverted) by itself. Polygons of the same line
    /// are one obstacle, which covers each place once: if its rings overlap, but do not cross, they
    /// are normalised. Its segments must also come one after another. Files record which lines are
    /// rings of one polygon.
    ///
    /// Segments may meet at ends and at points, and may overlap, but must not cross unless
    /// [`Crossings::Split`] is set.
    ///
    /// # Errors
    /// Returns an error if an end is not [valid](crate::geometry::Point::is_valid), a z is
    /// infinite, the batch's arrays differ in length, segments cannot be spilled, or points were
    /// pushed already.
    pub fn push_lines(&mut self, kind: LineKind, first_line: u64, batch: &SegmentBatch) -> Result<(), BuildError> {
        self.before_points("push_lines")?;
        let lines: Vec<u64> = batch.lines.iter().map(|line| line.saturating_add(first_line)).collect();
        let (of_ends, of_records) = lines.split_at(lines.len().min(batch.ends.len()));
        self.segments.push(&batch.ends, &batch.z, kind, of_ends)?;
        self.segments.push_between(&batch.records, kind, of_records)?;
        if kind == LineKind::Obstacle {
            self.polygons.push(first_line, batch)?;
            self.given.has_obstacles = true;
        }
        self.reserve()
    }

    /// Pushes break lines given by their ends. Each is a line of its own.
    /// [`push_lines`](Self::push_lines) takes lines of any kind.
    ///
    /// # Errors
    /// Those of [`push_lines`](Self::push_lines).
    pub fn push_segments(&mut self, segments: &[[Point; 2]]) -> Result<(), BuildError> {
        self.before_points("push_segments")?;
        let lines: Vec<u64> = (self.segments.len()..).take(segments.len()).collect();
        self.segments.push(segments, &[], LineKind::BreakLine, &lines)?;
        self.reserve()
    }

    /// Pushes hole points: the region of each is a hole, that is, everything that can be reached
    /// from it without passing a constraint. A hole point on a constraint makes the regions on both
    /// sides of it holes. A hole point outside the hull has no effect.
    ///
    /// # Errors
    /// Returns an error if a point is not [valid](crate::geometry::Point::is_valid), the points
    /// take more than an eighth of the memory, or points were pushed already.
    pub fn push_seeds(&mut self, seeds: &[Point]) -> Result<(), BuildError> {
        self.before_points("push_seeds")?;
        let numbered = seeds.iter().zip(self.given.seeds.len() as u64..);
        if let Some((&point, seed)) = numbered.into_iter().find(|(seed, _)| !seed.is_valid()) {
            return Err(BuildError::InvalidSeed { seed, point });
        }
        self.given.seeds.extend(seeds.iter().map(|seed| seed.normalized()));
        self.reserve()
    }

    /// Pushes sites: points with an id. All of them are kept, even if several are at the same
    /// position. They become vertices.
    ///
    /// # Errors
    /// Returns an error if a site is not [valid](crate::geometry::Point::is_valid), its z is
    /// infinite, the batch's arrays differ in length, sites take more than a quarter of the memory,
    /// or points were pushed already.
    pub fn push_sites(&mut self, batch: &SiteBatch) -> Result<(), BuildError> {
        self.before_points("push_sites")?;
        self.sites.push(batch)?;
        self.reserve()
    }

    /// Pushes ponds: polygons in which all vertices, and on whose shores too, get the lowest z of the
    /// shore on the triangulation of the points, whatever z they have. Where corners of a shore have a
    /// z, that is the z of the shore there. Of several ponds at a place, the first one counts.
    ///
    /// The polygons are as [`push_lines`](Self::push_lines) takes those of obstacles. The shores are
    /// break lines, numbered from `first_line` on. Number them before all other lines: where lines cross,
    /// the first one determines the z.
    ///
    /// # Errors
    /// Returns an error if an end is not [valid](crate::geometry::Point::is_valid), the batch's arrays
    /// differ in length or have segments between records, ponds and sites take more than a quarter of
    /// the memory, or points were pushed already.
    pub fn push_ponds(&mut self, first_line: u64, batch: &SegmentBatch) -> Result<(), BuildError> {
        self.before_points("push_ponds")?;
        self.ponds.push(first_line, batch)?;
        self.reserve()
    }

    /// Returns [`BuildError::Order`] if points were pushed before `call`.
    fn before_points(&self, call: &'static str) -> Result<(), BuildError> {
        match self.given.points > 0 && self.needs_points() {
            true => Err(BuildError::Order { call }),
            false => Ok(()),
        }
    }

    /// Gives the memory that segments, seeds and sites do not take to everything else.
    fn reserve(&mut self) -> Result<(), BuildError> {
        let seeds = size_of_val(&*self.given.seeds) as u64;
        let sites = self.sites.byte_size() + self.ponds.byte_size() + seeds;
        self.context.segments = self.segments.len();
        self.context.memory = self.context.memory.with_arrivals(self.segments.byte_size(), sites)?;
        Ok(())
    }

    /// Builds the file and gives it its name. Must be awaited within a tokio runtime. Computing
    /// runs on threads of its own.
    ///
    /// # Errors
    /// Returns an error if something cannot be written, segments cross, vertices have no z when
    /// others have ([`MissingZ`](crate::input::MissingZ)), points are duplicates and that is an
    /// error, there is too little memory or room on the disk, or the build was cancelled.
    pub fn finish(mut self) -> impl Future<Output = Result<BuildSummary, BuildError>> + Send {
        async move {
            let built = self.build().await;
            self.keep_after(built)
        }
        .boxed()
    }

    /// Fails if the store has a file of this name, which is not to be replaced.
    async fn check_store(&self) -> Result<(), BuildError> {
        let BuildOptions { store, force, .. } = &*self.context.options;
        let Some(store) = store.as_ref().filter(|_| !force) else {
            return Ok(());
        };
        let cannot = |error| BuildError::io(&self.output, "look in the store for a file of the name of", error);
        match store.has_file().await.map_err(cannot)? {
            true => Err(BuildError::OutputExists(self.output.clone())),
            false => Ok(()),
        }
    }

    async fn build(&mut self) -> Result<BuildSummary, BuildError> {
        self.check_store().await?;
        if self.needs_points() {
            self.complete_points().await?;
        } else {
            self.gather().await?;
            self.read_back().await?;
        }
        let (assembly, points, segments) = self.assembly().await?;
        assembly.build(points, segments).await
    }

    /// Adds what becomes points once all points have arrived.
    async fn complete_points(&mut self) -> Result<(), BuildError> {
        if self.needs_surface()? {
            self.triangulate_points().await?;
        }
        self.push_ends().await
    }

    /// Returns what makes the file of all that has arrived.
    async fn assembly(&mut self) -> Result<(Assembly, Points, SegmentSpool), BuildError> {
        let intake = std::mem::replace(&mut self.intake, Intake::new());
        let points = intake.finish().await?;
        let segments = std::mem::replace(&mut self.segments, SegmentSpool::new(self.context.folder.spill(), 0));
        let mut given = std::mem::take(&mut self.given);
        let site_ids = std::mem::take(&mut self.sites).into_ids();
        if !site_ids.is_empty() {
            given.site_ids = site_ids;
        }
        let assembly = Assembly::new(&self.context, &self.output, given, self.began);
        Ok((assembly.on_surface(self.surface.take()), points, segments))
    }

    /// Returns whether there are ponds, or lines or sites lack a z and points have it. Asked before
    /// ends of lines become points.
    ///
    /// # Errors
    /// Fails if there are ponds, and the points have no z.
    fn needs_surface(&self) -> Result<bool, BuildError> {
        let lacks_z = self.segments.lacks_z() || self.sites.lacks_z();
        let drapes = self.context.options.missing_z == MissingZ::Drape && lacks_z;
        match (self.ponds.is_empty(), self.given.has_z) {
            (false, false) => Err(BuildError::PondsWithoutZ),
            (has_no_ponds, has_z) => Ok(has_z && (drapes || !has_no_ponds)),
        }
    }

    /// Triangulates the points alone, so that other vertices can take their z from the surface. Then
    /// the z of ponds are known, and their shores become lines.
    async fn triangulate_points(&mut self) -> Result<(), BuildError> {
        let intake = std::mem::replace(&mut self.intake, Intake::new());
        let given = Given {
            points: self.given.points,
            has_z: true,
            next_record: self.next_record,
            first_crossing: u64::MAX,
            first_site: u64::MAX,
            ..Given::default()
        };
        let input = (intake, self.ponds.take_shores());
        let made = surface_of(input, &mut self.context, &self.output, given, self.began).await;
        let (surface, intake) = made?;
        let (ponds, lines) = (surface.ponds(), self.ponds.lines());
        self.segments
            .push(&ponds.shores(), &ponds.z_of_edges(), LineKind::BreakLine, lines)?;
        self.reserve()?;
        (self.surface, self.intake) = (Some(Arc::new(surface)), intake);
        Ok(())
    }

    /// Decides by `result` whether the work folder is kept. A resumable build that was stopped by
    /// an external cause keeps its work. Once the plan is saved, the work is kept after other
    /// errors too, unless resuming would end in the same error.
    fn keep_after<T>(&self, result: Result<T, BuildError>) -> Result<T, BuildError> {
        let BuildContext { folder, options, .. } = &self.context;
        match result {
            Err(BuildError::Cancelled | BuildError::Io { .. } | BuildError::Disk { .. }) => {
                folder.keep(options.resumable.is_some());
            }
            Err(ref error) if error.is_of_input() => folder.keep(false),
            _ => {}
        }
        result
    }
}

/// Returns the file that an output's name stands for.
fn target(output: &Path) -> Result<PathBuf, BuildError> {
    new_output(output).map_err(|error| BuildError::io(output, "write a file under this name", error))
}
