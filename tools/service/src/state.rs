//! What all requests share.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::catalog::Catalog;
use crate::finished::Finished;
use crate::limits::{Outgoing, Slots};
use crate::metrics::{Metrics, Others, resident};
use crate::options::Options;

/// A service of tile files. Clones share their state.
///
/// [`router`](crate::router) is enough for a service that others run. This one also
/// [listens](crate::serve) and ends in order.
#[derive(Clone)]
pub struct Service(Arc<Shared>);

struct Shared {
    catalog: Catalog,
    options: Options,
    slots: Slots,
    outgoing: Outgoing,
    finished: Finished,
    metrics: Metrics,
    is_draining: AtomicBool,
}

impl Service {
    /// Creates a service of these files.
    #[must_use]
    pub fn new(catalog: Catalog, options: Options) -> Self {
        Self(Arc::new(Shared {
            slots: Slots::new(options.at_once, options.queue, options.max_time),
            outgoing: Outgoing::new(options.outgoing_bytes),
            finished: Finished::new(options.finished_bytes),
            metrics: Metrics::new(),
            is_draining: AtomicBool::new(false),
            catalog,
            options,
        }))
    }

    /// Lets `/health` and all new requests for work answer 503, because the service will end.
    pub fn drain(&self) {
        self.0.is_draining.store(true, Ordering::Relaxed);
    }

    /// Returns whether the service will end.
    #[must_use]
    pub fn is_draining(&self) -> bool {
        self.0.is_draining.load(Ordering::Relaxed)
    }

    /// Returns the files.
    #[must_use]
    pub fn catalog(&self) -> &Catalog {
        &self.0.catalog
    }

    /// Returns the options.
    #[must_use]
    pub fn options(&self) -> &Options {
        &self.0.options
    }

    pub(crate) fn slots(&self) -> &Slots {
        &self.0.slots
    }

    pub(crate) fn outgoing(&self) -> &Outgoing {
        &self.0.outgoing
    }

    pub(crate) fn finished(&self) -> &Finished {
        &self.0.finished
    }

    pub(crate) fn metrics(&self) -> &Metrics {
        &self.0.metrics
    }

    /// Returns all measurements as text.
    pub(crate) fn metrics_text(&self) -> String {
        let tiles = self.catalog().cache().statistics();
        let (finished, slots) = (self.finished(), self.slots());
        let others = Others {
            counters: [
                ("tiles_read", "Tiles that were read from files", tiles.misses),
                (
                    "tile_cache_hits",
                    "Tiles that were in the cache",
                    tiles.hits + tiles.shared_loads,
                ),
                ("tile_cache_evictions", "Tiles that were evicted", tiles.evictions),
                ("map_tile_cache_hits", "Map tiles that were finished", finished.hits()),
                ("map_tile_cache_misses", "Map tiles that were drawn", finished.misses()),
            ],
            gauges: [
                ("tile_cache_bytes", "Bytes of tiles in the cache", tiles.bytes as u64),
                ("map_tile_cache_bytes", "Bytes of finished map tiles", finished.bytes()),
                ("running", "Requests that compute", slots.running() as u64),
                ("waiting", "Requests that wait to compute", slots.waiting() as u64),
                (
                    "outgoing_bytes",
                    "Bytes that wait to be read",
                    self.outgoing().bytes() as u64,
                ),
                ("resident_bytes", "Memory of the process", resident()),
            ],
        };
        self.metrics().text(&others)
    }
}
