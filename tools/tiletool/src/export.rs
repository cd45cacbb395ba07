//! `tiletool export`: the triangulation in formats that other programs read.

use std::path::PathBuf;

use clap::Args;

/// Write the triangulation in another format: PLY, Triangle's .node and .ele, OBJ or GeoJSON.
#[derive(Args, Clone, Debug)]
pub struct ExportArgs {
    /// The tile file
    file: PathBuf,
}

/// Exports a file.
pub fn run(args: ExportArgs) -> anyhow::Result<()> {
    let _ = args.file;
    anyhow::bail!("not yet")
}
