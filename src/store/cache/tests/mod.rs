//! Tests of the cache: the state against a model, loads and pins in tasks, edits and write-backs.

mod edits;
mod model;
mod tasks;

use super::shelf::Failure;
use super::{CacheStatistics, Weight};

/// A value with the version of its key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Sample {
    version: u64,
    weight: usize,
}

impl Weight for Sample {
    fn weight(&self) -> usize {
        self.weight
    }
}

/// The reason why a load or a write failed.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Trouble {
    Disk(u32),
    Cancelled,
}

impl Failure for Trouble {
    const CANCELLED: Self = Self::Cancelled;

    fn is_cancelled(&self) -> bool {
        *self == Self::CANCELLED
    }
}

#[test]
fn statistics_are_shown_on_one_line() {
    let mut statistics = CacheStatistics {
        hits: 812,
        misses: 95,
        shared_loads: 3,
        evictions: 40,
        bytes: 13_002_342,
        most_bytes: 16 << 20,
        ..CacheStatistics::default()
    };
    assert_eq!(
        statistics.to_string(),
        "812 hits, 95 misses, 3 loads shared, 40 evictions, 12.4 MiB held, 16.0 MiB at most"
    );
    statistics.write_backs = 7;
    statistics.pinned_bytes = 1 << 19;
    assert_eq!(
        statistics.to_string(),
        "812 hits, 95 misses, 3 loads shared, 40 evictions, 7 written back, 12.4 MiB held (0.5 MiB pinned), \
         16.0 MiB at most"
    );
}
