//! What was measured, for people and programs.

use serde::Serialize;

use super::took::{Took, median};
use crate::common::{bytes, thousands};

/// The result; its names are the stable keys of `--json`.
#[derive(Serialize)]
pub struct Report {
    pub file: String,
    pub file_bytes: u64,
    pub tiles: u64,
    pub mean_tile_bytes: u64,
    pub rounds: u32,
    pub file_dropped_from_cache: bool,
    pub all_caches_dropped: bool,
    pub device: Option<OfDevice>,
    pub backends: Vec<OfBackend>,
    pub note: Option<String>,
}

/// The bare device.
#[derive(Serialize)]
pub struct OfDevice {
    pub gb_per_s: f64,
    /// Blocks of 1 MiB at a time, with which it was so fast.
    pub queue_depth: usize,
    pub depths: Vec<OfDepth>,
    /// Into huge pages, 4 at a time.
    pub huge_pages_gb_per_s: f64,
    /// With blocks as large as a tile, 32 at a time, at random places.
    pub random_gb_per_s: f64,
}

/// The device with so many blocks at a time.
#[derive(Serialize)]
pub struct OfDepth {
    pub queue_depth: usize,
    pub gb_per_s: f64,
}

/// A way to read tiles.
#[derive(Serialize)]
pub struct OfBackend {
    pub name: String,
    /// All tiles in order, cold.
    pub gb_per_s: f64,
    pub ratio_to_device: Option<f64>,
    pub ratio_to_huge_pages: Option<f64>,
    pub seconds: f64,
    pub cpu_seconds: f64,
    /// Processor time by time.
    pub cores_busy: f64,
    /// Again at once, with what is in the page cache by then.
    pub warm_gb_per_s: f64,
    /// By second of processor time.
    pub warm_gb_per_cpu_second: f64,
    /// Tiles at random places, 32 at a time, cold.
    pub random_gb_per_s: f64,
    pub random_ratio_to_device: Option<f64>,
}

impl OfDevice {
    /// The fastest depth by the median of its runs; none if there are no runs.
    pub fn best(depths: &[usize], runs: &[Vec<Took>], huge: &[Took], random: &[Took]) -> Option<Self> {
        let measured = depths.iter().zip(runs).filter(|(_, runs)| !runs.is_empty());
        let depths: Vec<_> = measured
            .map(|(&queue_depth, runs)| OfDepth {
                queue_depth,
                gb_per_s: median(runs, Took::rate).rate(),
            })
            .collect();
        let best = depths.iter().max_by(|a, b| a.gb_per_s.total_cmp(&b.gb_per_s))?;
        Some(Self {
            gb_per_s: best.gb_per_s,
            queue_depth: best.queue_depth,
            huge_pages_gb_per_s: median(huge, Took::rate).rate(),
            random_gb_per_s: median(random, Took::rate).rate(),
            depths,
        })
    }
}

impl OfBackend {
    /// From its medians.
    pub fn new(name: &str, cold: Took, warm: Took, random: Took, device: Option<&OfDevice>) -> Self {
        Self {
            name: name.to_owned(),
            gb_per_s: cold.rate(),
            ratio_to_device: device.map(|device| cold.rate() / device.gb_per_s),
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

impl Report {
    /// The tables for people.
    pub fn text(&self) -> String {
        let tile = bytes(self.mean_tile_bytes);
        let mut text = format!(
            "{}: {} in {} tiles of {tile}; medians of {} rounds\n",
            self.file,
            bytes(self.file_bytes),
            thousands(self.tiles),
            self.rounds
        );
        text += if self.all_caches_dropped {
            "cold: all caches of the system were dropped before each run\n"
        } else {
            "cold: the file was dropped from the page cache before each run; only root may drop the rest\n"
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
                backend.gb_per_s,
                share(backend.ratio_to_device),
                share(backend.ratio_to_huge_pages),
                backend.cores_busy,
                backend.warm_gb_per_s,
                backend.warm_gb_per_cpu_second,
                backend.random_gb_per_s,
                share(backend.random_ratio_to_device),
            );
        }
        text += "GB/s, each tile verified and decoded\n";
        text
    }
}
