//! `tiletool query matrix`: walking distances between all of some points and all of others.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{bail, ensure};
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{DistanceOutcome, PairDistance};
use delaunay_tiles::shown;
use delaunay_tiles::store::TileReader;
use futures::TryStreamExt;
use serde_json::{Value, json};

use super::answer::{Status, name};
use super::args::{Format, FormatArgs, ReadingArgs};
use super::batch::{self, Question};
use super::print::say;
use super::values::{COLLECTION, COLLECTION_END, bounds, line_string, pair, position, with_distance, write_feature};
use crate::common::{self, cell, thousands};
use crate::plot::{self, Overlay, PlotFile};

/// So many paths fit in a picture, and in memory.
const DRAWN: u64 = 10_000;

/// Distances between all of some points and all of others, or all sites.
///
/// Pairs come in the order of the shorter list, and for each of its points in the order of the other; points are numbered from 0.
/// One search serves all pairs of a point of the shorter list.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Example:
  tiletool query matrix town.tiles --from-file depots.csv --to-file homes.csv --csv
  tiletool query matrix town.tiles --batch depots.csv
  tiletool query matrix town.tiles --from-file homes.csv --sites --csv
  tiletool query matrix town.tiles --batch depots.csv --plot depots.svg")]
pub struct MatrixArgs {
    #[command(flatten)]
    reading: ReadingArgs,
    /// The points from which, x,y in each row; a header is passed over
    #[arg(long, value_name = "A.csv")]
    from_file: Option<PathBuf>,
    /// The points to which
    #[arg(long, value_name = "B.csv", requires = "from_file")]
    to_file: Option<PathBuf>,
    /// Points from each of which to all of them
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["from_file", "to_file"])]
    batch: Option<PathBuf>,
    /// To all sites of the file
    #[arg(long, conflicts_with = "to_file")]
    sites: bool,
    /// Draw what is in the way, and a path for each pair, if there are 10,000 at most
    #[arg(long, value_name = "MAP.svg|MAP.png", value_parser = PathBufValueParser::new().try_map(PlotFile::new))]
    plot: Option<PlotFile>,
    #[command(flatten)]
    format: FormatArgs,
}

/// Points, and what they are called.
struct Ends {
    points: Vec<Point>,
    names: Option<Vec<String>>,
}

impl Ends {
    fn read(path: &Path) -> anyhow::Result<Self> {
        let questions = batch::read(path, false)?.into_iter();
        let points = questions.filter_map(|question| match question {
            Question::At(at) => Some(at),
            Question::Way(..) => None,
        });
        Ok(Self {
            points: points.collect(),
            names: None,
        })
    }

    /// All sites, in the order of their numbers.
    async fn sites(reader: &TileReader) -> anyhow::Result<Self> {
        let mut sites = Vec::new();
        let mut tiles = reader.tiles();
        while let Some(tile) = tiles.try_next().await? {
            sites.extend(tile.sites().map(|site| {
                let name = name(Some(site.number), site.id);
                (site.number, tile.point(site.vertex), name)
            }));
        }
        ensure!(!sites.is_empty(), "{} has no sites", reader.name());
        sites.sort_by_key(|&(number, ..)| number);
        let (points, names) = sites.into_iter().map(|(_, point, name)| (point, name)).unzip();
        Ok(Self {
            points,
            names: Some(names),
        })
    }

    fn name(&self, place: usize) -> String {
        match &self.names {
            Some(names) => names[place].clone(),
            None => place.to_string(),
        }
    }
}

/// Prints the matrix.
pub fn run(args: &MatrixArgs) -> anyhow::Result<()> {
    common::block_on(async {
        let began = Instant::now();
        let reader = args.reading.open().await?;
        let from = match args.from_file.as_ref().or(args.batch.as_ref()) {
            Some(path) => Ends::read(path)?,
            None => bail!(
                "no points are given; give --from-file A.csv with --to-file B.csv or --sites, or --batch FILE.csv"
            ),
        };
        let to = match &args.to_file {
            _ if args.sites => Ends::sites(&reader).await?,
            Some(path) => Ends::read(path)?,
            None if args.batch.is_some() => Ends {
                points: from.points.clone(),
                names: None,
            },
            None => bail!("no points to which are given; give --to-file B.csv or --sites"),
        };
        let pairs = from.points.len() as u64 * to.points.len() as u64;
        ensure!(
            args.plot.is_none() || pairs <= DRAWN,
            "--plot draws {} paths at most, and these are {}; take fewer points",
            thousands(DRAWN),
            thousands(pairs)
        );
        let format = args.format.format();
        let mut options = args.reading.limits();
        if args.plot.is_some() || format == Format::GeoJson {
            options = options.paths();
        }
        let mut pairs = reader.distance_matrix(from.points.clone(), to.points.clone(), options);
        let mut out = BufWriter::new(io::stdout());
        match format {
            Format::Csv => writeln!(out, "from,to,from_x,from_y,to_x,to_y,status,distance,lower,upper")?,
            Format::GeoJson => write!(out, "{COLLECTION}")?,
            Format::Text | Format::Json => {}
        }
        let (mut count, mut paths) = (0, Vec::new());
        while let Some(found) = pairs.try_next().await? {
            match format {
                Format::Csv => writeln!(out, "{}", row(&from, &to, &found))?,
                Format::Json => writeln!(out, "{}", object(&from, &to, &found))?,
                Format::GeoJson => write_feature(&mut out, count, &feature(&from, &to, &found))?,
                Format::Text => write!(out, "{}", text(&from, &to, &found))?,
            }
            count += 1;
            if args.plot.is_some() {
                paths.extend(found.path.map(|path| path.points));
            }
        }
        if format == Format::GeoJson {
            writeln!(out, "{COLLECTION_END}")?;
        }
        out.flush()?;
        if let Some(file) = &args.plot {
            plot::draw_query(&reader, file, &picture(args, &from, to, paths)).await?;
        }
        args.reading.report("pairs", count, began, &reader);
        Ok(())
    })
}

/// The picture of all pairs.
fn picture(args: &MatrixArgs, from: &Ends, to: Ends, paths: Vec<Vec<Point>>) -> Overlay {
    let [starts, ends, found] = [from.points.len(), to.points.len(), paths.len()].map(|count| thousands(count as u64));
    let (sites, ends_seen) = match to.names {
        Some(_) => (to.points, Vec::new()),
        // To the same points: they are seen already.
        None if args.batch.is_some() => (Vec::new(), Vec::new()),
        None => (Vec::new(), to.points),
    };
    Overlay {
        title: format!("Shortest paths from {starts} to {ends} points  ·  {found} found"),
        starts: from.points.clone(),
        ends: ends_seen,
        sites,
        paths,
        ..Overlay::default()
    }
}

/// How a pair ended, in the words of other queries.
fn status(outcome: DistanceOutcome) -> Status {
    match outcome {
        DistanceOutcome::Found(_) => Status::Ok,
        DistanceOutcome::Unreachable => Status::Unreachable,
        DistanceOutcome::InsideObstacle { point, nearest_free } => Status::Inside(point, nearest_free),
        DistanceOutcome::OutOfBudget { at_least } => Status::Budget(at_least),
    }
}

fn row(from: &Ends, to: &Ends, found: &PairDistance) -> String {
    let numbers = match found.outcome {
        DistanceOutcome::Found(distance) => bounds(&distance),
        DistanceOutcome::OutOfBudget { at_least } => format!(",{at_least},"),
        _ => ",,".to_owned(),
    };
    let names = [cell(&from.name(found.from)), cell(&to.name(found.to))].join(",");
    let ends = [pair(from.points[found.from]), pair(to.points[found.to])].join(",");
    format!("{names},{ends},{},{numbers}", status(found.outcome).name())
}

fn feature(from: &Ends, to: &Ends, found: &PairDistance) -> Value {
    let geometry = found.path.as_ref().map_or(Value::Null, line_string);
    json!({"type": "Feature", "properties": object(from, to, found), "geometry": geometry})
}

fn object(from: &Ends, to: &Ends, found: &PairDistance) -> Value {
    let mut value = json!({
        "from": found.from,
        "to": found.to,
        "from_at": position(from.points[found.from]),
        "to_at": position(to.points[found.to]),
    });
    if let Some(names) = &to.names {
        value["to"] = names[found.to].clone().into();
    }
    status(found.outcome).put(&mut value);
    match found.outcome {
        DistanceOutcome::Found(distance) => with_distance(value, &distance),
        _ => value,
    }
}

fn text(from: &Ends, to: &Ends, found: &PairDistance) -> String {
    let [a, b] = [from.points[found.from], to.points[found.to]];
    let names = [from.name(found.from), to.name(found.to)];
    let [from, to] = names.each_ref().map(|name| shown::text(name));
    let mut text = format!("{from} ({}, {}) to {to} ({}, {})", a.x, a.y, b.x, b.y);
    say(&mut text, status(found.outcome));
    if let DistanceOutcome::Found(distance) = found.outcome {
        text += &format!(": {}", distance.value);
    }
    text.push('\n');
    text
}
