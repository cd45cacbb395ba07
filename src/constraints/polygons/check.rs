//! Detection of polygons that are inside out, one by one as they arrive.
//!
//! An area is covered if any polygon covers it. The depth of a region is the sum of the windings of
//! all polygons. In a covered region it is more than 0 if no winding is negative there. So each
//! polygon is swept by itself before it joins the sum.
//!
//! A polygon that does not fit in memory goes to the disk, and is swept in strips that do.

use std::path::{Path, PathBuf};

use crate::constraints::error::ConstraintError;
use crate::constraints::polygons::sweep::{BYTES, Outcome, Sweep};
use crate::constraints::segments::spool::SegmentSpool;
use crate::geometry::Point;
use crate::input::SegmentBatch;
use crate::memory::{MemoryShortage, MemoryUse, PolygonShares};
use crate::store::LineKind;

/// A polygon that is inside out, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Inverted {
    /// The number of the polygon's record among all lines.
    pub obstacle: u64,
    /// The smallest corner of the part that is inside out.
    pub point: Point,
}

/// The polygons that are inside out: the first one, and their number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvertedPolygons {
    /// The first one in the order in which they arrived.
    pub first: Inverted,
    /// Number of polygons that are inside out.
    pub polygons: u64,
}

/// Faults of polygons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PolygonFaults {
    /// The line number of the first polygon whose rings do not close.
    pub open: Option<u64>,
    /// The polygons that are inside out and whose rings do not cross. Sides that are traversed in
    /// both directions are ignored.
    pub inverted: Option<InvertedPolygons>,
    /// The polygons whose rings cross and that are inside out, provided that the crossings are at
    /// vertices only. Otherwise the crossings are the error to report.
    pub inverted_if_uncrossed: Option<InvertedPolygons>,
}

/// A check for polygons that are inside out.
#[derive(Debug)]
pub struct PolygonCheck {
    folder: PathBuf,
    /// Number of segments of a polygon that fit in memory.
    most: usize,
    shares: PolygonShares,
    counter: PolygonCounter,
    /// The current polygon, and the number of its line.
    polygon: u64,
    line: u64,
    segments: Vec<[Point; 2]>,
    /// The segments of the polygon before these, if they do not fit in memory.
    spooled: Option<SegmentSpool>,
    faults: PolygonFaults,
}

/// A counter that numbers polygons in the order in which they arrive. The segments of a polygon
/// must be consecutive.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PolygonCounter {
    last: Option<u64>,
    number: u64,
}

impl PolygonCounter {
    /// Returns the number of the last segment's polygon.
    pub(crate) fn number(self) -> u64 {
        self.number
    }

    /// Returns the number of the next segment's polygon, which the input calls `key`.
    pub(crate) fn next(&mut self, key: u64) -> u64 {
        if self.last.is_some_and(|last| last != key) {
            self.number += 1;
        }
        self.last = Some(key);
        self.number
    }
}

/// Returns the segments that a batch gives by their ends: for each, the input's name for its
/// polygon, the number of its line, and its ends. Lines are numbered from `first_line` on.
pub(crate) fn by_ends(first_line: u64, batch: &SegmentBatch) -> impl Iterator<Item = (u64, u64, [Point; 2])> {
    let segments = batch.ends.iter().zip(&batch.lines).enumerate();
    segments.map(move |(at, (&ends, &line))| {
        let line = first_line.saturating_add(line);
        (batch.polygons.get(at).copied().unwrap_or(line), line, ends)
    })
}

impl PolygonCheck {
    /// Makes a check that takes about `memory` bytes of memory. A polygon that takes more goes to a
    /// file in `folder`.
    #[must_use]
    pub fn new(folder: &Path, memory: u64) -> Self {
        let shares = PolygonShares::new(memory);
        Self {
            folder: folder.to_owned(),
            most: (shares.polygon / BYTES).clamp(16, u64::from(u32::MAX)) as usize,
            shares,
            counter: PolygonCounter::default(),
            polygon: 0,
            line: 0,
            segments: Vec::new(),
            spooled: None,
            faults: PolygonFaults::default(),
        }
    }

    /// Adds the segments that a batch of obstacles gives by their ends. The batch's lines are
    /// numbered from `first_line` on.
    ///
    /// # Errors
    /// Returns an error if a polygon is too large for the memory, or cannot be spilled.
    pub fn push(&mut self, first_line: u64, batch: &SegmentBatch) -> Result<(), ConstraintError> {
        for (key, line, ends) in by_ends(first_line, batch) {
            self.take(key, line, ends)?;
        }
        Ok(())
    }

    /// Adds a segment of a polygon.
    pub(crate) fn take(&mut self, key: u64, line: u64, ends: [Point; 2]) -> Result<(), ConstraintError> {
        let polygon = self.counter.next(key);
        if polygon != self.polygon {
            self.end_polygon()?;
            self.polygon = polygon;
        }
        self.line = line;
        self.segments.push(ends.map(Point::normalized));
        if self.segments.len() >= self.most {
            self.spill()?;
        }
        Ok(())
    }

    /// Returns the faults of the polygons that came so far. The next segment begins another
    /// polygon.
    ///
    /// # Errors
    /// Errors are those of [`push`](Self::push).
    pub fn finish(&mut self) -> Result<PolygonFaults, ConstraintError> {
        self.end_polygon()?;
        self.counter.last = None;
        self.segments = Vec::new();
        Ok(self.faults)
    }

    fn spill(&mut self) -> Result<(), ConstraintError> {
        let (folder, memory) = (&self.folder, self.shares.spool);
        let spool = self.spooled.get_or_insert_with(|| SegmentSpool::new(folder, memory));
        let lines = vec![0; self.segments.len()];
        spool.push(&self.segments, &[], LineKind::Obstacle, &lines)?;
        self.segments.clear();
        Ok(())
    }

    fn end_polygon(&mut self) -> Result<(), ConstraintError> {
        let outcome = if self.spooled.is_some() {
            self.spill()?;
            self.segments = Vec::new();
            let spool = self.spooled.take();
            spool.map_or(Ok(Outcome::Crosses), |spool| self.sweep_in_strips(spool))?
        } else {
            Sweep::new(self.segments.drain(..)).run(None, &mut |_| {})
        };
        match outcome {
            Outcome::Open => {
                self.faults.open.get_or_insert(self.line);
            }
            Outcome::Seen {
                first: Some(point),
                meets,
                ..
            } => {
                let found = match meets {
                    false => &mut self.faults.inverted,
                    true => &mut self.faults.inverted_if_uncrossed,
                };
                let first = Inverted {
                    obstacle: self.line,
                    point,
                };
                found.get_or_insert(InvertedPolygons { first, polygons: 0 }).polygons += 1;
            }
            Outcome::Crosses | Outcome::Seen { .. } => {}
        }
        Ok(())
    }

    /// Sweeps a polygon that does not fit in memory.
    fn sweep_in_strips(&self, mut spool: SegmentSpool) -> Result<Outcome, ConstraintError> {
        let cuts = self.cuts(&mut spool)?;
        let ends = [f64::NEG_INFINITY, f64::INFINITY];
        let bounds: Vec<f64> = [ends[0]]
            .into_iter()
            .chain(cuts.iter().copied())
            .chain([ends[1]])
            .collect();
        let (mut smallest, mut any_meets) = (None, false);
        for strip in bounds.windows(2) {
            let strip = [strip[0], strip[1]];
            match Sweep::new(self.within(&mut spool, strip)?.into_iter()).run(Some(strip), &mut |_| {}) {
                Outcome::Seen { first, meets, .. } => {
                    // Strips are swept from left to right, so the first point is the smallest.
                    smallest = smallest.or(first);
                    any_meets |= meets;
                }
                other => return Ok(other),
            }
        }
        Ok(Outcome::Seen {
            first: smallest,
            faces: 0,
            meets: any_meets,
        })
    }

    /// Returns where to cut a polygon into strips. Each strip meets about half of the segments that
    /// fit in memory, if few segments pass through it without an end there.
    fn cuts(&self, spool: &mut SegmentSpool) -> Result<Vec<f64>, ConstraintError> {
        const SAMPLE: u64 = 1 << 14;
        let every = spool.len().div_ceil(SAMPLE).max(1);
        let (mut count, mut sample) = (0, Vec::new());
        spool.for_each_chunk(|segments| {
            for segment in segments {
                if count % every == 0 {
                    sample.push(segment.ends[0].x);
                }
                count += 1;
            }
            Ok(())
        })?;
        sample.sort_unstable_by(f64::total_cmp);
        let step = (self.most as u64 / 4 / every).max(1) as usize;
        let mut cuts: Vec<f64> = sample.into_iter().step_by(step).skip(1).collect();
        cuts.dedup();
        Ok(cuts)
    }

    /// Returns the segments that meet a strip.
    fn within(&self, spool: &mut SegmentSpool, [left, right]: [f64; 2]) -> Result<Vec<[Point; 2]>, ConstraintError> {
        let (mut within, count) = (Vec::new(), spool.len());
        spool.for_each_chunk(|segments| {
            let meets = |ends: &[Point; 2]| {
                let [a, b] = ends.map(|end| end.x);
                a.max(b) >= left && a.min(b) <= right
            };
            within.extend(segments.iter().map(|segment| segment.ends).filter(meets));
            match within.len() > self.most {
                true => Err(MemoryShortage {
                    of: MemoryUse::Polygon { obstacle: self.line },
                    needed: count.saturating_mul(BYTES),
                    budget: self.shares.polygon,
                }
                .into()),
                false => Ok(()),
            }
        })?;
        Ok(within)
    }
}
