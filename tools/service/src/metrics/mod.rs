//! Measurements of the service, as Prometheus reads them.

mod process;

use std::sync::atomic::AtomicU64;

use prometheus_client::encoding::{EncodeLabelSet, text};
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::Registry;

pub use process::resident;

/// The upper ends of the classes of times, in seconds.
const CLASSES: [f64; 12] = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 5.0, 20.0];

/// What requests are counted by.
#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
pub struct Kind {
    /// The template of the path.
    pub route: String,
    /// The status code.
    pub status: u16,
}

/// What times are counted by.
#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
pub struct Route {
    /// The template of the path.
    pub route: String,
}

/// Measurements since the service began.
pub struct Metrics {
    /// Requests, by path and status.
    pub requests: Family<Kind, Counter>,
    /// Times of requests, by path.
    pub times: Family<Route, Histogram, fn() -> Histogram>,
    /// Requests in flight.
    pub in_flight: Gauge,
    /// Requests that were answered 503.
    pub rejected: Counter,
    /// Connections.
    pub connections: Gauge,
    /// Connections that were refused.
    pub refused: Counter,
    /// Requests that panicked.
    pub panics: Counter,
}

/// Numbers that others count.
#[derive(Clone, Copy, Debug, Default)]
pub struct Others {
    /// Names, helps and values of counters.
    pub counters: [(&'static str, &'static str, u64); 5],
    /// Names, helps and values of gauges.
    pub gauges: [(&'static str, &'static str, u64); 6],
}

impl Metrics {
    /// Creates measurements of nothing.
    pub fn new() -> Self {
        Self {
            requests: Family::default(),
            times: Family::new_with_constructor(|| Histogram::new(CLASSES)),
            in_flight: Gauge::default(),
            rejected: Counter::default(),
            connections: Gauge::default(),
            refused: Counter::default(),
            panics: Counter::default(),
        }
    }

    /// Returns all measurements as text.
    pub fn text(&self, others: &Others) -> String {
        let mut registry = Registry::with_prefix("delaunay_tiles");
        registry.register("requests", "Requests by path and status", self.requests.clone());
        registry.register("request_seconds", "Times of requests", self.times.clone());
        registry.register("in_flight", "Requests in flight", self.in_flight.clone());
        registry.register("rejected", "Requests that were answered 503", self.rejected.clone());
        registry.register("connections", "Connections", self.connections.clone());
        registry.register("refused", "Connections that were refused", self.refused.clone());
        registry.register("panics", "Requests that failed by a defect", self.panics.clone());
        for (name, help, value) in others.counters {
            let counter: Counter<u64, AtomicU64> = Counter::default();
            counter.inc_by(value);
            registry.register(name, help, counter);
        }
        for (name, help, value) in others.gauges {
            let gauge: Gauge = Gauge::default();
            gauge.set(i64::try_from(value).unwrap_or(i64::MAX));
            registry.register(name, help, gauge);
        }
        let mut out = String::new();
        // Writing to a string cannot fail.
        _ = text::encode(&mut out, &registry);
        out
    }
}
