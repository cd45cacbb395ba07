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

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
struct DigestReport {
    triangles: u64,
    triangles_digest: String,
    vertices: u64,
    vertices_digest: String,
    constraint_edges: u64,
    constraint_edges_digest: String,
    hole_triangles: u64,
    hole_triangles_digest: String,
    peak_memory_bytes: Option<u64>,
}

/// Prints the digest of a tile file.
pub fn run(args: DigestArgs) -> anyhow::Result<()> {
    let digest = common::block_on(async { Ok(args.memory.open(&args.file).await?.digest().await?) })?;
    if !args.json {
        return common::print("the digest", &format!("{digest}\n"));
    }
    let sum = |part: DigestSum| format!("{:032x}", part.sum);
    common::print_json(
        "the digest",
        &DigestReport {
            triangles: digest.triangles.count,
            triangles_digest: sum(digest.triangles),
            vertices: digest.vertices.count,
            vertices_digest: sum(digest.vertices),
            constraint_edges: digest.constraint_edges.count,
            constraint_edges_digest: sum(digest.constraint_edges),
            hole_triangles: digest.holes.count,
            hole_triangles_digest: sum(digest.holes),
            peak_memory_bytes: peak_memory(),
        },
    )
}
