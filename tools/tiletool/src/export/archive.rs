//! Export of map tiles.

use std::thread::available_parallelism;

use anyhow::anyhow;
use delaunay_tiles::map_archive::{self, ArchiveError, ArchiveOptions};
use delaunay_tiles::map_tiles::{GridKind, Layer, MapSource};
use delaunay_tiles::{TileReader, peak_memory};
use indicatif::ProgressBar;
use serde::Serialize;

use super::args::{ExportArgs, usage};
use super::given::first_given;
use super::progress::shown_on;
use super::targets::Targets;
use crate::common::{self, counted};

/// The share of the memory for the directory of the archive, and that for drawing: one part in this many.
const DIRECTORY: u64 = 4;
const DRAWING: u64 = 4;
/// The memory for each map tile that is drawn at once: its samples, its shapes, and its bytes.
const OF_DRAWING: u64 = 16 << 20;

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
struct ArchiveReport {
    layer: &'static str,
    grid: &'static str,
    zooms: [u8; 2],
    map_tiles: u64,
    files: Vec<String>,
    bytes: u64,
    peak_memory_bytes: Option<u64>,
    notes: Vec<String>,
}

/// Fails if an option has no effect on the output.
pub fn check(args: &ExportArgs) -> Result<(), clap::Error> {
    let others = [
        ("--what", args.what.is_some()),
        ("--edges", args.edges),
        ("--all", args.all),
        ("--max-edge", args.max_edge.is_some()),
        ("--clip", args.clip.is_some()),
        ("--contours", args.contours.are_given()),
    ];
    let other = first_given(others).or(args.raster.given());
    let why = if args.is_stdout() {
        "--format pmtiles cannot go to standard output, because its header is written last".to_owned()
    } else if let Some(option) = other {
        format!("{option} is not for pmtiles, which has the map tiles of `tiletool serve`")
    } else if args.crs.is_given() {
        "--crs is for --clip; map tiles are where the file's own coordinate reference system says".to_owned()
    } else {
        return Ok(());
    };
    Err(usage(&why))
}

/// Writes map tiles. Returns the summary.
pub async fn write(args: &ExportArgs, reader: &TileReader, bar: &ProgressBar) -> anyhow::Result<String> {
    let mut targets = Targets::create("the map tiles", vec![args.output.clone()], &args.file)?;
    let maps = MapSource::open(reader.clone()).await?;
    let mut notes = Vec::new();
    let (grid, layer) = (grid(args, &maps, &mut notes), args.maps.layer.unwrap_or(Layer::Shade));
    let in_file = |error| explained(error, args);
    let plan = map_archive::plan(&maps, options(args, grid, layer))
        .await
        .map_err(in_file)?;
    let output = targets.file()?;
    let written = map_archive::write(&maps, &plan, output, shown_on(bar)).await;
    let written = match written {
        Err(ArchiveError::Write(error)) => targets.explained(Err(anyhow!(error)))?,
        written => written.map_err(in_file)?,
    };
    let report = ArchiveReport {
        layer: layer.name(),
        grid: grid.name(),
        zooms: [plan.zooms().first(), plan.zooms().last()],
        map_tiles: written.tiles,
        files: targets.publish().await?,
        bytes: written.bytes,
        peak_memory_bytes: peak_memory(),
        notes,
    };
    text(&report, args.json)
}

/// Returns the grid that is wanted, or the one that fits the file.
fn grid(args: &ExportArgs, maps: &MapSource, notes: &mut Vec<String>) -> GridKind {
    match (args.maps.grid, maps.grid(GridKind::WebMercatorQuad)) {
        (Some(grid), _) => grid,
        (None, Ok(_)) => GridKind::WebMercatorQuad,
        (None, Err(why)) => {
            notes.push(format!("the grid is native: {why}"));
            GridKind::Native
        }
    }
}

fn options(args: &ExportArgs, grid: GridKind, layer: Layer) -> ArchiveOptions {
    let (maps, memory) = (&args.maps, args.memory.bytes());
    let processors = available_parallelism().map_or(1, usize::from);
    let at_once = maps.at_once.map_or(2 * processors, usize::from);
    let fitting = usize::try_from(memory / DRAWING / OF_DRAWING).unwrap_or(usize::MAX);
    let stem = args.file.file_stem().unwrap_or_default().to_string_lossy();
    let mut options = ArchiveOptions::new(grid, layer)
        .zooms(maps.zooms)
        .directory_memory(memory / DIRECTORY)
        .at_once(at_once.min(fitting))
        .name(format!("{stem} {layer}"))
        .attribution(maps.attribution.clone());
    if let Some(count) = maps.max_tiles {
        options = options.max_tiles(count);
    }
    if let Some(count) = maps.max_picture_tiles {
        options = options.max_picture_tiles(count);
    }
    options
}

/// Returns an error with the name of the file, or with what to do.
fn explained(error: ArchiveError, args: &ExportArgs) -> anyhow::Error {
    match error {
        ArchiveError::Memory { needed, .. } => {
            let mebibytes = (needed * DIRECTORY).div_ceil(1 << 20);
            anyhow!("{error}; give --memory {mebibytes}MiB, or fewer --zooms")
        }
        error => anyhow::Error::new(error).context(common::shown(&args.file)),
    }
}

fn text(report: &ArchiveReport, json: bool) -> anyhow::Result<String> {
    if json {
        return Ok(serde_json::to_string(report)? + "\n");
    }
    for note in &report.notes {
        common::note(note);
    }
    let (files, bytes) = (report.files.join(", "), common::bytes(report.bytes));
    let count = counted(report.map_tiles, "map tile", "map tiles");
    let [first, last] = report.zooms;
    let (layer, grid) = (report.layer, report.grid);
    Ok(format!(
        "{files}: {count} of {layer}, grid {grid}, zooms {first} to {last}; {bytes}\n"
    ))
}
