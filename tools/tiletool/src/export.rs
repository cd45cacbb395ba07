//! `tiletool export`: writes the triangulation in formats that other programs read.
//!
//! A file is written under a temporary name beside its final one, and renamed when it is complete
//! and on the disk. An export that fails or is interrupted leaves no files, and does not change
//! existing ones.

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use clap::Args;
use delaunay_tiles::export::{ExportOptions, Exported, Format, export};
use delaunay_tiles::peak_memory;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::common::{self, MemoryArgs, counted};
use crate::output::{StandardOutput, StreamOutput};

/// Export the triangulation as PLY, Triangle's .node and .ele, OBJ or GeoJSON
///
/// Vertices are numbered in the order of the file. PLY also has the record number of each vertex.
/// Triangle's format has z as an attribute. GeoJSON has a polygon for each triangle.
///
/// Triangles in holes are left out, but never vertices. An existing output is replaced when the new
/// one is complete.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool export survey.tiles -o survey.ply
  tiletool export survey.tiles -o survey --format node    # survey.node and survey.ele
  tiletool export survey.tiles -o - --format geojson | gzip > survey.geojson.gz")]
pub struct ExportArgs {
    /// Tile file to read
    file: PathBuf,
    /// File to write: .ply, .node or .ele (writes both), .obj or .geojson; - is standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Output format [default: by the suffix of the output]
    #[arg(long, value_name = "ply|node|obj|geojson")]
    format: Option<Format>,
    /// Also write triangles in holes
    #[arg(long)]
    all: bool,
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
    files: Vec<String>,
    bytes: u64,
    peak_memory_bytes: Option<u64>,
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
    let summary = ExportReport {
        vertices: exported.vertices,
        triangles: exported.triangles,
        files: names.iter().map(|name| name.display().to_string()).collect(),
        bytes: exported.bytes,
        peak_memory_bytes: peak_memory(),
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
                "standard output has no suffix: choose a --format: ply, obj or geojson",
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
    Ok((format, names))
}

fn usage(why: &str) -> clap::Error {
    let mut command = ExportArgs::augment_args(clap::Command::new("tiletool export"));
    command.error(clap::error::ErrorKind::ValueValidation, why)
}

fn text(summary: &ExportReport, json: bool) -> anyhow::Result<String> {
    if json {
        return Ok(serde_json::to_string(summary)? + "\n");
    }
    Ok(format!(
        "{}: {}, {}; {}\n",
        summary.files.join(", "),
        counted(summary.vertices, "vertex", "vertices"),
        counted(summary.triangles, "triangle", "triangles"),
        common::bytes(summary.bytes)
    ))
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
    let reader = args.memory.open(file).await?;
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
    let options = ExportOptions::default().holes(args.all);
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
