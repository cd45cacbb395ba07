//! `tiletool query matrix`: walking distances between all points of one list and all points of
//! another.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{bail, ensure};
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use delaunay_tiles::crs::Crs;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{DistanceOutcome, PairDistance, QueryError};
use delaunay_tiles::shown;
use delaunay_tiles::store::TileReader;
use delaunay_tiles_answers::matrix::{Matrix, NamedPoints, status};
use delaunay_tiles_answers::question::Question;
use delaunay_tiles_answers::units::{Measure, Unit, unit};
use delaunay_tiles_answers::values::{COLLECTION_END, bounds, collection, pair, write_feature};
use futures::{TryStream, TryStreamExt};

use super::args::{Format, FormatArgs, ReadingArgs};
use super::batch;
use super::picture::short_distance;
use super::text::{point, push_status};
use crate::common::{self, cell, counted, thousands};
use crate::output::StandardOutput;
use crate::plot::{self, Mark, Overlay, PlotFile, TitleArgs, Way};

/// Maximum number of paths in a picture, which also limits memory.
const MAX_DRAWN: u64 = 10_000;

/// Compute the walking distances between all points of two lists
///
/// The second list may be all sites of the tile file. Pairs are printed in the order of the shorter
/// list, and for each of its points in the order of the other list. Points are numbered from 0.
///
/// One search serves all pairs of a point of the shorter list.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  tiletool query matrix town.tiles --from-file depots.csv --to-file homes.csv --csv
  tiletool query matrix town.tiles --batch depots.csv
  tiletool query matrix town.tiles --from-file homes.csv --sites --csv
  tiletool query matrix town.tiles --batch depots.csv --plot depots.svg")]
pub struct MatrixArgs {
    #[command(flatten)]
    reading: ReadingArgs,
    /// CSV file of start points, with x,y in each row; a header row is skipped
    #[arg(long, value_name = "FILE")]
    from_file: Option<PathBuf>,
    /// CSV file of end points, in the same format
    #[arg(long, value_name = "FILE", requires = "from_file")]
    to_file: Option<PathBuf>,
    /// CSV file of points that are both start and end points
    #[arg(long, value_name = "FILE", conflicts_with_all = ["from_file", "to_file"])]
    batch: Option<PathBuf>,
    /// Take all sites of the tile file as end points
    #[arg(long, conflicts_with = "to_file")]
    sites: bool,
    /// Draw the obstacles and the path of each pair, as .svg or .png; at most 10,000 pairs
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(PlotFile::new))]
    plot: Option<PlotFile>,
    #[command(flatten)]
    title: TitleArgs,
    #[command(flatten)]
    format: FormatArgs,
}

/// Prints the matrix.
pub fn run(args: &MatrixArgs) -> anyhow::Result<()> {
    common::answer(async {
        let began = Instant::now();
        let reader = args.reading.open().await?;
        let matrix = lists(args, &reader).await?;
        let crs = args.reading.crs(&reader, true).await?;
        let format = args.format.format();
        let mut options = args.reading.limits();
        if args.plot.is_some() || format == Format::GeoJson {
            options = options.paths();
        }
        let [from, to] = [&matrix.from, &matrix.to].map(|ends| ends.points.clone());
        let mut drawn = args.plot.as_ref().map(|_| DrawnPairs::new(args, unit(crs.as_ref())));
        let pairs = reader.distance_matrix(from, to, options).inspect_ok(|found| {
            if let Some(drawn) = &mut drawn {
                drawn.take(&matrix, found);
            }
        });
        let count = print(&matrix, format, crs.as_ref(), pairs).await?;
        if let (Some(file), Some(drawn)) = (&args.plot, drawn) {
            plot::draw_query(&reader, &args.title.of(file), &drawn.picture(matrix)).await?;
        }
        args.reading.report(&counted(count, "pair", "pairs"), began, &reader);
        Ok(())
    })
}

/// Reads the points of a file.
fn read(path: &Path) -> anyhow::Result<NamedPoints> {
    let questions = batch::read(path, false)?.into_iter();
    let points = questions.filter_map(|question| match question {
        Question::At(at) => Some(at),
        Question::Way(..) => None,
    });
    Ok(NamedPoints::unnamed(points.collect()))
}

/// Reads the points of both lists.
async fn lists(args: &MatrixArgs, reader: &TileReader) -> anyhow::Result<Matrix> {
    let from = match args.from_file.as_ref().or(args.batch.as_ref()) {
        Some(path) => read(path)?,
        None => bail!("no points are given; give --from-file FILE with --to-file FILE or --sites, or --batch FILE"),
    };
    let to = match &args.to_file {
        _ if args.sites => NamedPoints::sites(reader).await?,
        Some(path) => read(path)?,
        None if args.batch.is_some() => NamedPoints::unnamed(from.points.clone()),
        None => bail!("no end points are given; give --to-file FILE or --sites"),
    };
    let pairs = from.points.len() as u64 * to.points.len() as u64;
    ensure!(
        args.plot.is_none() || pairs <= MAX_DRAWN,
        "--plot draws at most {} paths, but there are {} pairs; use fewer points",
        thousands(MAX_DRAWN),
        thousands(pairs)
    );
    Ok(Matrix { from, to })
}

/// Prints all pairs. Returns how many.
async fn print(
    matrix: &Matrix,
    format: Format,
    crs: Option<&Crs>,
    mut pairs: impl TryStream<Ok = PairDistance, Error = QueryError> + Unpin,
) -> anyhow::Result<u64> {
    let mut out = BufWriter::new(StandardOutput::of("the answers"));
    match format {
        Format::Csv => {
            let site = if matrix.to.names.is_some() { "site," } else { "" };
            writeln!(
                out,
                "from_index,to_index,{site}from_x,from_y,to_x,to_y,status,distance,lower,upper"
            )?;
        }
        Format::GeoJson => write!(out, "{}", collection(crs))?,
        Format::Text | Format::Json => {}
    }
    let mut count = 0;
    while let Some(found) = pairs.try_next().await? {
        match format {
            Format::Csv => writeln!(out, "{}", row(matrix, &found))?,
            Format::Json => writeln!(out, "{}", matrix.object(&found))?,
            Format::GeoJson => write_feature(&mut out, count, &matrix.feature(&found))?,
            Format::Text => write!(out, "{}", text(matrix, unit(crs), &found))?,
        }
        count += 1;
    }
    if format == Format::GeoJson {
        writeln!(out, "{COLLECTION_END}")?;
    }
    out.flush()?;
    Ok(count)
}

fn row(matrix: &Matrix, found: &PairDistance) -> String {
    let numbers = match found.outcome {
        DistanceOutcome::Found(distance) => bounds(&distance),
        DistanceOutcome::OutOfBudget { lower_bound } => format!(",{lower_bound},"),
        _ => ",,".to_owned(),
    };
    let mut start = format!("{},{}", found.from_index, found.to_index);
    if let Some(name) = matrix.to.name_of(found.to_index) {
        start += &format!(",{}", cell(name));
    }
    let ends = matrix.points(found).map(pair).join(",");
    format!("{start},{ends},{},{numbers}", status(found.outcome).name())
}

fn text(matrix: &Matrix, unit: Unit, found: &PairDistance) -> String {
    let [from, to] = matrix.points(found).map(point);
    let name = match matrix.to.name_of(found.to_index) {
        Some(name) => shown::text(name).into_owned(),
        None => found.to_index.to_string(),
    };
    let mut text = format!("{} {from} to {name} {to}", found.from_index);
    push_status(&mut text, status(found.outcome), unit);
    if let DistanceOutcome::Found(distance) = found.outcome {
        text += &format!(": {}", unit.distance(distance.value));
    }
    text.push('\n');
    text
}

/// The pairs of a picture.
struct DrawnPairs {
    unit: Unit,
    /// Whether both lists are the same.
    is_one_list: bool,
    found: u64,
    paths: Vec<Way>,
    missing: Vec<[Point; 2]>,
}

impl DrawnPairs {
    fn new(args: &MatrixArgs, unit: Unit) -> Self {
        Self {
            unit,
            is_one_list: args.batch.is_some() && !args.sites,
            found: 0,
            paths: Vec::new(),
            missing: Vec::new(),
        }
    }

    fn take(&mut self, matrix: &Matrix, pair: &PairDistance) {
        self.found += u64::from(pair.path.is_some());
        // A path and the same path in the other direction are drawn once.
        if self.is_one_list && pair.from_index >= pair.to_index {
            return;
        }
        match (&pair.path, pair.outcome) {
            (Some(path), DistanceOutcome::Found(distance)) => self.paths.push(Way {
                points: path.points.clone(),
                text: short_distance(self.unit, distance.value),
            }),
            _ => self.missing.push(matrix.points(pair)),
        }
    }

    fn picture(self, Matrix { from, to }: Matrix) -> Overlay {
        let starts = thousands(from.points.len() as u64);
        let found = thousands(self.found);
        let ends = counted(to.points.len() as u64, "point", "points");
        let title = format!("Shortest paths from {starts} to {ends}  ·  {found} found");
        let mut names = to.names.unwrap_or_default().into_iter();
        let mut mark = |at: Point| Mark {
            at,
            text: names
                .next()
                .map_or_else(String::new, |name| shown::text(&name).into_owned()),
            key: None,
        };
        Overlay {
            title,
            starts: from.points,
            starts_are_ends: self.is_one_list,
            ends: match self.is_one_list {
                true => Vec::new(),
                false => to.points.into_iter().map(&mut mark).collect(),
            },
            paths: self.paths,
            missing: self.missing,
            ..Overlay::default()
        }
    }
}
