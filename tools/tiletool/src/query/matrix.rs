//! `tiletool query matrix`: walking distances between all of some points and all of others.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{bail, ensure};
use clap::Args;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{DistanceOutcome, PairDistance};
use delaunay_tiles::store::TileReader;
use futures::TryStreamExt;
use serde_json::{Value, json};

use super::answer::{Status, name};
use super::args::ReadingArgs;
use super::batch::{self, Question};
use super::print::{bounds, pair, position, say, with_distance};
use super::report;
use crate::common::{self, cell};

/// Distances between all of some points and all of others, or all sites.
///
/// Pairs come in the order of the shorter list, and for each of its points in the order of the other; points are numbered from 0.
/// One search serves all pairs of a point of the shorter list.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Example:
  tiletool query matrix town.tiles --from-file depots.csv --to-file homes.csv --csv
  tiletool query matrix town.tiles --batch depots.csv
  tiletool query matrix town.tiles --from-file homes.csv --sites --csv")]
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
    /// Print a JSON object for each pair, on one line
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Print from,to,from_x,from_y,to_x,to_y,status,distance,lower,upper for each pair, numbers in full
    #[arg(long)]
    csv: bool,
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
        let mut pairs = reader.distance_matrix(from.points.clone(), to.points.clone(), args.reading.limits());
        let mut out = BufWriter::new(io::stdout());
        if args.csv {
            writeln!(out, "from,to,from_x,from_y,to_x,to_y,status,distance,lower,upper")?;
        }
        let mut count = 0;
        while let Some(found) = pairs.try_next().await? {
            count += 1;
            if args.csv {
                writeln!(out, "{}", row(&from, &to, found))?;
            } else if args.json {
                writeln!(out, "{}", object(&from, &to, found))?;
            } else {
                write!(out, "{}", text(&from, &to, found))?;
            }
        }
        out.flush()?;
        if args.reading.stats {
            report("pairs", count, began, &reader);
        }
        Ok(())
    })
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

fn row(from: &Ends, to: &Ends, found: PairDistance) -> String {
    let numbers = match found.outcome {
        DistanceOutcome::Found(distance) => bounds(&distance),
        DistanceOutcome::OutOfBudget { at_least } => format!(",{at_least},"),
        _ => ",,".to_owned(),
    };
    let names = [cell(&from.name(found.from)), cell(&to.name(found.to))].join(",");
    let ends = [pair(from.points[found.from]), pair(to.points[found.to])].join(",");
    format!("{names},{ends},{},{numbers}", status(found.outcome).name())
}

fn object(from: &Ends, to: &Ends, found: PairDistance) -> Value {
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

fn text(from: &Ends, to: &Ends, found: PairDistance) -> String {
    let [a, b] = [from.points[found.from], to.points[found.to]];
    let names = [from.name(found.from), to.name(found.to)];
    let mut text = format!("{} ({}, {}) to {} ({}, {})", names[0], a.x, a.y, names[1], b.x, b.y);
    say(&mut text, status(found.outcome));
    if let DistanceOutcome::Found(distance) = found.outcome {
        text += &format!(": {}", distance.value);
    }
    text.push('\n');
    text
}
