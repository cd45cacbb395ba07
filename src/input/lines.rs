//! Batches of segments, and the sink that numbers the segments and keeps z for all ends or for
//! none.

use crate::geometry::Point;
use crate::input::point_z::PointZ;
use crate::input::reader::{Batch, Sink, Totals};
use crate::shown;
use std::path::Path;

/// A batch of segments, as produced by a [`SegmentSource`](crate::input::SegmentSource) and
/// accepted by a [`Builder`](crate::Builder).
#[derive(Clone, Debug, Default)]
pub struct SegmentBatch {
    /// The segments that are given by their end points; the points are valid and normalized.
    pub ends: Vec<[Point; 2]>,
    /// The elevations of the ends in `ends`: finite, or NaN where an end has none. Empty if the
    /// source has no z ([`has_z`](crate::input::SegmentSource::has_z)), otherwise as long as
    /// `ends`.
    pub z: Vec<[f64; 2]>,
    /// The segments that are given by the record numbers of two points.
    pub records: Vec<[u64; 2]>,
    /// The line number of each segment: first for the segments in `ends`, then for those in
    /// `records`.
    pub lines: Vec<u64>,
    /// For obstacles, the polygon number of each segment in `ends`; the line of a MultiPolygon has
    /// several polygons, and a polygon may have several lines. Two polygons have the same number in
    /// no two batches. Empty where each line is one polygon.
    pub polygons: Vec<u64>,
}

impl SegmentBatch {
    /// Returns whether the batch has no segments.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty() && self.records.is_empty()
    }

    /// Removes all segments and keeps the memory.
    pub fn clear(&mut self) {
        self.ends.clear();
        self.z.clear();
        self.records.clear();
        self.lines.clear();
        self.polygons.clear();
    }
}

/// The counts of the reader of a file with segments.
#[derive(Default)]
pub struct LineTally {
    /// The number of lines that have ended, including those without segments.
    pub lines: u64,
    /// The number of polygons that have begun.
    pub polygons: u64,
}

/// The counts over all files with segments.
#[derive(Default)]
pub struct LineTotals {
    /// The numbers of lines and of polygons in the files that have ended.
    first_line: u64,
    first_polygon: u64,
    /// One more than the largest line number known so far.
    pub lines: u64,
    /// In the current file, the number of ends that had no z, and of ends whose z was dropped.
    padded: u64,
    cut: u64,
}

impl Batch for SegmentBatch {
    type Options = ();
    type Totals = LineTotals;
    type Tally = LineTally;

    fn len(&self) -> usize {
        self.ends.len() + self.records.len()
    }

    fn clear(&mut self) {
        Self::clear(self);
    }
}

impl Totals<SegmentBatch> for LineTotals {
    fn add(&mut self, batch: &SegmentBatch, tally: &LineTally) {
        let in_batch = batch.lines.last().map_or(0, |last| last + 1);
        self.lines = in_batch.max(self.first_line + tally.lines);
    }

    fn end_file(&mut self, tally: &LineTally, _: u64) -> u64 {
        self.first_line += tally.lines;
        self.first_polygon += tally.polygons;
        self.first_line
    }

    fn notes(&mut self, path: &Path) -> Vec<String> {
        let path = shown::path(path);
        let (padded, cut) = (std::mem::take(&mut self.padded), std::mem::take(&mut self.cut));
        let padded = (padded > 0).then(|| format!("{path}: {padded} ends have no z, and others have"));
        let cut = (cut > 0)
            .then(|| format!("{path}: the z of {cut} ends is not kept, since the first position of no file has one"));
        padded.into_iter().chain(cut).collect()
    }
}

impl Sink<'_, SegmentBatch> {
    /// Takes a segment of the line with the number `line` in the file.
    pub fn segment(&mut self, ends: [PointZ; 2], line: u64) {
        self.batch.ends.push(ends.map(|end| end.point));
        self.batch.lines.push(self.totals.first_line + line);
        for end in ends {
            self.totals.padded += u64::from(self.wants_z && end.z.is_none());
            self.totals.cut += u64::from(!self.wants_z && end.z.is_some());
        }
        if self.wants_z {
            self.batch.z.push(ends.map(|end| end.z.unwrap_or(f64::NAN)));
        }
    }

    /// Takes a segment of the polygon `polygon` of the file, which belongs to the line `line`.
    pub fn polygon_edge(&mut self, ends: [PointZ; 2], line: u64, polygon: u64) {
        self.segment(ends, line);
        self.batch.polygons.push(self.totals.first_polygon + polygon);
    }

    /// Takes a segment between two records.
    pub fn pair(&mut self, records: [u64; 2], line: u64) {
        self.batch.records.push(records);
        self.batch.lines.push(self.totals.first_line + line);
    }

    /// Returns the number over all files of line `line` of the file.
    pub fn line(&self, line: u64) -> u64 {
        self.totals.first_line + line
    }
}
