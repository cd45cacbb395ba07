//! The laboratory as its users run it, and the kernel that was not chosen.

#[path = "../../../tiletool/tests/support/mod.rs"]
mod support;

mod experiment;
mod incremental;
mod methods;
mod steps;

/// The program that the tests run.
const PROGRAM: &str = env!("CARGO_BIN_EXE_lab");
