//! `lab query`: answers by any method, and their cost.

use anyhow::bail;
use clap::{Args, Subcommand, ValueEnum};
use delaunay_tiles::query::baselines::{Measured, Method, Statistics, Stretch};
use delaunay_tiles::query::{Mode, PathOutcome, QueryOptions, SiteFound};
use delaunay_tiles::store::TileReader;
use serde_json::{Map, Value, json};

use tiletool::common::thousands;
use tiletool::query;
use tiletool::query::answer::{self, Answer, QueryResult, Status};
use tiletool::query::ask::{Ask, path_found};
use tiletool::query::command::{KnnArgs, PathArgs, QueryCommand, RangeArgs};
use tiletool::query::question::Question;

/// Ask a tile file for the nearest sites and for shortest paths, by any method, and for their cost.
///
/// Like `tiletool query`, with --method. With --stats each answer reports its cost.
#[derive(Args, Clone, Debug)]
pub struct QueryArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Clone, Debug)]
enum Command {
    /// The nearest sites by walking distance
    Knn(By<KnnArgs>),
    /// All sites within a walking distance, and the area
    Range(By<RangeArgs>),
    /// A shortest path
    Path(By<PathArgs>),
}

/// A question, and the method that answers it.
#[derive(Args, Clone, Debug)]
struct By<A: Args> {
    #[command(flatten)]
    question: A,
    #[command(flatten)]
    method: MethodArgs,
}

/// Answers queries.
pub fn run(args: &QueryArgs) -> anyhow::Result<()> {
    let (command, method) = match args.command.clone() {
        Command::Knn(by) => (QueryCommand::Knn(by.question), by.method),
        Command::Range(by) => (QueryCommand::Range(by.question), by.method),
        Command::Path(by) => (QueryCommand::Path(by.question), by.method),
    };
    let ((mode, is_progressive), (ask, _, common)) = (command.mode(), command.parts());
    let is_exact = mode == Mode::Exact && !is_progressive;
    let method = method.method();
    if method != Method::Wavefront {
        if matches!(ask, Ask::Range { area: true, .. }) {
            bail!("only --method wavefront gives an --area");
        } else if !is_exact {
            bail!("only --method wavefront has a --mode, or is --progressive; the others are exact");
        }
    }
    let reports_cost = common.reading.stats;
    // Modes other than exact are not measured.
    let measure =
        (is_exact && (reports_cost || method != Method::Wavefront)).then_some(Measure { method, reports_cost });
    query::answer(&command, move |ask, reader, question, options| async move {
        match measure {
            Some(measure) => measure.answer(ask, &reader, question, options).await,
            None => ask.answer(&reader, question, options).await,
        }
    })
}

/// Parses a stretch factor, which must be large enough.
fn stretch(text: &str) -> Result<Stretch, String> {
    let stretch = text.parse().map_err(|_| "a stretch factor is a number".to_owned())?;
    Stretch::new(stretch).map_err(|error| error.to_string())
}

/// The method that finds distances.
#[derive(Args, Clone, Copy, Debug)]
struct MethodArgs {
    /// The method that finds distances among obstacles; all methods give the same answers
    #[arg(long, value_enum, default_value_t = Name::Wavefront)]
    method: Name,
    /// The maximum ratio of the distance along edges to the walking distance, for --method
    /// visibility: 2.42 is proved, and less than 1.5932 is refused
    #[arg(long, value_name = "T", default_value = "2.42", value_parser = stretch)]
    stretch: Stretch,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Name {
    /// The library's own: a wavefront of intervals of edges, nearest first
    Wavefront,
    /// Wu's thesis: a local visibility graph of the obstacles near along edges
    Visibility,
    /// Zhang et al. 2004: a local visibility graph in a growing disc
    EuclidZhang,
    /// Xia et al. 2004: a local visibility graph of the obstacles that paths meet
    EuclidXia,
}

/// A method whose cost may be reported.
#[derive(Clone, Copy, Debug)]
struct Measure {
    method: Method,
    reports_cost: bool,
}

impl MethodArgs {
    fn method(self) -> Method {
        match self.method {
            Name::Wavefront => Method::Wavefront,
            Name::Visibility => Method::Visibility { stretch: self.stretch },
            Name::EuclidZhang => Method::EuclidZhang,
            Name::EuclidXia => Method::EuclidXia,
        }
    }
}

impl Measure {
    /// Answers a question, and reports the cost.
    async fn answer(
        self,
        ask: Ask,
        reader: &TileReader,
        question: Question,
        options: QueryOptions,
    ) -> anyhow::Result<Answer> {
        let (method, given) = (self.method, options.clone());
        let measured = match (ask, question) {
            (Ask::Knn { k, .. }, Question::At(at)) => {
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
            Err(error) => (Status::of(error)?, QueryResult::nothing(question), None),
            Ok((status, found, statistics)) => (status, found, Some(statistics)),
        };
        Ok(Answer {
            question,
            status,
            found,
            area: None,
            cost: statistics.filter(|_| self.reports_cost).map(|its| answer::Measured {
                object: object(&its),
                line: line(&its),
            }),
        })
    }
}

fn sites(measured: Measured<Vec<SiteFound>>) -> (Status, QueryResult, Statistics) {
    let status = measured.lower_bound.map_or(Status::Ok, Status::Budget);
    (status, QueryResult::Sites(measured.answer), measured.statistics)
}

fn path(measured: Measured<PathOutcome>) -> (Status, QueryResult, Statistics) {
    let (status, found) = path_found(measured.answer);
    (status, found, measured.statistics)
}

/// Returns the cost of an answer as JSON.
fn object(statistics: &Statistics) -> Value {
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

/// Returns the cost of an answer as a line of text.
fn line(statistics: &Statistics) -> String {
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
