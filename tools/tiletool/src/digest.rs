//! `tiletool digest`: a digest of the triangulation that does not depend on the tiles.

use std::path::PathBuf;

use clap::Args;
use delaunay_tiles::peak_memory;
use delaunay_tiles::store::DigestSum;
use serde::Serialize;

use crate::common::{self, MemoryArgs};

/// Print a digest of the triangulation, independent of its tiles
///
/// Files with the same triangulation have the same digest, whatever the tile size, memory, threads
/// or engine of their builds.
///
/// The digest has one line each for triangles, vertices, constraint edges and holes: name, count,
/// and the sum modulo 2^128 of the XXH3 hashes of their coordinates.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:\n  tiletool digest survey.tiles")]
pub struct DigestArgs {
    /// Tile file to read
    file: PathBuf,
    /// Print the result as one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    memory: MemoryArgs,
}

#[derive(Serialize)]
struct PartDigest {
    count: u64,
    digest: String,
}

#[derive(Serialize)]
struct DigestReport {
    triangles: PartDigest,
    vertices: PartDigest,
    constraint_edges: PartDigest,
    holes: PartDigest,
    peak_memory_bytes: Option<u64>,
}

/// Prints the digest of a tile file.
pub fn run(args: DigestArgs) -> anyhow::Result<()> {
    let digest = common::block_on(async { Ok(args.memory.open(&args.file).await?.digest().await?) })?;
    if !args.json {
        return common::print(&format!("{digest}\n"));
    }
    let sum = |DigestSum { count, sum }| PartDigest {
        count,
        digest: format!("{sum:032x}"),
    };
    common::print_json(&DigestReport {
        triangles: sum(digest.triangles),
        vertices: sum(digest.vertices),
        constraint_edges: sum(digest.constraint_edges),
        holes: sum(digest.holes),
        peak_memory_bytes: peak_memory(),
    })
}
