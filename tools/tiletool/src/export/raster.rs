//! Export of rasters.

use std::sync::Arc;

use anyhow::Context;
use delaunay_tiles::export::{RasterFormat, RasterOutput, Samples, export_raster};
use delaunay_tiles::terrain::{Clip, Grid, Light, Measure, RasterOptions};
use delaunay_tiles::{Rect, TileReader, peak_memory};
use indicatif::ProgressBar;
use serde::Serialize;

use super::args::{ExportArgs, RasterArgs, usage};
use super::formats::Shown;
use super::progress::shown_on;
use super::targets::Targets;
use crate::common::{self, counted};

/// Returns the cells of a raster of a file.
fn grid(args: &RasterArgs, reader: &TileReader) -> anyhow::Result<Grid> {
    let bounds = args.bounds.unwrap_or(reader.metadata().bounds);
    let resolution = args.resolution.context("a raster needs --resolution SIZE")?;
    let grid = match (args.bounds, args.align) {
        (Some(bounds), None) => Grid::starting_at(bounds, resolution),
        (_, align) => Grid::covering(bounds, resolution, align.unwrap_or_default()),
    };
    Ok(grid?)
}

/// Returns what a raster shows.
fn measure(args: &ExportArgs) -> Measure {
    let default = Light::default();
    match args.what {
        Some(Shown::Raster(Measure::Hillshade(_))) => Measure::Hillshade(Light {
            azimuth: args.raster.azimuth.unwrap_or(default.azimuth),
            altitude: args.raster.altitude.unwrap_or(default.altitude),
        }),
        Some(Shown::Raster(measure)) => measure,
        _ => Measure::Z,
    }
}

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
struct RasterReport {
    columns: u32,
    rows: u32,
    resolution: f64,
    bounds: [f64; 4],
    what: String,
    files: Vec<String>,
    bytes: u64,
    peak_memory_bytes: Option<u64>,
}

/// Fails if an option has no effect on the output.
pub fn check(args: &ExportArgs, format: RasterFormat) -> Result<(), clap::Error> {
    let raster = &args.raster;
    let is_shade = matches!(args.what, Some(Shown::Raster(Measure::Hillshade(_))));
    let why = if let Some(Shown::Mesh(what)) = args.what {
        format!("--what {what} is for geojson, fgb and parquet; a raster shows z, slope, aspect or hillshade")
    } else if raster.resolution.is_none() {
        "a raster needs --resolution SIZE, the size of its cells in units of the coordinates".to_owned()
    } else if args.edges {
        "--edges is for ply and glb".to_owned()
    } else if !is_shade && (raster.azimuth.is_some() || raster.altitude.is_some()) {
        "--azimuth and --altitude are for --what hillshade".to_owned()
    } else if is_shade && raster.float32 {
        "--float32 is not for hillshades, which are stored as bytes".to_owned()
    } else if raster.cog && format != RasterFormat::GeoTiff {
        "--cog is for tif".to_owned()
    } else {
        return Ok(());
    };
    Err(usage(&why))
}

/// Writes a raster. Returns the summary.
pub async fn write(
    args: &ExportArgs,
    format: RasterFormat,
    reader: &TileReader,
    clip: Option<Arc<Clip>>,
    bar: &ProgressBar,
) -> anyhow::Result<String> {
    let grid = grid(&args.raster, reader)?;
    let measure = measure(args);
    let mut targets = Targets::create("the raster", vec![args.output.clone()], &args.file)?;
    let options = RasterOptions::new(grid)
        .measure(measure)
        .z_factor(args.raster.z_factor.unwrap_or(1.0))
        .surface(args.surface())
        .clip(clip);
    let samples = match args.raster.float32 {
        true => Samples::Float32,
        false => Samples::Float64,
    };
    let how = RasterOutput::new(format)
        .samples(samples)
        .overviews(args.raster.cog)
        .scratch(args.scratch());
    let output = targets.writers()?.remove(0);
    let exported = export_raster(reader, options, &how, output, shown_on(bar)).await;
    let exported = targets.explained(exported)?;
    let Rect {
        min_x,
        min_y,
        max_x,
        max_y,
    } = grid.bounds();
    let report = RasterReport {
        columns: exported.columns,
        rows: exported.rows,
        resolution: grid.resolution(),
        bounds: [min_x, min_y, max_x, max_y],
        what: measure.to_string(),
        files: targets.publish().await?,
        bytes: exported.bytes,
        peak_memory_bytes: peak_memory(),
    };
    text(&report, args.json)
}

fn text(report: &RasterReport, json: bool) -> anyhow::Result<String> {
    if json {
        return Ok(serde_json::to_string(report)? + "\n");
    }
    let cells = [
        counted(u64::from(report.columns), "column", "columns"),
        counted(u64::from(report.rows), "row", "rows"),
    ];
    let (files, bytes) = (report.files.join(", "), common::bytes(report.bytes));
    Ok(format!("{files}: {} of {}; {bytes}\n", cells.join(", "), report.what))
}
