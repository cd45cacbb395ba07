//! The options of `tiletool query`.

use std::ops::Deref;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use bytesize::ByteSize;
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use delaunay_tiles::crs::Crs;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Mode, QueryOptions, Search};
use delaunay_tiles::store::{Cache, OpenOptions, TileReader};
use delaunay_tiles_answers::question::{self, Question};
use delaunay_tiles_answers::units::{Measure, unit};

use crate::common::{self, thousands};
use crate::crs::CrsArgs;
use crate::plot::{PlotFile, TitleArgs};

#[derive(Args, Clone, Debug)]
pub struct AtArgs {
    #[command(flatten)]
    pub common: CommonArgs,
    /// Point to query, as X,Y; may be repeated
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = question::point)]
    pub at: Vec<Point>,
}

#[derive(Args, Clone, Debug)]
pub struct WayArgs {
    #[command(flatten)]
    pub common: CommonArgs,
    /// Start of the path or line, as X,Y
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = question::point, requires = "to")]
    pub from: Option<Point>,
    /// End of the path or line, as X,Y
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = question::point, requires = "from")]
    pub to: Option<Point>,
}

#[derive(Args, Clone, Copy, Debug)]
pub struct ModeArgs {
    /// Accuracy of distances: exact, fast, or within:TOLERANCE
    ///
    /// 'fast' returns a path along edges of the triangulation, shortened within the triangles that
    /// it passes, with a lower and an upper bound of the distance. 'within:0.05' returns an upper
    /// bound of at most 1.05 times the lower bound.
    #[arg(long, value_name = "MODE", default_value = "exact")]
    pub mode: Mode,
}

#[derive(Args, Clone, Copy, Debug)]
pub struct SearchArgs {
    /// How sites are searched for, with the same answers: auto, wavefront or aimed
    ///
    /// 'wavefront' searches everywhere up to the last site, which is fast where sites are dense.
    /// 'aimed' searches towards the sites that are nearest by Euclidean distance, which is fast
    /// where sites are sparse. 'auto' takes what is expected to be faster.
    #[arg(long, value_name = "SEARCH", default_value = "auto")]
    pub search: Search,
}

#[derive(Args, Clone, Copy, Debug)]
pub struct ProgressArgs {
    /// Print the fast answer first, with its bounds and the expected cost of the exact answer, and
    /// then the exact answer
    #[arg(long, conflicts_with = "mode")]
    pub progressive: bool,
}

/// The tile file.
#[derive(Args, Clone, Debug)]
pub struct FileArgs {
    /// Tile file to query
    file: PathBuf,
    /// Memory for the cache of tiles
    #[arg(long, value_name = "BYTES", default_value = "64MiB")]
    cache: ByteSize,
    /// Print the elapsed time and the number of tiles read to standard error
    #[arg(long)]
    pub stats: bool,
}

/// The tile file, and limits on reading it.
#[derive(Args, Clone, Debug)]
pub struct ReadingArgs {
    #[command(flatten)]
    file: FileArgs,
    /// Maximum number of different tiles that one query may read
    ///
    /// A query that reaches this limit answers with what it found until then.
    #[arg(long, value_name = "COUNT")]
    max_tiles: Option<u64>,
    /// Maximum time of one query in milliseconds, with the same effect as --max-tiles
    #[arg(long, value_name = "MILLISECONDS")]
    max_time: Option<u64>,
}

impl Deref for ReadingArgs {
    type Target = FileArgs;

    fn deref(&self) -> &FileArgs {
        &self.file
    }
}

#[derive(Args, Clone, Debug)]
pub struct CommonArgs {
    #[command(flatten)]
    pub reading: ReadingArgs,
    /// CSV file of queries: x,y in each row, or from_x,from_y,to_x,to_y for paths and lines
    ///
    /// A header row is skipped.
    #[arg(long, value_name = "FILE")]
    pub batch: Option<PathBuf>,
    /// Prove each path by a walk through the triangles that it passes
    #[arg(long)]
    pub certify: bool,
    /// Number of queries that run at once [default: one per processor]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Draw the obstacles, the searched triangles and the answer, as .svg or .png
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(PlotFile::new))]
    pub plot: Option<PlotFile>,
    #[command(flatten)]
    pub title: TitleArgs,
    #[command(flatten)]
    pub format: FormatArgs,
}

/// The format in which answers are printed.
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
    /// Print one JSON object per query, each on one line
    #[arg(long)]
    pub json: bool,
    /// Print CSV rows, with numbers in full precision
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

impl FileArgs {
    /// Opens the tile file with a cache of its own.
    pub async fn open(&self) -> anyhow::Result<TileReader> {
        let cache = Cache::new(usize::try_from(self.cache.as_u64()).unwrap_or(usize::MAX));
        common::open(&self.file, OpenOptions::default().cache(&cache)).await
    }

    /// Returns the coordinate reference system of the file. If `distances` are printed, also prints
    /// what their readers must know about its unit to standard error.
    ///
    /// # Errors
    /// Fails if a list of the file cannot be read.
    pub async fn crs(&self, reader: &TileReader, distances: bool) -> anyhow::Result<Option<Crs>> {
        let crs = reader.crs().await?.map(|text| Crs::new(&text));
        if let Some(warning) = unit(crs.as_ref()).warning().filter(|_| distances) {
            common::note(format_args!("{}: {warning}", common::shown(&self.file)));
        }
        Ok(crs)
    }

    /// Checks that the tile file has the coordinate reference system of other files.
    ///
    /// # Errors
    /// Fails if two of them have different systems, or if a list of the file cannot be read.
    pub async fn agree(&self, reader: &TileReader, crs: &CrsArgs, others: &[(PathBuf, String)]) -> anyhow::Result<()> {
        let own = reader.crs().await?.map(|text| (self.file.clone(), text));
        crs.agree(own.iter().chain(others)).map(drop)
    }

    /// Prints the elapsed time and the tiles read to standard error, if --stats is given. `things`
    /// is the number of answers with its noun.
    pub fn report(&self, things: &str, began: Instant, reader: &TileReader) {
        if !self.stats {
            return;
        }
        let statistics = reader.cache().statistics();
        common::say(format_args!(
            "{things} in {:.3} s; tiles: {} read, {} found in the cache, {} evicted from it",
            began.elapsed().as_secs_f64(),
            thousands(statistics.misses),
            thousands(statistics.hits),
            thousands(statistics.evictions),
        ));
    }
}

impl ReadingArgs {
    /// Returns the limits of one query.
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
