//! `tiletool inspect`: what is in a tile file.

use std::path::PathBuf;

use clap::Args;

/// Show what is in a tile file.
#[derive(Args, Clone, Debug)]
pub struct InspectArgs {
    /// The tile file
    file: PathBuf,
}

/// Shows what is in a file.
pub fn run(args: InspectArgs) -> anyhow::Result<()> {
    let _ = args.file;
    anyhow::bail!("not yet")
}
