//! `tiletool export`: writes the triangulation in formats that other programs read.
//!
//! A file is written under a temporary name beside its final one, and renamed when it is complete
//! and on the disk. An export that fails or is interrupted leaves no files, and does not change
//! existing ones.

mod args;
mod contours;
mod formats;
mod mesh;
mod progress;
mod raster;
mod targets;

use anyhow::bail;
use indicatif::ProgressBar;

use crate::common;
use crate::surface::open_clipped;
use args::usage;
use formats::AnyFormat;
use progress::bar;

pub use args::ExportArgs;

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
    if args.is_stdout() {
        // Standard output holds the triangulation, so the summary goes to standard error.
        common::say(summary.trim_end());
        return Ok(());
    }
    common::print("the summary", &summary)
}

/// Exports a tile file. Returns the summary.
async fn write(args: &ExportArgs, format: AnyFormat, bar: &ProgressBar) -> anyhow::Result<String> {
    let (reader, clip) = open_clipped(&args.file, args.clip.as_deref(), &args.crs, &args.memory).await?;
    match format {
        AnyFormat::Mesh(format) if args.contours.are_given() => contours::write(args, format, &reader, clip, bar).await,
        AnyFormat::Mesh(format) => mesh::write(args, format, &reader, clip, bar).await,
        AnyFormat::Raster(format) => raster::write(args, format, &reader, clip, bar).await,
    }
}

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
