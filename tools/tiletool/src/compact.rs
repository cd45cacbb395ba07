//! `tiletool compact`: rewrites a tile file without the bytes that edits left unused.

use std::fs::File;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use delaunay_tiles::io::{open_regular, output_target};
use delaunay_tiles::store::OpenOptions;
use serde::Serialize;

use crate::common;

/// Rewrite a tile file without the bytes that edits left unused
///
/// The new file has the same tiles, in their order, without the bytes that `tiletool constrain`
/// left unused. It replaces the old file in one step when it is complete. Readers that have the old
/// file open continue with it. With --output, a file in parts, or one elsewhere, becomes one file here.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool compact survey.tiles
  tiletool compact s3://maps/survey.tiles.parts -o survey.tiles")]
pub struct CompactArgs {
    /// Tile file to compact
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// File to write [default: replace the tile file]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace the output if it exists
    #[arg(long, requires = "output")]
    force: bool,
    /// Print the result as one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct CompactReport {
    bytes_before: u64,
    bytes_after: u64,
}

/// Rewrites a tile file.
pub fn run(args: CompactArgs) -> anyhow::Result<()> {
    let output = args.output.as_ref().unwrap_or(&args.file);
    if args.output.is_some() && !args.force && output.exists() {
        anyhow::bail!("{} exists already; give --force to replace it", common::shown(output));
    }
    let is_elsewhere = common::url(&args.file).is_some();
    anyhow::ensure!(
        !is_elsewhere || args.output.is_some(),
        "{}: it cannot be replaced there; give --output",
        common::shown(&args.file)
    );
    let _lock = (!is_elsewhere).then(|| lock(&args.file)).transpose()?;
    let (bytes_before, bytes_after) = common::wait_for("compacting", async {
        let reader = common::open(&args.file, OpenOptions::default()).await?;
        Ok((reader.file_length(), reader.compact(output).await?))
    })?;
    if args.json {
        return common::print_json(
            "the summary",
            &CompactReport {
                bytes_before,
                bytes_after,
            },
        );
    }
    common::print_summary(
        "the summary",
        &format!(
            "{}: compacted from {} to {}\n",
            common::shown(output),
            common::bytes(bytes_before),
            common::bytes(bytes_after)
        ),
    )
}

/// Locks a file, so that no other process changes it.
fn lock(path: &Path) -> anyhow::Result<File> {
    // A process that edits the file holds a lock on it.
    let opened = output_target(path).and_then(|file| open_regular(&file, File::options().read(true)));
    let (file, _) = opened.with_context(|| common::shown(path))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(_) => anyhow::bail!(
            "{}: another process is changing the file; try again later",
            common::shown(path)
        ),
    }
}
