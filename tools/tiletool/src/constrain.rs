//! `tiletool constrain`: adds lines to an existing tile file as constraints.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use delaunay_tiles::{EditError, EditSummary, Editor, OpenOptions, peak_memory};
use serde::Serialize;

use crate::allocator;
use crate::common::{self, MemoryArgs, counted};
use crate::crs::CrsArgs;
use crate::lines::{LineFiles, LineInput, MissingZArgs};

/// Add lines to a tile file as constraints
///
/// The resulting triangles are those of a build with the lines from the start. The ends of the
/// lines become vertices, which must lie within the convex hull. No line may cross another line or
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
    /// Tile file to change
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    lines: LineFiles,
    #[command(flatten)]
    missing_z: MissingZArgs,
    #[command(flatten)]
    crs: CrsArgs,
    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
    /// Print only errors
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    memory: MemoryArgs,
}

/// The output of `--json`. Its keys are stable.
#[derive(Serialize)]
struct ConstrainReport {
    segments: u64,
    added_vertices: u64,
    inserted_edges: u64,
    constraint_edges: u64,
    tiles_written: u64,
    tile_reads: u64,
    regions: u64,
    hole_regions: u64,
    hole_triangles: u64,
    bytes_appended: u64,
    file_bytes: u64,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
    notes: Vec<String>,
}

/// Adds the lines to the file.
pub fn run(args: ConstrainArgs) -> anyhow::Result<()> {
    if args.lines.is_empty() {
        anyhow::bail!("no lines are given; add --segments, --walls or --obstacles");
    }
    let lines = args.lines.clone().open()?;
    let (summary, lines) = common::block_on(constrain(&args, lines))?;
    let mut notes = lines.notes();
    // The lines are in the file, whether this can be found out or not.
    if common::block_on(has_stale_overviews(&args.file)).unwrap_or(false) {
        let file = common::shown(&args.file);
        notes.push(format!(
            "the overviews of the file are stale now; renew them with `tiletool overviews {file}`"
        ));
    }
    for note in notes.iter().filter(|_| !args.quiet) {
        common::say(format_args!("note: {note}"));
    }
    if args.json {
        common::print_json(
            "the summary",
            &ConstrainReport {
                segments: summary.segments,
                added_vertices: summary.added_vertices,
                inserted_edges: summary.inserted_edges,
                constraint_edges: summary.constraint_edges,
                tiles_written: summary.tiles_written,
                tile_reads: summary.tile_reads,
                regions: summary.regions,
                hole_regions: summary.hole_regions,
                hole_triangles: summary.hole_triangles,
                bytes_appended: summary.bytes_appended,
                file_bytes: summary.file_bytes,
                seconds: summary.seconds,
                peak_memory_bytes: peak_memory(),
                notes,
            },
        )
    } else if args.quiet {
        Ok(())
    } else {
        common::print("the summary", &report(&args.file, &summary))
    }
}

async fn constrain(args: &ConstrainArgs, lines: LineInput) -> anyhow::Result<(EditSummary, LineInput)> {
    let file = &args.file;
    // Lists of tiles grow in small steps and would leave free gaps of their sizes in the heap. So
    // as many allocations as possible are mappings of their own.
    allocator::keep_to(0);
    let mut editor = Editor::open(file, args.memory.bytes()).await?;
    editor.missing_z(args.missing_z.option());
    let of_file = editor.crs().map(|crs| (file.clone(), crs.to_owned()));
    args.crs.agree(of_file.iter().chain(lines.crs_of_files()))?;
    let first_line = editor.first_line();
    let (editor, lines) = common::on_thread("lines", move || lines.feed_editor(editor)).await?;
    if lines.segments() == 0 {
        anyhow::bail!(
            "there are no lines in these files; {} was not changed",
            common::shown(file)
        );
    }
    let edited = tokio::select! {
        edited = editor.finish() => edited,
        () = common::interrupted() => Err(EditError::Cancelled),
    };
    match edited {
        Ok(summary) => Ok((summary, lines)),
        Err(EditError::Cancelled) => anyhow::bail!("interrupted; {} was not changed", common::shown(file)),
        Err(error) => {
            let name = |number: u64| match number.checked_sub(first_line) {
                Some(line) => lines.name(line),
                None => format!("line {number} of {}", common::shown(file)),
            };
            let named = match &error {
                EditError::Outside { line, .. } | EditError::OpenRing { line } | EditError::NoZ { line, .. } => {
                    Some(name(*line))
                }
                EditError::Inverted(inverted) => Some(name(inverted.first.obstacle)),
                EditError::Overlapping(overlapping) => Some(name(overlapping.obstacle)),
                EditError::Crossed { line, other, .. } => {
                    let other = other.map(|other| format!(" and {}", name(other.number())));
                    Some(name(line.number()) + &other.unwrap_or_default())
                }
                _ => None,
            };
            let error = anyhow::Error::new(error);
            Err(named.map_or_else(
                || anyhow::anyhow!("{error:#}"),
                |named| anyhow::anyhow!("{named}: {error:#}"),
            ))
        }
    }
    .with_context(|| format!("{} was not changed", common::shown(file)))
}

async fn has_stale_overviews(file: &Path) -> anyhow::Result<bool> {
    let reader = common::open(file, OpenOptions::default()).await?;
    Ok(!reader.stale_overviews().is_empty())
}

fn report(file: &Path, summary: &EditSummary) -> String {
    format!(
        "{}: inserted {} as {}, with {}; the file has {}\n\
         regions    {}; {} with {}\n\
         written    {}, {} appended; the file has {}\n\
         time       {:.2} s\n",
        common::shown(file),
        counted(summary.segments, "segment", "segments"),
        counted(summary.inserted_edges, "edge", "edges"),
        counted(summary.added_vertices, "added vertex", "added vertices"),
        counted(summary.constraint_edges, "constraint edge", "constraint edges"),
        counted(summary.regions, "region", "regions"),
        counted(summary.hole_regions, "hole", "holes"),
        counted(summary.hole_triangles, "triangle", "triangles"),
        counted(summary.tiles_written, "tile", "tiles"),
        common::bytes(summary.bytes_appended),
        common::bytes(summary.file_bytes),
        summary.seconds,
    )
}
