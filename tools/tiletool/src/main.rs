//! The command line of delaunay-tiles: a file or a folder per command.

mod against;
mod allocator;
mod bench;
mod build;
mod common;
mod compact;
mod constrain;
mod digest;
mod experiment;
mod export;
mod generate;
mod input_args;
mod inspect;
mod limits;
mod lines;
mod output;
mod plot;
mod progress;
mod query;
mod system;
mod unchanged;
mod verify;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use delaunay_tiles::input::panic_is_caught;
use delaunay_tiles::shown;

/// Delaunay triangulations larger than memory, kept as tiles in one file.
#[derive(Parser, Debug)]
#[command(name = "tiletool", version, max_term_width = 110, after_help = EXAMPLES)]
struct Cli {
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

#[derive(Subcommand, Debug)]
enum Command {
    Build(build::BuildArgs),
    Constrain(constrain::ConstrainArgs),
    Compact(compact::CompactArgs),
    Inspect(inspect::InspectArgs),
    Verify(verify::VerifyArgs),
    Digest(digest::DigestArgs),
    Export(export::ExportArgs),
    Generate(generate::GenerateArgs),
    Query(query::QueryArgs),
    Bench(bench::BenchArgs),
    Experiment(experiment::ExperimentArgs),
}

fn main() -> ExitCode {
    allocator::begin();
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        // What a reader catches becomes an error.
        if !panic_is_caught() {
            report(panic);
        }
    }));
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return refuse(&error),
    };
    let done = limits::prepare().and_then(|()| run(cli.command));
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if common::is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            common::say(format_args!("error: {error:#}"));
            ExitCode::FAILURE
        }
    }
}

fn run(command: Command) -> anyhow::Result<()> {
    match command {
        Command::Build(args) => build::run(args),
        Command::Constrain(args) => constrain::run(args),
        Command::Compact(args) => compact::run(args),
        Command::Inspect(args) => inspect::run(args),
        Command::Verify(args) => verify::run(args),
        Command::Digest(args) => digest::run(args),
        Command::Export(args) => export::run(args),
        Command::Generate(args) => generate::run(args),
        Command::Query(args) => query::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Experiment(args) => experiment::run(args),
    }
}

/// Says that the command line is not understood, or what was asked for with `--help`.
fn refuse(error: &clap::Error) -> ExitCode {
    let text = error.render().to_string();
    if shown::message(&text) == text {
        error.exit();
    }
    // A name on the command line, perhaps of a file that others named, would command the terminal.
    common::say(text.trim_end());
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}
