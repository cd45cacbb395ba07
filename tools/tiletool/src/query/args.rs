//! What `tiletool query` can be told.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use bytesize::ByteSize;
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Mode, QueryOptions};
use delaunay_tiles::store::{Cache, OpenOptions, TileReader};

use super::batch::{self, Question};
use crate::common::{self, thousands};
use crate::plot::PlotFile;

#[derive(Args, Clone, Debug)]
pub struct AtArgs {
    #[command(flatten)]
    pub common: CommonArgs,
    /// A point to ask for, as X,Y; may be repeated
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = batch::point)]
    pub at: Vec<Point>,
}

#[derive(Args, Clone, Debug)]
pub struct WayArgs {
    #[command(flatten)]
    pub common: CommonArgs,
    /// Where it begins, as X,Y
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = batch::point, requires = "to")]
    pub from: Option<Point>,
    /// Where it ends
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = batch::point, requires = "from")]
    pub to: Option<Point>,
}

#[derive(Args, Clone, Copy, Debug)]
pub struct ModeArgs {
    /// How exact: exact, fast (along edges, pulled taut, with bounds), or within:0.05 (the upper bound at most 1.05 times the lower)
    #[arg(long, value_name = "MODE", default_value = "exact")]
    pub mode: Mode,
}

#[derive(Args, Clone, Copy, Debug)]
pub struct ProgressArgs {
    /// Print the fast answer first, with its bounds and what the exact one is expected to cost, and then the exact one
    #[arg(long, conflicts_with = "mode")]
    pub progressive: bool,
}

/// What is read, and how much of it.
#[derive(Args, Clone, Debug)]
pub struct ReadingArgs {
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
    pub stats: bool,
}

#[derive(Args, Clone, Debug)]
pub struct CommonArgs {
    #[command(flatten)]
    pub reading: ReadingArgs,
    /// A file of points: x,y in each row, or from_x,from_y,to_x,to_y for paths and lines; a header is passed over
    #[arg(long, value_name = "FILE.csv")]
    pub batch: Option<PathBuf>,
    /// Prove each path by a walk through the triangles that it passes
    #[arg(long)]
    pub certify: bool,
    /// Queries at once; by default as many as there are processors
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Draw what is in the way, what was searched and what was found
    #[arg(long, value_name = "MAP.svg|MAP.png", value_parser = PathBufValueParser::new().try_map(PlotFile::new))]
    pub plot: Option<PlotFile>,
    #[command(flatten)]
    pub format: FormatArgs,
}

/// How answers are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Text,
    Json,
    Csv,
    GeoJson,
}

#[derive(Args, Clone, Copy, Debug)]
#[group(multiple = false)]
pub struct FormatArgs {
    /// Print a JSON object for each query, on one line
    #[arg(long)]
    pub json: bool,
    /// Print rows of numbers in full
    #[arg(long)]
    pub csv: bool,
    /// Print a GeoJSON FeatureCollection
    #[arg(long)]
    pub geojson: bool,
}

impl FormatArgs {
    pub fn format(self) -> Format {
        match self {
            Self { json: true, .. } => Format::Json,
            Self { csv: true, .. } => Format::Csv,
            Self { geojson: true, .. } => Format::GeoJson,
            _ => Format::Text,
        }
    }
}

impl WayArgs {
    pub fn ways(&self) -> Vec<Question> {
        let way = self.from.zip(self.to).map(|(from, to)| Question::Way(from, to));
        way.into_iter().collect()
    }
}

impl ReadingArgs {
    /// Opens the file, with a cache of its own.
    pub async fn open(&self) -> anyhow::Result<TileReader> {
        let cache = Cache::new(usize::try_from(self.cache.as_u64()).unwrap_or(usize::MAX));
        common::open(&self.file, OpenOptions::default().cache(&cache)).await
    }

    /// Tells on standard error how long it took and what was read, if that is asked for.
    pub fn report(&self, what: &str, count: u64, began: Instant, reader: &TileReader) {
        if !self.stats {
            return;
        }
        let statistics = reader.cache().statistics();
        common::say(format_args!(
            "{} {what} in {:.3} s; tiles: {} read, {} found in the cache, {} dropped from it",
            thousands(count),
            began.elapsed().as_secs_f64(),
            thousands(statistics.misses),
            thousands(statistics.hits),
            thousands(statistics.evictions),
        ));
    }

    /// The limits of one search.
    pub fn limits(&self) -> QueryOptions {
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
    pub fn options(&self, format: Format) -> QueryOptions {
        let mut options = self.reading.limits();
        if self.certify {
            options = options.certified();
        } else if format == Format::GeoJson || self.plot.is_some() {
            options = options.paths();
        }
        options
    }
}
