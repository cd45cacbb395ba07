//! A build in progress.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use delaunay_tiles::crs::{Agreement, Crs};
use delaunay_tiles::input::{PointBatch, PointSource, PolySource, Reading, SegmentSource, SiteBatch, SiteSource};
use delaunay_tiles::store::Source;
use delaunay_tiles::{BuildSummary, Builder, Description, Planned};
use tiletool::crs::Extents;
use tiletool::lines::{LineInput, LineSet};
use tiletool::points::push_points;
use tiletool::task::reading;
use tokio::sync::Notify;

use super::options::Role;
use crate::error::{Failure, Outcome};

/// A build in progress: the library's builder, and what it is told of its inputs at the end.
pub struct Work {
    pub builder: Builder,
    lines: LineInput,
    /// The numbers of records and of sites that were pushed.
    pub records: u64,
    pub sites: u64,
    sources: Vec<Source>,
    agreement: Agreement,
    extents: Extents,
    notes: Vec<String>,
    stop: Arc<Stop>,
}

/// What wakes a build that is to end: it may wait for a file.
#[derive(Default)]
pub struct Stop {
    is_set: AtomicBool,
    cancelled: Notify,
    readings: Mutex<Vec<Reading>>,
}

impl Stop {
    /// Ends the reading of files.
    pub fn now(&self) {
        self.is_set.store(true, Ordering::Relaxed);
        let readings = self.readings.lock().unwrap_or_else(PoisonError::into_inner);
        readings.iter().for_each(Reading::stop);
        self.cancelled.notify_one();
    }

    fn watch(&self, reading: &Reading) {
        let mut readings = self.readings.lock().unwrap_or_else(PoisonError::into_inner);
        readings.push(reading.clone());
    }
}

/// Returns whether a file is one of points and segments.
pub fn is_poly(path: &Path) -> bool {
    let name = path.to_string_lossy().to_ascii_lowercase();
    name.ends_with(".poly") || name.ends_with(".poly.gz")
}

impl Work {
    pub fn new(builder: Builder, crs: Option<&str>, stop: Arc<Stop>) -> Outcome<Self> {
        let given = crs.map(Crs::new);
        if let Some(unknown) = given.as_ref().filter(|crs| !crs.is_known()) {
            let text = delaunay_tiles::shown::beginning(unknown.text(), 60).to_string();
            return Err(Failure::value(format!(
                "crs must be a code such as 'EPSG:25832', or WKT, not '{text}'"
            )));
        }
        let sites = SiteSource::open(&[], None)?;
        Ok(Self {
            builder,
            lines: LineInput::new(Vec::new(), sites),
            records: 0,
            sites: 0,
            sources: Vec::new(),
            agreement: given.map_or_else(Agreement::default, Agreement::on),
            extents: Extents::default(),
            notes: Vec::new(),
            stop,
        })
    }

    /// Takes the coordinate reference system of an input.
    ///
    /// # Errors
    /// Fails if it contradicts that of another input.
    pub fn take_crs(&mut self, input: &Path, text: &str) -> Outcome<()> {
        let agreed = self.agreement.add(input, Crs::new(text));
        agreed.map_err(|conflict| Failure::input(conflict.to_string()))
    }

    /// Takes the coordinate reference systems of files, which must agree.
    pub fn take_systems(&mut self, systems: &[(PathBuf, String)]) -> Outcome<()> {
        systems.iter().try_for_each(|(path, text)| self.take_crs(path, text))
    }

    /// Pushes the lines of a file.
    pub fn push_line_file(&mut self, role: Role, path: PathBuf) -> Outcome<()> {
        let source = role.open(&[path])?;
        self.stop.watch(source.reading());
        self.take_systems(source.crs_of_files())?;
        self.push_lines(role, source)
    }

    /// Pushes geometries, as well-known binary.
    pub fn push_wkb(&mut self, role: Role, name: &str, geometries: Vec<Vec<u8>>) -> Outcome<()> {
        let source = SegmentSource::from_wkb(name, geometries.into_iter(), role.takes_polygons())?;
        self.stop.watch(source.reading());
        self.push_lines(role, source)
    }

    fn push_lines(&mut self, role: Role, source: SegmentSource) -> Outcome<()> {
        self.lines.add(match role {
            Role::Ponds => LineSet::ponds(source),
            Role::Lines(kind) => LineSet::files(kind, 0, source),
        });
        self.push_sets()
    }

    fn push_sets(&mut self) -> Outcome<()> {
        let pushed = self.lines.push_lines(&mut self.builder);
        pushed.map_err(|error| self.explain(error))
    }

    /// Pushes the edges of the triangulation in a file of points that come next, as break lines.
    pub fn push_edges(&mut self, path: &Path) -> Outcome<()> {
        let (edges, _) = SegmentSource::open_edges(path, None)?;
        self.stop.watch(edges.reading());
        self.lines.add(LineSet::edges(self.records, edges));
        self.push_sets()
    }

    /// Pushes the sites of a file.
    pub fn push_site_file(&mut self, path: PathBuf, id_field: Option<&str>) -> Outcome<()> {
        let mut source = SiteSource::open(&[path], id_field)?;
        self.stop.watch(source.reading());
        let mut batch = SiteBatch::default();
        while source.next_batch(&mut batch)? {
            self.push_sites(&batch)?;
        }
        self.take_systems(source.crs_of_files())?;
        self.notes.extend_from_slice(source.notes());
        Ok(())
    }

    /// Pushes a batch of sites.
    pub fn push_sites(&mut self, batch: &SiteBatch) -> Outcome<()> {
        self.sites += batch.len() as u64;
        Ok(self.builder.push_sites(batch)?)
    }

    /// Pushes a batch of points, whose records are numbered after all others.
    pub async fn push_points(&mut self, batch: &PointBatch) -> Outcome<()> {
        self.records += batch.len() as u64;
        self.extents.add_points(&batch.points);
        Ok(self.builder.push(batch).await?)
    }

    /// Notes an input of points that is no file, and has `records` records.
    pub fn note_source(&mut self, name: &str, records: u64) {
        let first = self.records - records;
        let name = name.to_owned();
        self.sources.push(Source { name, records, first });
    }

    /// Pushes the segments of a file of points and segments, whose points come next.
    pub fn push_segments_of(&mut self, path: &Path) -> Outcome<()> {
        let poly = PolySource::open(path)?;
        self.stop.watch(poly.reading());
        self.lines.add(LineSet::poly(path, self.records, poly));
        self.push_sets()
    }

    /// Pushes the points of files. `are_all` tells whether no other points come.
    pub async fn push_point_files(&mut self, source: PointSource, are_all: bool) -> Outcome<()> {
        self.take_systems(source.crs_of_files())?;
        self.stop.watch(source.reading());
        let first = self.records;
        let (builder, extents) = (&mut self.builder, &mut self.extents);
        let read = push_points(source, builder, first, are_all, extents, &self.stop.cancelled).await;
        let source = read.map_err(|error| self.explain(error))?;
        for (name, records) in source.sources() {
            self.records += records;
            self.note_source(name, *records);
        }
        self.notes.extend_from_slice(source.notes());
        self.take_systems(source.crs_of_files())
    }

    /// Takes the points that tasks distributed.
    pub fn take_inputs(mut self) -> Outcome<Self> {
        let taken = reading::take(self.builder, &self.stop.is_set);
        let (builder, read, corners) = taken.map_err(Failure::of_build)?;
        self.builder = builder;
        self.extents.add_points(&corners);
        for (name, records) in &read.sources {
            self.records += records;
            self.note_source(name, *records);
        }
        self.notes.extend(read.notes);
        self.take_systems(&read.crs)?;
        Ok(self)
    }

    /// Builds the file. Returns the summary, and notes for the user.
    pub async fn finish(mut self) -> Outcome<(BuildSummary, Vec<String>)> {
        self.describe_if_read()?;
        let Self {
            builder, lines, notes, ..
        } = self;
        let built = builder.finish().await;
        let summary = built.map_err(|error| Failure::of_build(lines.name_in(error.into())))?;
        let notes = all_notes(notes, &lines, &summary);
        Ok((summary, notes))
    }

    /// Leaves the blocks to tasks, or builds the file if all points are in memory. Returns notes for the
    /// user too.
    pub async fn plan(mut self) -> Outcome<(Planned, Vec<String>)> {
        self.describe_if_read()?;
        let Self {
            builder, lines, notes, ..
        } = self;
        let planned = builder.plan_tasks().await;
        let planned = planned.map_err(|error| Failure::of_build(lines.name_in(error.into())))?;
        let notes = match &planned {
            Planned::Built(summary) => all_notes(notes, &lines, summary),
            _ => notes,
        };
        Ok((planned, notes))
    }

    fn describe_if_read(&mut self) -> Outcome<()> {
        match self.builder.needs_points() {
            true => self.describe(),
            false => Ok(()),
        }
    }

    fn describe(&mut self) -> Outcome<()> {
        let systems: Vec<_> = self.lines.crs_of_files().cloned().collect();
        self.take_systems(&systems)?;
        let of_lines = self.lines.sources();
        let mut extents = self.lines.extents().clone();
        extents.add_all(&self.extents);
        let names = self.sources.iter().map(|source| &*source.name);
        let names = names.chain(of_lines.iter().map(|lines| &*lines.name));
        let crs = self
            .agreement
            .crs()
            .cloned()
            .or_else(|| extents.of_plain_geojson(names));
        self.notes.extend(extents.notes());
        self.builder.describe(Description {
            sources: std::mem::take(&mut self.sources),
            lines: of_lines,
            crs: crs.as_ref().map(Crs::text).map(str::to_owned),
            memo: String::new(),
        });
        Ok(())
    }

    /// Names the lines in an error by their input.
    fn explain(&self, error: tiletool::Error) -> Failure {
        Failure::of_build(self.lines.name_in(error))
    }
}

/// Adds the notes on lines, and those that follow from the summary.
fn all_notes(mut notes: Vec<String>, lines: &LineInput, summary: &BuildSummary) -> Vec<String> {
    notes.extend(lines.notes());
    if let Some(first) = summary.first_inverted {
        notes.push(lines.inverted_note(summary.inverted_parts, first));
    }
    notes
}
