//! `tiletool export`: writes the triangulation in formats that other programs read.
//!
//! A file is written under a temporary name beside its final one, and renamed when it is complete
//! and on the disk. An export that fails or is interrupted leaves no files, and does not change
//! existing ones.

mod contours;
mod formats;
mod mesh;
mod raster;
mod targets;

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{bail, ensure};
use clap::Args;
use delaunay_tiles::input::{SegmentBatch, SegmentSource};
use delaunay_tiles::terrain::Clip;
use indicatif::{ProgressBar, ProgressStyle};

use crate::common::{self, MemoryArgs};
use contours::ContourArgs;
use formats::{AnyFormat, Shown};
use raster::RasterArgs;

/// Export the triangulation: PLY, Triangle's .node and .ele, OBJ, glTF, GeoJSON, FlatGeobuf, GeoParquet;
/// and its surface as a raster or as contours: GeoTIFF, ASCII grid; GeoJSON, FlatGeobuf
///
/// PLY, Triangle's format, OBJ and glTF are meshes: all vertices, numbered in the order of the file, and
/// triangles. GeoJSON, FlatGeobuf and GeoParquet are features for GIS and databases, by --what.
///
/// A raster holds, for each cell, the height of the triangle at its centre, or, by --what, its slope,
/// aspect or shade. Cells without a triangle have the value -9999, of shades 0.
///
/// Triangles in holes are left out, and with --max-edge and --clip further ones, but never vertices of
/// a mesh. An existing output is replaced when the new one is complete.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool export survey.tiles -o survey.ply
  tiletool export survey.tiles -o survey --format node    # survey.node and survey.ele
  tiletool export survey.tiles -o survey.fgb --max-edge 50
  tiletool export survey.tiles -o points.parquet --what vertices --clip district.geojson
  tiletool export survey.tiles -o dem.tif --resolution 1
  tiletool export survey.tiles -o contours.fgb --contours 5
  tiletool export survey.tiles -o shaded.tif --resolution 0.5 --what hillshade --cog
  tiletool export survey.tiles -o - --format geojson | gzip > survey.geojson.gz")]
pub struct ExportArgs {
    /// Tile file to read
    file: PathBuf,
    /// File to write: .ply, .node or .ele (writes both), .obj, .glb, .geojson, .fgb, .parquet, .tif or
    /// .asc; - is standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Output format [default: by the suffix of the output]
    #[arg(long, value_name = "ply|node|obj|glb|geojson|fgb|parquet|tif|asc")]
    format: Option<AnyFormat>,
    /// For GeoJSON, FlatGeobuf and GeoParquet: a feature for each of the triangles, vertices or edges
    /// (constraint edges, with the kind and number of their lines) [default: triangles; vertices if
    /// there are no triangles]. For rasters: z, slope or aspect (both in degrees) or hillshade [default:
    /// z]
    #[arg(long, value_name = "triangles|vertices|edges|z|slope|aspect|hillshade")]
    what: Option<Shown>,
    /// For PLY and glTF: also write constraint edges; some readers of PLY refuse them
    #[arg(long)]
    edges: bool,
    /// Also write triangles in holes
    #[arg(long)]
    all: bool,
    /// Leave out triangles with an edge longer than this, in units of the coordinates
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    max_edge: Option<f64>,
    /// Write only triangles and edges that meet the interior of these polygons, whole, and, with --what
    /// vertices, vertices in them; of rasters, cells whose centres are in them. The polygons must have
    /// the file's coordinate reference system
    #[arg(long, value_name = "POLYGONS.geojson")]
    clip: Option<PathBuf>,
    #[command(flatten)]
    raster: RasterArgs,
    #[command(flatten)]
    contours: ContourArgs,
    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    memory: MemoryArgs,
}

/// Exports a tile file.
pub fn run(args: ExportArgs) -> anyhow::Result<()> {
    let format = format(&args).unwrap_or_else(|error| error.exit());
    let bar = bar(args.json);
    let done = common::block_on(async {
        tokio::select! {
            done = write(&args, format, &bar) => done,
            // Dropping the future of the other branch removes the unfinished files.
            () = common::interrupted() => bail!("interrupted"),
        }
    });
    bar.finish_and_clear();
    let summary = done?;
    if is_stdout(&args) {
        // Standard output holds the triangulation, so the summary goes to standard error.
        common::say(summary.trim_end());
        return Ok(());
    }
    common::print("the summary", &summary)
}

fn is_stdout(args: &ExportArgs) -> bool {
    args.output == Path::new("-")
}

/// Exports a tile file. Returns the summary.
async fn write(args: &ExportArgs, format: AnyFormat, bar: &ProgressBar) -> anyhow::Result<String> {
    let reader = args.memory.open(&args.file).await?;
    match format {
        AnyFormat::Mesh(format) if args.contours.are_given() => contours::write(args, format, &reader, bar).await,
        AnyFormat::Mesh(format) => mesh::write(args, format, &reader, bar).await,
        AnyFormat::Raster(format) => raster::write(args, format, &reader, bar).await,
    }
}

/// Returns the format of the output.
fn format(args: &ExportArgs) -> Result<AnyFormat, clap::Error> {
    let to_stdout = is_stdout(args);
    let format = match args.format {
        Some(format) => format,
        None if to_stdout => {
            return Err(usage(
                "standard output has no suffix: choose a --format: ply, obj, glb, geojson, fgb, parquet, tif or asc",
            ));
        }
        None => AnyFormat::from_path(&args.output).map_err(|error| {
            let output = common::shown(&args.output);
            usage(&format!("{output}: {error}; choose another suffix or a --format"))
        })?,
    };
    match format {
        AnyFormat::Mesh(format) if args.contours.are_given() => contours::check(args, format)?,
        AnyFormat::Mesh(format) => mesh::check(args, format)?,
        AnyFormat::Raster(format) if args.contours.are_given() => {
            let formats = contours::FORMATS;
            return Err(usage(&format!("--contours is for {formats}, and not for {format}")));
        }
        AnyFormat::Raster(format) => raster::check(args, format)?,
    }
    Ok(format)
}

/// Parses a length.
fn length(text: &str) -> Result<f64, String> {
    let length = text
        .parse()
        .ok()
        .filter(|length: &f64| *length > 0.0 && length.is_finite());
    length.ok_or_else(|| "a length is a number above 0".to_owned())
}

/// Reads the polygons of `--clip`.
fn read_polygons(path: &Path) -> anyhow::Result<Clip> {
    let mut source = SegmentSource::open_obstacles(&[path.to_owned()])?;
    let (mut batch, mut edges) = (SegmentBatch::default(), Vec::new());
    while source.next_batch(&mut batch)? {
        edges.extend_from_slice(&batch.ends);
        ensure!(
            edges.len() <= Clip::MAX_EDGES,
            "{}: polygons to clip by can have {} edges; simplify them",
            common::shown(path),
            Clip::MAX_EDGES
        );
    }
    Ok(Clip::new(edges))
}

/// Reads the polygons of `--clip`, if it is given.
async fn read_clip(args: &ExportArgs) -> anyhow::Result<Option<Arc<Clip>>> {
    let Some(path) = args.clip.clone() else {
        return Ok(None);
    };
    let clip = common::on_thread("reading polygons", move || read_polygons(&path)).await?;
    Ok(Some(Arc::new(clip)))
}

/// Returns the folder for temporary files: that of the output, or the system's for standard output.
fn scratch(args: &ExportArgs) -> PathBuf {
    match args.output.parent() {
        _ if is_stdout(args) => std::env::temp_dir(),
        Some(folder) if folder != Path::new("") => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Returns a function that shows the number of tiles done on a bar.
fn shown_on(bar: &ProgressBar) -> impl FnMut(u64, u64) + Send {
    |done, total| {
        bar.set_length(total);
        bar.set_position(done);
    }
}

fn usage(why: &str) -> clap::Error {
    let mut command = ExportArgs::augment_args(clap::Command::new("tiletool export"));
    command.error(clap::error::ErrorKind::ValueValidation, why)
}

/// Returns a progress bar that counts tiles, hidden if standard error is not a terminal.
fn bar(json: bool) -> ProgressBar {
    if json || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = "export   {wide_bar} {percent:>3}%  {eta} left";
    ProgressBar::new(0).with_style(ProgressStyle::with_template(style).unwrap_or_else(|_| ProgressStyle::default_bar()))
}
