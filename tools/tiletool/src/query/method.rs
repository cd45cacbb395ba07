//! By which method distances are found, and what an answer cost.

use clap::{Args, ValueEnum};
use delaunay_tiles::query::baselines::{Measured, Method, Statistics, Stretch};
use delaunay_tiles::query::{PathOutcome, QueryOptions, SiteFound};
use delaunay_tiles::store::TileReader;
use serde_json::{Map, Value, json};

use super::answer::{Answer, Found, Status};
use super::ask::{Ask, path_found};
use super::batch::Question;
use crate::common::thousands;

/// A stretch factor that may hold.
fn stretch(text: &str) -> Result<Stretch, String> {
    let stretch = text.parse().map_err(|_| "a stretch factor is a number".to_owned())?;
    Stretch::new(stretch).map_err(|error| error.to_string())
}

/// How distances are found.
#[derive(Args, Clone, Copy, Debug)]
pub struct MethodArgs {
    /// How distances among obstacles are found; the answers are the same
    #[arg(long, value_enum, default_value_t = Name::Wave)]
    method: Name,
    /// What the distance along edges is of the walking distance at most, for --method visibility: 2.42 is proved, and less than
    /// 1.5932 refused
    #[arg(long, value_name = "T", default_value = "2.42", value_parser = stretch)]
    stretch: Stretch,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Name {
    /// The library's own: intervals of sides, nearest first
    Wave,
    /// Wu's thesis: a local visibility graph of what is near along edges
    Visibility,
    /// Zhang et al. 2004: a local visibility graph in a disc that grows
    EuclidZhang,
    /// Xia et al. 2004: a local visibility graph of what paths run into
    EuclidXia,
}

/// A method whose cost may be of interest.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    method: Method,
    tells: bool,
}

impl MethodArgs {
    /// The method, unless it is the one that needs no name and nobody wants to know what it costs.
    pub fn measure(self, tells: bool) -> Option<Measure> {
        let method = match self.method {
            Name::Wave => Method::Wave,
            Name::Visibility => Method::Visibility { stretch: self.stretch },
            Name::EuclidZhang => Method::EuclidZhang,
            Name::EuclidXia => Method::EuclidXia,
        };
        (tells || method != Method::Wave).then_some(Measure { method, tells })
    }
}

impl Measure {
    /// Whether it is the library's own method.
    pub fn is_wave(self) -> bool {
        self.method == Method::Wave
    }

    /// The answer to a question, with what it cost.
    pub async fn answer(
        self,
        ask: Ask,
        reader: &TileReader,
        question: Question,
        options: QueryOptions,
    ) -> anyhow::Result<Answer> {
        let (method, given) = (self.method, options.clone());
        let measured = match (ask, question) {
            (Ask::Knn { k }, Question::At(at)) => {
                let found = reader.nearest_sites_by(method, at, k as usize, given).await;
                found.map(sites)
            }
            (Ask::Range { radius, area: false }, Question::At(at)) => {
                let found = reader.sites_within_by(method, at, radius, given).await;
                found.map(sites)
            }
            (_, Question::Way(from, to)) => reader.shortest_path_by(method, from, to, given).await.map(path),
            (_, Question::At(_)) => return ask.answer(reader, question, options).await,
        };
        let (status, found, statistics) = match measured {
            Err(error) => (Status::of(error)?, Found::nothing(question), None),
            Ok((status, found, statistics)) => (status, found, Some(statistics)),
        };
        Ok(Answer {
            question,
            status,
            found,
            area: None,
            statistics: statistics.filter(|_| self.tells),
        })
    }
}

fn sites(measured: Measured<Vec<SiteFound>>) -> (Status, Found, Statistics) {
    let status = measured.at_least.map_or(Status::Ok, Status::Budget);
    (status, Found::Sites(measured.answer), measured.statistics)
}

fn path(measured: Measured<PathOutcome>) -> (Status, Found, Statistics) {
    let (status, found) = path_found(measured.answer);
    (status, found, measured.statistics)
}

/// What an answer cost, for programs.
pub fn object(statistics: &Statistics) -> Value {
    let times = statistics.times.iter();
    let milliseconds: Map<String, Value> = times
        .map(|step| (step.step.to_owned(), (1e3 * step.time.as_secs_f64()).into()))
        .collect();
    json!({
        "candidates": statistics.candidates,
        "edges_considered": statistics.edges_considered,
        "edges_kept": statistics.edges_kept,
        "graph_nodes": statistics.graph_nodes,
        "graph_edges": statistics.graph_edges,
        "nodes_swept": statistics.nodes_swept,
        "rounds": statistics.rounds,
        "tiles": statistics.tiles,
        "milliseconds": milliseconds,
    })
}

/// What an answer cost, for people.
pub fn line(statistics: &Statistics) -> String {
    let times = statistics.times.iter();
    let times: Vec<String> = times
        .map(|step| format!("{} {:.3}", step.step, 1e3 * step.time.as_secs_f64()))
        .collect();
    format!(
        "candidates: {}; constraint edges: {} considered, {} kept; graph: {} nodes, {} swept, {} edges, {} rounds; tiles: {}; ms: {}",
        thousands(statistics.candidates),
        thousands(statistics.edges_considered),
        thousands(statistics.edges_kept),
        thousands(statistics.graph_nodes),
        thousands(statistics.nodes_swept),
        thousands(statistics.graph_edges),
        thousands(statistics.rounds),
        thousands(statistics.tiles),
        times.join(", "),
    )
}
