//! `tiletool compact`: writes a file anew without what edits left behind.

use std::fs::File;
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use delaunay_tiles::io::{open_regular, output_target};
use delaunay_tiles::store::{OpenOptions, TileReader};
use serde::Serialize;

use crate::common;

/// Write a tile file anew, in the order of its tiles and without the bytes that `tiletool constrain` has left unused.
///
/// Its tiles stay as they are. The file is replaced at once when all is written; readers that have it open go on with the old one.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:
  tiletool compact survey.tiles")]
pub struct CompactArgs {
    /// The tile file
    #[arg(value_name = "FILE.tiles")]
    file: PathBuf,
    /// Where to write it, if not in its own place
    #[arg(short, long, value_name = "FILE.tiles")]
    output: Option<PathBuf>,
    /// Replace the output if it exists
    #[arg(long, requires = "output")]
    force: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Output {
    bytes_before: u64,
    bytes_after: u64,
}

/// Writes a file anew.
pub fn run(args: CompactArgs) -> anyhow::Result<()> {
    let output = args.output.as_ref().unwrap_or(&args.file);
    if args.output.is_some() && !args.force && output.exists() {
        anyhow::bail!("{} exists; give --force to replace it", common::shown(output));
    }
    // Whoever edits it has it locked.
    let lock = output_target(&args.file).and_then(|file| open_regular(&file, File::options().read(true)));
    let (lock, _) = lock.with_context(|| common::shown(&args.file))?;
    if lock.try_lock().is_err() {
        anyhow::bail!(
            "{}: somebody else is changing it; try again later",
            common::shown(&args.file)
        );
    }
    let (bytes_before, bytes_after) = common::block_on(async {
        let reader = TileReader::open(&args.file, OpenOptions::default()).await?;
        Ok((reader.file_length(), reader.compact(output).await?))
    })?;
    if args.json {
        return common::print_json(&Output {
            bytes_before,
            bytes_after,
        });
    }
    common::print(&format!(
        "{}: {}, before {}\n",
        common::shown(output),
        common::bytes(bytes_after),
        common::bytes(bytes_before)
    ))
}
