//! The reasons why segments cannot become edges.

use crate::geometry::Point;

/// Two segments cross, or a subsegment cannot be inserted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossed {
    /// A subsegment, or the rest of one.
    pub(crate) subsegment: [Point; 2],
    /// The constraint that it crosses.
    pub(crate) edge: [Point; 2],
}

/// The sources of overlapping lines do not fit in memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Overlaps {
    /// Number of subsegments on the edges of one node, at least.
    pub(crate) sources: u64,
    /// A point on the overlapping lines.
    pub(crate) point: Point,
}

/// The reason why segments cannot become edges.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Refusal {
    Crossed(Crossed),
    Overlaps(Overlaps),
}

impl From<Crossed> for Refusal {
    fn from(crossed: Crossed) -> Self {
        Self::Crossed(crossed)
    }
}
