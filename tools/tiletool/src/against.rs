//! The input of a build, read again and compared with the file: points, lines, sites.
//!
//! Points, ends of segments and sites are vertices, and numbered as in the build: points first, then ends, then sites. Segments
//! between records get their ends from the points, which are read again for each part of them that fits in memory.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use delaunay_tiles::input::{InputOptions, PointBatch, PointSource, SegmentBatch, SiteBatch};
use delaunay_tiles::store::{EdgeSource, LineBatch, TileReader};

use crate::common;
use crate::lines::{LineArgs, Lines};

/// Segments in a batch.
const BATCH: usize = 8192;
/// Bytes that a segment takes while records of some are looked up: ends and source, and two records with their places.
const SEGMENT_BYTES: u64 = 40 + 2 * size_of::<(u64, u32)>() as u64;

/// What a file is compared with.
pub struct Against<'a> {
    /// Files of points.
    pub inputs: &'a [PathBuf],
    /// How to read these.
    pub options: InputOptions,
    /// Files of lines and sites.
    pub lines: &'a LineArgs,
    /// Bytes for segments between records, if there are any.
    pub memory: u64,
}

/// How much was compared; nothing if there are neither lines nor sites.
pub struct Compared {
    pub points: u64,
    pub segments: Option<u64>,
    pub sites: Option<u64>,
}

impl Against<'_> {
    /// Whether there is nothing to compare with.
    pub fn is_empty(&self) -> bool {
        self.inputs.is_empty() && !self.has_lines()
    }

    fn has_lines(&self) -> bool {
        !self.lines.is_empty(self.inputs)
    }

    /// Bytes of memory that it takes.
    pub fn byte_size(&self) -> u64 {
        match self.lines.has_pairs(self.inputs) {
            true => self.memory,
            false => 0,
        }
    }

    /// Compares a file with all of it: what says most of what is wrong comes first.
    pub async fn compare(&self, reader: &TileReader) -> anyhow::Result<Compared> {
        self.check_completeness(reader)?;
        let (mut segments, mut sites) = (None, None);
        if self.has_lines() {
            segments = Some(self.compare_lines(reader).await?);
            sites = Some(self.compare_sites(reader).await?);
        }
        let mut places = Places {
            points: PointSource::open(self.inputs, &self.options)?,
            lines: self.lines.open(self.inputs)?,
            segments: SegmentBatch::default(),
            sites: SiteBatch::default(),
            next_record: 0,
        };
        let report = reader.verify_points(|batch| places.next_batch(batch)).await?;
        Ok(Compared {
            points: report.vertices,
            segments,
            sites,
        })
    }

    /// Says what was forgotten, where the file tells that.
    fn check_completeness(&self, reader: &TileReader) -> anyhow::Result<()> {
        let metadata = &reader.directory().metadata;
        if metadata.crossings > 0 {
            let crossings = common::thousands(metadata.crossings);
            bail!(
                "{crossings} pairs of its lines crossed and were split, at vertices that are not of the input: such a file cannot be \
                 compared with its input as yet; --deep proves it without"
            );
        }
        if metadata.points > 0 && self.inputs.is_empty() {
            let points = common::thousands(metadata.points);
            bail!("it was built from {points} points too; name their files with --against");
        }
        if metadata.ends > 0 && !self.has_lines() {
            let ends = common::thousands(metadata.ends);
            bail!(
                "{ends} of its vertices are ends of lines, or sites; name these files too, with --segments, --walls, \
                 --obstacles and --sites"
            );
        }
        Ok(())
    }

    async fn compare_lines(&self, reader: &TileReader) -> anyhow::Result<u64> {
        let has_pairs = self.lines.has_pairs(self.inputs);
        if has_pairs && self.inputs.iter().any(|path| path == Path::new("-")) {
            bail!("points that segments name by their numbers are read more than once; name a file instead of -");
        }
        let room = if has_pairs { self.memory / SEGMENT_BYTES } else { 0 };
        let mut segments = Segments {
            against: self,
            lines: self.lines.open(self.inputs)?,
            read: SegmentBatch::default(),
            ready: LineBatch::default(),
            given: 0,
            sought: Vec::new(),
            room: room.min(1 << 30) as usize,
        };
        let verified = reader.verify_lines(|batch| segments.next_batch(batch)).await;
        let lines = segments.lines;
        let report = verified.map_err(|error| lines.name_in(error.into()))?;
        if reader.directory().metadata.seeds != lines.seeds() {
            bail!("its hole points are not those of the .poly files");
        }
        Ok(report.segments)
    }

    async fn compare_sites(&self, reader: &TileReader) -> anyhow::Result<u64> {
        let mut lines = self.lines.open(self.inputs)?;
        Ok(reader.verify_sites(|batch| lines.next_sites(batch)).await?.sites)
    }
}

/// All that lies at vertices: points, ends of segments, and sites, numbered one behind the other.
struct Places {
    points: PointSource,
    lines: Lines,
    segments: SegmentBatch,
    sites: SiteBatch,
    /// One more than the largest number so far.
    next_record: u64,
}

impl Places {
    fn next_batch(&mut self, batch: &mut PointBatch) -> anyhow::Result<bool> {
        if self.points.next_batch(batch)? {
            self.next_record = batch.records.last().map_or(0, |last| last + 1);
            return Ok(true);
        }
        batch.clear();
        while batch.is_empty() {
            if self.lines.next_batch(&mut self.segments)?.is_some() {
                batch.points.extend_from_slice(self.segments.ends.as_flattened());
                batch.z.extend_from_slice(self.segments.z.as_flattened());
            } else if self.lines.next_sites(&mut self.sites)? {
                batch.points.extend_from_slice(&self.sites.points);
                batch.z.extend_from_slice(&self.sites.z);
            } else {
                return Ok(false);
            }
        }
        let next = self.next_record + batch.points.len() as u64;
        batch.records.extend(self.next_record..next);
        self.next_record = next;
        Ok(true)
    }
}

/// All segments by their ends, in order.
struct Segments<'a> {
    against: &'a Against<'a>,
    lines: Lines,
    /// What was read last.
    read: SegmentBatch,
    /// Segments that are handed out next, of which so many were.
    ready: LineBatch,
    given: usize,
    /// Records whose places are ends of these: twice the segment's place among them, and one more for its second end.
    sought: Vec<(u64, u32)>,
    /// About how many of them wait for points.
    room: usize,
}

impl Segments<'_> {
    fn next_batch(&mut self, batch: &mut LineBatch) -> anyhow::Result<bool> {
        batch.clear();
        if self.given == self.ready.ends.len() {
            self.ready.clear();
            self.given = 0;
            self.fill()?;
        }
        let end = self.ready.ends.len().min(self.given + BATCH);
        batch.ends.extend_from_slice(&self.ready.ends[self.given..end]);
        batch.sources.extend_from_slice(&self.ready.sources[self.given..end]);
        self.given = end;
        Ok(!batch.ends.is_empty())
    }

    /// Reads segments: a few, or as many as there is room for if points are to be read for them.
    fn fill(&mut self) -> anyhow::Result<()> {
        while let Some((kind, first)) = self.lines.next_batch(&mut self.read)? {
            let SegmentBatch {
                ends, records, lines, ..
            } = &self.read;
            if !records.is_empty() && self.sought.is_empty() {
                let more = (self.room + BATCH).saturating_sub(self.ready.ends.len());
                self.ready.ends.reserve_exact(more);
                self.ready.sources.reserve_exact(more);
                self.sought.reserve_exact(2 * (self.room + BATCH));
            }
            let sources = lines.iter().map(|line| EdgeSource::new(kind, first + line));
            self.ready.sources.extend(sources);
            self.ready.ends.extend_from_slice(ends);
            for pair in records {
                let place = 2 * self.ready.ends.len() as u32;
                self.sought.extend(pair.iter().copied().zip(place..));
                self.ready.ends.push(Default::default());
            }
            if self.sought.is_empty() || self.ready.ends.len() >= self.room {
                break;
            }
        }
        self.look_up()
    }

    /// Reads the points, and takes those whose records are sought.
    fn look_up(&mut self) -> anyhow::Result<()> {
        if self.sought.is_empty() {
            return Ok(());
        }
        self.sought.sort_unstable();
        let mut points = PointSource::open(self.against.inputs, &self.against.options)?;
        let mut batch = PointBatch::default();
        let ends = self.ready.ends.as_flattened_mut();
        let mut sought = self.sought.iter().peekable();
        // Records ascend in both.
        while sought.peek().is_some() && points.next_batch(&mut batch)? {
            let last = batch.records.last().copied().unwrap_or(0);
            while let Some((record, end)) = sought.next_if(|(record, _)| *record <= last) {
                let found = batch.records.binary_search(record).ok();
                let found = found.with_context(|| missing(*record))?;
                ends[*end as usize] = batch.points[found];
            }
        }
        if let Some((record, _)) = sought.next() {
            bail!(missing(*record));
        }
        self.sought.clear();
        Ok(())
    }
}

fn missing(record: u64) -> String {
    format!("a segment ends at record {record}, and there is no point of this number")
}
