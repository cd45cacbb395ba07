//! What becomes points once all points have arrived: ends of segments, crossings, sites.

use std::sync::atomic::Ordering;

use crate::constraints::polygons::check::PolygonFaults;
use crate::constraints::segments::spool::SegmentSpool;
use crate::constraints::split_lines::SplitLines;
use crate::geometry::Point;
use crate::pipeline::builder::Builder;
use crate::pipeline::error::BuildError;
use crate::pipeline::options::{Crossings, Steiner};

impl Builder {
    /// Checks the obstacles that were pushed so far.
    pub(super) fn check_obstacles(&mut self) -> Result<(), BuildError> {
        check_polygons(self.polygons.faults()?)
    }

    /// Pushes the ends of segments as points, which other points replace, then sites, which all
    /// others replace.
    pub(super) async fn push_ends(&mut self) -> Result<(), BuildError> {
        let faults = self.polygons.all_faults(&mut self.segments)?;
        check_polygons(faults)?;
        self.given.inverted_if_uncrossed = faults.inverted_if_uncrossed;
        self.given.overlapping_if_uncrossed = faults.overlapping_if_uncrossed;
        self.given.polygon_lines = self.polygons.take_lines();
        let first_end = &self.context.first_end;
        // That of the next state of a file is known before.
        let _ = first_end.compare_exchange(u64::MAX, self.next_record, Ordering::Relaxed, Ordering::Relaxed);
        let mut record = self.next_record.max(first_end.load(Ordering::Relaxed));
        for batch in self.segments.ends(record) {
            let mut batch = batch?;
            record = record.saturating_add(batch.records.len() as u64);
            self.given.has_z |= !batch.z.is_empty();
            batch.remove_pairs_at_one_point();
            self.intake.push(&batch, &self.context).await?;
        }
        self.given.first_crossing = record;
        let options = &self.context.options;
        let may_split = options.crossings == Crossings::Split || options.steiner == Steiner::Borders;
        match may_split && self.split_lines(&mut record).await? {
            true => {}
            false => self.normalize_polygons()?,
        }
        self.given.first_site = record;
        self.given.next_record = record.saturating_add(self.sites.count());
        self.given.has_z |= self.sites.has_z();
        for batch in self.sites.take_points(record) {
            self.intake.push(&batch, &self.context).await?;
        }
        Ok(())
    }

    /// Replaces the segments of obstacles that cover a place more than once.
    fn normalize_polygons(&mut self) -> Result<(), BuildError> {
        let Some(normalizer) = self.polygons.normalizer() else {
            return Ok(());
        };
        let memory = self.context.memory.for_segments();
        let mut normalized = SegmentSpool::new(self.context.folder.spill(), memory / 2);
        normalizer.copy(&mut self.segments, &mut normalized)?;
        self.segments = normalized;
        self.reserve()
    }

    /// Splits segments where they cross each other or borders, and pushes the crossing points, from
    /// `record` on, which becomes the next record number. Returns whether any segment was replaced.
    async fn split_lines(&mut self, record: &mut u64) -> Result<bool, BuildError> {
        let (arrived, sites) = (self.intake.arrived(&self.context).await?, self.sites.points());
        let mut points = |within, take: &mut dyn FnMut(&[Point])| {
            take(sites);
            arrived.for_each(within, take)
        };
        let borders = |within| match self.context.options.steiner {
            Steiner::Borders => arrived.borders(within),
            Steiner::Never => Vec::new(),
        };
        let may_cross = self.context.options.crossings == Crossings::Split;
        let memory = self.context.memory.rest();
        let polygons = self.polygons.numbers();
        let split = SplitLines::of(
            (&mut self.segments, polygons),
            memory,
            (may_cross, &borders),
            &mut points,
        )?;
        let Some(lines) = split else {
            return Ok(false);
        };
        self.given.crossings = lines.crossings();
        self.given.repair = lines.repair();
        self.given.borders = lines.borders().to_vec();
        self.segments = SegmentSpool::new(self.context.folder.spill(), self.context.memory.for_segments());
        lines.push_subsegments(&mut self.segments)?;
        self.reserve()?;
        for batch in lines.points(*record) {
            *record = record.saturating_add(batch.points.len() as u64);
            self.given.split_points += batch.points.len() as u64;
            self.given.has_z |= !batch.z.is_empty();
            self.intake.push(&batch, &self.context).await?;
        }
        Ok(true)
    }
}

/// Returns an error if a polygon is invalid: an open ring first, then one that is inside out.
fn check_polygons(faults: PolygonFaults) -> Result<(), BuildError> {
    match (faults.open, faults.inverted) {
        (Some(obstacle), _) => Err(BuildError::OpenRing { obstacle }),
        (None, Some(inverted)) => Err(BuildError::Inverted(inverted)),
        (None, None) => Ok(()),
    }
}
