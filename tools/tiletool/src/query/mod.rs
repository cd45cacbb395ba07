//! `tiletool query`: what is where, what is near, and how to get there.

mod along;
mod answer;
mod area;
mod ask;
mod batch;
mod matrix;
mod method;
mod picture;
mod print;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use bytesize::ByteSize;
use clap::builder::{PathBufValueParser, TypedValueParser};
use clap::{Args, Subcommand};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Explored, QueryOptions};
use delaunay_tiles::store::{Cache, OpenOptions, TileReader};
use futures::{StreamExt, TryStreamExt, stream};

use crate::common::{self, thousands};
use crate::plot::{self, PlotFile};
use ask::Ask;
use batch::Question;
use method::{Measure, MethodArgs};
use picture::Picture;
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
  tiletool query range town.tiles --batch places.csv --radius 500 --csv
  tiletool query range town.tiles --at 7,7 --radius 500 --area --plot reach.png
  tiletool query along town.tiles --from -1,2 --to 8,8 -k 3";

#[derive(Subcommand, Clone, Debug)]
enum QueryCommand {
    /// The vertex, edge or triangle that a point lies on or in, and whether it is free
    Locate(AtArgs),
    /// The nearest sites as the crow flies, or the nearest vertices
    Nearest(NearestArgs),
    /// The nearest sites by walking distance
    Knn(KnnArgs),
    /// All sites within a walking distance, and the area
    Range(RangeArgs),
    /// A shortest path
    Path(PathArgs),
    Matrix(matrix::MatrixArgs),
    /// The nearest sites along a straight line: the intervals on which they stay the same
    Along(AlongArgs),
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
    method: MethodArgs,
}

#[derive(Args, Clone, Debug)]
struct RangeArgs {
    #[command(flatten)]
    places: AtArgs,
    /// How far away they are at most
    #[arg(long, value_name = "DISTANCE", value_parser = batch::radius)]
    radius: f64,
    #[command(flatten)]
    method: MethodArgs,
    /// Give the area within that distance, too, in --geojson and --plot: polygons whose arcs are lines, a ten-thousandth of the
    /// arc's radius inside it at most
    #[arg(long)]
    area: bool,
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
    method: MethodArgs,
}

#[derive(Args, Clone, Debug)]
struct AlongArgs {
    #[command(flatten)]
    line: PathArgs,
    /// How many
    #[arg(short, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    k: u32,
}

#[derive(Args, Clone, Debug)]
struct CommonArgs {
    /// The tile file
    file: PathBuf,
    /// A file of points: x,y in each row, or from_x,from_y,to_x,to_y for paths and lines; a header is passed over
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
    /// Draw what is in the way, what was searched and what was found
    #[arg(long, value_name = "MAP.svg|MAP.png", value_parser = PathBufValueParser::new().try_map(PlotFile::new))]
    plot: Option<PlotFile>,
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
                Ask::Range {
                    radius: args.radius,
                    area: args.area,
                },
                of(&args.places),
                &args.places.common,
            ),
            Self::Path(args) => (Ask::Path, args.ways(), &args.common),
            Self::Along(args) => (Ask::Along { k: args.k }, args.line.ways(), &args.line.common),
            Self::Matrix(_) => unreachable!("it asks for itself"),
        }
    }
}

impl QueryCommand {
    /// By which method, if that is asked for or what it costs.
    fn measure(&self) -> Option<Measure> {
        match self {
            Self::Knn(KnnArgs { method, places, .. }) | Self::Range(RangeArgs { method, places, .. }) => {
                method.measure(places.common.stats)
            }
            Self::Path(PathArgs { method, common, .. }) => method.measure(common.stats),
            Self::Locate(_) | Self::Nearest(_) | Self::Matrix(_) | Self::Along(_) => None,
        }
    }
}

impl PathArgs {
    fn ways(&self) -> Vec<Question> {
        let way = self.from.zip(self.to).map(|(from, to)| Question::Way(from, to));
        way.into_iter().collect()
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
        } else if format == Format::GeoJson || self.plot.is_some() {
            options = options.paths();
        }
        options
    }
}

/// Answers queries.
pub fn run(args: QueryArgs) -> anyhow::Result<()> {
    if let QueryCommand::Matrix(args) = &args.command {
        return matrix::run(args);
    }
    let measure = args.command.measure();
    let (ask, mut questions, common) = args.command.parts();
    if let Some(path) = &common.batch {
        questions.extend(batch::read(path, matches!(ask, Ask::Path | Ask::Along { .. }))?);
    } else if questions.is_empty() {
        match ask {
            Ask::Along { .. } => bail!("no line is given; give --from X,Y --to X,Y, or --batch FILE.csv"),
            Ask::Path => bail!("no path is asked for; give --from X,Y --to X,Y, or --batch FILE.csv"),
            _ => bail!("no point is asked for; give --at X,Y, or --batch FILE.csv"),
        }
    }
    if matches!(ask, Ask::Range { area: true, .. }) && common.plot.is_none() && !common.format.geojson {
        bail!("--area is given as GeoJSON or drawn: add --geojson or --plot MAP.svg");
    }
    if matches!(ask, Ask::Range { area: true, .. }) && measure.is_some_and(|measure| !measure.is_wave()) {
        bail!("only --method wave gives an --area");
    }
    common::block_on(answer_all(ask, measure, questions, common))
}

/// Answers in parallel, and prints in order.
async fn answer_all(
    ask: Ask,
    measure: Option<Measure>,
    questions: Vec<Question>,
    args: &CommonArgs,
) -> anyhow::Result<()> {
    let cache = Cache::new(usize::try_from(args.cache.as_u64()).unwrap_or(usize::MAX));
    let reader = TileReader::open(&args.file, OpenOptions::default().cache(&cache)).await?;
    let format = args.format.format();
    let mut options = args.options(format);
    let explored = Explored::default();
    // For several queries a picture of what was searched would show little.
    if args.plot.is_some() && questions.len() == 1 {
        options = options.explored(&explored);
    }
    let available = std::thread::available_parallelism().map_or(1, usize::from);
    let at_once = args.threads.map_or(available, usize::from);
    let began = Instant::now();
    let count = questions.len();
    let answers = stream::iter(questions).map(|question| {
        let (reader, options) = (reader.clone(), options.clone());
        let task = tokio::spawn(async move {
            match measure {
                Some(measure) => measure.answer(ask, &reader, question, options).await,
                None => ask.answer(&reader, question, options).await,
            }
        });
        async move { task.await.context("a query broke down")? }
    });
    let mut answers = answers.buffered(at_once);
    let mut printer = Printer::new(format, ask)?;
    let mut picture = args.plot.as_ref().map(|_| Picture::new());
    while let Some(answer) = answers.try_next().await? {
        printer.print(&answer)?;
        if let (Some(statistics), true) = (&answer.statistics, format != Format::Json) {
            eprintln!("{}", method::line(statistics));
        }
        if let Some(picture) = &mut picture {
            picture.take(ask, &answer);
        }
    }
    printer.finish()?;
    if let (Some(picture), Some(file)) = (picture, &args.plot) {
        plot::draw_query(&reader, file, &picture.finish(&explored)).await?;
    }
    if args.stats {
        report("queries", count as u64, began, &reader);
    }
    Ok(())
}

/// Tells on standard error how long it took and what was read.
fn report(what: &str, count: u64, began: Instant, reader: &TileReader) {
    let statistics = reader.cache().statistics();
    eprintln!(
        "{} {what} in {:.3} s; tiles: {} read, {} found in the cache, {} dropped from it",
        thousands(count),
        began.elapsed().as_secs_f64(),
        thousands(statistics.misses),
        thousands(statistics.hits),
        thousands(statistics.evictions),
    );
}
