//! `tiletool export`: the triangulation in formats that other programs read.
//!
//! What goes to a file is written beside it under another name, and renamed when all of it is complete and on the disk: an
//! export that fails or is interrupted leaves nothing, and does not touch what stood there before.

use std::fs::{self, File, OpenOptions};
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use clap::Args;
use delaunay_tiles::build::peak_memory;
use delaunay_tiles::export::{ExportOptions, Exported, Format, export};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use tempfile::TempPath;

use crate::common::{self, MemoryArgs};

/// Write the triangulation in another format: PLY, Triangle's .node and .ele, OBJ or GeoJSON.
///
/// Vertices are numbered in the order of the file. PLY has the record number of each vertex too; Triangle's format has z
/// as an attribute; GeoJSON has a polygon for each triangle. Triangles in holes are left out, vertices never. An output that exists is replaced once the new one is
/// complete.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool export survey.tiles -o survey.ply
  tiletool export survey.tiles -o survey --format node    # survey.node and survey.ele
  tiletool export survey.tiles -o - --format geojson | gzip > survey.geojson.gz")]
pub struct ExportArgs {
    /// The tile file
    file: PathBuf,
    /// What to write: .ply, .node or .ele (both are written), .obj, .geojson; - is standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// The format, if the output's suffix does not tell
    #[arg(long, value_name = "ply|node|obj|geojson")]
    format: Option<Format>,
    /// Write the triangles in holes too
    #[arg(long)]
    all: bool,
    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    memory: MemoryArgs,
}

/// The keys of `--json`, which are stable.
#[derive(Serialize)]
struct Summary {
    vertices: u64,
    triangles: u64,
    files: Vec<String>,
    bytes: u64,
    peak_memory_bytes: Option<u64>,
}

/// Exports a file.
pub fn run(args: ExportArgs) -> anyhow::Result<()> {
    let to_stdout = args.output == Path::new("-");
    let (format, names) = outputs(&args).unwrap_or_else(|error| error.exit());
    let bar = bar(args.json);
    let done = common::block_on(async {
        tokio::select! {
            done = write(&args, format, to_stdout, &names, &bar) => done,
            // What is written goes away with the future of the other branch.
            _ = tokio::signal::ctrl_c() => bail!("interrupted"),
        }
    });
    bar.finish_and_clear();
    let exported = done?;
    let summary = Summary {
        vertices: exported.vertices,
        triangles: exported.triangles,
        files: names.iter().map(|name| name.display().to_string()).collect(),
        bytes: exported.bytes,
        peak_memory_bytes: peak_memory(),
    };
    if to_stdout {
        // The output proper is there.
        common::say(text(&summary, args.json)?.trim_end());
        return Ok(());
    }
    common::print(&text(&summary, args.json)?)
}

/// The format and the names of the outputs.
fn outputs(args: &ExportArgs) -> Result<(Format, Vec<PathBuf>), clap::Error> {
    let to_stdout = args.output == Path::new("-");
    let format = match args.format {
        Some(format) => format,
        None if to_stdout => {
            return Err(usage(
                "standard output has no suffix: choose a --format of ply, obj or geojson",
            ));
        }
        None => Format::from_path(&args.output).map_err(|error| {
            let output = args.output.display();
            usage(&format!("{output}: {error}; choose another suffix, or a --format"))
        })?,
    };
    let names = names(&args.output, format);
    if to_stdout && names.len() > 1 {
        let count = names.len();
        return Err(usage(&format!(
            "--format {format} makes {count} files, so it cannot go to standard output"
        )));
    }
    Ok((format, names))
}

fn usage(why: &str) -> clap::Error {
    let mut command = ExportArgs::augment_args(clap::Command::new("tiletool export"));
    command.error(clap::error::ErrorKind::ValueValidation, why)
}

fn text(summary: &Summary, json: bool) -> anyhow::Result<String> {
    if json {
        return Ok(serde_json::to_string(summary)? + "\n");
    }
    Ok(format!(
        "{}: {} vertices, {} triangles; {}\n",
        summary.files.join(", "),
        common::thousands(summary.vertices),
        common::thousands(summary.triangles),
        common::bytes(summary.bytes)
    ))
}

/// The names of the outputs: the one given, or with a format of several files its stem with all their suffixes.
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

/// A bar of tiles, where people see it.
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
        outputs.push(Box::new(io::stdout()));
    } else {
        for name in names {
            let (target, output) = Target::create(name, file)?;
            targets.push(target);
            outputs.push(Box::new(output));
        }
    }
    let progress = |done, total| {
        bar.set_length(total);
        bar.set_position(done);
    };
    let options = ExportOptions { holes: args.all };
    let exported = export(&reader, format, options, outputs, progress).await;
    let exported = exported.with_context(|| {
        if to_stdout {
            "standard output".to_owned()
        } else {
            joined(names)
        }
    })?;
    // All are on the disk before the first gets its name.
    for target in &targets {
        target.sync().await?;
    }
    for target in targets {
        target.publish()?;
    }
    Ok(exported)
}

fn joined(names: &[PathBuf]) -> String {
    names
        .iter()
        .map(|name| name.display().to_string())
        .collect::<Vec<_>>()
        .join(", ")
}

/// An output on the way to its name.
struct Target {
    name: PathBuf,
    /// The file, and where it is until it gets its name; None for what is written in place, a device or a pipe.
    unfinished: Option<(File, TempPath)>,
}

impl Target {
    /// Opens an output that is not the input. Returns what to write to as well.
    fn create(name: &Path, input: &Path) -> anyhow::Result<(Self, File)> {
        let shown = name.display();
        let mut name = name.to_owned();
        match fs::metadata(&name) {
            Ok(found) if found.is_dir() => bail!("{shown} is a folder"),
            Ok(found) if found.is_file() => {
                // What a symbolic link points to is replaced, and the link stays.
                name = name.canonicalize().with_context(|| shown.to_string())?;
                let is_input = input.canonicalize().is_ok_and(|input| input == name);
                ensure!(!is_input, "{shown} is the tile file itself");
            }
            Ok(_) => {
                let output = OpenOptions::new()
                    .write(true)
                    .open(&name)
                    .with_context(|| shown.to_string())?;
                let unfinished = None;
                return Ok((Self { name, unfinished }, output));
            }
            // Not there; or what else is wrong shows below.
            Err(_) => {}
        }
        let file_name = name
            .file_name()
            .with_context(|| format!("{shown} is no name of a file"))?;
        let mut prefix = file_name.to_owned();
        prefix.push(".");
        // Made like any other file, and not for its owner only, as temporary files are by default.
        let made = tempfile::Builder::new()
            .prefix(&prefix)
            .suffix(".partial")
            .make_in(folder(&name), |path| File::create_new(path));
        let (file, path) = made.with_context(|| format!("cannot create {shown}"))?.into_parts();
        let output = file.try_clone().with_context(|| shown.to_string())?;
        let unfinished = Some((file, path));
        Ok((Self { name, unfinished }, output))
    }

    /// Waits until all is on the disk: on another thread, because it may take long, and an interrupt shall not.
    async fn sync(&self) -> anyhow::Result<()> {
        let Some((file, _)) = &self.unfinished else {
            return Ok(());
        };
        let failed = || format!("cannot write {}", self.name.display());
        let file = file.try_clone().with_context(failed)?;
        tokio::task::spawn_blocking(move || file.sync_all())
            .await?
            .with_context(failed)
    }

    /// Gives the file its name.
    fn publish(self) -> anyhow::Result<()> {
        let Some((_, path)) = self.unfinished else {
            return Ok(());
        };
        let shown = self.name.display();
        let renamed = path.persist(&self.name).map_err(|error| error.error);
        renamed.with_context(|| format!("cannot give the finished file its name {shown}"))?;
        let folder = folder(&self.name);
        let synced = File::open(folder).and_then(|folder| folder.sync_all());
        synced.with_context(|| format!("cannot sync the folder {}", folder.display()))
    }
}

/// The folder that a file lies in.
fn folder(name: &Path) -> &Path {
    match name.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}
