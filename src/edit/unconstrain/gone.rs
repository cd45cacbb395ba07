//! The lines that go.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::constraints::segment::Segment;
use crate::store::{LineKind, PolygonLine, polygon_of};

/// The lines that go.
#[derive(Clone, Debug, Default)]
pub(crate) struct GoneLines {
    /// The segments of the lines that are given by geometry, after obstacles were normalised. Their
    /// sources have the numbers of the given lines.
    pub(crate) segments: Arc<Vec<Segment>>,
    /// The given lines that belong to the polygon of a smaller one.
    pub(crate) polygon_lines: Vec<PolygonLine>,
    /// The numbers of lines of the file.
    pub(crate) numbers: BTreeSet<u64>,
    /// The memory of the edit, half of which the ends of removed lines may take.
    pub(crate) memory: u64,
    /// Whether to leave out lines that are not there.
    pub(crate) skip_missing: bool,
}

impl GoneLines {
    pub(crate) fn is_empty(&self) -> bool {
        self.segments.is_empty() && self.numbers.is_empty()
    }

    /// Returns the segments of each given line, or of each given obstacle.
    pub(crate) fn groups(&self) -> impl Iterator<Item = &[Segment]> {
        let of_line = |segment: &Segment| {
            let (kind, number) = (segment.source.kind(), segment.source.number());
            match kind {
                LineKind::Obstacle => (kind, polygon_of(&self.polygon_lines, number)),
                LineKind::BreakLine | LineKind::Wall => (kind, number),
            }
        };
        self.segments.chunk_by(move |one, next| of_line(one) == of_line(next))
    }
}
