//! The nearest sites along a straight line, for a moving point or for all points of a street at
//! once.
//!
//! The input is a line and a number of sites. The output is intervals of the line, each with its
//! nearest sites in order. Gao and Zheng ("Continuous obstructed nearest neighbor queries in
//! spatial databases", SIGMOD 2009) introduced continuous nearest neighbours among obstacles, and
//! compute them on local visibility graphs. This module works as follows:
//!
//! 1. The line is cut into intervals that nothing blocks. Along an interval of length *l*, each
//!    walking distance changes by at most *l*, so only sites within the distance of the k-th site
//!    from its middle, plus *l*, can be among the nearest. Long intervals are halved.
//! 2. A wavefront starts at each of these sites, and goes as far as it can matter. It returns which
//!    parts of the line each root sees ([`wavefront`](crate::query::wavefront)), so the site's
//!    distance is known exactly as a function of the position on the line.
//! 3. Where the order of these functions changes ([`envelope`]), an interval ends.
//!
//! The intervals are processed in groups, small ones first. So results come before the whole line
//! is searched, and remain valid if the search has to stop.

mod envelope;
mod interval;
mod intervals;
mod line;
mod search;

pub use interval::{AlongInterval, SiteAlong};
