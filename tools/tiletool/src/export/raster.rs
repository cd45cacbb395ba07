//! Export of rasters.

use anyhow::Context;
use clap::Args;
use delaunay_tiles::export::{RasterFormat, RasterOutput, Samples, export_raster};
use delaunay_tiles::terrain::{Grid, Light, Measure, RasterOptions, Surface};
use delaunay_tiles::{Point, Rect, TileReader, peak_memory};
use indicatif::ProgressBar;
use serde::Serialize;

use super::formats::Shown;
use super::targets::Targets;
use super::{ExportArgs, length, read_clip, scratch, shown_on, usage};
use crate::common::{self, counted};
use crate::input_args::rect;
use crate::query::batch::point;

/// The formats of rasters, for messages.
pub const FORMATS: &str = "tif and asc";

/// Options for rasters.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Options for rasters")]
pub struct RasterArgs {
    /// Size of the cells, in units of the coordinates; required for rasters
    #[arg(long, value_name = "SIZE", value_parser = length)]
    resolution: Option<f64>,
    /// Rectangle to cover; without --align its upper left corner is that of a cell [default: all]
    #[arg(long, value_name = "XMIN,YMIN,XMAX,YMAX", allow_hyphen_values = true, value_parser = rect)]
    bounds: Option<Rect>,
    /// Corners of cells are whole multiples of the resolution away from this point [default: 0,0]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = point)]
    align: Option<Point>,
    /// Multiply heights by this first, for instance to convert feet to metres
    #[arg(long, value_name = "FACTOR", value_parser = length)]
    z_factor: Option<f64>,
    /// For hillshade: direction of the light, in degrees clockwise from north [default: 315]
    #[arg(long, value_name = "DEGREES", value_parser = azimuth)]
    azimuth: Option<f64>,
    /// For hillshade: height of the light above the horizon, in degrees [default: 45]
    #[arg(long, value_name = "DEGREES", value_parser = altitude)]
    altitude: Option<f64>,
    /// Store numbers of 32 bits instead of 64
    #[arg(long)]
    float32: bool,
    /// For GeoTIFF: add overviews, which make it a Cloud Optimized GeoTIFF
    #[arg(long)]
    cog: bool,
}

impl RasterArgs {
    /// Returns the first option that is given.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            ("--resolution", self.resolution.is_some()),
            ("--bounds", self.bounds.is_some()),
            ("--align", self.align.is_some()),
            ("--z-factor", self.z_factor.is_some()),
            ("--azimuth", self.azimuth.is_some()),
            ("--altitude", self.altitude.is_some()),
            ("--float32", self.float32),
            ("--cog", self.cog),
        ];
        given.into_iter().find_map(|(name, is_given)| is_given.then_some(name))
    }

    /// Returns the cells of a raster of a file.
    fn grid(&self, reader: &TileReader) -> anyhow::Result<Grid> {
        let bounds = self.bounds.unwrap_or(reader.metadata().bounds);
        let resolution = self.resolution.context("a raster needs --resolution SIZE")?;
        let grid = match (self.bounds, self.align) {
            (Some(bounds), None) => Grid::starting_at(bounds, resolution),
            (_, align) => Grid::covering(bounds, resolution, align.unwrap_or_default()),
        };
        Ok(grid?)
    }

    /// Returns what the raster shows.
    fn measure(&self, what: Option<Shown>) -> Measure {
        let default = Light::default();
        match what {
            Some(Shown::Raster(Measure::Hillshade(_))) => Measure::Hillshade(Light {
                azimuth: self.azimuth.unwrap_or(default.azimuth),
                altitude: self.altitude.unwrap_or(default.altitude),
            }),
            Some(Shown::Raster(measure)) => measure,
            _ => Measure::Z,
        }
    }
}

fn azimuth(text: &str) -> Result<f64, String> {
    let degrees = text.parse().ok().filter(|degrees| (0.0..=360.0).contains(degrees));
    degrees.ok_or_else(|| "a direction is a number from 0 to 360".to_owned())
}

fn altitude(text: &str) -> Result<f64, String> {
    let degrees = text.parse().ok().filter(|degrees| (0.0..=90.0).contains(degrees));
    degrees.ok_or_else(|| "a height above the horizon is a number from 0 to 90".to_owned())
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
    bar: &ProgressBar,
) -> anyhow::Result<String> {
    let grid = args.raster.grid(reader)?;
    let measure = args.raster.measure(args.what);
    let clip = read_clip(args).await?;
    let mut targets = Targets::create(vec![args.output.clone()], &args.file)?;
    let options = RasterOptions::new(grid)
        .measure(measure)
        .z_factor(args.raster.z_factor.unwrap_or(1.0))
        .surface(Surface::default().holes(args.all).max_edge(args.max_edge))
        .clip(clip);
    let samples = match args.raster.float32 {
        true => Samples::Float32,
        false => Samples::Float64,
    };
    let how = RasterOutput::new(format)
        .samples(samples)
        .overviews(args.raster.cog)
        .scratch(scratch(args));
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
