//! What the library promises of builds, of what they read, and of the files that they write: each module names a promise.
//!
//! Tests that would disturb other tests of the same process are programs of their own:
//! `object_store` measures the process's memory, `refused_ring` has the system refuse calls, and in
//! `concurrency` a checker of interleavings replaces the scheduler.

#![allow(clippy::too_many_lines)]

#[path = "../support/mod.rs"]
mod support;

mod bad_input;
mod compression;
mod constraints;
mod faults;
mod format;
mod held;
mod hostile;
mod input;
mod invariance;
mod larger_than_memory;
mod polygons;
mod regions;
