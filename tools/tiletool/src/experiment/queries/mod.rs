//! `tiletool experiment queries`: the wave, the method of Wu's thesis and those that it compares with, on the same queries.
//!
//! Comes in: a tile file with sites, or obstacles to make one of, with random sites. Goes out: `queries.csv` with what each query cost by
//! each method, `summary.csv` with medians and means, charts of time, constraint edges and sweeps.

mod measure;
mod report;
mod sites;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use delaunay_tiles::query::Method;
use delaunay_tiles::store::{Cache, OpenOptions, TileReader};

use super::folder::Folder;
use crate::common;

/// Compare methods for the nearest sites among obstacles.
///
/// The same random places are asked for their k nearest sites, and for all sites within the median distance of the k-th. All
/// methods must say the same, or it is an error. Files that are no tiles are triangulated first, with random sites: GeoJSON as obstacles,
/// and Triangle's .poly.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool experiment queries islands.geojson --sites 1000 -o results
  tiletool experiment queries town.tiles --k 1,10 --queries 50 -o results")]
pub struct QueriesArgs {
    /// A tile file with sites, obstacles as GeoJSON, or a .poly
    file: PathBuf,
    /// The folder for the results
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// How many random free places become sites, in a file that is no tile file
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    sites: u32,
    /// How many random free places are asked
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    queries: u32,
    /// For how many nearest sites
    #[arg(long, value_name = "K,…", value_delimiter = ',', default_values_t = [1, 10, 50], value_parser = clap::value_parser!(u32).range(1..))]
    k: Vec<u32>,
    /// Stretch factors for the thesis's method
    #[arg(long, value_name = "T,…", value_delimiter = ',', default_values_t = [Method::LEAST_STRETCH, 2.0, Method::STRETCH])]
    stretches: Vec<f64>,
    /// Which of all random places
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
}

/// Measures and writes.
pub fn run(args: QueriesArgs) -> anyhow::Result<()> {
    let mut methods = vec![Method::Wave];
    methods.extend(args.stretches.iter().map(|&stretch| Method::Visibility { stretch }));
    methods.extend([Method::EuclidZhang, Method::EuclidXia]);
    let mut folder = Folder::create(&args.output)?;
    let work = async {
        let (file, asked) = prepare(&args, folder.scratch()).await?;
        let cache = Cache::new(1 << 30);
        let reader = TileReader::open(&file, OpenOptions::default().cache(&cache)).await?;
        if reader.directory().metadata.sites == 0 {
            bail!("{} has no sites; build it with --sites", args.file.display());
        }
        let places = sites::free_places(&reader, asked, args.seed ^ 1).await?;
        measure::measure(&reader, &places, &args.k, &methods).await
    };
    let costs = common::block_on(async {
        tokio::select! {
            done = work => done,
            _ = tokio::signal::ctrl_c() => bail!("interrupted; nothing was written"),
        }
    })?;
    let name = format!("{}, {} places", common::file_name(&args.file), args.queries);
    report::keep(&name, &costs, &mut folder)?;
    for path in folder.publish()? {
        common::print(&format!("{}\n", path.display()))?;
    }
    Ok(())
}

/// The tile file, and how many places are to be asked.
async fn prepare(args: &QueriesArgs, scratch: &Path) -> anyhow::Result<(PathBuf, usize)> {
    let asked = args.queries as usize;
    let suffix = args.file.extension().unwrap_or_default().to_ascii_lowercase();
    if suffix == "tiles" {
        return Ok((args.file.clone(), asked));
    }
    let (bare, list, file) = (
        scratch.join("bare.tiles"),
        scratch.join("sites.csv"),
        scratch.join("sites.tiles"),
    );
    let is_poly = suffix == "poly";
    sites::build(&args.file, is_poly, None, &bare)?;
    let reader = TileReader::open(&bare, OpenOptions::default()).await?;
    let places = sites::free_places(&reader, args.sites as usize, args.seed).await?;
    let rows: String = places
        .iter()
        .map(|place| format!("{},{}\n", place.x, place.y))
        .collect();
    std::fs::write(&list, rows).with_context(|| format!("cannot write {}", list.display()))?;
    sites::build(&args.file, is_poly, Some(&list), &file)?;
    Ok((file, asked))
}
