//! `tiletool constrain`: adds lines to an existing tile file as constraints.

use clap::Args;
use delaunay_tiles::EditSummary;

use crate::common;
use crate::crs::CrsArgs;
use crate::edit::{EditArgs, line_error};
use crate::lines::{LineFiles, LineInput, MissingZArgs};

/// Add lines to a tile file as constraints
///
/// The resulting triangles are those of a build with the lines from the start. The ends of the
/// lines become vertices, which may lie outside the convex hull. No line may cross another line or
/// a constraint.
///
/// The changes are appended to the file and become valid in one step when they are complete. Until
/// then, and for readers that have the file open, the file is unchanged. Replaced tiles stay in the
/// file as unused bytes until `tiletool compact` rewrites it. Overviews of the file become stale
/// until `tiletool overviews` renews them.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:
  tiletool constrain survey.tiles --segments breaklines.geojson --walls fences.geojson")]
pub struct ConstrainArgs {
    #[command(flatten)]
    edit: EditArgs,
    #[command(flatten)]
    lines: LineFiles,
    #[command(flatten)]
    missing_z: MissingZArgs,
    #[command(flatten)]
    crs: CrsArgs,
}

/// Adds the lines to the file.
pub fn run(args: ConstrainArgs) -> anyhow::Result<()> {
    if args.lines.is_empty() {
        anyhow::bail!("no lines are given; add --segments, --walls or --obstacles");
    }
    let lines = args.lines.clone().open()?;
    let (summary, lines) = common::wait_for("editing", constrain(&args, lines))?;
    args.edit.report(&summary, lines.notes())
}

async fn constrain(args: &ConstrainArgs, lines: LineInput) -> anyhow::Result<(EditSummary, LineInput)> {
    let file = &args.edit.file;
    let mut transaction = args.edit.open().await?;
    transaction.missing_z(args.missing_z.option());
    let of_file = transaction.crs().map(|crs| (file.clone(), crs.to_owned()));
    args.crs.agree(of_file.iter().chain(lines.crs_of_files()))?;
    let first_line = transaction.first_line();
    let (transaction, lines) = common::on_thread("lines", move || lines.feed_transaction(transaction)).await?;
    if lines.segments() == 0 {
        anyhow::bail!(
            "there are no lines in these files; {} was not changed",
            common::shown(file)
        );
    }
    let name = |number: u64| match number.checked_sub(first_line) {
        Some(line) => lines.name(line),
        None => format!("line {number} of {}", common::shown(file)),
    };
    let summary = args.edit.finish(transaction, |error| line_error(error, name)).await?;
    Ok((summary, lines))
}
