//! The commands of `tiletool`, one file or folder per command. The laboratory (`tools/lab`) uses
//! them too.
#![allow(
    missing_docs,
    reason = "the items belong to commands, whose help texts document them"
)]

mod against;
mod allocator;
pub mod bench;
mod build;
pub mod common;
mod compact;
mod constrain;
mod crs;
mod digest;
mod export;
mod flags;
pub mod generate;
mod info;
mod input_args;
mod inspect;
mod limits;
mod lines;
mod numbers;
pub mod output;
pub mod plot;
mod progress;
pub mod query;
mod surface;
mod system;
mod unchanged;
mod units;
mod verify;

use std::io::ErrorKind;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use delaunay_tiles::input::panic_is_caught;
use delaunay_tiles::shown;
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::fmt::format::FmtSpan;

pub use system::Ending;

/// The commands of the tool.
#[derive(Subcommand, Debug)]
pub enum Command {
    Build(build::BuildArgs),
    Constrain(constrain::ConstrainArgs),
    Compact(compact::CompactArgs),
    Info(info::InfoArgs),
    Inspect(inspect::InspectArgs),
    Verify(verify::VerifyArgs),
    Digest(digest::DigestArgs),
    Export(export::ExportArgs),
    Generate(generate::GenerateArgs),
    Query(query::QueryArgs),
    Bench(bench::BenchArgs),
}

/// Runs a program: parses the command line and calls `run` with it. Prints an error in one line.
pub fn start<C: Parser>(run: impl FnOnce(C) -> anyhow::Result<()>) -> ExitCode {
    allocator::begin();
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        // A reader turns this panic into an error.
        if !panic_is_caught() {
            report(panic);
        }
    }));
    let cli = match C::try_parse() {
        Ok(cli) => cli,
        Err(error) => return refuse(&error),
    };
    let done = limits::prepare().and_then(|()| run(cli));
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if common::is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            common::say(format_args!("error: {error:#}"));
            ExitCode::FAILURE
        }
    }
}

/// Sends the library's log to standard error: nothing at level 0, the plan of a build at 1, each
/// step at 2, and everything from 3 on.
pub fn log(verbose: u8) {
    let level = match verbose {
        0 => return,
        1 => LevelFilter::INFO,
        2 => LevelFilter::DEBUG,
        _ => LevelFilter::TRACE,
    };
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_span_events(FmtSpan::CLOSE)
        .with_ansi(false)
        .with_writer(std::io::stderr)
        .init();
}

/// Runs a command.
///
/// # Errors
/// Returns the error of the command.
pub fn run(command: Command) -> anyhow::Result<()> {
    match command {
        Command::Build(args) => build::run(args),
        Command::Constrain(args) => constrain::run(args),
        Command::Compact(args) => compact::run(args),
        Command::Info(args) => info::run(args),
        Command::Inspect(args) => inspect::run(args),
        Command::Verify(args) => verify::run(args),
        Command::Digest(args) => digest::run(args),
        Command::Export(args) => export::run(args),
        Command::Generate(args) => generate::run(args),
        Command::Query(args) => query::run(args),
        Command::Bench(args) => bench::run(args),
    }
}

/// Prints an error of the command line, or the text of `--help` or `--version`.
fn refuse(error: &clap::Error) -> ExitCode {
    let text = error.render().to_string();
    if shown::message(&text) == text {
        let code = ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        return match error.print() {
            Err(failed) if !error.use_stderr() && failed.kind() != ErrorKind::BrokenPipe => {
                common::say(format_args!(
                    "error: cannot write the help to standard output: {failed}"
                ));
                ExitCode::FAILURE
            }
            _ => code,
        };
    }
    // A name on the command line, perhaps of a file that someone else named, must not control the
    // terminal.
    common::say(text.trim_end());
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}
