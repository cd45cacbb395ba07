//! Reading lines and sites, one file after the other, and where each comes from.

use std::path::{Path, PathBuf};

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{FileStamp, PolySource, Reading, SegmentBatch, SegmentSource, SiteBatch, SiteSource};
use delaunay_tiles::store::{LineKind, LineSource};
use delaunay_tiles::{Builder, Editor, shown};

use crate::common;

/// Lines of one kind.
pub struct Set {
    kind: LineKind,
    /// The number of its first line, once it is begun.
    first: u64,
    /// 0: the build. Else the number of the edit that added them.
    edit: u32,
    source: Source,
}

enum Source {
    Files(SegmentSource),
    /// Of this file; its points come behind so many records.
    Poly(PathBuf, u64, Option<PolySource>, u64),
}

/// Lines and sites, open.
pub struct Lines {
    sets: Vec<Set>,
    /// How many of them were read.
    done: usize,
    sites: SiteSource,
    /// Lines of all sets that were read.
    lines: u64,
    /// Points in holes.
    seeds: Vec<Point>,
}

impl Set {
    /// Lines of one kind that an edit added, or the build, which is 0.
    pub fn files(kind: LineKind, edit: u32, files: SegmentSource) -> Self {
        Self {
            kind,
            first: u64::MAX,
            edit,
            source: Source::Files(files),
        }
    }

    /// The segments of a .poly file, whose points come behind so many records.
    pub fn poly(path: &Path, records: u64, poly: PolySource) -> Self {
        Self {
            kind: LineKind::Wall,
            first: u64::MAX,
            edit: 0,
            source: Source::Poly(path.to_owned(), records, Some(poly), 0),
        }
    }
}

impl Lines {
    /// Lines in the order of these sets, and sites.
    pub fn new(sets: Vec<Set>, sites: SiteSource) -> Self {
        Self {
            sets,
            done: 0,
            sites,
            lines: 0,
            seeds: Vec::new(),
        }
    }

    /// Adds lines behind all others.
    pub fn add(&mut self, set: Set) {
        self.sets.push(set);
    }

    /// Fills the batch with the next segments. Returns their kind, and the number of the first line of these files.
    pub fn next_batch(&mut self, batch: &mut SegmentBatch) -> anyhow::Result<Option<(LineKind, u64)>> {
        self.next_batch_until(u32::MAX, batch)
    }

    /// The same, but only for lines of the build and of edits up to number `last_edit`.
    pub fn next_batch_until(
        &mut self,
        last_edit: u32,
        batch: &mut SegmentBatch,
    ) -> anyhow::Result<Option<(LineKind, u64)>> {
        while let Some(set) = self.sets.get_mut(self.done).filter(|set| set.edit <= last_edit) {
            set.first = self.lines;
            match &mut set.source {
                Source::Files(files) => {
                    if files.next_batch(batch)? {
                        return Ok(Some((set.kind, set.first)));
                    }
                    self.lines += files.sources().iter().map(|(_, lines)| lines).sum::<u64>();
                }
                Source::Poly(_, records, poly, segments) => {
                    if let Some(poly) = poly
                        && poly.next_batch(batch)?
                    {
                        for ends in &mut batch.records {
                            *ends = ends.map(|record| record + *records);
                        }
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

    /// Fills the batch with the next sites; false if there are none left.
    pub fn next_sites(&mut self, batch: &mut SiteBatch) -> anyhow::Result<bool> {
        Ok(self.sites.next_batch(batch)?)
    }

    /// Points in holes, once all segments were read.
    pub fn seeds(&self) -> &[Point] {
        &self.seeds
    }

    /// Gives all of them to a builder.
    pub fn feed(mut self, mut builder: Builder) -> anyhow::Result<(Builder, Self)> {
        let mut batch = SegmentBatch::default();
        while let Some((kind, first)) = self.next_batch(&mut batch)? {
            builder.push_lines(kind, first, &batch)?;
        }
        builder.push_seeds(&self.seeds)?;
        let mut sites = SiteBatch::default();
        while self.next_sites(&mut sites)? {
            builder.push_sites(&sites)?;
        }
        Ok((builder, self))
    }

    /// Gives all of them to an editor.
    pub fn feed_editor(mut self, mut editor: Editor) -> anyhow::Result<(Editor, Self)> {
        let mut batch = SegmentBatch::default();
        while let Some((kind, first)) = self.next_batch(&mut batch)? {
            editor.push(kind, first, &batch)?;
        }
        editor.add_sources(self.sources());
        Ok((editor, self))
    }

    /// Segments that were read.
    pub fn segments(&self) -> u64 {
        let of_set = |set: &Set| match &set.source {
            Source::Files(files) => files.segments(),
            Source::Poly(.., segments) => *segments,
        };
        self.sets.iter().map(of_set).sum()
    }

    /// How far the reading of the files is, and the way to stop it.
    pub fn readings(&self) -> impl Iterator<Item = &Reading> {
        fn of_set(set: &Set) -> Option<&Reading> {
            match &set.source {
                Source::Files(files) => Some(files.reading()),
                Source::Poly(_, _, poly, _) => poly.as_ref().map(PolySource::reading),
            }
        }
        self.sets.iter().filter_map(of_set).chain([self.sites.reading()])
    }

    /// The regular files, as they were when they were opened. To be asked before they are read.
    pub fn stamps(&self) -> impl Iterator<Item = &(PathBuf, FileStamp)> {
        fn of_set(set: &Set) -> &[(PathBuf, FileStamp)] {
            match &set.source {
                Source::Files(files) => files.stamps(),
                Source::Poly(_, _, poly, _) => poly.as_ref().map_or(&[], PolySource::stamps),
            }
        }
        self.sets.iter().flat_map(of_set).chain(self.sites.stamps())
    }

    /// Bytes read of all files but those of points.
    pub fn bytes_read(&self) -> u64 {
        let of_set = |set: &Set| match &set.source {
            Source::Files(files) => files.bytes_read(),
            Source::Poly(..) => 0,
        };
        self.sets.iter().map(of_set).sum::<u64>() + self.sites.bytes_read()
    }

    /// The files, for the directory.
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
                Source::Files(files) => files
                    .sources()
                    .iter()
                    .for_each(|(name, lines)| add(name.clone(), *lines)),
                Source::Poly(path, _, _, segments) => add(common::file_name(path), *segments),
            }
        }
        sources
    }

    /// What a person should know.
    pub fn notes(&self) -> Vec<String> {
        let of_set = |set: &Set| match &set.source {
            Source::Files(files) => files.notes().to_vec(),
            Source::Poly(..) => Vec::new(),
        };
        let mut notes: Vec<String> = self.sets.iter().flat_map(of_set).collect();
        notes.extend_from_slice(self.sites.notes());
        notes
    }

    /// Where a line comes from.
    pub fn name(&self, line: u64) -> String {
        let set = self.sets.iter().rev().find(|set| set.first <= line);
        let name = set.and_then(|set| match &set.source {
            Source::Files(files) => files.origin(line - set.first).map(|origin| origin.to_string()),
            Source::Poly(path, ..) => Some(format!(
                "{}: segment {} (counted from 0)",
                common::shown(path),
                line - set.first
            )),
        });
        name.unwrap_or_else(|| format!("line {line}"))
    }

    /// Where a site comes from.
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
