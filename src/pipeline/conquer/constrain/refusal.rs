//! Why segments cannot be edges.

use crate::geometry::Point;

/// Two segments cross, or a piece cannot be placed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossed {
    /// A piece, or the end of one.
    pub(crate) piece: [Point; 2],
    /// The constraint that it crosses.
    pub(crate) edge: [Point; 2],
}

/// So many lines run along each other that what edges know of them does not fit in memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Overlaps {
    /// Lines along edges of one node, at least.
    pub(crate) sources: u64,
    /// Where.
    pub(crate) place: Point,
}

/// Why segments cannot be edges.
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
