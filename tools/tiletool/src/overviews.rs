//! `tiletool overviews`: makes the levels of detail of a tile file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use clap::Args;
use delaunay_tiles::overviews::{self, OverviewError, OverviewOptions, OverviewProgress, OverviewSummary};
use delaunay_tiles::peak_memory;
use delaunay_tiles::store::{OpenOptions, Overview, TileReader};
use serde::Serialize;

use crate::allocator;
use crate::common::{self, MemoryArgs, bytes, counted, thousands};
use crate::progress::Bar;

/// Make overviews: coarser triangulations of the same surface
///
/// Each overview is the Delaunay triangulation of about a quarter of the vertices of the one
/// before, down to one tile. With z, the vertices are chosen so that the surface stays; the error
/// of each overview is measured at all vertices of the file. Services draw overviews where single
/// triangles could not be seen.
///
/// The overviews are appended to the file, of which they take about a third, and become valid in
/// one step when they are complete. A change of the file, as by `tiletool constrain`, makes them
/// stale. Then this command replaces them, and `tiletool compact` removes what they took.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool overviews survey.tiles
  tiletool build survey.laz -o survey.tiles --overviews")]
pub struct OverviewsArgs {
    /// Tile file to change
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Make them again even if those that the file has are not stale
    #[arg(long)]
    force: bool,
    /// Remove the overviews of the file instead
    #[arg(long, conflicts_with_all = ["force", "threads"])]
    remove: bool,
    /// Number of computing threads [default: one per processor]
    #[arg(long, value_name = "COUNT")]
    threads: Option<usize>,
    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    memory: MemoryArgs,
}

/// An overview. Its field names are stable keys of `--json`.
#[derive(Debug, Serialize)]
pub struct OverviewRow {
    pub level: usize,
    pub vertices: u64,
    /// The number of its tiles; `None` if it is stale.
    pub tiles: Option<u64>,
    pub bytes: u64,
    pub largest_error: f64,
    pub rms_error: f64,
    pub is_stale: bool,
}

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
struct OverviewsReport {
    is_new: bool,
    removed: usize,
    overview_list: Vec<OverviewRow>,
    bytes_appended: u64,
    file_bytes: u64,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
}

impl OverviewRow {
    fn new(level: usize, overview: &Overview, tiles: Option<u64>) -> Self {
        Self {
            level,
            vertices: overview.vertices,
            tiles,
            bytes: overview.bytes,
            largest_error: overview.largest_error,
            rms_error: overview.rms_error,
            is_stale: tiles.is_none(),
        }
    }

    /// Returns all overviews of a file, stale ones last.
    pub async fn all(reader: &TileReader) -> anyhow::Result<Vec<Self>> {
        let mut rows = Vec::new();
        for (place, overview) in reader.overviews().iter().enumerate() {
            let opened = reader.overview(place).await?;
            rows.push(Self::new(place + 1, overview, Some(opened.metadata().tiles.into())));
        }
        let stale = reader.stale_overviews().iter().zip(1..);
        rows.extend(stale.map(|(overview, level)| Self::new(level, overview, None)));
        Ok(rows)
    }

    /// Returns the row for people.
    pub fn text(&self, has_z: bool) -> String {
        let mut text = counted(self.vertices, "vertex", "vertices");
        if let Some(tiles) = self.tiles {
            text += &format!(" in {}", counted(tiles, "tile", "tiles"));
        }
        text += &format!(", {}", bytes(self.bytes));
        if has_z {
            text += &format!("; error {:.3} rms, {:.3} at most", self.rms_error, self.largest_error);
        }
        text
    }
}

/// The overviews that were made of a file.
pub struct MadeOverviews {
    pub summary: OverviewSummary,
    pub rows: Vec<OverviewRow>,
    has_z: bool,
}

impl MadeOverviews {
    /// Makes the overviews of a file.
    pub async fn of(file: &Path, options: OverviewOptions) -> anyhow::Result<Self> {
        let summary = make(file, options).await?;
        let reader = common::open(file, OpenOptions::default()).await?;
        Ok(Self {
            summary,
            rows: OverviewRow::all(&reader).await?,
            has_z: reader.metadata().has_z,
        })
    }

    /// Returns the summary for people.
    pub fn report(&self, file: &Path) -> String {
        let Self { summary, rows, has_z } = self;
        let [before, after] = summary.file_bytes;
        let what = match (summary.is_new, rows.is_empty()) {
            (_, true) => "it needs no overviews: it has one tile, or no triangles".to_owned(),
            (false, _) => format!("{} as before; they are not stale", counted_levels(rows)),
            (true, _) => counted_levels(rows),
        };
        let mut text = format!("{}: {what}\n", common::shown(file));
        for row in rows {
            text += &format!("  {:<9}{}\n", row.level, row.text(*has_z));
        }
        if summary.is_new {
            text += &format!(
                "written    {}; the file has {} ({} bytes)\ntime       {:.2} s\n",
                bytes(after - before),
                bytes(after),
                thousands(after),
                summary.seconds
            );
        }
        text
    }
}

/// Makes or removes overviews.
pub fn run(args: OverviewsArgs) -> anyhow::Result<()> {
    allocator::keep_to(args.memory.bytes());
    if args.remove {
        return remove(&args);
    }
    let mut options = OverviewOptions::default().memory(args.memory.bytes()).again(args.force);
    if let Some(threads) = args.threads {
        options = options.threads(threads);
    }
    let made = common::block_on(MadeOverviews::of(&args.file, options))?;
    let [before, after] = made.summary.file_bytes;
    if args.json {
        let report = OverviewsReport {
            is_new: made.summary.is_new,
            removed: 0,
            overview_list: made.rows,
            bytes_appended: after - before,
            file_bytes: after,
            seconds: made.summary.seconds,
            peak_memory_bytes: peak_memory(),
        };
        return common::print_json("the summary", &report);
    }
    common::print_summary("the summary", &made.report(&args.file))
}

/// Makes the overviews of a file, until it is interrupted.
async fn make(file: &Path, options: OverviewOptions) -> anyhow::Result<OverviewSummary> {
    let progress = Arc::new(OverviewProgress::default());
    let bar = Bar::of_overviews(Arc::clone(&progress));
    let made = tokio::select! {
        made = overviews::make(file, options.progress(Arc::clone(&progress))) => made,
        () = common::interrupted() => Err(OverviewError::Cancelled),
    };
    drop(bar);
    match made {
        Err(OverviewError::Cancelled) => anyhow::bail!("interrupted; {} has no new overviews", common::shown(file)),
        made => made.with_context(|| format!("{} has no new overviews", common::shown(file))),
    }
}

fn remove(args: &OverviewsArgs) -> anyhow::Result<()> {
    let (removed, reader) = common::block_on(async {
        let before = args.memory.open(&args.file).await?;
        Ok((overviews::remove(&args.file).await?, before))
    })?;
    let after = common::block_on(args.memory.open(&args.file))?.file_length();
    if args.json {
        let report = OverviewsReport {
            is_new: false,
            removed,
            overview_list: Vec::new(),
            bytes_appended: after - reader.file_length(),
            file_bytes: after,
            seconds: 0.0,
            peak_memory_bytes: peak_memory(),
        };
        return common::print_json("the summary", &report);
    }
    let count = counted(removed as u64, "overview", "overviews");
    let file = common::shown(&args.file);
    common::print_summary(
        "the summary",
        &format!("{file}: {count} removed; `tiletool compact` removes their bytes too\n"),
    )
}

fn counted_levels(rows: &[OverviewRow]) -> String {
    counted(rows.len() as u64, "overview", "overviews")
}
