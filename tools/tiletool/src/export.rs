//! `tiletool export`: writes the triangulation in formats that other programs read.
//!
//! A file is written under a temporary name beside its final one, and renamed when it is complete
//! and on the disk. An export that fails or is interrupted leaves no files, and does not change
//! existing ones.

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail, ensure};
use clap::Args;
use delaunay_tiles::export::{Clip, ExportOptions, Exported, Format, What, export};
use delaunay_tiles::input::{SegmentBatch, SegmentSource};
use delaunay_tiles::peak_memory;
use delaunay_tiles::store::TileReader;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::common::{self, MemoryArgs, counted};
use crate::crs::CrsArgs;
use crate::output::{StandardOutput, StreamOutput};

/// Export the triangulation: PLY, Triangle's .node and .ele, OBJ, glTF, GeoJSON, FlatGeobuf, GeoParquet
///
/// PLY, Triangle's format, OBJ and glTF are meshes: all vertices, numbered in the order of the file, and
/// triangles. GeoJSON, FlatGeobuf and GeoParquet are features for GIS and databases, by --what.
///
/// Triangles in holes are left out, and with --max-edge and --clip further ones, but never vertices of
/// a mesh. An existing output is replaced when the new one is complete.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool export survey.tiles -o survey.ply
  tiletool export survey.tiles -o survey --format node    # survey.node and survey.ele
  tiletool export survey.tiles -o survey.fgb --max-edge 50
  tiletool export survey.tiles -o points.parquet --what vertices --clip district.geojson
  tiletool export survey.tiles -o - --format geojson | gzip > survey.geojson.gz")]
pub struct ExportArgs {
    /// Tile file to read
    file: PathBuf,
    /// File to write: .ply, .node or .ele (writes both), .obj, .glb, .geojson, .fgb or .parquet; - is
    /// standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Output format [default: by the suffix of the output]
    #[arg(long, value_name = "ply|node|obj|glb|geojson|fgb|parquet")]
    format: Option<Format>,
    /// For GeoJSON, FlatGeobuf and GeoParquet: a feature for each of the triangles, vertices or edges
    /// (constraint edges, with the kind and number of their lines) [default: triangles; vertices if
    /// there are no triangles]
    #[arg(long, value_name = "triangles|vertices|edges")]
    what: Option<What>,
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
    /// vertices, vertices in them. The polygons must have the file's coordinate reference system, and take at most half of --memory
    #[arg(long, value_name = "POLYGONS.geojson")]
    clip: Option<PathBuf>,
    #[command(flatten)]
    crs: CrsArgs,
    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    memory: MemoryArgs,
}

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
struct ExportReport {
    vertices: u64,
    triangles: u64,
    edges: u64,
    files: Vec<String>,
    bytes: u64,
    peak_memory_bytes: Option<u64>,
    notes: Vec<String>,
}

/// Exports a tile file.
pub fn run(args: ExportArgs) -> anyhow::Result<()> {
    let to_stdout = args.output == Path::new("-");
    let (format, names) = outputs(&args).unwrap_or_else(|error| error.exit());
    let bar = bar(args.json);
    let done = common::block_on(async {
        tokio::select! {
            done = write(&args, format, to_stdout, &names, &bar) => done,
            // Dropping the future of the other branch removes the unfinished files.
            () = common::interrupted() => bail!("interrupted"),
        }
    });
    bar.finish_and_clear();
    let exported = done?;
    for note in &exported.notes {
        common::say(format_args!("note: {note}"));
    }
    let summary = ExportReport {
        vertices: exported.vertices,
        triangles: exported.triangles,
        edges: exported.edges,
        files: names.iter().map(|name| name.display().to_string()).collect(),
        bytes: exported.bytes,
        peak_memory_bytes: peak_memory(),
        notes: exported.notes,
    };
    if to_stdout {
        // Standard output holds the triangulation, so the summary goes to standard error.
        common::say(text(&summary, args.json)?.trim_end());
        return Ok(());
    }
    common::print("the summary", &text(&summary, args.json)?)
}

/// Returns the format and the names of the outputs.
fn outputs(args: &ExportArgs) -> Result<(Format, Vec<PathBuf>), clap::Error> {
    let to_stdout = args.output == Path::new("-");
    let format = match args.format {
        Some(format) => format,
        None if to_stdout => {
            return Err(usage(
                "standard output has no suffix: choose a --format: ply, obj, glb, geojson, fgb or parquet",
            ));
        }
        None => Format::from_path(&args.output).map_err(|error| {
            let output = common::shown(&args.output);
            usage(&format!("{output}: {error}; choose another suffix or a --format"))
        })?,
    };
    let names = names(&args.output, format);
    if to_stdout && names.len() > 1 {
        let count = names.len();
        return Err(usage(&format!(
            "--format {format} writes {count} files, so it cannot go to standard output"
        )));
    }
    check_options(args, format)?;
    Ok((format, names))
}

/// Fails if an option has no effect on the output.
fn check_options(args: &ExportArgs, format: Format) -> Result<(), clap::Error> {
    let why = match args.what {
        Some(what) if !format.has_features() => format!(
            "--what {what} is for geojson, fgb and parquet; {format} has the whole mesh, with constraint edges if \
             --edges is given and the format is ply or glb"
        ),
        Some(what @ (What::Vertices | What::Edges)) if args.max_edge.is_some() || args.all => {
            let option = if args.all { "--all" } else { "--max-edge" };
            format!("{option} is about triangles, but --what {what} writes none")
        }
        _ if args.edges && !matches!(format, Format::Ply | Format::Glb) => match format.has_features() {
            true => "--edges is for ply and glb; use --what edges".to_owned(),
            false => format!("--edges is for ply and glb; {format} has no edges"),
        },
        _ => return Ok(()),
    };
    Err(usage(&why))
}

/// Parses a length.
fn length(text: &str) -> Result<f64, String> {
    let length = text
        .parse()
        .ok()
        .filter(|length: &f64| *length > 0.0 && length.is_finite());
    length.ok_or_else(|| "a length is a number above 0".to_owned())
}

/// The polygons of `--clip`, and the text of their coordinate reference system.
type ClipFile = (Clip, Vec<(PathBuf, String)>);

/// Opens the tile file, and reads the polygons of `--clip` first, which take at most half of the memory.
async fn open(args: &ExportArgs) -> anyhow::Result<(TileReader, Option<Arc<Clip>>)> {
    let Some(path) = args.clip.clone() else {
        return Ok((args.memory.open(&args.file).await?, None));
    };
    let memory = args.memory.bytes() / 2;
    let (clip, of_clip) = common::on_thread("reading polygons", move || read_clip(&path, memory)).await?;
    let reader = args.memory.open_beside(&args.file, clip.bytes()).await?;
    let of_file = reader.lists().await?.crs.clone().map(|crs| (args.file.clone(), crs));
    args.crs.agree(of_file.iter().chain(&of_clip))?;
    Ok((reader, Some(Arc::new(clip))))
}

/// Reads the polygons of `--clip`, which may take this many bytes of memory.
fn read_clip(path: &Path, memory: u64) -> anyhow::Result<ClipFile> {
    let mut source = SegmentSource::open_obstacles(&[path.to_owned()])?;
    let (mut batch, mut edges) = (SegmentBatch::default(), Vec::new());
    let most = Clip::MAX_EDGES.min(usize::try_from(memory / Clip::BYTES_PER_EDGE).unwrap_or(usize::MAX));
    while source.next_batch(&mut batch)? {
        edges.extend_from_slice(&batch.ends);
        ensure!(
            edges.len() <= most,
            "{}: polygons to clip by can have {} with this memory, and {} with any; simplify them, or give more --memory",
            common::shown(path),
            counted(most as u64, "edge", "edges"),
            common::thousands(Clip::MAX_EDGES as u64)
        );
    }
    Ok((Clip::new(edges), source.crs_of_files().to_vec()))
}

fn usage(why: &str) -> clap::Error {
    let mut command = ExportArgs::augment_args(clap::Command::new("tiletool export"));
    command.error(clap::error::ErrorKind::ValueValidation, why)
}

fn text(summary: &ExportReport, json: bool) -> anyhow::Result<String> {
    if json {
        return Ok(serde_json::to_string(summary)? + "\n");
    }
    let mut counts = vec![
        counted(summary.vertices, "vertex", "vertices"),
        counted(summary.triangles, "triangle", "triangles"),
    ];
    if summary.edges > 0 {
        counts.push(counted(summary.edges, "constraint edge", "constraint edges"));
    }
    let (files, bytes) = (summary.files.join(", "), common::bytes(summary.bytes));
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

/// Returns a progress bar that counts tiles, hidden if standard error is not a terminal.
fn bar(json: bool) -> ProgressBar {
    if json || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = "export   {wide_bar} {percent:>3}%  {eta} left";
    ProgressBar::new(0).with_style(ProgressStyle::with_template(style).unwrap_or_else(|_| ProgressStyle::default_bar()))
}

async fn write(
    args: &ExportArgs,
    format: Format,
    to_stdout: bool,
    names: &[PathBuf],
    bar: &ProgressBar,
) -> anyhow::Result<Exported<Box<dyn Write + Send>>> {
    let file = &args.file;
    let (reader, clip) = open(args).await?;
    let mut targets = Vec::new();
    let mut outputs: Vec<Box<dyn Write + Send>> = Vec::new();
    if to_stdout {
        outputs.push(Box::new(StandardOutput::of("the triangulation")));
    } else {
        for name in names {
            let mut target = create(name, file)?;
            let output = target.file().try_clone();
            outputs.push(Box::new(output.with_context(|| name.display().to_string())?));
            targets.push(target);
        }
    }
    let progress = |done, total| {
        bar.set_length(total);
        bar.set_position(done);
    };
    let options = ExportOptions::default()
        .holes(args.all)
        .edges(args.edges)
        .what(args.what)
        .max_edge(args.max_edge)
        .clip(clip);
    let exported = export(&reader, format, options, outputs, progress).await;
    let exported = match to_stdout {
        // Its errors say so themselves.
        true => exported?,
        false => exported.with_context(|| joined(names))?,
    };
    // All files are on the disk before the first one gets its name. This runs on another thread,
    // because an interrupt must not wait for it.
    let finish = move || {
        targets.iter().try_for_each(StreamOutput::sync)?;
        Ok(targets.into_iter().try_for_each(StreamOutput::publish)?)
    };
    let finished = common::on_thread("finishing", finish).await;
    finished.with_context(|| format!("cannot write {}", joined(names)))?;
    Ok(exported)
}

fn joined(names: &[PathBuf]) -> String {
    names
        .iter()
        .map(|name| common::shown(name))
        .collect::<Vec<_>>()
        .join(", ")
}

/// Opens an output.
///
/// # Errors
/// Fails if the output is the input.
fn create(name: &Path, input: &Path) -> anyhow::Result<StreamOutput> {
    let shown = common::shown(name);
    let is_input = name
        .canonicalize()
        .is_ok_and(|name| input.canonicalize().is_ok_and(|input| input == name));
    ensure!(!is_input, "{shown} is the tile file itself; choose another output");
    StreamOutput::create(name).with_context(|| format!("cannot create {shown}"))
}
