//! `tiletool experiment`: measurements on this machine, as tables, charts and a page of Markdown.
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
//! ```

mod build;

mod folder;

mod machine;
mod peer;
mod queries;
mod stretch;
mod table;
mod tiles;

use std::future::Future;

use anyhow::bail;
use clap::{Args, Subcommand, ValueEnum};

use crate::common;

/// Repeat the experiments of docs/experiments.md on this machine.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:\n  tiletool experiment build -o results --sizes 1M,4M,16M")]
pub struct ExperimentArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Clone, Debug)]
enum Command {
    Build(build::BuildExperimentArgs),
    Stretch(stretch::StretchArgs),
    Queries(queries::QueriesArgs),
    #[command(hide = true)]
    Peer(peer::PeerArgs),
}

/// How pictures are written.
#[derive(Args, Clone, Copy, Debug)]
pub struct Pictures {
    /// The format of the pictures
    #[arg(long, value_name = "svg|png", default_value = "svg")]
    pictures: Format,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    Svg,
    Png,
}

impl Pictures {
    /// The name of a picture's file.
    pub fn name(self, stem: &str) -> String {
        let suffix = match self.pictures {
            Format::Svg => "svg",
            Format::Png => "png",
        };
        format!("{stem}.{suffix}")
    }
}

/// Runs the asynchronous part of an experiment, until it is done or Ctrl-C ends it.
fn block_on<T>(work: impl Future<Output = anyhow::Result<T>>) -> anyhow::Result<T> {
    common::block_on(async {
        tokio::select! {
            done = work => done,
            _ = tokio::signal::ctrl_c() => bail!("interrupted; nothing was written"),
        }
    })
}

/// Measures.
pub fn run(args: ExperimentArgs) -> anyhow::Result<()> {
    match args.command {
        Command::Build(args) => build::run(args),
        Command::Stretch(args) => stretch::run(args),
        Command::Peer(args) => peer::run(args),
        Command::Queries(args) => queries::run(args),
    }
}
