//! `tiletool query volume`: cut and fill.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use delaunay_tiles::crs::Crs;
use delaunay_tiles::terrain::Volume;
use delaunay_tiles_answers::units::{Measure, Unit, number, unit};
use serde::Serialize;

use super::surface::WholeSurfaceArgs;
use crate::common::{self, MemoryArgs};
use crate::crs::CrsArgs;
use crate::surface::open_clipped;

/// Find the volumes of the surface above and below a level
///
/// The cut is the volume below the surface and above the level; the fill is that above the surface and
/// below the level. They are exact but for rounding, and do not depend on memory and threads. Volumes are
/// in units of the coordinates squared, times those of z.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  tiletool query volume survey.tiles --level 420
  tiletool query volume survey.tiles --level 420 --polygon pit.geojson --json")]
pub struct VolumeArgs {
    /// Tile file to query
    file: PathBuf,
    /// Height of the plane
    #[arg(long, value_name = "Z", allow_hyphen_values = true, value_parser = level)]
    level: f64,
    /// Count only what is in the polygons of this file, in a format of --obstacles, such as GeoJSON. Where
    /// they overlap, the surface counts once. They must have the tile file's coordinate reference system
    #[arg(long, value_name = "FILE")]
    polygon: Option<PathBuf>,
    #[command(flatten)]
    crs: CrsArgs,
    #[command(flatten)]
    surface: WholeSurfaceArgs,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Print CSV, with numbers in full precision
    #[arg(long, conflicts_with = "json")]
    csv: bool,
    #[command(flatten)]
    memory: MemoryArgs,
}

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
struct VolumeReport {
    level: f64,
    cut: f64,
    fill: f64,
    area: f64,
    area_above: f64,
    area_below: f64,
}

fn level(text: &str) -> Result<f64, String> {
    let level = text.parse().ok().filter(|level: &f64| level.is_finite());
    level.ok_or_else(|| "a level is a number".to_owned())
}

/// Prints the volumes.
pub fn run(args: &VolumeArgs) -> anyhow::Result<()> {
    let report = common::wait_for("measuring the volume", async {
        tokio::select! {
            found = volume(args) => found,
            () = common::interrupted() => bail!("interrupted"),
        }
    });
    let (found, unit) = report?;
    let VolumeReport {
        level,
        cut,
        fill,
        area,
        area_above,
        area_below,
    } = found;
    if args.json {
        return common::print_json("the volumes", &found);
    }
    if args.csv {
        let row = format!("{level},{cut},{fill},{area},{area_above},{area_below}");
        let text = format!("level,cut,fill,area,area_above,area_below\n{row}\n");
        return common::print("the volumes", &text);
    }
    let side = |volume, area| format!("{}, on {}", number(volume), unit.area(area));
    let text = format!(
        "cut above {level}: {}\nfill below {level}: {}\narea: {}\n",
        side(cut, area_above),
        side(fill, area_below),
        unit.area(area)
    );
    common::print("the volumes", &text)
}

async fn volume(args: &VolumeArgs) -> anyhow::Result<(VolumeReport, Unit)> {
    let (reader, clip) = open_clipped(&args.file, args.polygon.as_deref(), &args.crs, &args.memory).await?;
    let found: Volume = reader.volume(args.level, args.surface.surface(), clip).await?;
    let crs = reader.crs().await?.map(|text| Crs::new(&text));
    let report = VolumeReport {
        level: args.level,
        cut: found.cut,
        fill: found.fill,
        area: found.area,
        area_above: found.area_above,
        area_below: found.area_below,
    };
    Ok((report, unit(crs.as_ref())))
}
