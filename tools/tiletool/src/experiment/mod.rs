//! `tiletool experiment`: measurements on this machine, as tables, charts and a page of Markdown.
//!
//! Comes in: options. Goes out: a folder with `README.md`, ready to be published, and the tables and pictures that it shows. An
//! experiment writes them in one go when it is through (`folder.rs`), so that one that fails leaves what was there before.
//!
//! ```text
//!   build ────▶ child ──▶ peer       whole processes, measured from outside
//!   stretch                          two distances for the same pairs of vertices
//!   queries                          several methods for the same queries
//!     │
//!     └──▶ table, plot::chart ──▶ folder
//! ```

mod folder;
mod machine;
mod queries;
mod table;

use clap::{Args, Subcommand};

/// Repeat the experiments of docs/experiments.md on this machine.
#[derive(Args, Clone, Debug)]
pub struct ExperimentArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Clone, Debug)]
enum Command {
    Queries(queries::QueriesArgs),
}

/// Measures.
pub fn run(args: ExperimentArgs) -> anyhow::Result<()> {
    match args.command {
        Command::Queries(args) => queries::run(args),
    }
}
