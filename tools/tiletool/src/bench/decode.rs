//! `tiletool bench decode`: the time from the stored bytes of a tile, in memory, to an open tile.

use std::path::PathBuf;

use anyhow::Context;
use bytes::Bytes;
use clap::Args;
use delaunay_tiles::store::{Cache, OpenOptions, TileEntry, TileId, TileReader};
use serde::Serialize;

use super::measurement::{Clock, Measurement};
use crate::common;

/// Measure how fast tiles are decoded and checked on one core, from memory
///
/// Checksums and ranges are checked too, so measure a file with and one without --compress: the
/// difference is the time of decoding. The whole file is read into memory first. The result is the
/// fastest of several rounds. 1 GB is 10^9 bytes of decoded tiles.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:\n  tiletool bench decode survey.tiles --rounds 10")]
pub struct DecodeArgs {
    /// Tile file to read
    file: PathBuf,
    /// Print the result as one JSON object
    #[arg(long)]
    json: bool,
    /// Number of rounds
    #[arg(long, value_name = "COUNT", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
}

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
struct DecodeReport {
    file: String,
    file_bytes: u64,
    tiles: u64,
    vertices: u64,
    bytes_per_vertex: f64,
    stored_bytes: u64,
    raw_bytes: u64,
    seconds: f64,
    gb_per_s: f64,
}

/// Runs the benchmark.
pub fn run(args: DecodeArgs) -> anyhow::Result<()> {
    let bytes = std::fs::read(&args.file)
        .map(Bytes::from)
        .with_context(|| format!("{}: cannot read", common::shown(&args.file)))?;
    // One tile at a time, none of which is kept.
    let options = OpenOptions::default().cache(&Cache::new(0));
    let name = args.file.to_string_lossy().into_owned();
    let report = common::wait_for("measuring", async move {
        let reader = TileReader::open_source(bytes, &name, options).await?;
        let directory = reader.directory().await?;
        let sum = |of: fn(&TileEntry) -> u64| directory.tiles.iter().map(of).sum();
        let raw_bytes = sum(TileEntry::decoded_bytes);
        let mut best: Option<Measurement> = None;
        for _ in 0..args.rounds {
            let clock = Clock::start();
            for tile in 0..directory.tiles.len() as u32 {
                reader.tile(TileId(tile)).await?;
            }
            let round = clock.measure(raw_bytes);
            best = best.filter(|best| best.seconds <= round.seconds).or(Some(round));
        }
        let best = best.context("there were no rounds")?;
        let (file_bytes, vertices) = (reader.file_length(), reader.metadata().vertices);
        Ok(DecodeReport {
            file: name,
            file_bytes,
            tiles: directory.tiles.len() as u64,
            vertices,
            bytes_per_vertex: common::share(file_bytes, vertices),
            stored_bytes: sum(TileEntry::stored_bytes),
            raw_bytes,
            seconds: best.seconds,
            gb_per_s: best.rate(),
        })
    })?;
    if args.json {
        return common::print_json("the result", &report);
    }
    let text = format!(
        "{}: {:.1} bytes per vertex\n  tiles    {}, stored in {}\n  opened   {:.3} s, {:.2} GB/s on one core\n",
        report.file,
        report.bytes_per_vertex,
        common::bytes(report.raw_bytes),
        common::bytes(report.stored_bytes),
        report.seconds,
        report.gb_per_s
    );
    common::print("the result", &text)
}
