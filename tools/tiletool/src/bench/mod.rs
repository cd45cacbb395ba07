//! `tiletool bench`: how fast this machine does what the library promises.

pub mod caches;
mod device;
mod map;
mod read;
mod report;
mod took;

use clap::{Args, Subcommand};

/// Measure how fast tile files are read on this machine, beside what it can do at best.
#[derive(Args, Clone, Debug)]
pub struct BenchArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Clone, Debug)]
enum Command {
    Read(read::ReadArgs),
}

/// Measures.
pub fn run(args: BenchArgs) -> anyhow::Result<()> {
    match args.command {
        Command::Read(args) => read::run(args),
    }
}
