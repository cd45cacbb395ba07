//! `lab stretch`: the walking distance and the CDT distance, as in section 4.2 of Wu's thesis.
//!
//! The input is a tile file, or obstacles to make one from. The output is `pairs.csv` with both
//! distances between random vertices, a histogram of their ratios, and pictures of the structures
//! on which both distances are measured: islands, visibility graph, triangulation, trees of
//! shortest paths.

mod extract;
mod pairs;
mod pictures;
mod report;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::{Context, bail};
use clap::Args;
use delaunay_tiles::store::{OpenOptions, TileReader};

use super::folder::Folder;
use super::pictures::Pictures;
use super::table::Table;
use super::tiles;
use crate::work;
use extract::Within;
use tiletool::common;

/// Compare the walking distance with the distance along edges of the triangulation.
///
/// Both are measured between random vertices: the shortest path among obstacles, and the shortest
/// path along edges of the constrained Delaunay triangulation. The second is never shorter, and
/// always less than 2.42 times as long; a pair that violates this is an error. Files that are not
/// tile files are triangulated first: GeoJSON as obstacles, and Triangle's .poly.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  lab stretch islands.geojson --pairs 2000 -o results
  lab stretch islands.geojson --within 112,-10,132,-7 -o results
  lab stretch town.tiles --seed 7 -o results")]
pub struct StretchArgs {
    /// A tile file, obstacles as GeoJSON, or a .poly
    file: PathBuf,
    /// The folder for the results
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Number of pairs of vertices
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pairs: u32,
    /// Seed of the random pairs
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Only the polygons of a GeoJSON file within this rectangle
    #[arg(long, value_name = "X0,Y0,X1,Y1", allow_hyphen_values = true)]
    within: Option<Within>,
    /// Draw the visibility graph of files with at most this number of vertices
    #[arg(long, value_name = "N", default_value_t = 3000)]
    graph_vertices: u64,
    /// Concurrent queries; by default one for each processor
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,
    #[command(flatten)]
    pictures: Pictures,
}

/// The maximum bytes of disk for a byte of input, and the bytes for pictures.
const DISK_PER_BYTE: u64 = 20;
const DISK_FOR_PICTURES: u64 = 64 << 20;

/// Runs the experiment, and writes its results.
pub fn run(args: StretchArgs) -> anyhow::Result<()> {
    let file = args.file.metadata();
    let file = file.with_context(|| format!("cannot read {}", args.file.display()))?;
    let stop = common::interruption();
    let mut folder = Folder::create(&args.output)?;
    folder.require(
        file.len()
            .saturating_mul(DISK_PER_BYTE)
            .saturating_add(DISK_FOR_PICTURES),
    )?;
    let tiles = prepare(&args, folder.scratch(), &stop)?;
    let available = std::thread::available_parallelism().map_or(1, usize::from);
    let at_once = args.threads.map_or(available, |threads| threads as usize);
    let name = match args.within {
        Some(Within(rect)) => format!(
            "{}, islands within {} to {} and {} to {}",
            common::file_name(&args.file),
            rect.min_x,
            rect.max_x,
            rect.min_y,
            rect.max_y
        ),
        None => common::file_name(&args.file),
    };
    let work = async {
        let reader = TileReader::open(&tiles, OpenOptions::default()).await?;
        let drawn = pairs::draw(&reader, args.pairs as usize, args.seed, at_once).await?;
        let figures = pictures::figures(&reader, &name, &drawn, args.graph_vertices, at_once).await?;
        Ok((reader, drawn, figures))
    };
    let (reader, drawn, figures) = work::block_on(work)?;
    folder.keep("pairs.csv", Table::of(report::COLUMNS, &drawn.pairs).csv());
    report::keep(&reader, &name, &drawn, figures, args.pictures, &mut folder)?;
    folder.publish()
}

/// Returns the tile file: the given file, or one that is made from it.
fn prepare(args: &StretchArgs, scratch: &Path, stop: &AtomicBool) -> anyhow::Result<PathBuf> {
    let file = &args.file;
    match args.within {
        Some(_) if tiles::ends_in(file, "tiles") => {
            bail!(
                "--within chooses polygons of a GeoJSON file, and {} has tiles",
                file.display()
            )
        }
        None if tiles::ends_in(file, "tiles") => Ok(file.clone()),
        None => tiles::triangulate(file, None, scratch, "input.tiles", stop),
        Some(within) => {
            let chosen = scratch.join("chosen.geojson");
            extract::extract(file, within, &chosen)?;
            tiles::triangulate(&chosen, None, scratch, "input.tiles", stop)
        }
    }
}
