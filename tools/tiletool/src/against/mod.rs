//! The input of a build, read again and compared with the file: points, lines, sites.
//!
//! Points, ends of segments, points where segments cross, and sites are vertices. They are numbered
//! as in the build, in this order. Segments between record numbers get their end points from the
//! points. The points are read again for each part of these segments that fits in memory.

mod ponds;
mod vertex_points;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::{InputOptions, PointBatch, PointSource, SegmentBatch};
use delaunay_tiles::store::{EdgeSource, LineBatch, LineKind, LinePart, LineSource, Lists, Metadata, TileReader};
use delaunay_tiles::{LinesToSplit, PolygonCheck, PolygonFaults, PolygonNormalizer, SplitLines};

use crate::common;
use crate::lines::{LineArgs, LineInput};
use crate::unchanged::Unchanged;
pub use ponds::BuildPonds;
use vertex_points::VertexPoints;

/// Maximum number of segments in a batch.
const BATCH: usize = 8192;
/// Bytes of a segment while records are looked up: its ends and source, and two records with the
/// indices of their ends.
const SEGMENT_BYTES: u64 = 40 + 2 * size_of::<(u64, u32)>() as u64;

/// The input of a build, which a tile file is compared with.
pub struct BuildInput<'a> {
    /// Files of points.
    pub inputs: &'a [PathBuf],
    /// Options for reading these files.
    pub options: InputOptions,
    /// Files of lines and sites.
    pub lines: &'a LineArgs,
    /// The sources of lines that the tile file's directory lists.
    pub added: Vec<LineSource>,
    /// Bytes for segments between record numbers, if there are any, and for checking a polygon.
    pub memory: u64,
    /// Bytes for splitting segments.
    pub split_memory: u64,
    /// The ponds, with the z that the tile file has at their shores.
    pub ponds: Option<BuildPonds>,
    /// The stamps of all these files, which are read several times.
    pub files: Unchanged,
}

/// The numbers of compared points, segments and sites. Segments and sites are `None` if the input
/// has neither lines nor sites.
pub struct ComparedCounts {
    pub points: u64,
    pub segments: Option<u64>,
    pub sites: Option<u64>,
}

impl BuildInput<'_> {
    /// Returns whether there is no input to compare with.
    pub fn is_empty(&self) -> bool {
        self.inputs.is_empty() && !self.has_lines()
    }

    fn has_lines(&self) -> bool {
        !self.lines.is_empty(self.inputs)
    }

    /// Returns the bytes of memory for looking up records; 0 if no segments refer to record
    /// numbers.
    pub fn byte_size(&self) -> u64 {
        match self.lines.has_pairs(self.inputs) {
            true => self.memory,
            false => 0,
        }
    }

    /// Compares a tile file with all of the input. `is_split` says whether the build split lines.
    /// Lines and sites are compared before points, because their errors are the most specific.
    ///
    /// # Errors
    /// Fails at the first difference.
    pub async fn compare(&self, reader: &TileReader, is_split: bool) -> anyhow::Result<ComparedCounts> {
        self.check_completeness(reader)?;
        let split = match is_split {
            true => Some(self.split(reader.metadata(), &*reader.lists().await?)?),
            false => None,
        };
        let (mut segments, mut sites) = (None, None);
        if self.has_lines() {
            segments = Some(self.compare_lines(reader, split.as_ref()).await?);
            sites = Some(self.compare_sites(reader).await?);
        }
        let mut vertex_points = self.vertex_points(split.as_ref())?;
        let report = reader.verify_points(|batch| vertex_points.next_batch(batch)).await?;
        Ok(ComparedCounts {
            points: report.vertices,
            segments,
            sites,
        })
    }

    /// Fails if the tile file shows that files of points, lines or sites are missing from the
    /// command line.
    fn check_completeness(&self, reader: &TileReader) -> anyhow::Result<()> {
        let metadata = reader.metadata();
        if metadata.points > 0 && self.inputs.is_empty() {
            let points = common::counted(metadata.points, "point", "points");
            bail!("the file was also built from {points}; name the files of points with --against");
        }
        if metadata.ends > 0 && !self.has_lines() {
            let ends = common::thousands(metadata.ends);
            bail!(
                "the file has vertices from lines or sites ({ends}); name the files of these too, with --segments, \
                 --walls, --obstacles and --sites"
            );
        }
        Ok(())
    }

    /// Opens the files of lines and sites.
    ///
    /// # Errors
    /// Fails if a file changed since it was first opened.
    fn open_lines(&self) -> anyhow::Result<LineInput> {
        let lines = self.lines.open_as_added(self.inputs, &self.added)?;
        self.files.check(lines.stamps())?;
        Ok(lines)
    }

    /// Opens the files of points.
    ///
    /// # Errors
    /// Fails if a file changed since it was first opened.
    fn open_points(&self) -> anyhow::Result<PointSource> {
        let points = PointSource::open(self.inputs, &self.options)?;
        self.files.check(points.stamps())?;
        Ok(points)
    }

    /// Finds the ponds. Returns the bytes of memory that they take.
    pub async fn find_ponds(&mut self, reader: &TileReader) -> anyhow::Result<u64> {
        if self.lines.has_ponds() {
            self.ponds = BuildPonds::of(self.open_lines()?, reader).await?;
        }
        Ok(self.ponds.as_ref().map_or(0, BuildPonds::byte_size))
    }

    /// Returns whether the build split lines or corrected polygons. Only a build that splits lines
    /// does so.
    pub async fn is_split(&self, reader: &TileReader) -> anyhow::Result<bool> {
        let (metadata, lists) = (reader.metadata(), reader.lists().await?);
        Ok(!self.is_empty() && (metadata.crossings > 0 || !lists.cell_borders.is_empty() || self.any_inverted()?))
    }

    /// Returns whether any polygon is inside out.
    fn any_inverted(&self) -> anyhow::Result<bool> {
        let (faults, _) = self.check_polygons(false)?;
        Ok(faults.inverted.is_some() || faults.inverted_if_uncrossed.is_some())
    }

    /// Checks all polygons, or those of edits only. Returns their faults, and the normaliser of the
    /// obstacles that overlap themselves, if there are any.
    fn check_polygons(&self, of_edits: bool) -> anyhow::Result<(PolygonFaults, Option<PolygonNormalizer>)> {
        let mut check = PolygonCheck::new(&std::env::temp_dir(), self.memory);
        let (mut lines, mut batch) = (self.open_lines()?, SegmentBatch::default());
        if of_edits {
            while lines.next_batch_until(0, &mut batch)?.is_some() {}
        }
        let mut set = None;
        while let Some((kind, first)) = lines.next_batch(&mut batch)? {
            if kind == LineKind::Obstacle {
                // Each set numbers its polygons from 0 on.
                if set.replace(first).is_some_and(|before| before != first) {
                    check.finish()?;
                }
                check.push(first, &batch)?;
            }
        }
        Ok((check.finish()?, check.normalizer()))
    }

    /// Returns a reader of all segments, in order.
    fn segments(&self) -> anyhow::Result<InputSegments<'_>> {
        let has_pairs = self.lines.has_pairs(self.inputs);
        if has_pairs && self.inputs.iter().any(|path| path == Path::new("-")) {
            bail!(
                "segments refer to points by record number, so the points are read more than once; name a file instead of -"
            );
        }
        let capacity = if has_pairs { self.memory / SEGMENT_BYTES } else { 0 };
        Ok(InputSegments {
            input: self,
            lines: self.open_lines()?,
            last_edit: u32::MAX,
            read: SegmentBatch::default(),
            ready: LineBatch::default(),
            z: Vec::new(),
            polygons: Vec::new(),
            returned: 0,
            wanted: Vec::new(),
            capacity: capacity.min(1 << 30) as usize,
            shores: self.ponds.as_ref().map_or(&[], BuildPonds::z_of_edges),
        })
    }

    /// Splits the segments where they cross each other and cell borders, as the build did.
    fn split(&self, metadata: &Metadata, lists: &Lists) -> anyhow::Result<SplitLines> {
        let crossings = metadata.crossings;
        let (mut segments, mut batch) = (self.segments()?, LineBatch::default());
        segments.last_edit = 0;
        let mut lines = LinesToSplit::new(self.split_memory).at_borders(&lists.cell_borders);
        while let Some((z, polygons)) = segments.next_with_z(&mut batch)? {
            lines.push(&batch, z, polygons)?;
        }
        let split = lines.split(|within, take| self.points_within(within, take))?;
        if split.crossings() != crossings {
            bail!(
                "the build split {}, but the given lines have {}; name the lines of the build",
                common::counted(crossings, "crossing", "crossings"),
                common::thousands(split.crossings())
            );
        }
        Ok(split)
    }

    /// Passes the points, ends of lines and sites within a rectangle to `take`.
    fn points_within(&self, within: Rect, take: &mut dyn FnMut(&[Point])) -> anyhow::Result<()> {
        if self.inputs.iter().any(|path| path == Path::new("-")) {
            bail!("lines are split at points, so the points are read more than once; name a file instead of -");
        }
        let (mut vertex_points, mut batch) = (self.vertex_points(None)?.of_build(), PointBatch::default());
        while vertex_points.next_batch(&mut batch)?.is_some() {
            batch.points.retain(|&point| within.contains(point));
            for point in &mut batch.points {
                *point = point.normalized();
            }
            take(&batch.points);
        }
        Ok(())
    }

    /// Returns a reader of all points that are vertices, with the crossing points if lines were
    /// split.
    fn vertex_points<'b>(&'b self, split: Option<&'b SplitLines>) -> anyhow::Result<VertexPoints<'b>> {
        let (points, lines) = (self.open_points()?, self.open_lines()?);
        Ok(VertexPoints::new(points, lines, split, self.ponds.as_ref()))
    }

    /// Compares the file with the segments, or with the subsegments that they were split into.
    /// Returns the number of segments.
    async fn compare_lines(&self, reader: &TileReader, split: Option<&SplitLines>) -> anyhow::Result<u64> {
        let mut segments = self.segments()?;
        // Splitting normalises the obstacles of the build.
        let (_, mut normalizer) = self.check_polygons(split.is_some())?;
        let mut normalized = |segments: &mut InputSegments<'_>, batch: &mut LineBatch| {
            let is_there = segments.next_batch(batch)?;
            if let Some(normalizer) = &mut normalizer {
                normalizer.normalize(batch);
            }
            anyhow::Ok(is_there)
        };
        let verified = match split {
            None => reader.verify_lines(|batch| normalized(&mut segments, batch)).await,
            Some(split) => {
                // The segments of the build are read only to count them and for the names of their
                // lines.
                segments.last_edit = 0;
                while segments.next_batch(&mut LineBatch::default())? {}
                segments.last_edit = u32::MAX;
                let mut subsegments = split.subsegments();
                // Lines of edits are not split.
                let next = |batch: &mut LineBatch| match subsegments.next() {
                    Some(next) => {
                        *batch = next;
                        Ok(true)
                    }
                    None => normalized(&mut segments, batch),
                };
                reader.verify_lines(next).await
            }
        };
        let lines = segments.lines;
        verified.map_err(|error| match reader.metadata().line_removals {
            0 => lines.name_in(error.into()),
            // Lines of the file have other numbers than those given.
            _ => error.into(),
        })?;
        if reader.lists().await?.hole_points != lines.seeds() {
            bail!("the hole points of the file are not those of the .poly files");
        }
        Ok(lines.segments())
    }

    async fn compare_sites(&self, reader: &TileReader) -> anyhow::Result<u64> {
        let mut lines = self.open_lines()?;
        Ok(reader.verify_sites(|batch| lines.next_sites(batch)).await?.sites)
    }
}

/// Returns the part of a verification's `memory`, in bytes, for splitting lines again: half, or up
/// to three quarters if the file has so many constraint edges and crossings that the build may have
/// needed more.
pub fn split_memory(metadata: &Metadata, memory: u64) -> u64 {
    /// Bytes per segment, and per crossing, while segments are split.
    const BYTES: u64 = 300;
    // Each segment has at least one edge.
    let most = metadata.constraint_edges.saturating_add(metadata.crossings);
    most.saturating_mul(BYTES).clamp(memory / 2, memory / 4 * 3)
}

/// The z at both ends of each segment, and the polygon of each segment.
type ZAndPolygons<'a> = (&'a [[f64; 2]], &'a [u64]);

/// A reader of all segments with their end points, in order.
struct InputSegments<'a> {
    input: &'a BuildInput<'a>,
    lines: LineInput,
    /// Number of the last edit whose segments are returned.
    last_edit: u32,
    /// The batch that was read last.
    read: SegmentBatch,
    /// The segments to return next; the first `returned` of them were returned already.
    ready: LineBatch,
    /// The z at the ends of `ready`, or NaN.
    z: Vec<[f64; 2]>,
    /// The polygons of `ready` for segments of obstacles.
    polygons: Vec<u64>,
    /// The number of segments of `ready` that were returned.
    returned: usize,
    /// The record numbers to look up, each with the index of its end in `ready`: twice the index of
    /// the segment, plus 1 for its second end.
    wanted: Vec<(u64, u32)>,
    /// Approximate maximum number of segments in `ready` that wait for points.
    capacity: usize,
    /// The z at the ends of the edges of shores that were not read yet.
    shores: &'a [[f64; 2]],
}

impl InputSegments<'_> {
    fn next_batch(&mut self, batch: &mut LineBatch) -> anyhow::Result<bool> {
        Ok(self.next_with_z(batch)?.is_some())
    }

    /// Fills the batch with the next segments. Returns the z of their ends and the polygon of each;
    /// `None` at the end.
    fn next_with_z(&mut self, batch: &mut LineBatch) -> anyhow::Result<Option<ZAndPolygons<'_>>> {
        batch.clear();
        if self.returned == self.ready.ends.len() {
            self.ready.clear();
            self.z.clear();
            self.polygons.clear();
            self.returned = 0;
            self.fill()?;
        }
        let end = self.ready.ends.len().min(self.returned + BATCH);
        batch.ends.extend_from_slice(&self.ready.ends[self.returned..end]);
        batch.sources.extend_from_slice(&self.ready.sources[self.returned..end]);
        let returned = self.returned..end;
        self.returned = end;
        Ok((!batch.ends.is_empty()).then_some((&self.z[returned.clone()], &self.polygons[returned])))
    }

    /// Reads segments into `ready`: one batch, or up to `capacity` segments if points must be read
    /// for them.
    fn fill(&mut self) -> anyhow::Result<()> {
        while let Some((kind, first)) = self.lines.next_batch_until(self.last_edit, &mut self.read)? {
            let SegmentBatch {
                ends,
                z,
                records,
                lines,
                polygons,
            } = &self.read;
            if !records.is_empty() && self.wanted.is_empty() {
                let more = (self.capacity + BATCH).saturating_sub(self.ready.ends.len());
                self.ready.ends.reserve_exact(more);
                self.ready.sources.reserve_exact(more);
                self.wanted.reserve_exact(2 * (self.capacity + BATCH));
            }
            let sources = lines
                .iter()
                .map(|line| LinePart::whole(EdgeSource::new(kind, first + line)));
            self.ready.sources.extend(sources);
            self.z.resize(self.ready.ends.len(), [f64::NAN; 2]);
            if let Some((z, others)) = self
                .shores
                .split_at_checked(ends.len())
                .filter(|_| self.lines.is_of_ponds())
            {
                self.z.extend_from_slice(z);
                self.shores = others;
            } else {
                self.z.extend_from_slice(z);
            }
            self.polygons.resize(self.ready.ends.len(), 0);
            if kind == LineKind::Obstacle {
                self.polygons.extend_from_slice(polygons);
            }
            self.ready.ends.extend_from_slice(ends);
            for pair in records {
                let index = 2 * self.ready.ends.len() as u32;
                self.wanted.extend(pair.iter().copied().zip(index..));
                self.ready.ends.push(Default::default());
            }
            if self.wanted.is_empty() || self.ready.ends.len() >= self.capacity {
                break;
            }
        }
        self.z.resize(self.ready.ends.len(), [f64::NAN; 2]);
        self.polygons.resize(self.ready.ends.len(), 0);
        self.look_up()
    }

    /// Reads the points and fills in the ends whose records are wanted.
    fn look_up(&mut self) -> anyhow::Result<()> {
        if self.wanted.is_empty() {
            return Ok(());
        }
        self.wanted.sort_unstable();
        let mut points = self.input.open_points()?;
        let mut batch = PointBatch::default();
        let ends = self.ready.ends.as_flattened_mut();
        let mut wanted = self.wanted.iter().peekable();
        // Records ascend in both lists.
        while wanted.peek().is_some() && points.next_batch(&mut batch)? {
            let last = batch.records.last().copied().unwrap_or(0);
            while let Some((record, end)) = wanted.next_if(|(record, _)| *record <= last) {
                let found = batch.records.binary_search(record).ok();
                let found = found.with_context(|| missing_point(*record))?;
                ends[*end as usize] = batch.points[found];
            }
        }
        if let Some((record, _)) = wanted.next() {
            bail!(missing_point(*record));
        }
        self.wanted.clear();
        Ok(())
    }
}

fn missing_point(record: u64) -> String {
    format!("a segment ends at record {record}, but no point has this number")
}
