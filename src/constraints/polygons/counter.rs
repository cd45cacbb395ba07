//! Which segments belong to one polygon, and which polygons to one obstacle.

use crate::geometry::Point;
use crate::input::SegmentBatch;

/// A counter that numbers polygons in the order in which they arrive. The segments of a polygon
/// must be consecutive, and so must be the polygons of an obstacle. Segments of zero length do not
/// count.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PolygonCounter {
    /// The input's name for the last segment's polygon, and the number of its line.
    last: Option<(u64, u64)>,
    number: u64,
}

/// What begins with a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Begins {
    /// It belongs to the polygon of the segment before it.
    Nothing,
    /// Another polygon of the same obstacle.
    Polygon,
    /// Another obstacle.
    Obstacle,
}

impl PolygonCounter {
    /// Returns the number of the last segment's polygon.
    pub(crate) fn number(self) -> u64 {
        self.number
    }

    /// Takes the next segment, which belongs to the line `line` and to the polygon that the input
    /// calls `key`. Returns what begins with it; the first segment begins an obstacle.
    pub(crate) fn next(&mut self, key: u64, line: u64) -> Begins {
        let begins = match self.last {
            Some((last, _)) if last == key => Begins::Nothing,
            Some((_, last)) if last == line => Begins::Polygon,
            _ => Begins::Obstacle,
        };
        self.number += u64::from(self.last.is_some() && begins != Begins::Nothing);
        self.last = Some((key, line));
        begins
    }

    /// The next segment begins another obstacle.
    pub(crate) fn end(&mut self) {
        self.number += u64::from(self.last.take().is_some());
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
