//! Export of meshes and features.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use delaunay_tiles::export::{ExportOptions, Format, What, export};
use delaunay_tiles::terrain::Clip;
use delaunay_tiles::{TileReader, peak_memory};
use indicatif::ProgressBar;
use serde::Serialize;

use super::args::{ExportArgs, usage};
use super::formats::Shown;
use super::progress::shown_on;
use super::targets::Targets;
use crate::common::{self, counted};

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
struct MeshReport {
    vertices: u64,
    triangles: u64,
    edges: u64,
    files: Vec<String>,
    bytes: u64,
    peak_memory_bytes: Option<u64>,
    notes: Vec<String>,
}

/// Fails if an option has no effect on the output.
pub fn check(args: &ExportArgs, format: Format) -> Result<(), clap::Error> {
    let names = names(&args.output, format);
    if args.is_stdout() && names.len() > 1 {
        let count = names.len();
        return Err(usage(&format!(
            "--format {format} writes {count} files, so it cannot go to standard output"
        )));
    }
    let why = match args.what {
        Some(Shown::Raster(measure)) => {
            format!("--what {measure} is for rasters, tif and asc; {format} has a mesh")
        }
        Some(Shown::Mesh(what)) if !format.has_features() => format!(
            "--what {what} is for geojson, fgb and parquet; {format} has the whole mesh, with constraint edges if \
             --edges is given and the format is ply or glb"
        ),
        Some(Shown::Mesh(what @ (What::Vertices | What::Edges))) if args.max_edge.is_some() || args.all => {
            let option = if args.all { "--all" } else { "--max-edge" };
            format!("{option} is about triangles, but --what {what} writes none")
        }
        _ if args.edges && !matches!(format, Format::Ply | Format::Glb) => match format.has_features() {
            true => "--edges is for ply and glb; use --what edges".to_owned(),
            false => format!("--edges is for ply and glb; {format} has no edges"),
        },
        _ => match args.raster.given() {
            Some(option) => format!("{option} is for rasters, tif and asc, and not for {format}"),
            None => return Ok(()),
        },
    };
    Err(usage(&why))
}

/// Writes a mesh. Returns the summary.
pub async fn write(
    args: &ExportArgs,
    format: Format,
    reader: &TileReader,
    clip: Option<Arc<Clip>>,
    bar: &ProgressBar,
) -> anyhow::Result<String> {
    let mut targets = Targets::create("the triangulation", names(&args.output, format), &args.file)?;
    let what = match args.what {
        Some(Shown::Mesh(what)) => Some(what),
        _ => None,
    };
    let options = ExportOptions::default()
        .holes(args.all)
        .edges(args.edges)
        .what(what)
        .max_edge(args.max_edge)
        .from_hull(args.from_hull)
        .clip(clip);
    let exported = export(reader, format, options, targets.writers()?, shown_on(bar)).await;
    let exported = targets.explained(exported)?;
    for note in &exported.notes {
        common::note(note);
    }
    let report = MeshReport {
        files: targets.publish().await?,
        vertices: exported.vertices,
        triangles: exported.triangles,
        edges: exported.edges,
        bytes: exported.bytes,
        peak_memory_bytes: peak_memory(),
        notes: exported.notes,
    };
    text(&report, args.json)
}

fn text(report: &MeshReport, json: bool) -> anyhow::Result<String> {
    if json {
        return Ok(serde_json::to_string(report)? + "\n");
    }
    let mut counts = vec![
        counted(report.vertices, "vertex", "vertices"),
        counted(report.triangles, "triangle", "triangles"),
    ];
    if report.edges > 0 {
        counts.push(counted(report.edges, "constraint edge", "constraint edges"));
    }
    let (files, bytes) = (report.files.join(", "), common::bytes(report.bytes));
    Ok(format!("{files}: {}; {bytes}\n", counts.join(", ")))
}

/// Returns the names of the outputs: `output` itself, or its stem with each suffix of a format that
/// has several files.
fn names(output: &Path, format: Format) -> Vec<PathBuf> {
    let suffixes = format.suffixes();
    if suffixes.len() == 1 {
        return vec![output.to_owned()];
    }
    let mut stem = output.to_owned();
    if Format::from_path(output).is_ok_and(|found| found == format) {
        stem.set_extension("");
    }
    let with_suffix = |suffix: &&str| {
        let mut name = stem.clone().into_os_string();
        name.push(".");
        name.push(suffix);
        name.into()
    };
    suffixes.iter().map(with_suffix).collect()
}
