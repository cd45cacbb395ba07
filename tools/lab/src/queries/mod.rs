//! `lab queries`: the wavefront search, the method of Wu's thesis and the methods that it is
//! compared with, on the same queries.
//!
//! The input is a tile file with sites, or obstacles to make one from, with random sites. The
//! output is `queries.csv` with the cost of each query by each method, `summary.csv` with medians
//! and means, and charts of time, constraint edges and sweeps.

mod free_points;
mod measure;
mod report;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::{Context, bail};
use clap::Args;
use delaunay_tiles::query::baselines::{Method, Stretch};
use delaunay_tiles::store::{Cache, OpenOptions, TileReader};

use super::folder::Folder;
use super::tiles;
use crate::work;
use tiletool::common;

/// Compare methods for the nearest sites among obstacles.
///
/// Each random point is queried for its k nearest sites, and for all sites within the median
/// distance of the k-th. It is an error if two methods give different answers. Files that are not
/// tile files are triangulated first, with random sites: GeoJSON as obstacles, and Triangle's
/// .poly.
/// and Triangle's .poly.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  lab queries islands.geojson --sites 1000 -o results
  lab queries town.tiles --k 1,10 --queries 50 -o results")]
pub struct QueriesArgs {
    /// A tile file with sites, obstacles as GeoJSON, or a .poly
    file: PathBuf,
    /// The folder for the results
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Number of random free points that become sites, if the file is not a tile file
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    sites: u32,
    /// Number of random free points that are queried
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    queries: u32,
    /// Numbers of nearest sites
    #[arg(long, value_name = "K,…", value_delimiter = ',', default_values_t = [1, 10, 50], value_parser = clap::value_parser!(u32).range(1..))]
    k: Vec<u32>,
    /// Stretch factors for the thesis's method
    #[arg(long, value_name = "T,…", value_delimiter = ',', default_values_t = [Stretch::LEAST.get(), 2.0, Stretch::PROVED.get()])]
    stretches: Vec<f64>,
    /// Seed of the random points
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
}

/// Runs the experiment, and writes its results.
pub fn run(args: QueriesArgs) -> anyhow::Result<()> {
    let mut methods = vec![Method::Wavefront];
    for &stretch in &args.stretches {
        let stretch = Stretch::new(stretch)?;
        methods.push(Method::Visibility { stretch });
    }
    methods.extend([Method::EuclidZhang, Method::EuclidXia]);
    let stop = common::interruption();
    let mut folder = Folder::create(&args.output)?;
    let file = prepare(&args, folder.scratch(), &stop)?;
    let costs = work::block_on(async {
        let cache = Cache::new(1 << 30);
        let reader = common::open(&file, OpenOptions::default().cache(&cache)).await?;
        if reader.metadata().sites == 0 {
            bail!("{} has no sites; build it with --sites", args.file.display());
        }
        let points = free_points::draw(&reader, args.queries as usize, args.seed ^ 1).await?;
        measure::measure(&reader, &points, &args.k, &methods).await
    })?;
    let name = format!("{}, {} points", common::file_name(&args.file), args.queries);
    report::keep(&name, &costs, &mut folder)?;
    folder.publish()
}

/// Returns the tile file: the given file, or one with random sites that is made from it.
fn prepare(args: &QueriesArgs, scratch: &Path, stop: &AtomicBool) -> anyhow::Result<PathBuf> {
    if tiles::ends_in(&args.file, "tiles") {
        return Ok(args.file.clone());
    }
    let bare = tiles::triangulate(&args.file, None, scratch, "bare.tiles", stop)?;
    let points = work::block_on(async {
        let reader = TileReader::open(&bare, OpenOptions::default()).await?;
        free_points::draw(&reader, args.sites as usize, args.seed).await
    })?;
    let rows: String = points
        .iter()
        .map(|point| format!("{},{}\n", point.x, point.y))
        .collect();
    let sites = scratch.join("sites.csv");
    fs::write(&sites, rows).with_context(|| format!("cannot write {}", sites.display()))?;
    tiles::triangulate(&args.file, Some(&sites), scratch, "sites.tiles", stop)
}
