//! What `tiletool query` can be told.

use std::path::PathBuf;
use std::time::Duration;

use bytesize::ByteSize;
use clap::builder::{PathBufValueParser, TypedValueParser};
use clap::{Args, Subcommand};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Mode, QueryOptions};
use delaunay_tiles::store::{Cache, OpenOptions, TileReader};

use super::ask::Ask;
use super::batch::{self, Question};
use super::matrix;
use super::method::{Measure, MethodArgs};
use super::print::Format;
use crate::common;
use crate::plot::PlotFile;

#[derive(Subcommand, Clone, Debug)]
pub(super) enum QueryCommand {
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
pub(super) struct AtArgs {
    #[command(flatten)]
    pub(super) common: CommonArgs,
    /// A point to ask for, as X,Y; may be repeated
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = batch::point)]
    pub(super) at: Vec<Point>,
}

#[derive(Args, Clone, Debug)]
pub(super) struct NearestArgs {
    #[command(flatten)]
    pub(super) places: AtArgs,
    /// How many
    #[arg(short, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) k: u32,
    /// Vertices, even if there are sites
    #[arg(long)]
    pub(super) vertices: bool,
}

#[derive(Args, Clone, Debug)]
pub(super) struct KnnArgs {
    #[command(flatten)]
    pub(super) places: AtArgs,
    /// How many
    #[arg(short, default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) k: u32,
    #[command(flatten)]
    pub(super) method: MethodArgs,
    #[command(flatten)]
    pub(super) mode: ModeArgs,
    #[command(flatten)]
    pub(super) progress: ProgressArgs,
}

#[derive(Args, Clone, Debug)]
pub(super) struct RangeArgs {
    #[command(flatten)]
    pub(super) places: AtArgs,
    /// How far away they are at most
    #[arg(long, value_name = "DISTANCE", value_parser = batch::radius)]
    pub(super) radius: f64,
    #[command(flatten)]
    pub(super) method: MethodArgs,
    #[command(flatten)]
    pub(super) mode: ModeArgs,
    /// Give the area within that distance, too, in --geojson and --plot: polygons whose arcs are lines, a ten-thousandth of the
    /// arc's radius inside it at most
    #[arg(long)]
    pub(super) area: bool,
}

#[derive(Args, Clone, Debug)]
pub(super) struct WayArgs {
    #[command(flatten)]
    pub(super) common: CommonArgs,
    /// Where it begins, as X,Y
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = batch::point, requires = "to")]
    pub(super) from: Option<Point>,
    /// Where it ends
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = batch::point, requires = "from")]
    pub(super) to: Option<Point>,
}

#[derive(Args, Clone, Debug)]
pub(super) struct PathArgs {
    #[command(flatten)]
    pub(super) way: WayArgs,
    #[command(flatten)]
    pub(super) method: MethodArgs,
    #[command(flatten)]
    pub(super) mode: ModeArgs,
    #[command(flatten)]
    pub(super) progress: ProgressArgs,
}

#[derive(Args, Clone, Debug)]
pub(super) struct AlongArgs {
    #[command(flatten)]
    pub(super) line: WayArgs,
    /// How many
    #[arg(short, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) k: u32,
}

#[derive(Args, Clone, Copy, Debug)]
pub(super) struct ModeArgs {
    /// How exact: exact, fast (along edges, pulled taut, with bounds), or within:0.05 (the upper bound at most 1.05 times the lower)
    #[arg(long, value_name = "MODE", default_value = "exact")]
    pub(super) mode: Mode,
}

#[derive(Args, Clone, Copy, Debug)]
pub(super) struct ProgressArgs {
    /// Print the fast answer first, with its bounds and what the exact one is expected to cost, and then the exact one
    #[arg(long, conflicts_with = "mode")]
    pub(super) progressive: bool,
}

/// What is read, and how much of it.
#[derive(Args, Clone, Debug)]
pub(super) struct ReadingArgs {
    /// The tile file
    file: PathBuf,
    /// Memory for tiles, as 64MiB
    #[arg(long, value_name = "SIZE", default_value = "64MiB")]
    cache: ByteSize,
    /// Different tiles that one search may read; what it found till then is the answer
    #[arg(long, value_name = "TILES")]
    max_tiles: Option<u64>,
    /// Milliseconds that one search may take
    #[arg(long, value_name = "MS")]
    max_time: Option<u64>,
    /// Tell on standard error how long it took and what was read
    #[arg(long)]
    pub(super) stats: bool,
}

#[derive(Args, Clone, Debug)]
pub(super) struct CommonArgs {
    #[command(flatten)]
    pub(super) reading: ReadingArgs,
    /// A file of points: x,y in each row, or from_x,from_y,to_x,to_y for paths and lines; a header is passed over
    #[arg(long, value_name = "FILE.csv")]
    pub(super) batch: Option<PathBuf>,
    /// Prove each path by a walk through the triangles that it passes
    #[arg(long)]
    pub(super) certify: bool,
    /// Queries at once; by default as many as there are processors
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
    /// Draw what is in the way, what was searched and what was found
    #[arg(long, value_name = "MAP.svg|MAP.png", value_parser = PathBufValueParser::new().try_map(PlotFile::new))]
    pub(super) plot: Option<PlotFile>,
    #[command(flatten)]
    pub(super) format: FormatArgs,
}

#[derive(Args, Clone, Copy, Debug)]
#[group(multiple = false)]
pub(super) struct FormatArgs {
    /// Print a JSON object for each query, on one line
    #[arg(long)]
    pub(super) json: bool,
    /// Print rows of numbers in full
    #[arg(long)]
    pub(super) csv: bool,
    /// Print a GeoJSON FeatureCollection
    #[arg(long)]
    pub(super) geojson: bool,
}

impl FormatArgs {
    pub(super) fn format(self) -> Format {
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
    pub(super) fn mode(&self) -> (Mode, bool) {
        match self {
            Self::Locate(_) | Self::Nearest(_) | Self::Matrix(_) | Self::Along(_) => (Mode::Exact, false),
            Self::Knn(args) => (args.mode.mode, args.progress.progressive),
            Self::Range(args) => (args.mode.mode, false),
            Self::Path(args) => (args.mode.mode, args.progress.progressive),
        }
    }

    /// What is asked, of which points, and with which options.
    pub(super) fn parts(&self) -> (Ask, Vec<Question>, &CommonArgs) {
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
            Self::Path(args) => (Ask::Path, args.way.ways(), &args.way.common),
            Self::Along(args) => (Ask::Along { k: args.k }, args.line.ways(), &args.line.common),
            Self::Matrix(_) => unreachable!("it asks for itself"),
        }
    }
}

impl QueryCommand {
    /// By which method, if that is asked for or what it costs.
    pub(super) fn measure(&self) -> Option<Measure> {
        match self {
            Self::Knn(KnnArgs { method, places, .. }) | Self::Range(RangeArgs { method, places, .. }) => {
                method.measure(places.common.reading.stats)
            }
            Self::Path(PathArgs { method, way, .. }) => method.measure(way.common.reading.stats),
            Self::Locate(_) | Self::Nearest(_) | Self::Matrix(_) | Self::Along(_) => None,
        }
    }
}

impl WayArgs {
    pub(super) fn ways(&self) -> Vec<Question> {
        let way = self.from.zip(self.to).map(|(from, to)| Question::Way(from, to));
        way.into_iter().collect()
    }
}

impl ReadingArgs {
    /// Opens the file, with a cache of its own.
    pub(super) async fn open(&self) -> anyhow::Result<TileReader> {
        let cache = Cache::new(usize::try_from(self.cache.as_u64()).unwrap_or(usize::MAX));
        common::open(&self.file, OpenOptions::default().cache(&cache)).await
    }

    /// The limits of one search.
    pub(super) fn limits(&self) -> QueryOptions {
        let mut options = QueryOptions::default();
        if let Some(tiles) = self.max_tiles {
            options = options.max_tiles(tiles);
        }
        if let Some(time) = self.max_time {
            options = options.max_time(Duration::from_millis(time));
        }
        options
    }
}

impl CommonArgs {
    pub(super) fn options(&self, format: Format) -> QueryOptions {
        let mut options = self.reading.limits();
        if self.certify {
            options = options.certified();
        } else if format == Format::GeoJson || self.plot.is_some() {
            options = options.paths();
        }
        options
    }
}
