//! The laboratory: measurements on this machine, as tables, charts and a page of Markdown.
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
//!   query                            questions to a tile file, answered by one of the methods
//! ```

mod build;
mod folder;
mod machine;
mod peer;
mod pictures;
mod plot;
mod queries;
mod query;
mod stretch;
mod table;
mod tiles;
mod work;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use tiletool::Ending;

/// As the tool has it: builds that are measured are this program.
#[global_allocator]
static ALLOCATOR: Ending = Ending;

/// Repeat the experiments of docs/experiments.md on this machine.
#[derive(Parser, Debug)]
#[command(
    name = "lab",
    version,
    max_term_width = 110,
    after_help = "Example:\n  lab build -o results --sizes 1M,4M,16M"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    Build(build::BuildExperimentArgs),
    Stretch(stretch::StretchArgs),
    Queries(queries::QueriesArgs),
    Query(query::QueryArgs),
    #[command(hide = true)]
    Peer(peer::PeerArgs),
    /// What tiletool does; experiments run it in processes of their own
    #[command(hide = true)]
    Tool(ToolArgs),
}

#[derive(clap::Args, Debug)]
struct ToolArgs {
    #[command(subcommand)]
    command: tiletool::Command,
}

fn main() -> ExitCode {
    tiletool::start(|cli: Cli| match cli.command {
        Command::Build(args) => build::run(args),
        Command::Stretch(args) => stretch::run(args),
        Command::Queries(args) => queries::run(args),
        Command::Query(args) => query::run(&args),
        Command::Peer(args) => peer::run(args),
        Command::Tool(args) => tiletool::run(args.command),
    })
}
