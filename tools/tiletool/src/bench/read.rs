//! `tiletool bench read`: tiles from a cold file, beside the bare device and a memory map.

use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use delaunay_tiles::io::Backend;
use delaunay_tiles::store::{Cache, OpenOptions, TileId, TileReader};
use futures::{StreamExt, TryStreamExt, stream};

use super::caches;
use super::device::{Device, Into};
use super::map::MappedFile;
use super::report::{OfBackend, OfDevice, Report};
use super::took::{Clock, Took, median};
use crate::common;

/// Bytes of a block that the bare device is read in.
const BLOCK: usize = 1 << 20;
/// How many of them at a time.
const DEPTHS: [usize; 6] = [1, 2, 4, 8, 16, 32];
/// How many of them at a time into huge pages, with which it matters little.
const HUGE_DEPTH: usize = 4;
/// Tiles that are read at random, and how many at a time.
const RANDOM_TILES: u64 = 256;
const RANDOM_DEPTH: usize = 32;

/// Measure how fast a file is read: all its tiles in order, then tiles at random.
///
/// Each tile's checksum is verified and its content decoded. In turns with that, blocks of 1 MiB of the same file are read past the page
/// cache with nothing in between, 1 to 32 at a time: what the device does for a program that does nothing else. It is also read into huge
/// pages, which it may be faster with. Before each run the file is thrown out of the page
/// cache, and, as root, all else too. Medians of several rounds. GB are 10^9 bytes. Take a file larger than the device's
/// own cache: 4 GiB or more.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:\n  tiletool bench read survey.tiles --rounds 5")]
pub struct ReadArgs {
    /// The tile file
    file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// What to read by
    #[arg(long, value_delimiter = ',', default_values = ["uring", "threads", "mmap"])]
    backends: Vec<Method>,
    /// How often
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
}

/// What a file is read by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    Uring,
    Threads,
    /// A memory map, to compare with; the library has no such backend.
    Mmap,
}

impl Method {
    fn name(self) -> String {
        let value = self.to_possible_value();
        value.map_or_else(String::new, |value| value.get_name().to_owned())
    }

    async fn open(self, path: &Path, is_scan: bool) -> anyhow::Result<TileReader> {
        let options = OpenOptions::default().cache(&Cache::new(0));
        let backend = match self {
            Self::Uring => Backend::Uring,
            Self::Threads => Backend::Threads,
            Self::Mmap => {
                let file = MappedFile::open(path, is_scan)
                    .with_context(|| format!("cannot map {} into memory", common::shown(path)))?;
                return Ok(TileReader::open_source(file, &path.display().to_string(), options).await?);
            }
        };
        Ok(TileReader::open(path, options.backend(backend)).await?)
    }

    /// All tiles in order.
    async fn scan(self, path: &Path) -> anyhow::Result<Took> {
        let clock = Clock::start();
        let reader = self.open(path, true).await?;
        let mut tiles = reader.tiles();
        while tiles.try_next().await?.is_some() {}
        Ok(clock.took(tile_bytes(&reader)))
    }

    /// Some tiles, in any order.
    async fn read(self, path: &Path, tiles: &[TileId]) -> anyhow::Result<Took> {
        let reader = self.open(path, false).await?;
        let clock = Clock::start();
        let mut loads = stream::iter(tiles)
            .map(|&id| reader.tile(id))
            .buffer_unordered(RANDOM_DEPTH);
        while loads.try_next().await?.is_some() {}
        let entries = &reader.directory().tiles;
        let bytes = |id: &TileId| {
            entries
                .get(id.0 as usize)
                .map_or(0, |t| u64::from(t.core.length + t.border.length))
        };
        Ok(clock.took(tiles.iter().map(bytes).sum()))
    }
}

/// Bytes of all tiles.
fn tile_bytes(reader: &TileReader) -> u64 {
    let length = |t: &delaunay_tiles::store::TileEntry| u64::from(t.core.length) + u64::from(t.border.length);
    reader.directory().tiles.iter().map(length).sum()
}

/// The runs of a backend.
#[derive(Default)]
struct Runs {
    cold: Vec<Took>,
    warm: Vec<Took>,
    random: Vec<Took>,
}

/// The runs of the bare device.
#[derive(Default)]
struct DeviceRuns {
    depths: [Vec<Took>; DEPTHS.len()],
    huge: Vec<Took>,
    random: Vec<Took>,
}

impl DeviceRuns {
    /// Reads all with so many blocks at a time as there are depths, then into huge pages, then blocks at some places.
    fn measure(&mut self, device: &Device, places: &[u64], block: usize) -> io::Result<()> {
        for (depth, runs) in DEPTHS.into_iter().zip(&mut self.depths) {
            runs.push(device.scan(BLOCK, depth, Into::Pages)?);
        }
        self.huge.push(device.scan(BLOCK, HUGE_DEPTH, Into::HugePages)?);
        let took = device.read(places, block, RANDOM_DEPTH, Into::Pages)?;
        self.random.push(took);
        Ok(())
    }
}

/// Measures and prints.
pub fn run(args: ReadArgs) -> anyhow::Result<()> {
    let report = common::block_on(measure(&args))?;
    if args.json {
        common::print_json(&report)
    } else {
        common::print(&report.text())
    }
}

async fn measure(args: &ReadArgs) -> anyhow::Result<Report> {
    let path = args.file.as_path();
    let reader = TileReader::open(path, OpenOptions::default().backend(Backend::Threads)).await?;
    let tiles = reader.directory().tiles.len() as u64;
    let mean = tile_bytes(&reader) / tiles.max(1);
    // Any order will do, as long as it is the same for all: steps that are prime to most numbers.
    let random: Vec<_> = (0..RANDOM_TILES.min(tiles))
        .map(|i| TileId((i * 7_919 % tiles) as u32))
        .collect();
    let places: Vec<u64> = random
        .iter()
        .map(|id| reader.directory().tiles[id.0 as usize].core.offset)
        .collect();
    let random_block = mean.next_multiple_of(4096) as usize;
    // Where the device cannot be read alone, there is nothing to compare with.
    let device = Device::open(path);
    let note = device
        .as_ref()
        .err()
        .map(|error| format!("the file cannot be read past the page cache: {error}"));
    let mut device_runs = DeviceRuns::default();
    let mut runs: Vec<Runs> = args.backends.iter().map(|_| Runs::default()).collect();
    let mut all_dropped = true;
    for _ in 0..args.rounds {
        if let Ok(device) = &device {
            let measured = device_runs.measure(device, &places, random_block);
            measured.context("cannot read the device")?;
        }
        for (method, runs) in args.backends.iter().zip(&mut runs) {
            all_dropped &= caches::drop_for(path)?;
            runs.cold.push(method.scan(path).await?);
            runs.warm.push(method.scan(path).await?);
            all_dropped &= caches::drop_for(path)?;
            runs.random.push(method.read(path, &random).await?);
        }
    }
    let device = OfDevice::best(&DEPTHS, &device_runs.depths, &device_runs.huge, &device_runs.random);
    let backends = args.backends.iter().zip(&runs).map(|(method, runs)| {
        let [cold, warm, random] = [&runs.cold, &runs.warm, &runs.random].map(|runs| median(runs, Took::rate));
        OfBackend::new(&method.name(), cold, warm, random, device.as_ref())
    });
    Ok(Report {
        file: reader.name().to_owned(),
        file_bytes: reader.file_length(),
        tiles,
        mean_tile_bytes: mean,
        rounds: args.rounds,
        file_dropped_from_cache: true,
        all_caches_dropped: all_dropped,
        backends: backends.collect(),
        device,
        note,
    })
}
