//! The command line tool of delaunay-tiles.

use std::process::ExitCode;

use clap::Parser;
use tiletool::{Command, Ending};

/// The global allocator. A failed allocation ends the tool with an error.
#[global_allocator]
static ALLOCATOR: Ending = Ending;

/// Build, query and verify Delaunay triangulations larger than memory, kept as tiles in one file.
#[derive(Parser, Debug)]
#[command(name = "tiletool", version, max_term_width = 110, after_help = EXAMPLES)]
struct Cli {
    /// Log to standard error: -v how memory is divided, -vv each step, -vvv all details
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  tiletool info survey.laz
  tiletool build survey.laz -o survey.tiles
  tiletool inspect survey.tiles --plot survey.png
  tiletool verify --deep survey.tiles --against survey.laz
  tiletool query path town.tiles --from 0,0 --to 8,8

Exit codes: 0 success, 1 failure, 2 wrong usage.";

fn main() -> ExitCode {
    tiletool::start(|cli: Cli| {
        tiletool::log(cli.verbose);
        tiletool::run(cli.command)
    })
}
