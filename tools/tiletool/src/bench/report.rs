//! The report of `tiletool bench read`, for people and programs.

use serde::Serialize;

use super::measurement::{Measurement, median};
use crate::common::{bytes, counted};

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
pub struct ReadReport {
    pub file: String,
    pub file_bytes: u64,
    pub tiles: u64,
    pub mean_tile_bytes: u64,
    pub rounds: u32,
    pub file_dropped_from_cache: bool,
    pub all_caches_dropped: bool,
    pub device: Option<DeviceRates>,
    pub backends: Vec<BackendRates>,
    pub note: Option<String>,
}

/// The rates of the bare device.
#[derive(Serialize)]
pub struct DeviceRates {
    pub sequential_gb_per_s: f64,
    /// The number of blocks of 1 MiB at a time with which the device was fastest.
    pub queue_depth: usize,
    pub depths: Vec<DepthRate>,
    /// The rate into huge pages, 4 blocks at a time.
    pub huge_pages_gb_per_s: f64,
    /// The rate of blocks as large as a tile, 32 at a time, at random offsets.
    pub random_gb_per_s: f64,
}

/// The rate of the device with `queue_depth` blocks at a time.
#[derive(Serialize)]
pub struct DepthRate {
    pub queue_depth: usize,
    pub gb_per_s: f64,
}

/// The rates of a backend.
#[derive(Serialize)]
pub struct BackendRates {
    pub name: String,
    /// The rate of all tiles in order, cold.
    pub cold_gb_per_s: f64,
    pub ratio_to_device: Option<f64>,
    pub ratio_to_huge_pages: Option<f64>,
    pub seconds: f64,
    pub cpu_seconds: f64,
    /// Processor time divided by elapsed time.
    pub cores_busy: f64,
    /// The rate of a second run immediately after the first, with the page cache that the first one
    /// left.
    pub warm_gb_per_s: f64,
    /// The rate of that run per second of processor time.
    pub warm_gb_per_cpu_second: f64,
    /// The rate of tiles in random order, 32 at a time, cold.
    pub random_gb_per_s: f64,
    pub random_ratio_to_device: Option<f64>,
}

impl DeviceRates {
    /// Returns the rates with the fastest depth by the median of its runs; `None` if there are no
    /// runs.
    pub fn best(
        depths: &[usize],
        runs: &[Vec<Measurement>],
        huge: &[Measurement],
        random: &[Measurement],
    ) -> Option<Self> {
        let measured = depths.iter().zip(runs).filter(|(_, runs)| !runs.is_empty());
        let depths: Vec<_> = measured
            .map(|(&queue_depth, runs)| DepthRate {
                queue_depth,
                gb_per_s: median(runs, Measurement::rate).rate(),
            })
            .collect();
        let best = depths.iter().max_by(|a, b| a.gb_per_s.total_cmp(&b.gb_per_s))?;
        Some(Self {
            sequential_gb_per_s: best.gb_per_s,
            queue_depth: best.queue_depth,
            huge_pages_gb_per_s: median(huge, Measurement::rate).rate(),
            random_gb_per_s: median(random, Measurement::rate).rate(),
            depths,
        })
    }
}

impl BackendRates {
    /// Creates the rates of a backend from its median measurements.
    pub fn new(
        name: &str,
        cold: Measurement,
        warm: Measurement,
        random: Measurement,
        device: Option<&DeviceRates>,
    ) -> Self {
        Self {
            name: name.to_owned(),
            cold_gb_per_s: cold.rate(),
            ratio_to_device: device.map(|device| cold.rate() / device.sequential_gb_per_s),
            ratio_to_huge_pages: device.map(|device| cold.rate() / device.huge_pages_gb_per_s),
            seconds: cold.seconds,
            cpu_seconds: cold.cpu_seconds,
            cores_busy: cold.cpu_seconds / cold.seconds,
            warm_gb_per_s: warm.rate(),
            warm_gb_per_cpu_second: warm.rate_per_core(),
            random_gb_per_s: random.rate(),
            random_ratio_to_device: device.map(|device| random.rate() / device.random_gb_per_s),
        }
    }
}

impl ReadReport {
    /// Returns the tables for people.
    pub fn text(&self) -> String {
        let tile = bytes(self.mean_tile_bytes);
        let mut text = format!(
            "{}: {} in {} with a mean of {tile}; medians of {}\n",
            self.file,
            bytes(self.file_bytes),
            counted(self.tiles, "tile", "tiles"),
            counted(self.rounds.into(), "round", "rounds")
        );
        text += if self.all_caches_dropped {
            "cold: all caches of the system were dropped before each run\n"
        } else {
            "cold: the file was dropped from the page cache before each run; only root can drop the other caches\n"
        };
        if let Some(note) = &self.note {
            text += &format!("{note}\n");
        }
        if let Some(device) = &self.device {
            text += "\ndevice, 1 MiB at a time\n";
            for depth in &device.depths {
                text += &format!("  queue depth {:>2} {:>6.2} GB/s\n", depth.queue_depth, depth.gb_per_s);
            }
            text += &format!(
                "  huge pages     {:>6.2} GB/s, queue depth 4\n",
                device.huge_pages_gb_per_s
            );
            text += &format!(
                "  random tiles   {:>6.2} GB/s, queue depth 32\n",
                device.random_gb_per_s
            );
        }
        text += "\nbackend      cold  of device  of huge pages  cores busy     warm  per core   random  of device\n";
        let share = |ratio: Option<f64>| ratio.map_or_else(|| "-".to_owned(), |ratio| format!("{ratio:.2}"));
        for backend in &self.backends {
            text += &format!(
                "{:<8} {:>8.2} {:>10} {:>14} {:>11.2} {:>8.2} {:>9.2} {:>8.2} {:>10}\n",
                backend.name,
                backend.cold_gb_per_s,
                share(backend.ratio_to_device),
                share(backend.ratio_to_huge_pages),
                backend.cores_busy,
                backend.warm_gb_per_s,
                backend.warm_gb_per_cpu_second,
                backend.random_gb_per_s,
                share(backend.random_ratio_to_device),
            );
        }
        text += "All rates are in GB/s; each tile was verified and decoded.\n";
        text
    }
}
