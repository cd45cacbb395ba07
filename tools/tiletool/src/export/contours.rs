//! Export of contours.

use std::sync::Arc;

use anyhow::Context;
use delaunay_tiles::export::{ContourOutput, Format, export_contours};
use delaunay_tiles::terrain::{Clip, ContourOptions, Levels};
use delaunay_tiles::{TileReader, peak_memory};
use indicatif::ProgressBar;
use serde::Serialize;

use super::args::{ExportArgs, usage};
use super::formats::Shown;
use super::progress::shown_on;
use super::targets::Targets;
use crate::common::{self, counted};

/// The formats of contours, for messages.
pub const FORMATS: &str = "geojson and fgb";

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
struct ContourReport {
    contours: u64,
    points: u64,
    step: f64,
    base: f64,
    files: Vec<String>,
    bytes: u64,
    peak_memory_bytes: Option<u64>,
}

/// Fails if an option has no effect on the output.
pub fn check(args: &ExportArgs, format: Format) -> Result<(), clap::Error> {
    let why = if !matches!(format, Format::GeoJson | Format::FlatGeobuf) {
        format!("--contours is for {FORMATS}, and not for {format}")
    } else if let Some(Shown::Mesh(_) | Shown::Raster(_)) = args.what {
        "--contours and --what exclude each other: an export shows one of them".to_owned()
    } else if args.edges {
        "--edges is for ply and glb".to_owned()
    } else if let Some(option) = args.raster.given() {
        format!("{option} is for rasters, and not for --contours")
    } else {
        return Ok(());
    };
    Err(usage(&why))
}

/// Writes contours. Returns the summary.
pub async fn write(
    args: &ExportArgs,
    format: Format,
    reader: &TileReader,
    clip: Option<Arc<Clip>>,
    bar: &ProgressBar,
) -> anyhow::Result<String> {
    let step = args.contours.step.context("contours need --contours STEP")?;
    let base = args.contours.base.unwrap_or(0.0);
    let options = ContourOptions::new(Levels::new(step, base)?)
        .surface(args.surface())
        .clip(clip);
    let how = ContourOutput::new(format).scratch(args.scratch());
    let mut targets = Targets::create("the contours", vec![args.output.clone()], &args.file)?;
    let output = targets.writers()?.remove(0);
    let exported = export_contours(reader, options, &how, output, shown_on(bar)).await;
    let exported = targets.explained(exported)?;
    let report = ContourReport {
        contours: exported.contours,
        points: exported.points,
        step,
        base,
        files: targets.publish().await?,
        bytes: exported.bytes,
        peak_memory_bytes: peak_memory(),
    };
    if args.json {
        return Ok(serde_json::to_string(&report)? + "\n");
    }
    let counts = [
        counted(report.contours, "contour", "contours"),
        counted(report.points, "point", "points"),
    ];
    let (files, bytes) = (report.files.join(", "), common::bytes(report.bytes));
    Ok(format!("{files}: {}; {bytes}\n", counts.join(", ")))
}
