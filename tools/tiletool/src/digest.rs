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
/// The digest has one line each for triangles, vertices, constraint edges, triangles in holes,
/// vertices with their z, sources of edges and sites: name, count, and the sum modulo 2^128 of
/// their XXH3 hashes.
///
/// A file stores its digest, so the answer comes at once. `--recompute` reads every tile instead.
/// `tiletool verify` compares both.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:\n  tiletool digest survey.tiles\n  tiletool digest --recompute survey.tiles")]
pub struct DigestArgs {
    /// Tile file to read
    file: PathBuf,
    /// Compute the digest from the tiles
    #[arg(long)]
    recompute: bool,
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
    vertices_with_z: u64,
    vertices_with_z_digest: String,
    edge_sources: u64,
    edge_sources_digest: String,
    sites: u64,
    sites_digest: String,
    recomputed: bool,
    peak_memory_bytes: Option<u64>,
}

/// Prints the digest of a tile file.
pub fn run(args: DigestArgs) -> anyhow::Result<()> {
    let digest = common::wait_for("reading the tiles", async {
        let reader = args.memory.open(&args.file).await?;
        match args.recompute {
            true => Ok(reader.recompute_digest().await?),
            false => Ok(reader.metadata().digest),
        }
    })?;
    if !args.json {
        common::print("the digest", &format!("{digest}\n"))?;
        if !args.recompute {
            common::note("this is the digest that the file stores; --recompute computes it from the tiles");
        }
        return Ok(());
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
            vertices_with_z: digest.vertices_with_z.count,
            vertices_with_z_digest: sum(digest.vertices_with_z),
            edge_sources: digest.edge_sources.count,
            edge_sources_digest: sum(digest.edge_sources),
            sites: digest.sites.count,
            sites_digest: sum(digest.sites),
            recomputed: args.recompute,
            peak_memory_bytes: peak_memory(),
        },
    )
}
