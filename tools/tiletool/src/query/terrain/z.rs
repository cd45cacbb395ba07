//! `tiletool query z`: heights at points.

use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, bail};
use clap::Args;
use delaunay_tiles::crs::Crs;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::store::TileReader;
use delaunay_tiles::terrain::TerrainError;
use delaunay_tiles_answers::height::Height;
use delaunay_tiles_answers::question::{self, Question};
use delaunay_tiles_answers::values::{COLLECTION_END, collection, pair, write_feature};
use futures::{StreamExt, TryStreamExt, stream};

use super::super::args::{FileArgs, Format, FormatArgs};
use super::super::batch;
use super::surface::SurfaceArgs;
use crate::common;
use crate::output::StandardOutput;

/// The number of points whose tiles are read at once.
const AT_ONCE: usize = 32;

/// Find the height of the surface at a point
///
/// The height is that of the plane of the triangle at the point. Text is the number alone. A point
/// outside the triangulation, or in a hole, has none.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  tiletool query z survey.tiles --at 637000.5,849000.25
  tiletool query z survey.tiles --batch wells.csv --csv")]
pub struct ZArgs {
    #[command(flatten)]
    file: FileArgs,
    /// Point to query, as X,Y; may be repeated
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = question::point)]
    at: Vec<Point>,
    /// CSV file of points, with x,y in each row; a header row is skipped
    #[arg(long, value_name = "FILE")]
    batch: Option<PathBuf>,
    #[command(flatten)]
    surface: SurfaceArgs,
    #[command(flatten)]
    format: FormatArgs,
}

/// Prints the heights.
pub fn run(args: &ZArgs) -> anyhow::Result<()> {
    let points = points(args)?;
    common::answer(async {
        let began = Instant::now();
        let reader = args.file.open().await?;
        if !reader.metadata().has_z {
            let file = reader.name().to_owned();
            bail!(TerrainError::NoZ { file });
        }
        let crs = args.file.crs(&reader, false).await?;
        let count = common::counted(points.len() as u64, "query", "queries");
        print(args, &reader, points, crs.as_ref()).await?;
        args.file.report(&count, began, &reader);
        Ok(())
    })
}

/// Returns the points of the command line and of the file.
fn points(args: &ZArgs) -> anyhow::Result<Vec<Point>> {
    let mut points = args.at.clone();
    if let Some(path) = &args.batch {
        let questions = batch::read(path, false)?.into_iter();
        points.extend(questions.filter_map(|question| match question {
            Question::At(at) => Some(at),
            Question::Way(..) => None,
        }));
    } else if points.is_empty() {
        bail!("no point is given; give --at X,Y, or --batch FILE");
    }
    Ok(points)
}

async fn print(args: &ZArgs, reader: &TileReader, points: Vec<Point>, crs: Option<&Crs>) -> anyhow::Result<()> {
    let format = args.format.format();
    let mut out = BufWriter::new(StandardOutput::of("the answers"));
    match format {
        Format::Csv => writeln!(out, "x,y,z")?,
        Format::GeoJson => write!(out, "{}", collection(crs))?,
        Format::Text | Format::Json => {}
    }
    let heights = stream::iter(points).map(|at| {
        let (reader, counted) = (reader.clone(), args.surface.counted());
        let task = tokio::spawn(async move { Height::find(&reader, at, counted).await });
        async move { anyhow::Ok(task.await.context("a query task failed")??) }
    });
    let mut heights = heights.buffered(AT_ONCE);
    let mut count = 0;
    while let Some(height) = heights.try_next().await? {
        match format {
            Format::Text => match height.z {
                Ok(z) => writeln!(out, "{z}")?,
                Err(why) => writeln!(out, "{why}")?,
            },
            Format::Json => writeln!(out, "{}", height.object())?,
            Format::Csv => {
                let z = height.z.map_or_else(|_| String::new(), |z| z.to_string());
                writeln!(out, "{},{z}", pair(height.at))?;
            }
            Format::GeoJson => write_feature(&mut out, count, &height.feature())?,
        }
        count += 1;
    }
    if format == Format::GeoJson {
        writeln!(out, "{COLLECTION_END}")?;
    }
    Ok(out.flush()?)
}
