//! The input of a build, read again and compared with the file: points, lines, sites.
//!
//! Points, ends of segments, points where these cross and sites are vertices, and numbered as in the build, in this order. Segments
//! between records get their ends from the points, which are read again for each part of them that fits in memory.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::{InputOptions, PointBatch, PointSource, SegmentBatch, SiteBatch};
use delaunay_tiles::store::{EdgeSource, LineBatch, LineKind, LineSource, Metadata, TileReader};
use delaunay_tiles::{LinesToSplit, PolygonCheck, SplitLines};

use crate::common;
use crate::lines::{LineArgs, Lines};
use crate::unchanged::Unchanged;

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
    /// The files that lines were added from, by the directory.
    pub added: Vec<LineSource>,
    /// Bytes for segments between records, if there are any, and for a polygon that is checked.
    pub memory: u64,
    /// Bytes for segments that are to be split.
    pub split_memory: u64,
    /// All these files, which are read several times.
    pub files: Unchanged,
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

    /// Compares a file, whose lines were split or not, with all of it: what says most of what is wrong comes first.
    pub async fn compare(&self, reader: &TileReader, is_split: bool) -> anyhow::Result<Compared> {
        self.check_completeness(reader)?;
        let split = match is_split {
            true => Some(self.split(&reader.directory().metadata)?),
            false => None,
        };
        let (mut segments, mut sites) = (None, None);
        if self.has_lines() {
            segments = Some(self.compare_lines(reader, split.as_ref()).await?);
            sites = Some(self.compare_sites(reader).await?);
        }
        let mut places = self.places(split.as_ref())?;
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

    /// Opens the files of lines and sites, which must be what they were before.
    fn open_lines(&self) -> anyhow::Result<Lines> {
        let lines = self.lines.open_as_added(self.inputs, &self.added)?;
        self.files.check(lines.stamps())?;
        Ok(lines)
    }

    /// The same with the files of points.
    fn open_points(&self) -> anyhow::Result<PointSource> {
        let points = PointSource::open(self.inputs, &self.options)?;
        self.files.check(points.stamps())?;
        Ok(points)
    }

    /// Whether lines of a file were split, or polygons put right, which only a build that splits lines does.
    pub fn is_split(&self, reader: &TileReader) -> anyhow::Result<bool> {
        let metadata = &reader.directory().metadata;
        Ok(!self.is_empty() && (metadata.crossings > 0 || !metadata.borders.is_empty() || self.any_inverted()?))
    }

    /// Whether any polygon is inside out.
    fn any_inverted(&self) -> anyhow::Result<bool> {
        let mut check = PolygonCheck::new(&std::env::temp_dir(), self.memory);
        let (mut lines, mut batch) = (self.open_lines()?, SegmentBatch::default());
        while let Some((kind, first)) = lines.next_batch(&mut batch)? {
            if kind == LineKind::Obstacle {
                check.push(first, &batch)?;
            }
        }
        let faults = check.finish()?;
        Ok(faults.inverted.is_some() || faults.inverted_if_uncrossed.is_some())
    }

    /// All segments, in order.
    fn segments(&self) -> anyhow::Result<Segments<'_>> {
        let has_pairs = self.lines.has_pairs(self.inputs);
        if has_pairs && self.inputs.iter().any(|path| path == Path::new("-")) {
            bail!("points that segments name by their numbers are read more than once; name a file instead of -");
        }
        let room = if has_pairs { self.memory / SEGMENT_BYTES } else { 0 };
        Ok(Segments {
            against: self,
            lines: self.open_lines()?,
            last_edit: u32::MAX,
            read: SegmentBatch::default(),
            ready: LineBatch::default(),
            z: Vec::new(),
            polygons: Vec::new(),
            given: 0,
            sought: Vec::new(),
            room: room.min(1 << 30) as usize,
        })
    }

    /// Splits the segments where they cross each other and borders, as the build did.
    fn split(&self, metadata: &Metadata) -> anyhow::Result<SplitLines> {
        let crossings = metadata.crossings;
        let (mut segments, mut batch) = (self.segments()?, LineBatch::default());
        segments.last_edit = 0;
        let mut lines = LinesToSplit::new(self.split_memory).at_borders(&metadata.borders);
        while let Some((z, polygons)) = segments.next_with_z(&mut batch)? {
            lines.push(&batch, z, polygons)?;
        }
        let split = lines.split(|within, take| self.points_within(within, take))?;
        if split.crossings() != crossings {
            bail!(
                "{} pairs of its lines crossed, and {} of these do: they are not those that it was built from",
                common::thousands(crossings),
                common::thousands(split.crossings())
            );
        }
        Ok(split)
    }

    /// Gives the points, ends of lines and sites within a rectangle.
    fn points_within(&self, within: Rect, take: &mut dyn FnMut(&[Point])) -> anyhow::Result<()> {
        if self.inputs.iter().any(|path| path == Path::new("-")) {
            bail!("points that lines are split at are read more than once; name a file instead of -");
        }
        let (mut places, mut batch) = (self.places(None)?, PointBatch::default());
        places.last_edit = 0;
        while places.next_batch(&mut batch)? {
            batch.points.retain(|&point| within.contains(point));
            for point in &mut batch.points {
                *point = point.normalized();
            }
            take(&batch.points);
        }
        Ok(())
    }

    /// All that lies at vertices, crossing points if lines were split.
    fn places<'b>(&self, split: Option<&'b SplitLines>) -> anyhow::Result<Places<'b>> {
        Ok(Places {
            points: self.open_points()?,
            lines: self.open_lines()?,
            last_edit: u32::MAX,
            segments: SegmentBatch::default(),
            sites: SiteBatch::default(),
            split,
            crossing_points: None,
            next_record: 0,
        })
    }

    /// Compares the file with the segments, or with what they were split to.
    async fn compare_lines(&self, reader: &TileReader, split: Option<&SplitLines>) -> anyhow::Result<u64> {
        let mut segments = self.segments()?;
        let verified = match split {
            None => reader.verify_lines(|batch| segments.next_batch(batch)).await,
            Some(split) => {
                // Those of the build are read to count them, and for the names of their lines.
                segments.last_edit = 0;
                while segments.next_batch(&mut LineBatch::default())? {}
                segments.last_edit = u32::MAX;
                let mut pieces = split.pieces();
                // An edit does not split lines.
                let next = |batch: &mut LineBatch| match pieces.next() {
                    Some(pieces) => {
                        *batch = pieces;
                        Ok(true)
                    }
                    None => segments.next_batch(batch),
                };
                reader.verify_lines(next).await
            }
        };
        let lines = segments.lines;
        verified.map_err(|error| lines.name_in(error.into()))?;
        if reader.directory().metadata.seeds != lines.seeds() {
            bail!("its hole points are not those of the .poly files");
        }
        Ok(lines.segments())
    }

    async fn compare_sites(&self, reader: &TileReader) -> anyhow::Result<u64> {
        let mut lines = self.open_lines()?;
        Ok(reader.verify_sites(|batch| lines.next_sites(batch)).await?.sites)
    }
}

/// Of the memory of a verification, in bytes, the part for lines that are split again: half, or what the build may have had for as many.
pub fn split_memory(metadata: &Metadata, memory: u64) -> u64 {
    /// Bytes of a segment, and of a crossing, while segments are split.
    const BYTES: u64 = 300;
    // Each segment is an edge at least.
    let most = metadata.constraint_edges.saturating_add(metadata.crossings);
    most.saturating_mul(BYTES).clamp(memory / 2, memory / 4 * 3)
}

/// All that lies at vertices, numbered one behind the other: points, ends of the build's segments, points where these cross, sites,
/// and ends of the segments of each edit.
struct Places<'a> {
    points: PointSource,
    lines: Lines,
    /// The last edit whose lines belong to them.
    last_edit: u32,
    segments: SegmentBatch,
    sites: SiteBatch,
    split: Option<&'a SplitLines>,
    /// The points where segments cross, once it is their turn.
    crossing_points: Option<Box<dyn Iterator<Item = PointBatch> + 'a>>,
    /// One more than the largest number so far.
    next_record: u64,
}

impl Places<'_> {
    fn next_batch(&mut self, batch: &mut PointBatch) -> anyhow::Result<bool> {
        if self.points.next_batch(batch)? {
            self.next_record = batch.records.last().map_or(0, |last| last + 1);
            return Ok(true);
        }
        batch.clear();
        while batch.is_empty() {
            if self.lines.next_batch_until(0, &mut self.segments)?.is_some() {
                self.take_ends(batch);
            } else if let Some(points) = self.next_crossing_points() {
                *batch = points;
            } else if self.lines.next_sites(&mut self.sites)? {
                batch.points.extend_from_slice(&self.sites.points);
                batch.z.extend_from_slice(&self.sites.z);
            } else if self
                .lines
                .next_batch_until(self.last_edit, &mut self.segments)?
                .is_some()
            {
                self.take_ends(batch);
            } else {
                return Ok(false);
            }
        }
        let next = self.next_record + batch.points.len() as u64;
        batch.records.clear();
        batch.records.extend(self.next_record..next);
        self.next_record = next;
        Ok(true)
    }

    fn take_ends(&self, batch: &mut PointBatch) {
        batch.points.extend_from_slice(self.segments.ends.as_flattened());
        batch.z.extend_from_slice(self.segments.z.as_flattened());
    }

    fn next_crossing_points(&mut self) -> Option<PointBatch> {
        if let Some(split) = self.split.take() {
            self.crossing_points = Some(Box::new(split.points(self.next_record)));
        }
        self.crossing_points.as_mut()?.next()
    }
}

/// z at the ends of segments, and their polygons.
type WithZ<'a> = (&'a [[f64; 2]], &'a [u64]);

/// All segments by their ends, in order.
struct Segments<'a> {
    against: &'a Against<'a>,
    lines: Lines,
    /// The last edit whose segments are handed out.
    last_edit: u32,
    /// What was read last.
    read: SegmentBatch,
    /// Segments that are handed out next, of which so many were; and z at their ends, or NaN.
    ready: LineBatch,
    z: Vec<[f64; 2]>,
    /// The polygons of those that are of obstacles.
    polygons: Vec<u64>,
    given: usize,
    /// Records whose places are ends of these: twice the segment's place among them, and one more for its second end.
    sought: Vec<(u64, u32)>,
    /// About how many of them wait for points.
    room: usize,
}

impl Segments<'_> {
    fn next_batch(&mut self, batch: &mut LineBatch) -> anyhow::Result<bool> {
        Ok(self.next_with_z(batch)?.is_some())
    }

    /// The same, with z at the ends, and the polygon of each.
    fn next_with_z(&mut self, batch: &mut LineBatch) -> anyhow::Result<Option<WithZ<'_>>> {
        batch.clear();
        if self.given == self.ready.ends.len() {
            self.ready.clear();
            self.z.clear();
            self.polygons.clear();
            self.given = 0;
            self.fill()?;
        }
        let end = self.ready.ends.len().min(self.given + BATCH);
        batch.ends.extend_from_slice(&self.ready.ends[self.given..end]);
        batch.sources.extend_from_slice(&self.ready.sources[self.given..end]);
        let given = self.given..end;
        self.given = end;
        Ok((!batch.ends.is_empty()).then_some((&self.z[given.clone()], &self.polygons[given])))
    }

    /// Reads segments: a few, or as many as there is room for if points are to be read for them.
    fn fill(&mut self) -> anyhow::Result<()> {
        while let Some((kind, first)) = self.lines.next_batch_until(self.last_edit, &mut self.read)? {
            let SegmentBatch {
                ends,
                z,
                records,
                lines,
                polygons,
            } = &self.read;
            if !records.is_empty() && self.sought.is_empty() {
                let more = (self.room + BATCH).saturating_sub(self.ready.ends.len());
                self.ready.ends.reserve_exact(more);
                self.ready.sources.reserve_exact(more);
                self.sought.reserve_exact(2 * (self.room + BATCH));
            }
            let sources = lines.iter().map(|line| EdgeSource::new(kind, first + line));
            self.ready.sources.extend(sources);
            self.z.resize(self.ready.ends.len(), [f64::NAN; 2]);
            self.z.extend_from_slice(z);
            self.polygons.resize(self.ready.ends.len(), 0);
            self.polygons.extend_from_slice(polygons);
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
        self.z.resize(self.ready.ends.len(), [f64::NAN; 2]);
        self.polygons.resize(self.ready.ends.len(), 0);
        self.look_up()
    }

    /// Reads the points, and takes those whose records are sought.
    fn look_up(&mut self) -> anyhow::Result<()> {
        if self.sought.is_empty() {
            return Ok(());
        }
        self.sought.sort_unstable();
        let mut points = self.against.open_points()?;
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
