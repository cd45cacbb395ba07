//! All points of the input that are vertices of the file.

use delaunay_tiles::SplitLines;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{PointBatch, PointSource, SegmentBatch, SiteBatch};
use delaunay_tiles::store::PointOrigin;

use super::ponds::BuildPonds;
use crate::lines::LineInput;

/// A reader of all points that are vertices, numbered consecutively: points, ends of the build's
/// segments, points where these segments cross, sites, and ends of the segments of each edit.
pub struct VertexPoints<'a> {
    points: PointSource,
    lines: LineInput,
    /// Number of the last edit whose lines are included.
    last_edit: u32,
    segments: SegmentBatch,
    sites: SiteBatch,
    split: Option<&'a SplitLines>,
    /// The remaining points where segments cross, once the ends of the build's segments are read.
    crossing_points: Option<Box<dyn Iterator<Item = PointBatch> + 'a>>,
    ponds: Option<&'a BuildPonds>,
    /// Ends of the edges of shores, which come after those of other segments of the build.
    shores: Vec<Point>,
    /// The largest record number so far, plus 1.
    next_record: u64,
}

impl<'a> VertexPoints<'a> {
    /// Creates a reader of the points of a build and of its edits. `split` is given if the build split
    /// lines.
    pub fn new(
        points: PointSource,
        lines: LineInput,
        split: Option<&'a SplitLines>,
        ponds: Option<&'a BuildPonds>,
    ) -> Self {
        Self {
            points,
            lines,
            last_edit: u32::MAX,
            segments: SegmentBatch::default(),
            sites: SiteBatch::default(),
            split,
            crossing_points: None,
            ponds,
            shores: Vec::new(),
            next_record: 0,
        }
    }

    /// Leaves out the lines of all edits.
    pub fn of_build(self) -> Self {
        Self { last_edit: 0, ..self }
    }

    /// Fills the batch with the next points. Returns where they come from; `None` at the end.
    pub fn next_batch(&mut self, batch: &mut PointBatch) -> anyhow::Result<Option<PointOrigin>> {
        if self.points.next_batch(batch)? {
            self.next_record = batch.records.last().map_or(0, |last| last + 1);
            self.flatten(batch);
            return Ok(Some(PointOrigin::Input));
        }
        batch.clear();
        let (mut has_pairs, mut is_of_edit) = (false, false);
        while batch.is_empty() {
            if self.lines.next_batch_until(0, &mut self.segments)?.is_some() {
                match self.lines.is_of_ponds() {
                    true => self.shores.extend_from_slice(self.segments.ends.as_flattened()),
                    false => self.take_ends(batch),
                }
                has_pairs = true;
            } else if !self.shores.is_empty() {
                batch.points = std::mem::take(&mut self.shores);
                has_pairs = true;
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
                (has_pairs, is_of_edit) = (true, true);
            } else {
                return Ok(None);
            }
        }
        let next = self.next_record + batch.points.len() as u64;
        batch.records.clear();
        batch.records.extend(self.next_record..next);
        self.next_record = next;
        if !is_of_edit {
            self.flatten(batch);
        }
        if has_pairs {
            batch.remove_pairs_at_one_point();
        }
        Ok(Some(PointOrigin::Other))
    }

    fn flatten(&self, batch: &mut PointBatch) {
        if let Some(ponds) = self.ponds {
            ponds.flatten(batch);
        }
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
