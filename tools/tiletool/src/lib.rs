//! What the command `tiletool` is made of: a file or a folder per command. Beside the command, the laboratory (`tools/lab`) uses it.
#![allow(missing_docs, reason = "what it has is the command's, and documented there")]

mod against;
mod allocator;
pub mod bench;
mod build;
pub mod common;
mod compact;
mod constrain;
mod digest;
mod export;
pub mod generate;
mod input_args;
mod inspect;
mod limits;
mod lines;
pub mod output;
pub mod plot;
mod progress;
pub mod query;
mod system;
mod unchanged;
mod verify;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use delaunay_tiles::input::panic_is_caught;
use delaunay_tiles::shown;
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::fmt::format::FmtSpan;

pub use system::Ending;

/// What the tool can do.
#[derive(Subcommand, Debug)]
pub enum Command {
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
}

/// What a program's `main` does: reads the command line and runs what it says. Errors are told in one line.
pub fn start<C: Parser>(run: impl FnOnce(C) -> anyhow::Result<()>) -> ExitCode {
    allocator::begin();
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        // What a reader catches becomes an error.
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

/// Has the library tell on standard error what it does: nothing, what a build goes by, each step, or all.
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

/// Does what a command says.
///
/// # Errors
/// Whatever the command has to complain of.
pub fn run(command: Command) -> anyhow::Result<()> {
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
