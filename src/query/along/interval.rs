//! Parts of a line with their nearest sites.

use crate::geometry::Point;
use crate::store::Vertex;

/// A part of a straight line on which the nearest sites, and their order, stay the same.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct AlongInterval {
    /// Where it starts: 0 at the start of the line, 1 at its end.
    pub from_t: f64,
    /// Where it ends.
    pub to_t: f64,
    /// The point where it starts, rounded.
    pub from: Point,
    /// The point where it ends, rounded.
    pub to: Point,
    /// The nearest sites, the nearest first; fewer than were asked for if no more can be reached. None: it lies in an obstacle.
    pub sites: Option<Vec<SiteAlong>>,
}

/// A site that is among the nearest on an interval.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SiteAlong {
    /// Its number, from 0 over all inputs.
    pub number: u64,
    /// Its id, if the input gave it one.
    pub id: Option<String>,
    /// The vertex at which it lies.
    pub vertex: Vertex,
    /// How far it is from the start of the interval and from its end, within a part in 10^12.
    pub distances: [f64; 2],
}
