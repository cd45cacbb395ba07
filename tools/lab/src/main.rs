//! The laboratory: measurements on this machine, as tables, charts and a page of Markdown.
//!
//! The input is options. The output is a folder with `README.md`, ready to be published, and the
//! tables and pictures that it shows. An experiment writes them together at its end (`folder.rs`),
//! so a failed experiment leaves the old results.
//!
//! ```text
//!   build ────▶ child ──▶ peer       whole processes, measured from outside
//!   stretch                          two distances for the same pairs of vertices
//!   queries                          several methods for the same queries
//!     │
//!     └──▶ table, plot::chart ──▶ folder
//!   steps                            the steps of a build, as pictures of a page
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
mod steps;
mod stretch;
mod table;
mod tiles;
mod work;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use tiletool::{Ending, ToolArgs};

/// The allocator of the tool: builds that are measured run in this program.
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
    Steps(steps::StepsArgs),
    #[command(hide = true)]
    Peer(peer::PeerArgs),
    /// The commands of tiletool; experiments run them in processes of their own
    #[command(hide = true)]
    Tool(Box<ToolArgs>),
}

fn main() -> ExitCode {
    tiletool::start(|cli: Cli| match cli.command {
        Command::Build(args) => build::run(args),
        Command::Stretch(args) => stretch::run(args),
        Command::Queries(args) => queries::run(args),
        Command::Query(args) => query::run(&args),
        Command::Steps(args) => steps::run(&args),
        Command::Peer(args) => peer::run(args),
        Command::Tool(args) => tiletool::run(*args),
    })
}
