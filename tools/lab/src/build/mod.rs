//! `lab build`: how builds scale with the points and with the segments, as in section 3.5 of Wu's
//! thesis.
//!
//! The input is sizes, shares of segments, and memory. Each set of points is generated,
//! triangulated by `tiletool build` and by its peers, each in a process of its own that is measured
//! from outside, and removed again. The output is `builds.csv` with a row for each process, and a
//! page with tables of medians and charts.

mod plan;
mod record;
mod report;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, bail, ensure};
use bytesize::ByteSize;
use clap::Args;
use delaunay_tiles::BuildOptions;
use distributions::Kind;
use indicatif::{ProgressBar, ProgressStyle};

use super::folder::Folder;
use super::peer::{self, Peer};
use super::pictures::Pictures;
use super::table::Table;
use super::tiles::own_program;
use limited::{Ended, Limit, Took, measure};
use plan::{BuildPlan, Data};
use record::{Engine, Measured, Record};
use tiletool::bench::caches;
use tiletool::common;
use tiletool::generate::parse_count;

/// Measure builds of growing size, and triangulators in memory.
///
/// The points are distributed as in Wu's thesis: uniform, by Kuzmin's distribution, and with a line
/// singularity; without segments, and with about ALPHA segments for each point. Each build and each
/// peer is a process of its own. At the end they run again under a hard limit of memory, which ends
/// those that work in memory. The defaults take a few minutes.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  lab build -o results
  lab build -o results --sizes 1M,10M,100M --memory 512MiB --limit 2GiB --rounds 3")]
pub struct BuildExperimentArgs {
    /// The folder for the results
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Numbers of points: 100000, 1e6, 1.5M
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = parse_size,
        default_values = ["100k", "200k", "500k", "1M", "2M"])]
    sizes: Vec<u64>,
    /// Distributions of the points: uniform, kuzmin, line-singularity
    #[arg(long, value_name = "KIND,…", value_delimiter = ',', value_parser = parse_kind,
        default_values = plan::KINDS.map(Kind::name))]
    distributions: Vec<Kind>,
    /// Segments for each point, from 0 to 1
    #[arg(long, value_name = "ALPHA,…", value_delimiter = ',', value_parser = parse_share,
        default_values = ["0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7", "0.8", "0.9"])]
    alphas: Vec<f64>,
    /// Number of points of the builds against ALPHA; by default the size in the middle
    #[arg(long, value_name = "N", value_parser = parse_size)]
    alpha_size: Option<u64>,
    /// Memory that `tiletool build` may use
    #[arg(long, value_name = "SIZE", default_value = "64MiB")]
    memory: ByteSize,
    /// The maximum number of vertices of a tile; little memory needs small tiles
    #[arg(long, value_name = "N", default_value_t = BuildOptions::default().tile_vertices)]
    tile_vertices: usize,
    /// The hard limit of the last builds; by default twice --memory
    #[arg(long, value_name = "SIZE")]
    limit: Option<ByteSize>,
    /// Computing threads of `tiletool build`; by default one for each processor
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    threads: Option<u32>,
    /// Number of measurements of each process; the tables have medians
    #[arg(long, value_name = "R", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Seed of the sets of points
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Triangulators to compare with, on the first distribution; none if no peer follows
    #[arg(long, value_name = "PEER,…", value_delimiter = ',', num_args = 0.., default_values = ["spade", "triangle"])]
    peers: Vec<Peer>,
    #[command(flatten)]
    pictures: Pictures,
}

/// The maximum number of points of a set: records have numbers of 32 bits.
const MOST: u64 = 1 << 32;
/// Bytes of disk for a point: the input, work, the tiles, and a copy as text for the program
/// triangle.
const DISK_PER_POINT: u64 = 400;

fn parse_size(text: &str) -> Result<u64, String> {
    match parse_count(text) {
        Ok(size) if (3..MOST).contains(&size) => Ok(size),
        Ok(_) => Err("sizes are from 3 up to 2^32".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

fn parse_kind(text: &str) -> Result<Kind, String> {
    let kind: Kind = text
        .parse()
        .map_err(|error: distributions::UnknownKind| error.to_string())?;
    match plan::KINDS.contains(&kind) {
        true => Ok(kind),
        false => Err(format!(
            "{kind} has no segments; take uniform, kuzmin or line-singularity"
        )),
    }
}

fn parse_share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("shares are from 0 to 1".to_owned()),
    }
}

/// Seconds after which a peer is slow: it is not measured again on the same points.
const SLOW: f64 = 60.0;

/// What was measured so far.
#[derive(Default)]
struct Results {
    records: Vec<Record>,
    notes: Vec<String>,
}

impl Results {
    /// Returns whether any build of ours succeeded.
    fn have_builds(&self) -> bool {
        let mut ours = self.records.iter().filter(|record| record.engine == Engine::Ours);
        ours.any(Record::is_done)
    }
}

/// The state that all processes of an experiment share.
struct Bench<'a> {
    args: &'a BuildExperimentArgs,
    program: PathBuf,
    triangle: Option<PathBuf>,
    threads: u32,
    limit: Limit,
    scratch: &'a Path,
    stop: &'a AtomicBool,
}

/// Runs the experiment, and writes its results.
pub fn run(args: BuildExperimentArgs) -> anyhow::Result<()> {
    let stop = common::interruption();
    let mut folder = Folder::create(&args.output)?;
    let plan = BuildPlan::new(&args.distributions, &args.sizes, &args.alphas, args.alpha_size);
    folder.require(DISK_PER_POINT.saturating_mul(plan.largest()))?;
    let available = std::thread::available_parallelism().map_or(1, usize::from);
    let limit = args.limit.map_or(2 * args.memory.as_u64(), |limit| limit.as_u64());
    // The children run in the work folder, so paths for them must be absolute.
    let scratch = folder.scratch().canonicalize().context("cannot find the work folder")?;
    let mut bench = Bench {
        args: &args,
        program: own_program()?,
        triangle: None,
        threads: args.threads.unwrap_or(available as u32),
        limit: Limit::new(limit),
        scratch: &scratch,
        stop: &stop,
    };
    let mut results = Results::default();
    if args.peers.contains(&Peer::Triangle) {
        bench.triangle = peer::find_triangle();
        if bench.triangle.is_none() {
            let note = "The program `triangle` is not installed here, so it is not among the peers.";
            results.notes.push(note.to_owned());
        }
    }
    let bar = ProgressBar::new(plan.data().len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} {msg} {eta}") {
        bar.set_style(style);
    }
    for data in plan.data() {
        bar.set_message(data.to_string());
        bench.measure_all(data, &plan, &mut results)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let Results { records, mut notes } = results;
    notes.extend(record::contradictions(&records));
    let measured = Measured {
        records,
        notes,
        plan,
        threads: bench.threads,
        memory: args.memory.as_u64(),
        limit: bench.limit,
        rounds: args.rounds,
    };
    folder.keep("builds.csv", Table::of(record::COLUMNS, &measured.records).csv());
    report::keep(&measured, args.pictures, &mut folder)?;
    folder.publish()
}

impl Bench<'_> {
    /// Generates a set of points, triangulates it with all engines, and removes it.
    fn measure_all(&self, data: &Data, plan: &BuildPlan, results: &mut Results) -> anyhow::Result<()> {
        let (points, segments) = (self.scratch.join("points.f64"), self.scratch.join("points.u32"));
        let mut generate = Command::new(&self.program);
        generate.args(["tool", "generate", data.kind.name(), "-n", &data.points.to_string()]);
        generate
            .args(["--seed", &self.args.seed.to_string(), "-o"])
            .arg(&points);
        if let Some(alpha) = data.alpha {
            generate.args(["--pslg", &alpha.to_string()]);
        }
        let took = measure(generate, self.scratch, None, self.stop)?;
        if took.ended != Ended::Done {
            bail!("{data}: the points could not be generated: {}", took.complaint());
        }
        let segments = data.alpha.map(|_| segments);
        let input = [Some(&points), segments.as_ref()];
        let bytes = |path: &&PathBuf| std::fs::metadata(path).map_or(0, |its| its.len());
        let input_bytes = input.iter().flatten().map(bytes).sum();
        let mut engines = vec![Engine::Ours];
        let peers = self.args.peers.iter().filter(|_| plan.has_peers(data));
        engines.extend(peers.map(|&peer| Engine::Peer(peer)));
        engines.retain(|&engine| engine != Engine::Peer(Peer::Triangle) || self.triangle.is_some());
        let limits = [Some(None), plan.is_limited(data).then_some(Some(&self.limit))];
        // Alternately, so that other work on this machine affects all alike.
        for round in 0..self.args.rounds {
            let mut slow = Vec::new();
            for limit in limits.iter().flatten() {
                for &engine in &engines {
                    for file in input.iter().flatten() {
                        caches::drop_file(file)?;
                    }
                    let took = self.measure_one(engine, &points, segments.as_deref(), *limit)?;
                    if engine == Engine::Ours && limit.is_none() && took.ended != Ended::Done {
                        let failure = format!("{data}: the build failed: {}", took.complaint());
                        // What was measured is kept.
                        ensure!(results.have_builds(), failure);
                        results.notes.push(failure);
                    }
                    if engine != Engine::Ours && took.seconds > SLOW {
                        slow.push(engine);
                    }
                    let limit = limit.map(|limit| limit.bytes);
                    let record = Record::new(engine, *data, round, limit, input_bytes, took)?;
                    results.records.push(record);
                }
            }
            engines.retain(|engine| !slow.contains(engine));
        }
        Ok(())
    }

    /// Triangulates a set of points with one engine, in a process of its own.
    fn measure_one(
        &self,
        engine: Engine,
        points: &Path,
        segments: Option<&Path>,
        limit: Option<&Limit>,
    ) -> anyhow::Result<Took> {
        let program = match (engine, &self.triangle) {
            (Engine::Peer(Peer::Triangle), Some(triangle)) => triangle,
            _ => &self.program,
        };
        let mut command = limit.map_or_else(|| Command::new(program), |limit| limit.command(program.as_os_str()));
        match engine {
            Engine::Ours => {
                let (threads, memory) = (self.threads.to_string(), self.args.memory.as_u64());
                command
                    .args(["tool", "build"])
                    .arg(points)
                    .args(["-o", "points.tiles", "--force", "--json"]);
                command.args(["--threads", &threads, "--memory", &format!("{memory}B")]);
                command.args(["--tile-vertices", &self.args.tile_vertices.to_string()]);
                segments.map(|path| command.arg("--segments").arg(path));
            }
            Engine::Peer(Peer::Spade) => {
                command.arg("peer").arg(points);
                segments.map(|path| command.arg("--segments").arg(path));
            }
            Engine::Peer(Peer::Triangle) => {
                let (options, name) = match segments {
                    None => ("-Q", "points.node"),
                    // With `c` the program keeps the triangles between the segments and the hull.
                    Some(_) => ("-pcQ", "points.poly"),
                };
                peer::write_for_triangle(points, segments, &self.scratch.join(name))?;
                command.args([options, name]);
            }
        }
        measure(command, self.scratch, limit.and_then(Limit::watched), self.stop)
    }
}
