//! The promise: any number of tasks read through one cache and get right answers, when callers are
//! cancelled, when tiles are evicted, and when the file is replaced or removed meanwhile.

#[path = "../support/mod.rs"]
mod support;

mod interleavings;
mod readers;
