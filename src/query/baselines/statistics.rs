//! What an answer cost.

use std::time::{Duration, Instant};

/// What an answer cost.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Places with sites that distances were computed to; by the wave those that it told.
    pub candidates: u64,
    /// Different obstacle edges that were looked at; of the wave: at vertices that it reached.
    pub edges_considered: u64,
    /// Those of them that the local visibility graph was made of in the end.
    pub edges_kept: u64,
    /// Nodes of the local visibility graph.
    pub graph_nodes: u64,
    /// Nodes that were swept, over all rounds; by the wave those that it turned round.
    pub nodes_swept: u64,
    /// Edges of the local visibility graph that were found, over all rounds.
    pub graph_edges: u64,
    /// How often shortest paths were searched for.
    pub rounds: u64,
    /// Different tiles that were asked for.
    pub tiles: u64,
    /// How long each step took.
    pub times: Vec<StepTime>,
}

/// How long a step took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepTime {
    /// What was done: `locate`, `collect` candidates and obstacle edges, `graph` (sweeps and search), `wave`, `paths`.
    pub step: &'static str,
    /// How long it took, in all.
    pub time: Duration,
}

impl Statistics {
    /// How long all steps took.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.times.iter().map(|step| step.time).sum()
    }
}

/// An answer, and what it cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured<T> {
    /// The answer; as far as it was found, if the options' limits were reached.
    pub answer: T,
    /// If the options' limits were reached: all that the answer lacks is at least as far away.
    pub at_least: Option<f64>,
    /// What it cost.
    pub statistics: Statistics,
}

/// Measures steps.
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

    /// What was done since the last step was this one.
    pub(super) fn lap(&mut self, step: &'static str) {
        let now = Instant::now();
        let time = now - std::mem::replace(&mut self.last, now);
        match self.times.iter_mut().find(|known| known.step == step) {
            Some(known) => known.time += time,
            None => self.times.push(StepTime { step, time }),
        }
    }
}
