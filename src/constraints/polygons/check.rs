//! Detection of polygons that are inside out, and of obstacles that overlap themselves, one by one
//! as they arrive.
//!
//! An area is covered if any obstacle covers it. The depth of a region is the sum of the windings of
//! all obstacles. In a covered region it is more than 0 if no winding is negative there. It remains
//! right when an obstacle is taken out if each winding is 0 or 1. So each polygon is swept by itself
//! before it joins the sum, and so are the polygons of one obstacle together.

use std::mem::take;
use std::ops::Range;
use std::path::Path;

use crate::constraints::error::ConstraintError;
use crate::constraints::polygons::counter::{Begins, PolygonCounter, by_ends};
use crate::constraints::polygons::normalize::PolygonNormalizer;
use crate::constraints::polygons::pile::{Pile, Sweeper};
use crate::geometry::Point;
use crate::input::SegmentBatch;
use crate::mesh::windings::sweep::Outcome;

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

/// An obstacle that covers a place more than once, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlapping {
    /// The number of the obstacle's record among all lines.
    pub obstacle: u64,
    /// The smallest corner of the part that is covered more than once.
    pub point: Point,
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
    /// The first obstacle whose rings cross and that covers a place more than once, provided that
    /// the crossings are at vertices only. An obstacle whose rings do not cross is normalised
    /// instead.
    pub overlapping_if_uncrossed: Option<Overlapping>,
}

/// A check for polygons that are inside out, and for obstacles that overlap themselves.
#[derive(Debug)]
pub struct PolygonCheck {
    sweeper: Sweeper,
    counter: PolygonCounter,
    /// The line of the last segment.
    line: u64,
    /// The segments of the current polygon.
    polygon: Pile,
    /// The segments of the polygons before it that belong to the same obstacle.
    obstacle: Pile,
    /// Number of segments of nonzero length so far, and at the start of the current obstacle.
    taken: u64,
    started: u64,
    faults: PolygonFaults,
    /// The segments of the obstacles to normalise, by their numbers among those of nonzero length.
    overlapping: Vec<Range<u64>>,
}

impl PolygonCheck {
    /// Makes a check that takes about `memory` bytes of memory. A polygon that takes more goes to a
    /// file in `folder`.
    #[must_use]
    pub fn new(folder: &Path, memory: u64) -> Self {
        Self {
            sweeper: Sweeper::new(folder, memory),
            counter: PolygonCounter::default(),
            line: 0,
            polygon: Pile::default(),
            obstacle: Pile::default(),
            taken: 0,
            started: 0,
            faults: PolygonFaults::default(),
            overlapping: Vec::new(),
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
        let ends = ends.map(Point::normalized);
        if ends[0] == ends[1] {
            return Ok(());
        }
        match self.counter.next(key, line) {
            Begins::Nothing => {}
            Begins::Polygon => {
                self.end_polygon()?;
                let polygon = take(&mut self.polygon);
                self.sweeper.append(&mut self.obstacle, polygon)?;
            }
            Begins::Obstacle => self.end_obstacle()?,
        }
        self.line = line;
        self.taken += 1;
        self.sweeper.push(&mut self.polygon, ends)
    }

    /// Returns the faults of the polygons that came so far. The next segment begins another
    /// polygon.
    ///
    /// # Errors
    /// Errors are those of [`push`](Self::push).
    pub fn finish(&mut self) -> Result<PolygonFaults, ConstraintError> {
        self.end_obstacle()?;
        self.counter.end();
        Ok(self.faults)
    }

    /// Returns a normaliser of the obstacles that cover a place more than once, if there are any.
    /// It takes the same segments again, in the same order.
    #[must_use]
    pub fn normalizer(&self) -> Option<PolygonNormalizer> {
        (!self.overlapping.is_empty()).then(|| PolygonNormalizer::new(self.overlapping.clone()))
    }

    fn end_obstacle(&mut self) -> Result<(), ConstraintError> {
        let mut outcome = self.end_polygon()?;
        let mut pile = take(&mut self.polygon);
        if !self.obstacle.is_empty() {
            let mut obstacle = take(&mut self.obstacle);
            self.sweeper.append(&mut obstacle, pile)?;
            outcome = self.sweeper.sweep(&mut obstacle, self.line)?;
            pile = obstacle;
        }
        let segments = self.started..self.taken;
        self.started = self.taken;
        let Outcome::Seen {
            overlap: Some(point),
            meets,
            ..
        } = outcome
        else {
            return Ok(());
        };
        if meets {
            let obstacle = self.line;
            let found = Overlapping { obstacle, point };
            self.faults.overlapping_if_uncrossed.get_or_insert(found);
            return Ok(());
        }
        if pile.is_spooled() {
            return Err(self.sweeper.shortage(self.line, segments.end - segments.start));
        }
        self.overlapping.push(segments);
        Ok(())
    }

    /// Sweeps the current polygon.
    fn end_polygon(&mut self) -> Result<Outcome, ConstraintError> {
        let outcome = self.sweeper.sweep(&mut self.polygon, self.line)?;
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
        Ok(outcome)
    }
}
