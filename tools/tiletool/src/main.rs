//! The command line of delaunay-tiles: a file or a folder per command.

use std::process::ExitCode;

use clap::Parser;
use tiletool::{Command, Ending};

/// A refusal of memory ends the tool with an error.
#[global_allocator]
static ALLOCATOR: Ending = Ending;

/// Delaunay triangulations larger than memory, kept as tiles in one file.
#[derive(Parser, Debug)]
#[command(name = "tiletool", version, max_term_width = 110, after_help = EXAMPLES)]
struct Cli {
    /// Tell on standard error what is done: -v who gets how much memory, -vv each step
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Example:
  tiletool build survey.laz -o survey.tiles
  tiletool inspect survey.tiles --plot survey.png
  tiletool verify --deep survey.tiles --against survey.laz
  tiletool query path town.tiles --from 0,0 --to 8,8

Exit codes: 0 done, 1 failed, 2 wrong usage.";

fn main() -> ExitCode {
    tiletool::start(|cli: Cli| {
        tiletool::log(cli.verbose);
        tiletool::run(cli.command)
    })
}
