//! What the library promises, as its user sees it: each module names a promise.
//!
//! What would disturb other tests of the same process has a program of its own: `object_store` measures this process's memory,
//! `refused_ring` has the system refuse calls, and in `concurrency` a checker of interleavings takes the place of the scheduler.

#![allow(clippy::too_many_lines)]

#[path = "../support/mod.rs"]
mod support;

mod bad_input;
mod constraints;
mod edits;
mod export;
mod faults;
mod format;
mod hostile;
mod input;
mod invariance;
mod larger_than_memory;
#[cfg(feature = "geojson")]
mod polygons;
mod proximity;
mod queries;
mod regions;
