//! Segments: what a batch of them is, and how their readers number them, with z for all ends or for none.

use crate::geometry::Point;
use crate::input::reader::{Batch, Sink, Totals};
use crate::input::spot::Spot;
use crate::shown;
use std::path::Path;

/// A batch of segments: what a [`SegmentSource`](crate::input::SegmentSource) gives, and a [`Builder`](crate::Builder) takes.
#[derive(Clone, Debug, Default)]
pub struct SegmentBatch {
    /// Segments by their ends: valid and normalized points.
    pub ends: Vec<[Point; 2]>,
    /// The elevations of these ends: finite, or NaN where an end has none. Empty if the source has
    /// none ([`has_z`](crate::input::SegmentSource::has_z)), else as long as `ends`.
    pub z: Vec<[f64; 2]>,
    /// Segments by the record numbers of two points.
    pub records: Vec<[u64; 2]>,
    /// The number of each segment's line, first of those in `ends`, then of those in `records`.
    pub lines: Vec<u64>,
    /// Of obstacles, the number of the polygon of each segment in `ends`: a line has several if it is a MultiPolygon. Empty where each
    /// line is one.
    pub polygons: Vec<u64>,
}

impl SegmentBatch {
    /// Whether there are none.
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

/// What the reader of a file with segments counts.
#[derive(Default)]
pub struct LineTally {
    /// The lines that are at their end, those without segments too.
    pub lines: u64,
    /// The polygons that were begun.
    pub polygons: u64,
}

/// What is counted over all files with segments.
#[derive(Default)]
pub struct LineTotals {
    /// Lines of the files that are done, and their polygons.
    first_line: u64,
    first_polygon: u64,
    /// One more than the largest line that is known by now.
    pub lines: u64,
    /// Ends of the file at hand that had no z, and those whose z was left out.
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
    /// Takes a segment of this line of the file.
    pub fn segment(&mut self, ends: [Spot; 2], line: u64) {
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

    /// Takes a segment of this polygon of the file, which is of this line.
    #[cfg(feature = "geojson")]
    pub fn side(&mut self, ends: [Spot; 2], line: u64, polygon: u64) {
        self.segment(ends, line);
        self.batch.polygons.push(self.totals.first_polygon + polygon);
    }

    /// Takes a segment between two records.
    pub fn pair(&mut self, records: [u64; 2], line: u64) {
        self.batch.records.push(records);
        self.batch.lines.push(self.totals.first_line + line);
    }

    /// The number of a line of the file, over all files.
    #[cfg(feature = "geojson")]
    pub fn line(&self, line: u64) -> u64 {
        self.totals.first_line + line
    }
}
