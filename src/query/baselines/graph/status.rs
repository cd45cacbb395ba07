//! The edges that the ray of a sweep crosses, nearest first.

use std::cmp::Ordering;
use std::collections::BTreeSet;

use crate::geometry::{Orientation, Point, orient2d};

/// An edge that the ray crosses. It starts where the ray meets it first, so the center of the sweep
/// is on its left.
///
/// Edges that a common ray crosses have an order along it. The order is the same for every such
/// ray, because the edges do not cross each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossed {
    pub(super) start: Point,
    pub(super) end: Point,
    pub(super) edge: u32,
}

impl Crossed {
    fn turns(&self, other: &Self) -> [Orientation; 2] {
        [other.start, other.end].map(|end| orient2d(self.start, self.end, end))
    }
}

impl Ord for Crossed {
    fn cmp(&self, other: &Self) -> Ordering {
        if self.edge == other.edge {
            return Ordering::Equal;
        }
        let turns = self.turns(other);
        match turns {
            [Orientation::Collinear, Orientation::Collinear] => self.edge.cmp(&other.edge),
            // The other edge is on the same side as the center.
            _ if !turns.contains(&Orientation::Clockwise) => Ordering::Greater,
            _ if !turns.contains(&Orientation::CounterClockwise) => Ordering::Less,
            // The other edge is on both sides of this one's line, so this edge is on one side of
            // the other's.
            _ if !other.turns(self).contains(&Orientation::Clockwise) => Ordering::Less,
            _ => Ordering::Greater,
        }
    }
}

impl PartialOrd for Crossed {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Crossed {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Crossed {}

/// The edges that the ray crosses.
pub(super) type Status = BTreeSet<Crossed>;
