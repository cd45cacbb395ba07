//! `lab query`: answers by any method, and what they cost.

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
use tiletool::query::batch::Question;
use tiletool::query::command::{KnnArgs, PathArgs, QueryCommand, RangeArgs};

/// Ask a tile file what is near and how to get there, by any method, and what that costs.
///
/// As `tiletool query`, with --method. With --stats each answer tells what it cost.
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

/// A question, and by which method it is answered.
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
            bail!("only --method wave gives an --area");
        } else if !is_exact {
            bail!("only --method wave has a --mode, or is --progressive; the others are exact");
        }
    }
    let tells = common.reading.stats;
    // What a mode other than exact costs is not measured.
    let measure = (is_exact && (tells || method != Method::Wavefront)).then_some(Measure { method, tells });
    query::answer(&command, move |ask, reader, question, options| async move {
        match measure {
            Some(measure) => measure.answer(ask, &reader, question, options).await,
            None => ask.answer(&reader, question, options).await,
        }
    })
}

/// A stretch factor that may hold.
fn stretch(text: &str) -> Result<Stretch, String> {
    let stretch = text.parse().map_err(|_| "a stretch factor is a number".to_owned())?;
    Stretch::new(stretch).map_err(|error| error.to_string())
}

/// How distances are found.
#[derive(Args, Clone, Copy, Debug)]
struct MethodArgs {
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
struct Measure {
    method: Method,
    tells: bool,
}

impl MethodArgs {
    fn method(self) -> Method {
        match self.method {
            Name::Wave => Method::Wavefront,
            Name::Visibility => Method::Visibility { stretch: self.stretch },
            Name::EuclidZhang => Method::EuclidZhang,
            Name::EuclidXia => Method::EuclidXia,
        }
    }
}

impl Measure {
    /// The answer to a question, with what it cost.
    async fn answer(
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
            Err(error) => (Status::of(error)?, QueryResult::nothing(question), None),
            Ok((status, found, statistics)) => (status, found, Some(statistics)),
        };
        Ok(Answer {
            question,
            status,
            found,
            area: None,
            cost: statistics.filter(|_| self.tells).map(|its| answer::Measured {
                object: object(&its),
                line: line(&its),
            }),
        })
    }
}

fn sites(measured: Measured<Vec<SiteFound>>) -> (Status, QueryResult, Statistics) {
    let status = measured.at_least.map_or(Status::Ok, Status::Budget);
    (status, QueryResult::Sites(measured.answer), measured.statistics)
}

fn path(measured: Measured<PathOutcome>) -> (Status, QueryResult, Statistics) {
    let (status, found) = path_found(measured.answer);
    (status, found, measured.statistics)
}

/// What an answer cost, for programs.
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

/// What an answer cost, for people.
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
