//! The promise: any number of tasks read through one cache and get right answers, whoever goes away, whatever is evicted, and
//! whatever happens meanwhile to the file's name.

#[path = "../support/mod.rs"]
mod support;

mod interleavings;
mod readers;
