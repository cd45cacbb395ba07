//! `tiletool checkpoint`: makes the changes in a file that are in its log.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use delaunay_tiles::store::pending_transactions;
use delaunay_tiles::{EditOptions, Editor, OpenOptions};
use serde::Serialize;

use crate::allocator;
use crate::common::{self, MemoryArgs, counted, shown};

/// Make the changes in a file that are in its log
///
/// A service that edits with durability `log` appends its transactions to FILE.log, and makes them in the
/// file from time to time. If it ended before, this makes them. Every command that changes the file does
/// so, too, before its own changes.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:
  tiletool checkpoint survey.tiles")]
pub struct CheckpointArgs {
    /// Tile file to change
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Print the result as one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    memory: MemoryArgs,
}

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
struct CheckpointReport {
    transactions: u64,
    vertices: u64,
    file_bytes: u64,
}

/// Makes the changes that are in the log.
pub fn run(args: CheckpointArgs) -> anyhow::Result<()> {
    allocator::keep_to(0);
    let options = EditOptions::default().memory(args.memory.bytes());
    let report = common::wait_for("making the changes", async {
        let before = common::open_file(&args.file, OpenOptions::default()).await?;
        let transactions = pending_transactions(&args.file, &before).await?;
        drop(before);
        let unchanged = || format!("{} was not changed", shown(&args.file));
        Editor::open(&args.file, options).await.with_context(unchanged)?;
        let after = common::open_file(&args.file, OpenOptions::default()).await?;
        Ok(CheckpointReport {
            transactions,
            vertices: after.metadata().vertices,
            file_bytes: after.file_length(),
        })
    })?;
    if args.json {
        return common::print_json("the summary", &report);
    }
    let text = match report.transactions {
        0 => "its log has no transactions".to_owned(),
        made => format!(
            "made {}; the file has {}",
            counted(made, "transaction", "transactions"),
            counted(report.vertices, "vertex", "vertices")
        ),
    };
    common::print_summary("the summary", &format!("{}: {text}\n", shown(&args.file)))
}
