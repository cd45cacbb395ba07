//! `tiletool unconstrain`: removes lines from a tile file.

use clap::Args;
use delaunay_tiles::{EditError, EditSummary};

use crate::common;
use crate::crs::CrsArgs;
use crate::edit::points::MissingArgs;
use crate::edit::{EditArgs, line_error};
use crate::lines::{LineFiles, LineInput};

/// Remove lines from a tile file
///
/// The resulting triangles are those of a build without the lines. Each segment of the files must be
/// a whole segment of a line of this kind in the file; points on its way do not matter. Obstacles are
/// removed with all their rings, and their interiors are free then. Vertices go if only ends of
/// removed lines were there: no point, no site, and no other line's end.
///
/// The changes are appended to the file and become valid in one step when they are complete. Until
/// then, and for readers that have the file open, the file is unchanged. `tiletool compact` removes
/// what is no longer used.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool unconstrain survey.tiles --walls old_fences.geojson
  tiletool unconstrain survey.tiles --line 17 --line 20")]
pub struct UnconstrainArgs {
    #[command(flatten)]
    edit: EditArgs,
    #[command(flatten)]
    lines: LineFiles,
    /// Number of a line in the file, which goes with all its segments, and an obstacle with all its
    /// rings; may be repeated
    #[arg(long = "line", value_name = "N", help_heading = "Lines and sites")]
    numbers: Vec<u64>,
    #[command(flatten)]
    missing: MissingArgs,
    #[command(flatten)]
    crs: CrsArgs,
}

/// Removes the lines from the file.
pub fn run(args: UnconstrainArgs) -> anyhow::Result<()> {
    if args.lines.is_empty() && args.numbers.is_empty() {
        anyhow::bail!("no lines are given; add --segments, --walls, --obstacles or --line");
    }
    let lines = args.lines.clone().open()?;
    let (summary, lines) = common::wait_for("editing", unconstrain(&args, lines))?;
    args.edit.report(&summary, lines.notes())
}

async fn unconstrain(args: &UnconstrainArgs, lines: LineInput) -> anyhow::Result<(EditSummary, LineInput)> {
    let file = &args.edit.file;
    let mut transaction = args.edit.open().await?;
    transaction.skip_missing(args.missing.skip_missing);
    transaction.remove_lines(&args.numbers);
    let of_file = transaction.crs().map(|crs| (file.clone(), crs.to_owned()));
    args.crs.agree(of_file.iter().chain(lines.crs_of_files()))?;
    let (transaction, lines) = common::on_thread("lines", move || lines.feed_removal(transaction)).await?;
    let name_in = |error: EditError| line_error(error, |line| lines.name(line));
    let summary = args.edit.finish(transaction, name_in).await?;
    Ok((summary, lines))
}
