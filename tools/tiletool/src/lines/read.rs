//! Reads lines and sites, file by file, and tells which file and record each line comes from.

use std::path::{Path, PathBuf};

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{FileStamp, PolySource, Reading, SegmentBatch, SegmentSource, SiteBatch, SiteSource};
use delaunay_tiles::store::{LineKind, LineSource};
use delaunay_tiles::{Builder, Transaction, shown};

use crate::common;
use crate::crs::Extents;

/// Lines of one kind.
pub struct LineSet {
    kind: LineKind,
    /// The number of its first line, or `u64::MAX` before the set is read.
    first: u64,
    /// The number of the edit that added the lines, or 0 for the build.
    edit: u32,
    /// Whether the lines are shores of ponds.
    is_of_ponds: bool,
    /// What is added to the record numbers of the source: those of inputs before its points.
    records_before: u64,
    source: LineSetSource,
}

/// The files of a [`LineSet`].
enum LineSetSource {
    Files(SegmentSource),
    /// A `.poly` file: its path, the open source, and its number of segments once it is read.
    Poly(PathBuf, Option<PolySource>, u64),
}

/// Open files of lines and sites.
pub struct LineInput {
    sets: Vec<LineSet>,
    /// The number of sets that were read.
    done: usize,
    sites: SiteSource,
    /// The number of lines in the sets that were read.
    lines: u64,
    /// The hole points of the `.poly` files that were read.
    seeds: Vec<Point>,
    extents: Extents,
}

impl LineSet {
    /// Creates a set of lines of one kind. `edit` is the number of the edit that added them, or 0
    /// for the build.
    pub fn files(kind: LineKind, edit: u32, files: SegmentSource) -> Self {
        Self {
            kind,
            first: u64::MAX,
            edit,
            is_of_ponds: false,
            records_before: 0,
            source: LineSetSource::Files(files),
        }
    }

    /// Creates a set of the shores of ponds, as break lines.
    pub fn ponds(files: SegmentSource) -> Self {
        Self {
            is_of_ponds: true,
            ..Self::files(LineKind::BreakLine, 0, files)
        }
    }

    /// Creates a set of the edges of a file of points, as break lines. `records` is the number of
    /// records before its points.
    pub fn edges(records: u64, edges: SegmentSource) -> Self {
        Self {
            records_before: records,
            ..Self::files(LineKind::BreakLine, 0, edges)
        }
    }

    /// Creates a set of the segments of a `.poly` file. `records` is the number of records before
    /// its points.
    pub fn poly(path: &Path, records: u64, poly: PolySource) -> Self {
        Self {
            kind: LineKind::Wall,
            first: u64::MAX,
            edit: 0,
            is_of_ponds: false,
            records_before: records,
            source: LineSetSource::Poly(path.to_owned(), Some(poly), 0),
        }
    }
}

impl LineInput {
    /// Creates a reader of the lines of `sets`, in this order, and of sites.
    pub fn new(sets: Vec<LineSet>, sites: SiteSource) -> Self {
        Self {
            sets,
            done: 0,
            sites,
            lines: 0,
            seeds: Vec::new(),
            extents: Extents::default(),
        }
    }

    /// Adds lines after all others.
    pub fn add(&mut self, set: LineSet) {
        self.sets.push(set);
    }

    /// Fills the batch with the next segments. Returns their kind and the number of the first line
    /// of their set; `None` at the end.
    pub fn next_batch(&mut self, batch: &mut SegmentBatch) -> anyhow::Result<Option<(LineKind, u64)>> {
        self.next_batch_until(u32::MAX, batch)
    }

    /// Fills the batch like [`next_batch`](Self::next_batch), but only with lines of the build and
    /// of edits up to number `last_edit`.
    pub fn next_batch_until(
        &mut self,
        last_edit: u32,
        batch: &mut SegmentBatch,
    ) -> anyhow::Result<Option<(LineKind, u64)>> {
        while let Some(set) = self.sets.get_mut(self.done).filter(|set| set.edit <= last_edit) {
            set.first = self.lines;
            let records_before = set.records_before;
            match &mut set.source {
                LineSetSource::Files(files) => {
                    if files.next_batch(batch)? {
                        if let Some(origin) = batch.lines.first().and_then(|&line| files.origin(line)) {
                            self.extents.add(origin.path, batch.ends.iter().flatten().copied());
                        }
                        renumber(batch, records_before);
                        return Ok(Some((set.kind, set.first)));
                    }
                    self.lines += files.sources().iter().map(|(_, lines)| lines).sum::<u64>();
                }
                LineSetSource::Poly(_, poly, segments) => {
                    if let Some(poly) = poly
                        && poly.next_batch(batch)?
                    {
                        renumber(batch, records_before);
                        return Ok(Some((set.kind, set.first)));
                    }
                    if let Some(poly) = poly.take() {
                        *segments = poly.segments();
                        self.lines += *segments;
                        self.seeds.extend(poly.holes()?);
                    }
                }
            }
            self.done += 1;
        }
        batch.clear();
        Ok(None)
    }

    /// Returns whether the batch that was read last has shores of ponds.
    pub fn is_of_ponds(&self) -> bool {
        self.sets.get(self.done).is_some_and(|set| set.is_of_ponds)
    }

    /// Fills the batch with the next sites. Returns false if no sites are left.
    pub fn next_sites(&mut self, batch: &mut SiteBatch) -> anyhow::Result<bool> {
        Ok(self.sites.next_batch(batch)?)
    }

    /// Returns the extents of the files of lines that were read.
    pub fn extents(&self) -> &Extents {
        &self.extents
    }

    /// Returns the files that name a coordinate reference system, with that name.
    pub fn crs_of_files(&self) -> impl Iterator<Item = &(PathBuf, String)> {
        fn of_set(set: &LineSet) -> &[(PathBuf, String)] {
            match &set.source {
                LineSetSource::Files(files) => files.crs_of_files(),
                LineSetSource::Poly(..) => &[],
            }
        }
        self.sets.iter().flat_map(of_set).chain(self.sites.crs_of_files())
    }

    /// Returns the hole points. They are complete when all segments were read.
    pub fn seeds(&self) -> &[Point] {
        &self.seeds
    }

    /// Passes all lines and sites to a builder.
    pub fn feed(mut self, mut builder: Builder) -> anyhow::Result<(Builder, Self)> {
        self.push_lines(&mut builder)?;
        let mut sites = SiteBatch::default();
        while self.next_sites(&mut sites)? {
            builder.push_sites(&sites)?;
        }
        Ok((builder, self))
    }

    /// Passes the lines to a builder that were not read before, and the hole points among them.
    pub fn push_lines(&mut self, builder: &mut Builder) -> anyhow::Result<()> {
        let seeds = self.seeds.len();
        let mut batch = SegmentBatch::default();
        while let Some((kind, first)) = self.next_batch(&mut batch)? {
            match self.is_of_ponds() {
                true => builder.push_ponds(first, &batch)?,
                false => builder.push_lines(kind, first, &batch)?,
            }
        }
        Ok(builder.push_seeds(&self.seeds[seeds..])?)
    }

    /// Passes all lines to an transaction.
    pub fn feed_transaction(mut self, mut transaction: Transaction) -> anyhow::Result<(Transaction, Self)> {
        let mut batch = SegmentBatch::default();
        while let Some((kind, first)) = self.next_batch(&mut batch)? {
            transaction.constrain(kind, first, &batch)?;
        }
        transaction.add_sources(self.sources());
        Ok((transaction, self))
    }

    /// Passes all lines to an editor, to be removed.
    pub fn feed_removal(mut self, mut transaction: Transaction) -> anyhow::Result<(Transaction, Self)> {
        let mut batch = SegmentBatch::default();
        while let Some((kind, first)) = self.next_batch(&mut batch)? {
            transaction.unconstrain(kind, first, &batch)?;
        }
        Ok((transaction, self))
    }

    /// Returns the number of segments that were read.
    pub fn segments(&self) -> u64 {
        let of_set = |set: &LineSet| match &set.source {
            LineSetSource::Files(files) => files.segments(),
            LineSetSource::Poly(.., segments) => *segments,
        };
        self.sets.iter().map(of_set).sum()
    }

    /// Returns handles that tell the progress of reading each file, and can stop it.
    pub fn readings(&self) -> impl Iterator<Item = &Reading> {
        fn of_set(set: &LineSet) -> Option<&Reading> {
            match &set.source {
                LineSetSource::Files(files) => Some(files.reading()),
                LineSetSource::Poly(_, poly, _) => poly.as_ref().map(PolySource::reading),
            }
        }
        self.sets.iter().filter_map(of_set).chain([self.sites.reading()])
    }

    /// Returns the stamps of the regular files when they were opened. Must be called before the
    /// files are read.
    pub fn stamps(&self) -> impl Iterator<Item = &(PathBuf, FileStamp)> {
        fn of_set(set: &LineSet) -> &[(PathBuf, FileStamp)] {
            match &set.source {
                LineSetSource::Files(files) => files.stamps(),
                LineSetSource::Poly(_, poly, _) => poly.as_ref().map_or(&[], PolySource::stamps),
            }
        }
        self.sets.iter().flat_map(of_set).chain(self.sites.stamps())
    }

    /// Returns the bytes read from all files except those of points.
    pub fn bytes_read(&self) -> u64 {
        let of_set = |set: &LineSet| match &set.source {
            LineSetSource::Files(files) => files.bytes_read(),
            LineSetSource::Poly(..) => 0,
        };
        self.sets.iter().map(of_set).sum::<u64>() + self.sites.bytes_read()
    }

    /// Returns the list of files for the directory.
    pub fn sources(&self) -> Vec<LineSource> {
        let mut sources = Vec::new();
        for set in &self.sets {
            let mut first = set.first;
            let mut add = |name: String, lines: u64| {
                sources.push(LineSource {
                    name,
                    kind: set.kind,
                    first,
                    lines,
                    edit: set.edit,
                });
                first += lines;
            };
            match &set.source {
                LineSetSource::Files(files) => files
                    .sources()
                    .iter()
                    .for_each(|(name, lines)| add(name.clone(), *lines)),
                LineSetSource::Poly(path, _, segments) => add(common::file_name(path), *segments),
            }
        }
        sources
    }

    /// Returns notes for the user about the input.
    pub fn notes(&self) -> Vec<String> {
        let of_set = |set: &LineSet| match &set.source {
            LineSetSource::Files(files) => files.notes().to_vec(),
            LineSetSource::Poly(..) => Vec::new(),
        };
        let mut notes: Vec<String> = self.sets.iter().flat_map(of_set).collect();
        notes.extend_from_slice(self.sites.notes());
        notes
    }

    /// Returns the file and record that a line comes from.
    pub fn name(&self, line: u64) -> String {
        let set = self.sets.iter().rev().find(|set| set.first <= line);
        let name = set.and_then(|set| match &set.source {
            LineSetSource::Files(files) => files.origin(line - set.first).map(|origin| origin.to_string()),
            LineSetSource::Poly(path, ..) => Some(format!(
                "{}: segment {} (counted from 0)",
                common::shown(path),
                line - set.first
            )),
        });
        name.unwrap_or_else(|| format!("line {line}"))
    }

    /// Returns the file and record that a site comes from.
    pub fn site_name(&self, site: u64) -> String {
        let mut first = 0;
        for (name, sites) in self.sites.sources() {
            if site < first + sites {
                return format!("{}: site {} (counted from 0)", shown::text(name), site - first);
            }
            first += sites;
        }
        format!("site {site}")
    }
}

/// Adds the number of the records of inputs before to the record numbers of a batch.
fn renumber(batch: &mut SegmentBatch, records_before: u64) {
    for ends in &mut batch.records {
        // It overflows only where a file claims more points than it can have.
        *ends = ends.map(|record| record.saturating_add(records_before));
    }
}
