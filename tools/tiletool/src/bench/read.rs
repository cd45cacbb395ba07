//! `tiletool bench read`: reads tiles of a cold file, compared with the bare device and a memory
//! map.

use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use delaunay_tiles::io::Backend;
use delaunay_tiles::store::{Cache, Directory, OpenOptions, TileEntry, TileId, TileReader};
use futures::{StreamExt, TryStreamExt, stream};

use super::caches;
use super::device::{BufferKind, Device};
use super::map::MappedFile;
use super::measurement::{Clock, Measurement, median};
use super::report::{BackendRates, DeviceRates, ReadReport};
use crate::common;

/// Bytes of a block that is read from the bare device.
const BLOCK: usize = 1 << 20;
/// Numbers of blocks that are read at a time.
const DEPTHS: [usize; 6] = [1, 2, 4, 8, 16, 32];
/// Number of blocks that are read at a time into huge pages, for which the number matters little.
const HUGE_DEPTH: usize = 4;
/// Number of tiles that are read at random.
const RANDOM_TILES: u64 = 256;
/// Number of random tiles that are read at a time.
const RANDOM_DEPTH: usize = 32;

/// Measure how fast a file is read: all its tiles in order, then tiles at random
///
/// Each tile's checksum is verified and its content decoded. Use a file larger than the device's
/// own cache: 4 GiB or more.
///
/// For comparison, and alternately with the tiles, blocks of 1 MiB of the same file are read with
/// direct I/O, which bypasses the page cache, 1 to 32 at a time: this is the speed of the device
/// for a program that does nothing else. The blocks are also read into huge pages, which may be
/// faster.
///
/// Before each run, the file is dropped from the page cache; root also drops all other caches. The
/// results are medians of several rounds. 1 GB is 10^9 bytes.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:\n  tiletool bench read survey.tiles --rounds 5")]
pub struct ReadArgs {
    /// Tile file to read
    file: PathBuf,
    /// Print the result as one JSON object
    #[arg(long)]
    json: bool,
    /// Backends to measure, separated by commas
    #[arg(long, value_name = "BACKENDS", value_delimiter = ',', default_values = ["uring", "threads", "mmap"])]
    backends: Vec<Method>,
    /// Number of rounds
    #[arg(long, value_name = "COUNT", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
}

/// A backend that reads a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// An io_uring of Linux
    Uring,
    /// A pool of threads
    Threads,
    /// A memory map, for comparison; the library has no such backend
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

    /// Reads all tiles in order, `bytes` in total.
    async fn scan(self, path: &Path, bytes: u64) -> anyhow::Result<Measurement> {
        let clock = Clock::start();
        let reader = self.open(path, true).await?;
        let mut tiles = reader.tiles();
        while tiles.try_next().await?.is_some() {}
        Ok(clock.measure(bytes))
    }

    /// Reads some tiles, `bytes` in total, in any order.
    async fn read(self, path: &Path, tiles: &[TileId], bytes: u64) -> anyhow::Result<Measurement> {
        let reader = self.open(path, false).await?;
        let clock = Clock::start();
        let mut loads = stream::iter(tiles)
            .map(|&id| reader.tile(id))
            .buffer_unordered(RANDOM_DEPTH);
        while loads.try_next().await?.is_some() {}
        Ok(clock.measure(bytes))
    }
}

/// Returns the bytes of tiles, as they are stored.
fn tile_bytes(directory: &Directory, tiles: &[TileId]) -> u64 {
    let entries = tiles.iter().filter_map(|&id| directory.entry(id));
    entries.map(TileEntry::stored_bytes).sum()
}

/// The measurements of a backend.
#[derive(Default)]
struct BackendRuns {
    cold: Vec<Measurement>,
    warm: Vec<Measurement>,
    random: Vec<Measurement>,
}

/// The measurements of the bare device.
#[derive(Default)]
struct DeviceRuns {
    depths: [Vec<Measurement>; DEPTHS.len()],
    huge: Vec<Measurement>,
    random: Vec<Measurement>,
}

impl DeviceRuns {
    /// Reads the whole file with each number of blocks at a time, then into huge pages, then blocks
    /// of `block` bytes at `offsets`.
    fn measure(&mut self, device: &Device, offsets: &[u64], block: usize) -> io::Result<()> {
        for (depth, runs) in DEPTHS.into_iter().zip(&mut self.depths) {
            runs.push(device.scan(BLOCK, depth, BufferKind::Pages)?);
        }
        self.huge.push(device.scan(BLOCK, HUGE_DEPTH, BufferKind::HugePages)?);
        let measurement = device.read(offsets, block, RANDOM_DEPTH, BufferKind::Pages)?;
        self.random.push(measurement);
        Ok(())
    }
}

/// Measures, and prints the report.
pub fn run(args: ReadArgs) -> anyhow::Result<()> {
    let report = common::wait_for("measuring", measure(&args))?;
    if args.json {
        common::print_json("the report", &report)
    } else {
        common::print("the report", &report.text())
    }
}

async fn measure(args: &ReadArgs) -> anyhow::Result<ReadReport> {
    let path = args.file.as_path();
    let reader = TileReader::open(path, OpenOptions::default().backend(Backend::Threads)).await?;
    let directory = reader.directory().await?;
    let ids: Vec<TileId> = directory.tile_ids().collect();
    let tiles = ids.len() as u64;
    let all_bytes = tile_bytes(&directory, &ids);
    let mean = all_bytes / tiles.max(1);
    // The order does not matter, but it must be the same for all backends. The step is coprime to
    // most numbers of tiles.
    let random: Vec<_> = (0..RANDOM_TILES.min(tiles))
        .map(|i| ids[(i * 7_919 % tiles) as usize])
        .collect();
    let random_bytes = tile_bytes(&directory, &random);
    let offsets: Vec<u64> = random
        .iter()
        .map(|id| directory.tiles[id.0 as usize].core.offset)
        .collect();
    let random_block = mean.next_multiple_of(4096) as usize;
    // If direct I/O is not possible, there is no comparison with the device.
    let device = Device::open(path);
    let note = device
        .as_ref()
        .err()
        .map(|error| format!("the file cannot be read with direct I/O, bypassing the page cache: {error}"));
    let mut device_runs = DeviceRuns::default();
    let mut runs: Vec<BackendRuns> = args.backends.iter().map(|_| BackendRuns::default()).collect();
    let mut all_dropped = true;
    for _ in 0..args.rounds {
        if let Ok(device) = &device {
            let measured = device_runs.measure(device, &offsets, random_block);
            measured.context("cannot read the device")?;
        }
        for (method, runs) in args.backends.iter().zip(&mut runs) {
            all_dropped &= caches::drop_for(path)?;
            runs.cold.push(method.scan(path, all_bytes).await?);
            runs.warm.push(method.scan(path, all_bytes).await?);
            all_dropped &= caches::drop_for(path)?;
            runs.random.push(method.read(path, &random, random_bytes).await?);
        }
    }
    let device = DeviceRates::best(&DEPTHS, &device_runs.depths, &device_runs.huge, &device_runs.random);
    let backends = args.backends.iter().zip(&runs).map(|(method, runs)| {
        let [cold, warm, random] = [&runs.cold, &runs.warm, &runs.random].map(|runs| median(runs, Measurement::rate));
        BackendRates::new(&method.name(), cold, warm, random, device.as_ref())
    });
    Ok(ReadReport {
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
