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
pub mod crs;
mod digest;
#[cfg(all(test, feature = "geopackage", feature = "object-store", feature = "parquet"))]
mod documented;
mod edit;
pub mod export;
mod flags;
pub mod generate;
mod groups;
mod info;
pub mod input_args;
mod inspect;
mod limits;
pub mod lines;
mod log;
mod numbers;
pub mod output;
mod overviews;
pub mod plot;
pub mod points;
mod progress;
pub mod query;
mod quiet;
#[cfg(feature = "serve")]
mod serve;
mod shell;
mod surface;
mod system;
pub mod task;
mod unchanged;
mod verify;

use std::ffi::OsString;
use std::io::ErrorKind;
use std::process::ExitCode;

use clap::{Args, CommandFactory, Parser, Subcommand};
use delaunay_tiles::input::panic_is_caught;
use delaunay_tiles::shown;

pub use anyhow::Error;
pub use system::Ending;

/// Build, query and verify Delaunay triangulations larger than memory, kept as tiles in one file.
#[derive(Parser, Debug)]
#[command(name = "tiletool", version, max_term_width = 110, after_help = EXAMPLES)]
struct Cli {
    #[command(flatten)]
    tool: ToolArgs,
}

/// A command, and what concerns all commands.
#[derive(Args, Debug)]
pub struct ToolArgs {
    /// Log to standard error: -v how memory is divided, -vv each step, -vvv all details. RUST_LOG
    /// chooses by module, as delaunay_tiles::io=debug
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    /// Print only what was asked for, and errors: no summary, no notes, no progress
    #[arg(short, long, global = true)]
    quiet: bool,
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
  tiletool serve town.tiles

`tiletool COMMAND --help` has the options of a command, and examples.
Exit codes: 0 success, 1 failure, 2 wrong usage.";

/// The exit codes.
const SUCCESS: u8 = 0;
const FAILURE: u8 = 1;

/// The commands of the tool.
#[derive(Subcommand, Debug)]
pub enum Command {
    Build(build::BuildArgs),
    Task(task::TaskArgs),
    Insert(edit::points::InsertArgs),
    Delete(edit::points::DeleteArgs),
    Move(edit::points::MoveArgs),
    SetZ(edit::points::SetZArgs),
    Constrain(edit::constrain::ConstrainArgs),
    Unconstrain(edit::unconstrain::UnconstrainArgs),
    Checkpoint(edit::checkpoint::CheckpointArgs),
    Compact(compact::CompactArgs),
    Overviews(overviews::OverviewsArgs),
    Info(info::InfoArgs),
    Inspect(inspect::InspectArgs),
    Verify(verify::VerifyArgs),
    Digest(digest::DigestArgs),
    Export(export::ExportArgs),
    Generate(generate::GenerateArgs),
    Query(query::QueryArgs),
    #[cfg(feature = "serve")]
    Serve(serve::ServeArgs),
    Bench(bench::BenchArgs),
    Completions(shell::CompletionsArgs),
    Man(shell::ManArgs),
}

/// Runs the tool with these arguments, the first of which is its name. Returns its exit code.
pub fn tiletool(args: impl IntoIterator<Item = OsString>) -> u8 {
    start_with(groups::grouped(Cli::command()), args, |cli: Cli| run(cli.tool))
}

/// Runs a program: parses the arguments of the process and calls `run` with them. Prints an error in one
/// line.
pub fn start<C: Parser>(run: impl FnOnce(C) -> anyhow::Result<()>) -> ExitCode {
    start_with(C::command(), std::env::args_os(), run).into()
}

/// Runs a program, whose command line is that of `command`, with these arguments. Returns the exit code.
fn start_with<C: Parser>(
    mut command: clap::Command,
    args: impl IntoIterator<Item = OsString>,
    run: impl FnOnce(C) -> anyhow::Result<()>,
) -> u8 {
    allocator::begin();
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        // A reader turns this panic into an error.
        if !panic_is_caught() {
            report(panic);
        }
    }));
    let parsed = command.try_get_matches_from_mut(args);
    let parsed = parsed.and_then(|matches| C::from_arg_matches(&matches).map_err(|error| error.format(&mut command)));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => return refuse(&error),
    };
    let done = limits::prepare().and_then(|()| run(cli));
    match done {
        Ok(()) => SUCCESS,
        Err(error) if common::is_broken_pipe(&error) => SUCCESS,
        Err(error) => {
            common::say(format_args!("error: {error:#}"));
            FAILURE
        }
    }
}

/// Runs a command.
///
/// # Errors
/// Returns the error of the command.
pub fn run(tool: ToolArgs) -> anyhow::Result<()> {
    quiet::set(tool.quiet);
    log::start(tool.verbose);
    match tool.command {
        Command::Build(args) => build::run(args),
        Command::Task(args) => task::run(args),
        Command::Insert(args) => edit::points::insert(args),
        Command::Delete(args) => edit::points::delete(args),
        Command::Move(args) => edit::points::move_points(args),
        Command::SetZ(args) => edit::points::set_z(args),
        Command::Constrain(args) => edit::constrain::run(args),
        Command::Unconstrain(args) => edit::unconstrain::run(args),
        Command::Checkpoint(args) => edit::checkpoint::run(args),
        Command::Compact(args) => compact::run(args),
        Command::Overviews(args) => overviews::run(args),
        Command::Info(args) => info::run(args),
        Command::Inspect(args) => inspect::run(args),
        Command::Verify(args) => verify::run(args),
        Command::Digest(args) => digest::run(args),
        Command::Export(args) => export::run(args),
        Command::Generate(args) => generate::run(args),
        Command::Query(args) => query::run(args),
        #[cfg(feature = "serve")]
        Command::Serve(args) => serve::run(&args),
        Command::Bench(args) => bench::run(args),
        Command::Completions(args) => shell::complete(&args),
        Command::Man(args) => shell::describe(&args),
    }
}

/// Prints an error of the command line, or the text of `--help` or `--version`.
fn refuse(error: &clap::Error) -> u8 {
    let text = error.render().to_string();
    if shown::message(&text) == text {
        let code = u8::try_from(error.exit_code()).unwrap_or(2);
        return match error.print() {
            Err(failed) if !error.use_stderr() && failed.kind() != ErrorKind::BrokenPipe => {
                common::say(format_args!(
                    "error: cannot write the help to standard output: {failed}"
                ));
                FAILURE
            }
            _ => code,
        };
    }
    // A name on the command line, perhaps of a file that someone else named, must not control the
    // terminal.
    common::say(text.trim_end());
    u8::try_from(error.exit_code()).unwrap_or(2)
}
