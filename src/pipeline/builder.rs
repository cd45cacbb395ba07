//! The builder: takes points and lines, and makes a file of them.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use crate::constraints::polygons::arrivals::Arrivals;
use crate::constraints::polygons::check::PolygonFaults;
use crate::constraints::segments::spool::SegmentSpool;
use crate::constraints::split_lines::SplitLines;
use crate::geometry::Point;
use crate::input::{PointBatch, SegmentBatch, SiteBatch};
use crate::io::output_target;
use crate::pipeline::assembly::Assembly;
use crate::pipeline::disk::{DiskLoad, check_disk};
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::intake::Intake;
use crate::pipeline::ingest::sites::Sites;
use crate::pipeline::options::{BuildOptions, Crossings, Phase, Steiner};
use crate::pipeline::records::Description;
use crate::pipeline::resume::journal::SavedPlan;
use crate::pipeline::summary::BuildSummary;
use crate::pipeline::terms::{Given, Terms};
use crate::pipeline::work_folder::WorkFolder;
use crate::store::LineKind;

/// Builds a tile file from batches of points.
///
/// If the output's name is a symbolic link, what it leads to is the output. Until [`finish`](Self::finish) has succeeded, nothing stands under the output's name; work lies in `OUT.partial/`,
/// which goes away with the builder, unless the build can be [resumed](BuildOptions::resumable).
///
/// Lines, sites and hole points come first, then points; else the build fails with [`BuildError::Order`].
#[derive(Debug)]
pub struct Builder {
    terms: Terms,
    output: PathBuf,
    intake: Intake,
    /// One more than the largest record number so far.
    next_record: u64,
    segments: SegmentSpool,
    polygons: Arrivals,
    sites: Sites,
    given: Given,
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
        let output = output.as_ref();
        let target = output_target(output);
        let output = target.map_err(|error| BuildError::io(output, "write a file under this name", error))?;
        let tmp = options.work_folder.as_deref();
        let folder = WorkFolder::create(&output, tmp, options.force, options.resume)?;
        let memory = options.memory_plan();
        let mut this = Self {
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
            given: Given::default(),
            began: Instant::now(),
            terms: Terms {
                options: Arc::new(options),
                folder: Arc::new(folder),
                first_end: Arc::new(AtomicU64::new(u64::MAX)),
                segments: 0,
                memory,
            },
        };
        if this.terms.options.resume {
            // The folder is kept until this is done: whatever is wrong with what is there, it stays.
            this.resume()?;
            this.terms.folder.keep(!this.needs_points());
        }
        this.terms.options.progress.start(Phase::Read, 0);
        Ok(this)
    }

    /// Takes up what a build before has left; if that is nothing to go on from, it goes away.
    fn resume(&mut self) -> Result<(), BuildError> {
        let Terms { folder, options, .. } = &self.terms;
        let cannot = |error| BuildError::io(folder.path(), "resume the work in", error);
        match SavedPlan::load(&folder.plan()).map_err(cannot)? {
            Some(saved) if !folder.was_published() => {
                let mine = options.identity();
                if let Some((left, _)) = saved.identity.lines().zip(mine.lines()).find(|(a, b)| a != b) {
                    return Err(BuildError::OtherBuild {
                        path: folder.path().to_owned(),
                        what: left.to_owned(),
                    });
                }
                self.given.points = saved.plan.points;
                self.given.has_z = saved.plan.has_z;
                self.given.next_record = saved.next_record;
                self.given.description = saved.description.clone();
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
        &self.given.description
    }

    /// Notes where the points come from and in which coordinate reference system, as metadata.
    pub fn describe(&mut self, description: Description) {
        self.given.description = description;
    }

    /// Tells about how many points will come, and of some of them where they lie, before the first one is pushed. It need not
    /// be right: it saves work where it is.
    ///
    /// # Errors
    /// If there is not enough room on the disk for so many points, the memory is too small for any work, or what is known of
    /// obstacles by now is wrong.
    pub fn expect(&mut self, points: u64, mut sample: Vec<Point>) -> Result<(), BuildError> {
        self.before_points("expect")?;
        judge(self.polygons.faults()?)?;
        sample.retain(|point| point.is_valid());
        let [by_ends, _] = self.segments.counts();
        // Ends become points, two of which are one vertex in a chain.
        let load = DiskLoad {
            points: points.saturating_add(by_ends).saturating_add(self.sites.count()),
            segments: self.segments.len(),
            segment_bytes: self.segments.disk_bytes(),
            spilled_bytes: self.segments.spilled_bytes(),
            has_z: false,
        };
        check_disk(&self.terms.folder, load)?;
        self.intake.expect(points, sample, &self.terms)
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
        let progress = &self.terms.options.progress;
        if progress.is_cancelled() {
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
        self.intake.push(batch, &self.terms).await?;
        self.segments.resolve(batch)?;
        self.given.has_z |= !batch.z.is_empty();
        let last = batch.records.iter().copied().max();
        self.next_record = self.next_record.max(last.map_or(0, |last| last.saturating_add(1)));
        let points = points as u64;
        self.given.points += points;
        self.terms.options.progress.advance(points, points);
        Ok(())
    }

    /// Takes segments: lines between two places, or between the points of two records that are pushed later, which become
    /// chains of edges. The ends of those between places join the vertices; where a point lies at the same place, that is kept.
    ///
    /// The batch's lines are numbered from `first_line` on: over all inputs, segments first, then walls, then obstacles. An
    /// obstacle's interior is on the left of its segments, which form closed rings. Those of one polygon come one after another, in
    /// one batch or several; each polygon is [checked](BuildError::Inverted) by itself.
    ///
    /// Segments may meet in ends, in points and along each other, but not cross. A build with segments cannot be resumed.
    ///
    /// # Errors
    /// If an end is not [valid](crate::geometry::Point::is_valid), a z infinite, the batch's arrays
    /// are not equally long, or segments cannot be spilled.
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

    /// Takes break lines by their ends, each a line of its own: what [`push_lines`](Self::push_lines) does with many kinds.
    ///
    /// # Errors
    /// Those of [`push_lines`](Self::push_lines).
    pub fn push_segments(&mut self, segments: &[[Point; 2]]) -> Result<(), BuildError> {
        self.before_points("push_segments")?;
        let lines: Vec<u64> = (self.segments.len()..).take(segments.len()).collect();
        self.segments.push(segments, &[], LineKind::BreakLine, &lines)?;
        self.reserve()
    }

    /// Takes points whose regions are holes: all that can be reached from one without passing a constraint. One that lies on a
    /// constraint counts for both sides of it, and one outside of the hull for nothing.
    ///
    /// # Errors
    /// If one is not [valid](crate::geometry::Point::is_valid), or they take more than an eighth of the memory.
    pub fn push_seeds(&mut self, seeds: &[Point]) -> Result<(), BuildError> {
        self.before_points("push_seeds")?;
        let numbered = seeds.iter().zip(self.given.seeds.len() as u64..);
        if let Some((&point, seed)) = numbered.into_iter().find(|(seed, _)| !seed.is_valid()) {
            return Err(BuildError::InvalidSeed { seed, point });
        }
        self.given.seeds.extend(seeds.iter().map(|seed| seed.normalized()));
        self.reserve()
    }

    /// Takes sites: points with an id, all of which are kept, several at one place too. They join the vertices.
    ///
    /// # Errors
    /// If a site is not [valid](crate::geometry::Point::is_valid) or its z infinite, the batch's
    /// arrays are not equally long, or sites take more than a quarter of the memory.
    pub fn push_sites(&mut self, batch: &SiteBatch) -> Result<(), BuildError> {
        self.before_points("push_sites")?;
        self.sites.push(batch)?;
        self.reserve()
    }

    /// Fails if points have come that a call must precede.
    fn before_points(&self, call: &'static str) -> Result<(), BuildError> {
        match self.given.points > 0 && self.needs_points() {
            true => Err(BuildError::Order { call }),
            false => Ok(()),
        }
    }

    /// Leaves the memory that segments, seeds and sites do not take for everything else.
    fn reserve(&mut self) -> Result<(), BuildError> {
        let seeds = size_of_val(&*self.given.seeds) as u64;
        let sites = self.sites.byte_size() + seeds;
        self.terms.segments = self.segments.len();
        self.terms.memory = self.terms.memory.with_arrivals(self.segments.byte_size(), sites)?;
        Ok(())
    }

    /// Pushes the ends of segments as points, which give way to others, and sites, which give way to all.
    async fn push_ends(&mut self) -> Result<(), BuildError> {
        let faults = self.polygons.all_faults(&mut self.segments)?;
        judge(faults)?;
        self.given.inverted_if_uncrossed = faults.inverted_if_uncrossed;
        self.terms.first_end.store(self.next_record, Ordering::Relaxed);
        let mut record = self.next_record;
        for batch in self.segments.ends(record) {
            let batch = batch?;
            record += batch.records.len() as u64;
            self.given.has_z |= !batch.z.is_empty();
            self.intake.push(&batch, &self.terms).await?;
        }
        self.given.first_crossing = record;
        let options = &self.terms.options;
        if options.crossings == Crossings::Split || options.steiner == Steiner::Borders {
            record = self.split_lines(record).await?;
        }
        self.given.first_site = record;
        self.given.next_record = record + self.sites.count();
        self.given.has_z |= self.sites.has_z();
        for batch in self.sites.take_points(record) {
            self.intake.push(&batch, &self.terms).await?;
        }
        Ok(())
    }

    /// Splits segments where they cross each other or borders, and pushes the crossing points. Returns the next record number.
    async fn split_lines(&mut self, first_record: u64) -> Result<u64, BuildError> {
        let (arrived, sites) = (self.intake.arrived(&self.terms).await?, self.sites.points());
        let mut points = |within, take: &mut dyn FnMut(&[Point])| {
            take(sites);
            arrived.for_each(within, take)
        };
        let borders = |within| match self.terms.options.steiner {
            Steiner::Borders => arrived.borders(within),
            Steiner::Never => Vec::new(),
        };
        let may_cross = self.terms.options.crossings == Crossings::Split;
        let memory = self.terms.memory.rest();
        let polygons = self.polygons.numbers();
        let split = SplitLines::of(
            (&mut self.segments, polygons),
            memory,
            (may_cross, &borders),
            &mut points,
        )?;
        let Some(lines) = split else {
            return Ok(first_record);
        };
        self.given.crossings = lines.crossings();
        self.given.put_right = lines.put_right();
        self.given.borders = lines.borders().to_vec();
        self.segments = SegmentSpool::new(self.terms.folder.spill(), self.terms.memory.for_segments());
        lines.push_pieces(&mut self.segments)?;
        self.reserve()?;
        let mut record = first_record;
        for batch in lines.points(first_record) {
            record += batch.points.len() as u64;
            self.given.split_points += batch.points.len() as u64;
            self.given.has_z |= !batch.z.is_empty();
            self.intake.push(&batch, &self.terms).await?;
        }
        Ok(record)
    }

    /// Builds the file and gives it its name. Must be awaited within a tokio runtime; computing happens on threads of its
    /// own.
    ///
    /// # Errors
    /// If something cannot be written, segments cross, vertices have no z where others have
    /// ([`MissingZ`](crate::input::MissingZ)), duplicates were to be an error, there is too little memory
    /// or room on the disk, or the build was cancelled.
    pub async fn finish(mut self) -> Result<BuildSummary, BuildError> {
        let built = self.build().await;
        self.keep_after(built)
    }

    async fn build(&mut self) -> Result<BuildSummary, BuildError> {
        let is_resumed = !self.needs_points();
        if !is_resumed {
            self.push_ends().await?;
        }
        let intake = std::mem::replace(&mut self.intake, Intake::new());
        let points = intake.finish().await?;
        let segments = std::mem::replace(&mut self.segments, SegmentSpool::new(self.terms.folder.spill(), 0));
        let mut given = std::mem::take(&mut self.given);
        given.site_ids = std::mem::take(&mut self.sites).into_ids();
        let assembly = Assembly::new(&self.terms, &self.output, given, self.began);
        assembly.build(points, segments, is_resumed).await
    }

    /// What was done stays where a build that can be resumed was stopped from without; once the plan is saved it stays
    /// anyway, unless going on would end in the same way.
    fn keep_after<T>(&self, result: Result<T, BuildError>) -> Result<T, BuildError> {
        let Terms { folder, options, .. } = &self.terms;
        match result {
            Err(BuildError::Cancelled | BuildError::Io { .. } | BuildError::Disk { .. }) => {
                folder.keep(options.resumable.is_some());
            }
            Err(BuildError::Duplicate { .. } | BuildError::TooManyTiles { .. }) => folder.keep(false),
            _ => {}
        }
        result
    }
}

/// Fails if something is wrong with polygons, whatever else is.
fn judge(faults: PolygonFaults) -> Result<(), BuildError> {
    match (faults.open, faults.inverted) {
        (Some(obstacle), _) => Err(BuildError::OpenRing { obstacle }),
        (None, Some(inverted)) => Err(BuildError::Inverted(inverted)),
        (None, None) => Ok(()),
    }
}
