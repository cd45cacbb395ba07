//! Intervals of a line with their nearest sites.

use crate::geometry::Point;
use crate::store::Vertex;

/// An interval of a straight line on which the nearest sites and their order stay the same.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct AlongInterval {
    /// The start of the interval: 0 is the start of the line, 1 its end.
    pub from_t: f64,
    /// The end of the interval, on the same scale.
    pub to_t: f64,
    /// The point at the start, rounded.
    pub from: Point,
    /// The point at the end, rounded.
    pub to: Point,
    /// The nearest sites, nearest first; fewer than requested if no more can be reached. `None` if
    /// the interval is in an obstacle.
    pub sites: Option<Vec<SiteAlong>>,
}

/// A site that is among the nearest on an interval.
///
/// [Examples](crate::query#examples).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SiteAlong {
    /// The number of the site, counted from 0 over all inputs.
    pub number: u64,
    /// The id of the site, if the input gave it one.
    pub id: Option<String>,
    /// The vertex of the site.
    pub vertex: Vertex,
    /// The distances of the site from the start and from the end of the interval, with a relative
    /// error of at most 10^-12.
    pub distances: [f64; 2],
}
