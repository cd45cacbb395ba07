//! A transaction: takes changes of points, lines and sites, and makes them all at once.

use std::collections::BTreeSet;
use std::num::NonZero;
use std::sync::Arc;
use std::thread;

use futures::future::FutureExt;
use tokio::sync::OwnedMutexGuard;

use crate::constraints::without_z::NO_Z;
use crate::edit::{EditError, EditSummary, GoneLines, PointCall, PointCalls, SiteCall, SiteCalls, Target, Work};
use crate::editor::drape::drape;
use crate::editor::intake::{LineIntake, TakenLines};
use crate::editor::locked::LockedFile;
use crate::editor::pieces::{normalized, normalized_pieces};
use crate::geometry::Point;
use crate::input::{MissingZ, PointBatch, SegmentBatch, SiteBatch};
use crate::io::folder_of;
use crate::memory::EditShares;
use crate::store::{LineKind, LineSource, Metadata, Source};

/// Changes of a file, which take effect at once when they are [committed](Self::commit). If it is
/// dropped before, nothing happens.
///
/// The calls that change points act in their order. Lines that are removed are those that the file
/// had before, and they go before others come. [`Editor`](crate::Editor) has an example.
pub struct Transaction {
    file: OwnedMutexGuard<LockedFile>,
    /// The metadata of the file, with the changes that are in its log.
    before: Metadata,
    memory: u64,
    /// The number of the first new line, which is the number of lines before the edit.
    first_line: u64,
    /// The number of this edit, from 1.
    number: u32,
    crs: Option<String>,
    next_record: u64,
    next_site: u64,
    is_dry_run: bool,
    prefers_build: bool,
    points: PointCalls,
    sources: Vec<LineSource>,
    /// The lines that come, and those that go.
    lines: LineIntake,
    gone: LineIntake,
    gone_numbers: BTreeSet<u64>,
    /// z at the ends of segments, as far as any have z.
    z: Vec<f64>,
    sites: SiteCalls,
    missing_z: MissingZ,
}

impl Transaction {
    /// Begins a transaction of a file in its current state.
    pub(super) fn begin(mut file: OwnedMutexGuard<LockedFile>) -> impl Future<Output = Result<Self, EditError>> + Send {
        async move {
            let (before, number, crs) = file.state().await?;
            let path = &file.target.path;
            Ok(Self {
                first_line: before.next_line,
                crs,
                next_record: before.next_record,
                next_site: before.next_site,
                is_dry_run: false,
                prefers_build: false,
                points: PointCalls::default(),
                number,
                lines: LineIntake::new(path, before.next_line),
                gone: LineIntake::new(path, 0),
                gone_numbers: BTreeSet::new(),
                memory: file.memory,
                before,
                file,
                sources: Vec::new(),
                z: Vec::new(),
                sites: SiteCalls::default(),
                missing_z: MissingZ::default(),
            })
        }
        .boxed()
    }

    /// Sets what to do with ends of lines that become vertices and have no z, in a file whose
    /// vertices have z. By default they take it from the triangulation before the edit
    /// ([`MissingZ::Drape`]). New points without z are an error, unless it becomes 0
    /// ([`MissingZ::Zero`]).
    pub fn missing_z(&mut self, missing_z: MissingZ) {
        self.missing_z = missing_z;
        self.points.missing_z = missing_z;
    }

    /// Sets whether to leave out changes of points, lines to remove and sites to delete that are not
    /// there, and count them ([`PointCounts::skipped`](crate::PointCounts::skipped),
    /// [`LineCounts::skipped`](crate::LineCounts::skipped),
    /// [`SiteCounts::skipped`](crate::SiteCounts::skipped)). By default they are an error.
    pub fn skip_missing(&mut self, skip_missing: bool) {
        self.points.skip_missing = skip_missing;
        self.sites.skip_missing = skip_missing;
    }

    /// Sets whether to do all the work without changing the file. By default the file is changed.
    pub fn dry_run(&mut self, is_dry_run: bool) {
        self.is_dry_run = is_dry_run;
    }

    /// Sets whether to build all tiles anew even if few points change. By default they are built anew
    /// if so many change that this is faster, or if the file has no triangles. If no point changes, a
    /// file with triangles is edited in any case.
    ///
    /// A build makes a file that takes the place of the edited one, with its permissions. It needs room
    /// for it in the same folder, where its work is in `FILE.partial/`. It has no
    /// [overviews](crate::TileReader::overviews).
    pub fn prefer_build(&mut self, prefers_build: bool) {
        self.prefers_build = prefers_build;
    }

    /// Inserts points, with z if the file has z. They may lie outside the hull. A point at the
    /// position of another one is a duplicate, and leaves the other as it is; at a vertex that only
    /// lines and sites hold, it gives the vertex its z. The record numbers of the batch, which
    /// start from 0 in an edit, follow the numbers that the file has given so far.
    ///
    /// # Errors
    /// Returns an error if a coordinate or z is not valid; then it has no effect. Changes of points that
    /// take more than half of the memory, with those of lines and sites, go to a file without a name in
    /// the folder of the edited one. Returns an error if the disk is full.
    pub fn insert(&mut self, batch: &PointBatch) -> Result<(), EditError> {
        check_values(&batch.points, &batch.z)?;
        self.push_calls(batch.len(), false, |this, place| {
            let number = batch.records.get(place).copied().unwrap_or(this.points.records);
            let record = this.next_record.saturating_add(number);
            let z = batch.z.get(place).copied().unwrap_or(NO_Z);
            this.points.records = this.points.records.max(number.saturating_add(1));
            PointCall::Insert(batch.points[place].normalized(), z, record)
        })
    }

    /// Names the files that inserted points come from, each with its number of records, in the order
    /// of these.
    pub fn add_point_sources(&mut self, sources: &[(String, u64)]) {
        let mut first = self.next_record;
        self.points.sources = sources
            .iter()
            .map(|(name, records)| {
                let source = Source {
                    name: name.clone(),
                    records: *records,
                    first,
                };
                first += records;
                source
            })
            .collect();
        self.points.records = self.points.records.max(first - self.next_record);
    }

    /// Deletes the points at these positions. A vertex stays as long as a site or the end of a
    /// segment holds it. If a line passes it, the line stays, without the vertex.
    ///
    /// # Errors
    /// As for [`insert`](Self::insert).
    pub fn delete(&mut self, points: &[Point]) -> Result<(), EditError> {
        check_values(points, &[])?;
        self.push_calls(points.len(), false, |_, place| {
            PointCall::Delete(points[place].normalized())
        })
    }

    /// Moves points, each from its first position to its second, with its z and its record number.
    /// A point that is moved to the position of another one is a duplicate, and gone. Ends of lines
    /// and sites do not move with it.
    ///
    /// # Errors
    /// As for [`insert`](Self::insert).
    pub fn move_points(&mut self, pairs: &[[Point; 2]]) -> Result<(), EditError> {
        check_values(pairs.as_flattened(), &[])?;
        self.push_calls(pairs.len(), true, |_, place| {
            PointCall::Move(pairs[place].map(Point::normalized))
        })
    }

    /// Gives the points at the positions of a batch the z of the batch.
    ///
    /// # Errors
    /// As for [`insert`](Self::insert).
    pub fn set_z(&mut self, batch: &PointBatch) -> Result<(), EditError> {
        check_values(&batch.points, &batch.z)?;
        self.push_calls(batch.len(), false, |_, place| {
            let z = batch.z.get(place).copied().unwrap_or(NO_Z);
            PointCall::SetZ(batch.points[place].normalized(), z)
        })
    }

    /// Adds calls, which are given by their place. Where memory is short, those so far go to disk.
    fn push_calls(
        &mut self,
        count: usize,
        are_moves: bool,
        call: impl Fn(&mut Self, usize) -> PointCall,
    ) -> Result<(), EditError> {
        for place in 0..count {
            self.make_room(|this| this.points.memory_with(1, are_moves) + this.sites.memory(), 0)?;
            let call = call(self, place);
            self.points.push(call);
        }
        Ok(())
    }

    /// Returns the coordinate reference system of the file, as it names it.
    #[must_use]
    pub fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }

    /// Returns the number that the first new line gets in the file.
    #[must_use]
    pub fn first_line(&self) -> u64 {
        self.first_line
    }

    /// Returns the number that follows those of all sites so far, in the file and in this edit. Sites
    /// without ids may take it.
    #[must_use]
    pub fn next_site(&self) -> u64 {
        self.next_site.saturating_add(self.sites.all.len() as u64)
    }

    /// Sets the files that the lines come from, in the order of their numbers from 0 on.
    pub fn add_sources(&mut self, sources: Vec<LineSource>) {
        let (first_line, edit) = (self.first_line, self.number);
        let numbered = sources.into_iter().map(|source| LineSource {
            name: source.name,
            kind: source.kind,
            first: first_line + source.first,
            lines: source.lines,
            edit,
        });
        self.sources.extend(numbered);
    }

    /// Makes segments constraints. Their lines are numbered from `first_line` on, among the new lines.
    ///
    /// # Errors
    /// Returns an error if segments are given by record numbers, if only some of them have a
    /// polygon number, or if they take more than half of the memory.
    pub fn constrain(&mut self, kind: LineKind, first_line: u64, batch: &SegmentBatch) -> Result<(), EditError> {
        self.check_segments(batch)?;
        let before = self.lines.segments.len();
        self.lines.push(kind, first_line, batch)?;
        if !batch.z.is_empty() {
            self.z.resize(2 * before, NO_Z);
            self.z.extend_from_slice(batch.z.as_flattened());
        }
        Ok(())
    }

    /// Removes lines, by their segments. Each segment must be a whole segment of a line of this kind
    /// in the file; the points on its way do not matter. If several lines have it, the one with the
    /// smallest number loses it that has all segments of the given line. Obstacles are removed as
    /// whole polygons. Vertices that nothing else holds go, too: no point, no site, and no end of
    /// another segment. The lines are numbered from `first_line` on, for errors.
    ///
    /// # Errors
    /// Returns an error if segments are given by record numbers, if only some of them have a
    /// polygon number, or if they take more than half of the memory.
    pub fn unconstrain(&mut self, kind: LineKind, first_line: u64, batch: &SegmentBatch) -> Result<(), EditError> {
        self.check_segments(batch)?;
        self.gone.push(kind, first_line, batch)
    }

    /// Removes lines, by their numbers in the file, with all their segments. Of obstacles, all rings
    /// go. This reads all tiles.
    pub fn remove_lines(&mut self, numbers: &[u64]) {
        self.gone_numbers.extend(numbers);
    }

    /// Inserts sites. Where no vertex is, a site makes one, which takes its z; outside the hull, too.
    ///
    /// # Errors
    /// Returns an error if the arrays of the batch differ in length, if a coordinate or z is not
    /// valid, or if the changes of sites take more than half of the memory. Then it has no effect.
    pub fn insert_sites(&mut self, batch: &SiteBatch) -> Result<(), EditError> {
        let (sites, z, ids) = (batch.points.len(), batch.z.len(), batch.ids.len());
        if ids != sites || (z != sites && z != 0) {
            return Err(EditError::SiteBatch { sites, z, ids });
        }
        check_values(&batch.points, &batch.z)?;
        self.make_room(|this| this.points.memory() + this.sites.memory_with_batch(batch), 0)?;
        for (place, (point, id)) in batch.points.iter().zip(&batch.ids).enumerate() {
            let z = batch.z.get(place).copied().unwrap_or(NO_Z);
            self.sites.push(SiteCall::Insert(point.normalized(), z, id.clone()));
        }
        Ok(())
    }

    /// Deletes the sites at these positions, whatever their ids. A vertex goes with them if nothing
    /// else holds it: no point, and no end of a segment. Calls that change sites act in their order.
    ///
    /// # Errors
    /// As for [`insert_sites`](Self::insert_sites).
    pub fn delete_sites(&mut self, points: &[Point]) -> Result<(), EditError> {
        check_values(points, &[])?;
        self.make_room(|this| this.points.memory() + this.sites.memory_with(points.len(), 0), 0)?;
        let calls = points.iter().map(|point| SiteCall::Delete(point.normalized()));
        calls.for_each(|call| self.sites.push(call));
        Ok(())
    }

    /// Checks that the ends of segments are valid, and that there is memory for the segments.
    fn check_segments(&mut self, batch: &SegmentBatch) -> Result<(), EditError> {
        check_values(batch.ends.as_flattened(), batch.z.as_flattened())?;
        self.make_room(|this| this.points.memory() + this.sites.memory(), batch.ends.len())
    }

    /// Checks that there is memory for changes of points and sites, which take `points` bytes, and for
    /// `more` segments. If there is none, changes of points go to disk.
    fn make_room(&mut self, points: impl Fn(&Self) -> u64, more: usize) -> Result<(), EditError> {
        let segments = (self.lines.segments.len() + self.gone.segments.len() + more) as u64;
        let check = |this: &Self| EditShares::check_input(this.memory, points(this), segments);
        if check(self).is_err() && !self.points.all.is_empty() {
            self.spill()?;
        }
        Ok(check(self)?)
    }

    /// Moves the changes of points to disk.
    fn spill(&mut self) -> Result<(), EditError> {
        let path = &self.file.target.path;
        // Lines and sites may take as much.
        let spilled = self.points.spill(folder_of(path), self.memory / 4);
        spilled.map_err(|error| EditError::io(path, "write changes to disk beside", error))
    }

    /// Makes all changes. An obstacle that covers a place more than once is normalised, so
    /// that it covers it once. The file is unchanged until the very end.
    ///
    /// # Errors
    /// Returns an error if a point or a site is not there, or lies where lines cross; if a point, a site or an end lacks
    /// a z ([`missing_z`](Self::missing_z)), or a point has z in a file without; if a line crosses a
    /// constraint, if a line to remove is not there, or if the file's lines were split where they cross;
    /// if a ring does not close, if a polygon is inside out, if an obstacle covers a place
    /// more than once and its rings cross; or if the system fails.
    pub fn commit(mut self) -> impl Future<Output = Result<EditSummary, EditError>> + Send {
        async move {
            let is_small = self.may_be_logged();
            if self.points.spilled.is_some() {
                // One part is in memory at a time.
                self.spill()?;
            }
            let Self {
                mut file,
                mut before,
                memory,
                mut z,
                missing_z,
                mut points,
                mut sites,
                is_dry_run,
                prefers_build,
                ..
            } = self;
            if is_small {
                points = match file.log(points).await? {
                    Ok(summary) => return Ok(summary),
                    Err(points) => points,
                };
            }
            // New vertices take their z from the surface with what is in the log.
            let unused_records = file.settle(&mut before).await?;
            let lines = self.lines.finish()?;
            let gone = gone_lines(self.gone.finish()?, self.gone_numbers, memory, points.skip_missing);
            if missing_z == MissingZ::Drape {
                let memory = EditShares::for_draping(memory);
                let ends: Vec<Point> = lines.segments.iter().flat_map(|segment| segment.ends).collect();
                drape(&file.target, &ends, &mut z, memory).await?;
                drape_sites(&file.target, &mut sites, memory).await?;
            }
            z.shrink_to_fit();
            let pieces = |normalizer| Arc::new(normalized_pieces(&lines.segments, normalizer));
            let work = Work {
                new_records: unused_records + points.records + 2 * lines.segments.len() as u64 + sites.all.len() as u64,
                points,
                sites,
                gone,
                pieces: lines.normalizer.map(pieces),
                segments: Arc::new(lines.segments),
                z: Arc::new(z),
                missing_z,
                lines: self.sources,
                polygon_lines: lines.polygon_lines,
                inverted: lines.faults.inverted_if_uncrossed,
                overlapping: lines.faults.overlapping_if_uncrossed,
                is_dry_run,
                threads: thread::available_parallelism().map_or(1, NonZero::get),
                ..Work::default()
            };
            file.make(&before, work, prefers_build).await
        }
        .boxed()
    }

    /// Returns whether points are all that it changes.
    fn may_be_logged(&self) -> bool {
        let lines = [&self.lines, &self.gone].iter().any(|lines| !lines.segments.is_empty());
        let others = lines || !self.gone_numbers.is_empty() || !self.sites.all.is_empty() || !self.sources.is_empty();
        let is_plain = self.points.sources.is_empty() && !self.is_dry_run && !self.prefers_build;
        is_plain && !others && !self.points.is_empty()
    }
}

/// Returns what removes lines, given by geometry and by their numbers.
fn gone_lines(lines: TakenLines, numbers: BTreeSet<u64>, memory: u64, skip_missing: bool) -> GoneLines {
    GoneLines {
        segments: Arc::new(normalized(lines.segments, lines.normalizer)),
        polygon_lines: lines.polygon_lines,
        numbers,
        memory,
        skip_missing,
    }
}

/// Fills in the z of new sites that have none, in a file with z.
async fn drape_sites(target: &Target, sites: &mut SiteCalls, memory: u64) -> Result<(), EditError> {
    let inserted = sites.all.iter_mut().filter_map(|call| match call {
        SiteCall::Insert(point, z, _) => Some((*point, z)),
        SiteCall::Delete(_) => None,
    });
    let (points, places): (Vec<Point>, Vec<&mut f64>) = inserted.unzip();
    let mut z = places.iter().map(|z| **z).collect();
    drape(target, &points, &mut z, memory).await?;
    places.into_iter().zip(z).for_each(|(place, z)| *place = z);
    Ok(())
}

/// Checks that points are valid, and z finite or missing.
fn check_values(points: &[Point], z: &[f64]) -> Result<(), EditError> {
    if let Some(&point) = points.iter().find(|point| !point.is_valid()) {
        return Err(EditError::InvalidPoint(point));
    }
    match z.iter().zip(points).find(|(z, _)| z.is_infinite()) {
        Some((&z, &point)) => Err(EditError::InvalidZ { point, z }),
        None => Ok(()),
    }
}
