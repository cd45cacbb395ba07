//! Tests of the tool from the command line. Each test runs it in separate processes.

#![allow(clippy::too_many_lines)]

#[path = "../support/mod.rs"]
mod support;

mod against;
#[cfg(feature = "pmtiles")]
mod archive;
mod backends;
mod bench;
mod changed;
mod cli;
mod compress;
mod constrain;
mod contours;
mod crs;
mod digest;
mod drape;
mod export;
mod faults;
mod info;
mod input_tasks;
mod inside_out;
mod inspect;
mod keep_edges;
mod limits;
mod lines;
mod log;
mod map;
mod memory;
mod outputs;
mod overviews;
mod pictures;
mod points;
mod printing;
mod query;
mod query_tables;
mod refusals;
mod resume;
#[cfg(feature = "serve")]
mod serve;
mod shell;
mod sites;
mod tasks;
mod terrain;
mod town;
mod vector;
#[cfg(feature = "object-store")]
mod web;

/// The web server of the library's tests.
#[cfg(feature = "object-store")]
#[path = "../../../../tests/object_store/server.rs"]
mod server;

/// The program that the tests run.
const PROGRAM: &str = env!("CARGO_BIN_EXE_tiletool");
