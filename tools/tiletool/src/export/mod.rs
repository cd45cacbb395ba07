//! `tiletool export`: writes the triangulation in formats that other programs read.
//!
//! A file is written under a temporary name beside its final one, and renamed when it is complete
//! and on the disk. An export that fails or is interrupted leaves no files, and does not change
//! existing ones.

#[cfg(feature = "pmtiles")]
mod archive;
mod args;
mod contours;
mod formats;
mod given;
#[cfg(feature = "pmtiles")]
mod map_args;
mod mesh;
mod progress;
mod raster;
mod targets;

use std::ffi::OsString;
use std::fmt;
use std::sync::Arc;

use anyhow::bail;
use clap::{Args, FromArgMatches};
use delaunay_tiles::TileReader;
use delaunay_tiles::terrain::Clip;
use indicatif::ProgressBar;

use crate::common;
use crate::progress::OwnBar;
use crate::surface::open_clipped;
use args::usage;
use formats::AnyFormat;

pub use args::ExportArgs;

/// Exports a tile file.
pub fn run(args: ExportArgs) -> anyhow::Result<()> {
    let format = format(&args).unwrap_or_else(|error| error.exit());
    let bar = OwnBar::new(0, "export   {wide_bar} {percent:>3}%  {eta} left");
    let done = common::block_on(async {
        tokio::select! {
            done = write(&args, format, &bar) => done,
            // Dropping the future of the other branch removes the unfinished files.
            () = common::interrupted() => bail!("interrupted"),
        }
    });
    drop(bar);
    let summary = done?;
    if args.is_stdout() {
        // Standard output holds the triangulation, so the summary goes to standard error.
        common::tell(summary.trim_end());
        return Ok(());
    }
    if args.json {
        return common::print("the summary", &summary);
    }
    common::print_summary("the summary", &summary)
}

/// Exports a tile file. Returns the summary.
async fn write(args: &ExportArgs, format: AnyFormat, bar: &ProgressBar) -> anyhow::Result<String> {
    let (reader, clip) = open_clipped(&args.file, args.clip.as_deref(), &args.crs, &args.memory).await?;
    write_from(&reader, clip, args, format, bar).await
}

async fn write_from(
    reader: &TileReader,
    clip: Option<Arc<Clip>>,
    args: &ExportArgs,
    format: AnyFormat,
    bar: &ProgressBar,
) -> anyhow::Result<String> {
    match format {
        AnyFormat::Mesh(format) if args.contours.are_given() => contours::write(args, format, reader, clip, bar).await,
        AnyFormat::Mesh(format) => mesh::write(args, format, reader, clip, bar).await,
        AnyFormat::Raster(format) => raster::write(args, format, reader, clip, bar).await,
        #[cfg(feature = "pmtiles")]
        AnyFormat::Archive => archive::write(args, reader, bar).await,
    }
}

/// Exports an open tile file, as the command with these arguments does, which begin with the name of the
/// tile file. Returns the summary as JSON.
///
/// # Errors
/// Fails if an argument is wrong, or the export fails. No file is written then.
pub async fn export_open(
    reader: &TileReader,
    clip: Option<Arc<Clip>>,
    arguments: Vec<OsString>,
) -> anyhow::Result<String> {
    let command = ExportArgs::augment_args(clap::Command::new("export").no_binary_name(true));
    let wrong = |error: clap::Error| {
        let text = error.render().to_string();
        let words = text.trim_start_matches("error: ").lines().next().unwrap_or_default();
        anyhow::Error::new(WrongArgument(words.to_owned()))
    };
    let matches = command.try_get_matches_from(arguments).map_err(wrong)?;
    let mut args = ExportArgs::from_arg_matches(&matches).map_err(wrong)?;
    args.json = true;
    let format = format(&args).map_err(wrong)?;
    write_from(reader, clip, &args, format, &ProgressBar::hidden()).await
}

/// The error of an argument, in the words of the command line.
#[derive(Debug)]
pub struct WrongArgument(String);

impl fmt::Display for WrongArgument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for WrongArgument {}

/// Returns the format of the output.
fn format(args: &ExportArgs) -> Result<AnyFormat, clap::Error> {
    let to_stdout = args.is_stdout();
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
    #[cfg(feature = "pmtiles")]
    if let (Some(option), false) = (args.maps.given(), matches!(format, AnyFormat::Archive)) {
        return Err(usage(&format!("{option} is for pmtiles, and not for {format}")));
    }
    match format {
        AnyFormat::Mesh(format) if args.contours.are_given() => contours::check(args, format)?,
        AnyFormat::Mesh(format) => mesh::check(args, format)?,
        AnyFormat::Raster(format) if args.contours.are_given() => {
            let formats = contours::FORMATS;
            return Err(usage(&format!("--contours is for {formats}, and not for {format}")));
        }
        AnyFormat::Raster(format) => raster::check(args, format)?,
        #[cfg(feature = "pmtiles")]
        AnyFormat::Archive => archive::check(args)?,
    }
    Ok(format)
}
