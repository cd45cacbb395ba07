//! The segments of a polygon that is to be swept, in memory or on the disk.
//!
//! A polygon that does not fit in memory goes to the disk, and is swept in strips that do.

use std::path::{Path, PathBuf};

use crate::constraints::error::ConstraintError;
use crate::constraints::segments::spool::SegmentSpool;
use crate::geometry::Point;
use crate::memory::{MemoryShortage, MemoryUse, PolygonShares};
use crate::mesh::windings::sweep::{BYTES, Outcome, Sweep};
use crate::store::LineKind;

/// The segments of a polygon, in order.
#[derive(Debug, Default)]
pub(crate) struct Pile {
    /// Those after the spooled ones.
    segments: Vec<[Point; 2]>,
    spooled: Option<SegmentSpool>,
}

/// Where piles of segments are stored and swept.
#[derive(Debug)]
pub(crate) struct Sweeper {
    folder: PathBuf,
    /// Number of segments of a pile that fit in memory.
    most: usize,
    shares: PolygonShares,
}

impl Pile {
    pub(crate) fn is_empty(&self) -> bool {
        self.segments.is_empty() && self.spooled.is_none()
    }

    /// Returns whether some segments did not fit in memory.
    pub(crate) fn is_spooled(&self) -> bool {
        self.spooled.is_some()
    }
}

impl Sweeper {
    /// Makes a sweeper that takes about `memory` bytes of memory for a pile. A pile that takes more
    /// goes to a file in `folder`.
    pub(crate) fn new(folder: &Path, memory: u64) -> Self {
        let shares = PolygonShares::new(memory);
        Self {
            folder: folder.to_owned(),
            most: (shares.polygon / BYTES).clamp(16, u64::from(u32::MAX)) as usize,
            shares,
        }
    }

    /// Adds a segment to a pile.
    pub(crate) fn push(&self, pile: &mut Pile, ends: [Point; 2]) -> Result<(), ConstraintError> {
        pile.segments.push(ends);
        if pile.segments.len() >= self.most {
            self.spill(pile)?;
        }
        Ok(())
    }

    /// Moves all segments of `from` to `pile`.
    pub(crate) fn append(&self, pile: &mut Pile, mut from: Pile) -> Result<(), ConstraintError> {
        if pile.is_empty() {
            *pile = from;
            return Ok(());
        }
        if let Some(spool) = &mut from.spooled {
            spool.for_each_chunk(|segments| segments.iter().try_for_each(|segment| self.push(pile, segment.ends)))?;
        }
        from.segments.into_iter().try_for_each(|ends| self.push(pile, ends))
    }

    fn spill(&self, pile: &mut Pile) -> Result<(), ConstraintError> {
        let spool = &mut pile.spooled;
        let spool = spool.get_or_insert_with(|| SegmentSpool::new(&self.folder, self.shares.spool));
        let lines = vec![0; pile.segments.len()];
        spool.push(&pile.segments, &[], LineKind::Obstacle, &lines)?;
        pile.segments.clear();
        Ok(())
    }

    /// Sweeps the segments of a pile, which belong to the line `line` at last.
    pub(crate) fn sweep(&self, pile: &mut Pile, line: u64) -> Result<Outcome, ConstraintError> {
        if pile.spooled.is_some() {
            self.spill(pile)?;
            // The strips need the memory.
            pile.segments = Vec::new();
        }
        match &mut pile.spooled {
            Some(spool) => self.sweep_in_strips(spool, line),
            None => Ok(Sweep::new(pile.segments.iter().copied()).run(None, &mut |_| {})),
        }
    }

    fn sweep_in_strips(&self, spool: &mut SegmentSpool, line: u64) -> Result<Outcome, ConstraintError> {
        let cuts = self.cuts(spool)?;
        let ends = [f64::NEG_INFINITY, f64::INFINITY];
        let bounds: Vec<f64> = [ends[0]]
            .into_iter()
            .chain(cuts.iter().copied())
            .chain([ends[1]])
            .collect();
        let (mut smallest, mut smallest_overlap, mut any_meets) = (None, None, false);
        for strip in bounds.windows(2) {
            let strip = [strip[0], strip[1]];
            let sweep = Sweep::new(self.within(spool, strip, line)?.into_iter());
            match sweep.run(Some(strip), &mut |_| {}) {
                Outcome::Seen {
                    first, overlap, meets, ..
                } => {
                    // Strips are swept from left to right, so the first point is the smallest.
                    smallest = smallest.or(first);
                    smallest_overlap = smallest_overlap.or(overlap);
                    any_meets |= meets;
                }
                other => return Ok(other),
            }
        }
        Ok(Outcome::Seen {
            first: smallest,
            faces: 0,
            overlap: smallest_overlap,
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
    fn within(
        &self,
        spool: &mut SegmentSpool,
        [left, right]: [f64; 2],
        line: u64,
    ) -> Result<Vec<[Point; 2]>, ConstraintError> {
        let (mut within, count) = (Vec::new(), spool.len());
        spool.for_each_chunk(|segments| {
            let meets = |ends: &[Point; 2]| {
                let [a, b] = ends.map(|end| end.x);
                a.max(b) >= left && a.min(b) <= right
            };
            within.extend(segments.iter().map(|segment| segment.ends).filter(meets));
            match within.len() > self.most {
                true => Err(self.shortage(line, count)),
                false => Ok(()),
            }
        })?;
        Ok(within)
    }

    /// Returns the error for a polygon of `segments` segments that must be in memory.
    pub(crate) fn shortage(&self, line: u64, segments: u64) -> ConstraintError {
        let shortage = MemoryShortage {
            of: MemoryUse::Polygon { obstacle: line },
            needed: segments.saturating_mul(BYTES),
            budget: self.shares.polygon,
        };
        shortage.into()
    }
}
