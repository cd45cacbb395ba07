//! `tiletool info`: shows what input files hold.

mod report;
mod text;

use std::path::{Path, PathBuf};

use anyhow::{anyhow, ensure};
use clap::Args;
use delaunay_tiles::input::{FileInfo, InputError, InputOptions, Reading, describe};
use delaunay_tiles::store::{OpenOptions, TileReader};

use crate::common;
use crate::input_args::FormatArgs;
use crate::progress::Bar;
use report::Report;

/// Show what input files hold, without building anything
///
/// Prints for each file its format, fields and coordinate reference system, the number of records of
/// each kind, and their bounds; for LAS also classes and returns, for a GeoPackage all layers. Each
/// file is read to its end, in little memory, and invalid records are counted. For tile files, use
/// `tiletool inspect`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool info survey.laz
  tiletool info points.csv --columns lon,lat
  tiletool info town.gpkg:houses roads.shp --json")]
pub struct InfoArgs {
    /// Files to read: points, lines, polygons or sites of any format; FILE.gpkg:LAYER for one layer
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Print one JSON object for each file, on one line
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    format: FormatArgs,
}

/// Shows what files hold, one after the other, up to the first one that cannot be read.
pub fn run(args: InfoArgs) -> anyhow::Result<()> {
    let options = args.format.options();
    for (number, path) in args.files.iter().enumerate() {
        let info = read(path, &options)?;
        let report = Report::new(&info);
        if args.json {
            common::print_json("the report", &report)?;
            continue;
        }
        let gap = if number > 0 { "\n" } else { "" };
        common::print("the report", &format!("{gap}{}", text::of(&info, &report)))?;
        info.notes.iter().for_each(common::note);
    }
    Ok(())
}

/// Reads a file.
fn read(path: &Path, options: &InputOptions) -> anyhow::Result<FileInfo> {
    ensure!(
        path.as_os_str() != "-",
        "standard input is not described; give the names of files"
    );
    ensure!(
        common::url(path).is_none(),
        "{}: only files on this machine are described",
        common::shown(path)
    );
    let reading = Reading::default();
    let total = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file);
    let bar = Bar::of_reading(reading.clone(), total.map(|metadata| metadata.len()));
    let info = describe(path, options, &reading);
    drop(bar);
    info.map_err(|error| match error {
        InputError::UnknownFormat { .. } | InputError::Malformed { .. } if is_tile_file(path) => anyhow!(
            "{}: this is a tile file, and no input; to show what it holds: tiletool inspect {}",
            common::shown(path),
            common::shown(path)
        ),
        error => error.into(),
    })
}

/// Returns whether a file is a tile file, by its content.
fn is_tile_file(path: &Path) -> bool {
    let open = async { Ok(TileReader::open(path, OpenOptions::default()).await.is_ok()) };
    common::block_on(open).unwrap_or(false)
}
