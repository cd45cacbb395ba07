//! `tiletool bench`: measures how fast this machine reads tile files.

pub mod caches;
mod decode;
mod device;
mod map;
mod measurement;
mod read;
mod report;

use clap::{Args, Subcommand};

/// Measure how fast tile files are read, compared with the bare device
#[derive(Args, Clone, Debug)]
pub struct BenchArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Clone, Debug)]
enum Command {
    Read(read::ReadArgs),
    Decode(decode::DecodeArgs),
}

/// Runs the benchmark.
pub fn run(args: BenchArgs) -> anyhow::Result<()> {
    match args.command {
        Command::Read(args) => read::run(args),
        Command::Decode(args) => decode::run(args),
    }
}
