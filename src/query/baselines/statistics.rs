//! The cost of an answer.

use std::time::{Duration, Instant};

/// The cost of an answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Statistics {
    /// The number of points with sites whose distances were computed; for the wavefront, the number
    /// of sites that it reported.
    pub candidates: u64,
    /// The number of different obstacle edges that were examined; for the wavefront, those at
    /// vertices that it reached.
    pub edges_considered: u64,
    /// The number of these edges in the final local visibility graph.
    pub edges_kept: u64,
    /// The number of nodes of the local visibility graph.
    pub graph_nodes: u64,
    /// The number of nodes that were swept, over all rounds; for the wavefront, the number of its
    /// roots.
    pub nodes_swept: u64,
    /// The number of edges of the local visibility graph that were found, over all rounds.
    pub graph_edges: u64,
    /// The number of searches for shortest paths.
    pub rounds: u64,
    /// The number of different tiles that were requested.
    pub tiles: u64,
    /// The time of each step.
    pub times: Vec<StepTime>,
}

/// The time of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepTime {
    /// The name of the step: `locate`, `collect` (candidates and obstacle edges), `graph` (sweeps
    /// and search), `wavefront`, `paths`.
    pub step: &'static str,
    /// The total time of the step.
    pub time: Duration,
}

impl Statistics {
    /// Returns the total time of all steps.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.times.iter().map(|step| step.time).sum()
    }
}

/// An answer, with its cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured<T> {
    /// The answer; a part of it if a limit of the options was reached.
    pub answer: T,
    /// If a limit of the options was reached: a lower bound of the distances of everything that the
    /// answer lacks.
    pub lower_bound: Option<f64>,
    /// The cost.
    pub statistics: Statistics,
}

/// Measures the time of steps.
pub(super) struct Clock {
    last: Instant,
    pub(super) times: Vec<StepTime>,
}

impl Clock {
    pub(super) fn start() -> Self {
        Self {
            last: Instant::now(),
            times: Vec::new(),
        }
    }

    /// Attributes the time since the last call to a step.
    pub(super) fn lap(&mut self, step: &'static str) {
        let now = Instant::now();
        let time = now - std::mem::replace(&mut self.last, now);
        match self.times.iter_mut().find(|known| known.step == step) {
            Some(known) => known.time += time,
            None => self.times.push(StepTime { step, time }),
        }
    }
}
