//! `tiletool inspect`: shows the contents of a tile file.

mod regions;
mod summary;
mod tile;
mod tiles;

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use delaunay_tiles::store::TileId;
use serde::Serialize;

use crate::common::{self, MemoryArgs};
use crate::numbers::Coordinates;
use crate::overviews::OverviewRow;
use crate::plot::{self, PlotFile, Plotted, TitleArgs};
use regions::Regions;
use summary::Summary;
use tile::WholeTile;
use tiles::TileRow;

/// Show the contents of a tile file
///
/// The summary and --tiles need only the directory, however large the file is. --tile reads one
/// tile. --regions and --plot read all tiles, as many at once as fit in --memory.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool inspect survey.tiles
  tiletool inspect survey.tiles --tiles
  tiletool inspect survey.tiles --json --tile 7
  tiletool inspect town.tiles --regions
  tiletool inspect survey.tiles --plot survey.png")]
pub struct InspectArgs {
    /// Tile file to read
    file: PathBuf,
    /// Print one JSON object with the summary and all that --tiles, --tile, --regions and --plot
    /// ask for
    #[arg(long)]
    json: bool,
    /// Print one row per tile instead of the summary; core, border and owned are numbers of
    /// triangles
    #[arg(long)]
    tiles: bool,
    /// Print one tile with its vertices and triangles instead of the summary
    #[arg(long, value_name = "ID")]
    tile: Option<u32>,
    /// Print the 20 largest regions between constraints instead of the summary
    #[arg(long)]
    regions: bool,
    /// With --regions: print all regions; memory grows with their number
    #[arg(long, requires = "regions")]
    all: bool,
    /// Draw a map of the triangulation and the cells of its tiles, as .svg or .png, over
    /// heights where there is z
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(PlotFile::new))]
    plot: Option<PlotFile>,
    #[command(flatten)]
    title: TitleArgs,
    #[command(flatten)]
    memory: MemoryArgs,
}

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
struct InspectReport<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    pending_transactions: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tile_list: Option<Vec<TileRow>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tile: Option<&'a WholeTile>,
    #[serde(flatten)]
    regions: Option<&'a Regions>,
    #[serde(skip_serializing_if = "Option::is_none")]
    plot: Option<&'a Plotted>,
}

/// Shows the contents of a tile file.
pub fn run(args: InspectArgs) -> anyhow::Result<()> {
    let (reader, directory, overviews, pending, tile, regions, plotted) =
        common::wait_for("reading the tiles", async {
            let memory = args.memory.bytes();
            let of_pixels = args
                .plot
                .as_ref()
                .map_or(0, |_| memory - plot::memory_of_reader(memory));
            let reader = args.memory.open_beside(&args.file, of_pixels).await?;
            let tile = match args.tile {
                Some(id) => Some(reader.tile(TileId(id)).await?),
                None => None,
            };
            let regions = match args.regions {
                true => Some(regions::gather(&reader, args.all).await?),
                false => None,
            };
            let plotted = match &args.plot {
                Some(file) => Some(plot::draw(&reader, &args.title.of(file)).await?),
                None => None,
            };
            let directory = reader.directory().await?;
            let overviews = OverviewRow::all(&reader).await?;
            let pending = common::pending_in_log(&args.file, &reader).await;
            Ok((reader, directory, overviews, pending, tile, regions, plotted))
        })?;
    let summary = Summary::new(&reader, &directory, overviews);
    let tile = tile.map(|tile| WholeTile::new(&directory, &tile));
    if args.json {
        let rows = || TileRow::all(&directory).collect();
        return common::print_json(
            "the report",
            &InspectReport {
                summary: &summary,
                pending_transactions: pending,
                tile_list: args.tiles.then(rows),
                tile: tile.as_ref(),
                regions: regions.as_ref(),
                plot: plotted.as_ref(),
            },
        );
    }
    let coordinates = Coordinates::within(directory.metadata.bounds);
    let mut texts = Vec::new();
    if args.tiles {
        texts.push(tiles::table(&directory, coordinates));
    }
    if let Some(tile) = &tile {
        texts.push(tile.report());
    }
    if let Some(regions) = &regions {
        texts.push(regions.report());
    }
    if texts.is_empty() {
        texts.push(summary.report(coordinates));
    }
    if let Some(plotted) = &plotted {
        texts.push(plotted.report());
    }
    common::print("the report", &texts.join("\n"))
}
