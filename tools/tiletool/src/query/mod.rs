//! `tiletool query`: what is where, what is near, and how to get there.

mod answer;
mod ask;
mod batch;
mod print;
mod progress;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use bytesize::ByteSize;
use clap::{Args, Subcommand};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Mode, QueryOptions};
use delaunay_tiles::store::{Cache, OpenOptions, TileReader};
use futures::{StreamExt, TryStreamExt, stream};

use crate::common::{self, thousands};
use ask::Ask;
use batch::Question;
use print::{Format, Printer};

/// Ask a tile file what is where, what is near, and how to get there among obstacles.
///
/// Walls and the rings of obstacles block the way; one may walk along them, and round the outside of all, unless the file was
/// built with --exterior hole. Break lines do not block.
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct QueryArgs {
    #[command(subcommand)]
    command: QueryCommand,
}

const EXAMPLES: &str = "\
Example:
  tiletool query knn town.tiles --at 3.5,-4 -k 3
  tiletool query path town.tiles --from -1,2 --to 8,8 --geojson
  tiletool query path town.tiles --from -1,2 --to 8,8 --mode within:0.05
  tiletool query range town.tiles --batch places.csv --radius 500 --csv";

#[derive(Subcommand, Clone, Debug)]
enum QueryCommand {
    /// The vertex, edge or triangle that a point lies on or in, and whether it is free
    Locate(AtArgs),
    /// The nearest sites as the crow flies, or the nearest vertices
    Nearest(NearestArgs),
    /// The nearest sites by walking distance
    Knn(KnnArgs),
    /// All sites within a walking distance
    Range(RangeArgs),
    /// A shortest path
    Path(PathArgs),
}

#[derive(Args, Clone, Debug)]
struct AtArgs {
    #[command(flatten)]
    common: CommonArgs,
    /// A point to ask for, as X,Y; may be repeated
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = batch::point)]
    at: Vec<Point>,
}

#[derive(Args, Clone, Debug)]
struct NearestArgs {
    #[command(flatten)]
    places: AtArgs,
    /// How many
    #[arg(short, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    k: u32,
    /// Vertices, even if there are sites
    #[arg(long)]
    vertices: bool,
}

#[derive(Args, Clone, Debug)]
struct KnnArgs {
    #[command(flatten)]
    places: AtArgs,
    /// How many
    #[arg(short, default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    k: u32,
    #[command(flatten)]
    mode: ModeArgs,
    #[command(flatten)]
    progress: ProgressArgs,
}

#[derive(Args, Clone, Debug)]
struct RangeArgs {
    #[command(flatten)]
    places: AtArgs,
    /// How far away they are at most
    #[arg(long, value_name = "DISTANCE", value_parser = batch::radius)]
    radius: f64,
    #[command(flatten)]
    mode: ModeArgs,
}

#[derive(Args, Clone, Debug)]
struct PathArgs {
    #[command(flatten)]
    common: CommonArgs,
    /// Where it begins, as X,Y
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = batch::point, requires = "to")]
    from: Option<Point>,
    /// Where it ends
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = batch::point, requires = "from")]
    to: Option<Point>,
    #[command(flatten)]
    mode: ModeArgs,
    #[command(flatten)]
    progress: ProgressArgs,
}

#[derive(Args, Clone, Copy, Debug)]
struct ModeArgs {
    /// How exact: exact, fast (along edges, pulled taut, with bounds), or within:0.05 (the upper bound at most 1.05 times the lower)
    #[arg(long, value_name = "MODE", default_value = "exact")]
    mode: Mode,
}

#[derive(Args, Clone, Copy, Debug)]
struct ProgressArgs {
    /// Print the fast answer first, with its bounds and what the exact one is expected to cost, and then the exact one
    #[arg(long, conflicts_with = "mode")]
    progressive: bool,
}

#[derive(Args, Clone, Debug)]
struct CommonArgs {
    /// The tile file
    file: PathBuf,
    /// A file of points: x,y in each row, or from_x,from_y,to_x,to_y for paths; a header is passed over
    #[arg(long, value_name = "FILE.csv")]
    batch: Option<PathBuf>,
    /// Memory for tiles, as 64MiB
    #[arg(long, value_name = "SIZE", default_value = "64MiB")]
    cache: ByteSize,
    /// Different tiles that one query may read; what it found till then is the answer
    #[arg(long, value_name = "TILES")]
    max_tiles: Option<u64>,
    /// Milliseconds that one query may take
    #[arg(long, value_name = "MS")]
    max_time: Option<u64>,
    /// Prove each path by a walk through the triangles that it passes
    #[arg(long)]
    certify: bool,
    /// Queries at once; by default as many as there are processors
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Tell on standard error how long it took and what was read
    #[arg(long)]
    stats: bool,
    #[command(flatten)]
    format: FormatArgs,
}

#[derive(Args, Clone, Copy, Debug)]
#[group(multiple = false)]
struct FormatArgs {
    /// Print a JSON object for each query, on one line
    #[arg(long)]
    json: bool,
    /// Print rows of numbers in full
    #[arg(long)]
    csv: bool,
    /// Print a GeoJSON FeatureCollection
    #[arg(long)]
    geojson: bool,
}

impl FormatArgs {
    fn format(self) -> Format {
        match self {
            Self { json: true, .. } => Format::Json,
            Self { csv: true, .. } => Format::Csv,
            Self { geojson: true, .. } => Format::GeoJson,
            _ => Format::Text,
        }
    }
}

impl QueryCommand {
    /// How exact the answer is to be, and whether the fast one comes first.
    fn mode(&self) -> (Mode, bool) {
        match self {
            Self::Locate(_) | Self::Nearest(_) => (Mode::Exact, false),
            Self::Knn(args) => (args.mode.mode, args.progress.progressive),
            Self::Range(args) => (args.mode.mode, false),
            Self::Path(args) => (args.mode.mode, args.progress.progressive),
        }
    }

    /// What is asked, of which points, and with which options.
    fn parts(&self) -> (Ask, Vec<Question>, &CommonArgs) {
        let of = |places: &AtArgs| places.at.iter().map(|&at| Question::At(at)).collect();
        match self {
            Self::Locate(args) => (Ask::Locate, of(args), &args.common),
            Self::Nearest(args) => {
                let ask = Ask::Nearest {
                    k: args.k,
                    vertices: args.vertices,
                };
                (ask, of(&args.places), &args.places.common)
            }
            Self::Knn(args) => (Ask::Knn { k: args.k }, of(&args.places), &args.places.common),
            Self::Range(args) => (
                Ask::Range { radius: args.radius },
                of(&args.places),
                &args.places.common,
            ),
            Self::Path(args) => {
                let way = args.from.zip(args.to).map(|(from, to)| Question::Way(from, to));
                (Ask::Path, way.into_iter().collect(), &args.common)
            }
        }
    }
}

impl CommonArgs {
    fn options(&self, format: Format) -> QueryOptions {
        let mut options = QueryOptions::default();
        if let Some(tiles) = self.max_tiles {
            options = options.max_tiles(tiles);
        }
        if let Some(time) = self.max_time {
            options = options.max_time(Duration::from_millis(time));
        }
        if self.certify {
            options = options.certified();
        } else if format == Format::GeoJson {
            options = options.paths();
        }
        options
    }
}

/// Answers queries.
pub fn run(args: QueryArgs) -> anyhow::Result<()> {
    let (ask, mut questions, common) = args.command.parts();
    if let Some(path) = &common.batch {
        questions.extend(batch::read(path, ask == Ask::Path)?);
    } else if questions.is_empty() {
        match ask {
            Ask::Path => bail!("no path is asked for; give --from X,Y --to X,Y, or --batch FILE.csv"),
            _ => bail!("no point is asked for; give --at X,Y, or --batch FILE.csv"),
        }
    }
    common::block_on(answer_all(ask, questions, args.command.mode(), common))
}

/// Answers in parallel, and prints in order.
async fn answer_all(
    ask: Ask,
    questions: Vec<Question>,
    (mode, is_progressive): (Mode, bool),
    args: &CommonArgs,
) -> anyhow::Result<()> {
    let cache = Cache::new(usize::try_from(args.cache.as_u64()).unwrap_or(usize::MAX));
    let reader = TileReader::open(&args.file, OpenOptions::default().cache(&cache)).await?;
    let format = args.format.format();
    let options = args.options(format).mode(mode);
    let available = std::thread::available_parallelism().map_or(1, usize::from);
    let at_once = args.threads.map_or(available, usize::from);
    let began = Instant::now();
    let count = questions.len();
    let (staged, questions) = if is_progressive {
        (questions, Vec::new())
    } else {
        (Vec::new(), questions)
    };
    let answers = stream::iter(questions).map(|question| {
        let (reader, options) = (reader.clone(), options.clone());
        let task = tokio::spawn(async move { ask.answer(&reader, question, options).await });
        async move { task.await.context("a query broke down")? }
    });
    let mut answers = answers.buffered(at_once);
    let mut printer = Printer::new(format, ask, is_progressive)?;
    for question in staged {
        progress::answer(ask, &reader, question, options.clone(), &mut printer).await?;
    }
    while let Some(answer) = answers.try_next().await? {
        printer.print(&answer)?;
    }
    printer.finish()?;
    if args.stats {
        let statistics = reader.cache().statistics();
        eprintln!(
            "{} queries in {:.3} s; tiles: {} read, {} found in the cache, {} dropped from it",
            thousands(count as u64),
            began.elapsed().as_secs_f64(),
            thousands(statistics.misses),
            thousands(statistics.hits),
            thousands(statistics.evictions),
        );
    }
    Ok(())
}
