//! The nearest sites along a straight line: for someone on the move, or for all places of a street at once.
//!
//! Comes in: a line and a number. Goes out: its intervals, each with its nearest sites in order. Continuous nearest neighbours among
//! obstacles are a query of Gao and Zheng ("Continuous obstructed nearest neighbor queries in spatial databases", SIGMOD 2009),
//! who compute them on local visibility graphs. However:
//!
//! 1. The line is cut into stretches that nothing blocks. Along one of length *l*, each walking distance changes by *l* at most, so the
//!    sites within the k-th distance from its middle, and *l* more, are all that can count. Long stretches are halved.
//! 2. From each of these sites a wave goes out, as far as it can matter. It tells which parts of the line are seen from which root
//!    ([`wave::parts`](crate::query::wavefront)), so the site's distance is known, exactly, as a function of the place on the line.
//! 3. Where the order of these functions changes ([`envelope`]), an interval ends.
//!
//! Some stretches are taken at a time, few at first, so that intervals come before the whole line is searched, and stand when the search
//! has to end.

mod envelope;
mod interval;
mod intervals;
mod line;
mod search;

pub use interval::{AlongInterval, SiteAlong};
