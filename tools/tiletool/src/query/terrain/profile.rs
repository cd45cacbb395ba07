//! `tiletool query profile`: heights along a line.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{bail, ensure};
use clap::Args;
use delaunay_tiles::crs::Crs;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{SegmentBatch, SegmentSource};
use delaunay_tiles::terrain::{Profile, ProfilePoint};
use delaunay_tiles_answers::units::{Measure, Unit, number, unit};
use delaunay_tiles_answers::values::{COLLECTION_END, collection, pair, write_feature};
use delaunay_tiles_answers::{profile, question};

use super::super::args::{FileArgs, Format, FormatArgs};
use super::surface::WholeSurfaceArgs;
use crate::common::{self, counted};
use crate::crs::CrsArgs;
use crate::output::StandardOutput;

/// Find the heights of the surface along a line
///
/// Prints a point at both ends of the line, at each of its corners, and wherever it crosses an edge or
/// meets a vertex of the triangulation: between two of them, the surface is a straight line. Distances
/// are horizontal. Where the line is outside the triangulation or in a hole, there is a gap.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  tiletool query profile survey.tiles --from 637000,849000 --to 638000,849500 --csv
  tiletool query profile survey.tiles --line road.geojson --geojson")]
pub struct ProfileArgs {
    #[command(flatten)]
    file: FileArgs,
    /// Start of the line, as X,Y
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = question::point, requires = "to")]
    from: Option<Point>,
    /// End of the line, as X,Y
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = question::point, requires = "from")]
    to: Option<Point>,
    /// File whose first line is the line, in a format of --segments, such as GeoJSON. It must have the
    /// tile file's coordinate reference system
    #[arg(long, value_name = "FILE", conflicts_with_all = ["from", "to"])]
    line: Option<PathBuf>,
    #[command(flatten)]
    crs: CrsArgs,
    #[command(flatten)]
    surface: WholeSurfaceArgs,
    #[command(flatten)]
    format: FormatArgs,
}

/// Prints the profile.
pub fn run(args: &ProfileArgs) -> anyhow::Result<()> {
    common::answer(async {
        let began = Instant::now();
        let (line, of_line) = match (&args.line, args.from.zip(args.to)) {
            (Some(path), _) => {
                let path = path.clone();
                common::on_thread("reading the line", move || first_line(&path)).await?
            }
            (None, Some((from, to))) => (vec![from, to], Vec::new()),
            (None, None) => bail!("no line is given; give --from X,Y --to X,Y, or --line FILE"),
        };
        let reader = args.file.open().await?;
        args.file.agree(&reader, &args.crs, &of_line).await?;
        let crs = args.file.crs(&reader, true).await?;
        let profile = reader.profile(&line, args.surface.surface()).await?;
        let ends = [line[0], line[line.len() - 1]];
        print(args.format.format(), &profile, ends, crs.as_ref())?;
        args.file.report("1 query", began, &reader);
        Ok(())
    })
}

/// The first line of a file, and the text of its coordinate reference system.
type LineFile = (Vec<Point>, Vec<(PathBuf, String)>);

/// Returns the first line of a file.
///
/// # Errors
/// Fails if the file cannot be read or has no lines.
fn first_line(path: &Path) -> anyhow::Result<LineFile> {
    let mut source = SegmentSource::open(&[path.to_owned()])?;
    let mut batch = SegmentBatch::default();
    let (mut line, mut is_complete): (Vec<Point>, _) = (Vec::new(), false);
    while source.next_batch(&mut batch)? {
        // GeoJSON may name its system at the end.
        if is_complete && !source.crs_of_files().is_empty() {
            break;
        }
        for (&[from, to], &number) in batch.ends.iter().zip(&batch.lines) {
            match line.last() {
                None => line.extend([from, to]),
                // The segments of one LineString are joined.
                Some(&last) if !is_complete && number == 0 && last == from => line.push(to),
                Some(_) => is_complete = true,
            }
        }
    }
    ensure!(!line.is_empty(), "{}: it has no lines", common::shown(path));
    Ok((line, source.crs_of_files().to_vec()))
}

fn print(format: Format, profile: &Profile, ends: [Point; 2], crs: Option<&Crs>) -> anyhow::Result<()> {
    let mut out = BufWriter::new(StandardOutput::of("the profile"));
    match format {
        Format::Text => print_text(&mut out, profile, unit(crs))?,
        Format::Json => writeln!(out, "{}", profile::object(profile))?,
        Format::Csv => print_rows(&mut out, profile, ends)?,
        Format::GeoJson => {
            write!(out, "{}", collection(crs))?;
            for (part, index) in profile.parts.iter().zip(0..) {
                write_feature(&mut out, index, &profile::feature(part, index))?;
            }
            writeln!(out, "{COLLECTION_END}")?;
        }
    }
    Ok(out.flush()?)
}

/// Prints a line for each point, and one for each gap.
fn print_text(out: &mut impl Write, profile: &Profile, unit: Unit) -> anyhow::Result<()> {
    let points = profile.parts.iter().map(|part| part.points.len() as u64).sum();
    let (points, parts) = (
        counted(points, "point", "points"),
        counted(profile.parts.len() as u64, "part", "parts"),
    );
    writeln!(out, "{}: {points} in {parts}", unit.distance(profile.length))?;
    let mut gaps = profile.gaps().into_iter().peekable();
    let mut print_gaps = |out: &mut dyn Write, until: f64| -> anyhow::Result<()> {
        while let Some([from, to]) = gaps.next_if(|[from, _]| *from < until) {
            writeln!(out, "{:>12}  to {}: not on the surface", number(from), number(to))?;
        }
        Ok(())
    };
    writeln!(out, "{:>12}  {:>12}  at", "distance", "z")?;
    for part in &profile.parts {
        print_gaps(out, part.points[0].distance)?;
        for &ProfilePoint { distance, point, z, .. } in &part.points {
            writeln!(
                out,
                "{:>12}  {:>12}  ({}, {})",
                number(distance),
                number(z),
                point.x,
                point.y
            )?;
        }
    }
    print_gaps(out, f64::INFINITY)
}

/// Prints a row for each point, with the number of its part, and one for each end of the line that is not
/// on the surface.
fn print_rows(out: &mut impl Write, profile: &Profile, [from, to]: [Point; 2]) -> anyhow::Result<()> {
    writeln!(out, "part,distance,x,y,z")?;
    let begins = profile.parts.first().and_then(|part| part.points.first());
    if begins.is_none_or(|point| point.distance > 0.0) {
        writeln!(out, ",0,{},", pair(from))?;
    }
    for (part, number) in profile.parts.iter().zip(0u64..) {
        for &ProfilePoint { distance, point, z, .. } in &part.points {
            writeln!(out, "{number},{distance},{},{z}", pair(point))?;
        }
    }
    let ends = profile.parts.last().and_then(|part| part.points.last());
    if ends.is_none_or(|point| point.distance < profile.length) {
        writeln!(out, ",{},{},", profile.length, pair(to))?;
    }
    Ok(())
}
