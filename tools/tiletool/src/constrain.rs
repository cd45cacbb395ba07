//! `tiletool constrain`: makes lines constraints of a tile file that is there already.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use delaunay_tiles::{EditError, EditSummary, Editor, peak_memory};
use serde::Serialize;

use crate::allocator;
use crate::common::{self, MemoryArgs};
use crate::lines::{LineFiles, Lines, MissingZArgs};

/// Make lines constraints of a tile file that is there already.
///
/// The ends of the lines become vertices, which must lie within the hull; no line may cross another or a constraint. What changes is
/// written behind the end of the file, and comes into force at once when all is there; until then, and for those who have the
/// file open, it is as it was. The triangles are those of a build with the lines from the start. What is replaced stays in the file as
/// unused bytes until `tiletool compact` writes it anew.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:
  tiletool constrain survey.tiles --segments breaklines.geojson --walls fences.geojson")]
pub struct ConstrainArgs {
    /// The tile file to change
    #[arg(value_name = "FILE.tiles")]
    file: PathBuf,
    #[command(flatten)]
    lines: LineFiles,
    #[command(flatten)]
    missing_z: MissingZArgs,
    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    memory: MemoryArgs,
}

/// The keys of `--json`, which are stable.
#[derive(Serialize)]
struct Output {
    segments: u64,
    vertices: u64,
    edges: u64,
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

/// Changes a file.
pub fn run(args: ConstrainArgs) -> anyhow::Result<()> {
    if args.lines.is_empty() {
        anyhow::bail!("there are no lines; give --segments, --walls or --obstacles");
    }
    let lines = args.lines.clone().open()?;
    let (summary, lines) = common::block_on(constrain(&args, lines))?;
    for note in lines.notes().iter().filter(|_| !args.quiet) {
        common::say(format_args!("note: {note}"));
    }
    if args.json {
        common::print_json(&Output {
            segments: summary.segments,
            vertices: summary.vertices,
            edges: summary.edges,
            constraint_edges: summary.constraint_edges,
            tiles_written: summary.tiles,
            tile_reads: summary.tile_reads,
            regions: summary.regions,
            hole_regions: summary.hole_regions,
            hole_triangles: summary.hole_triangles,
            bytes_appended: summary.bytes_appended,
            file_bytes: summary.file_bytes,
            seconds: summary.seconds,
            peak_memory_bytes: peak_memory(),
            notes: lines.notes(),
        })
    } else if args.quiet {
        Ok(())
    } else {
        common::print(&report(&args.file, &summary))
    }
}

async fn constrain(args: &ConstrainArgs, lines: Lines) -> anyhow::Result<(EditSummary, Lines)> {
    let file = &args.file;
    // Lists of tiles grow bit by bit, and would leave holes of their size behind: as much of them as can be is to be mapped.
    allocator::keep_to(0);
    let mut editor = Editor::open(file, args.memory.bytes()).await?;
    editor.missing_z(args.missing_z.option());
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
        _ = tokio::signal::ctrl_c() => Err(EditError::Cancelled),
    };
    match edited {
        Ok(summary) => Ok((summary, lines)),
        Err(EditError::Cancelled) => anyhow::bail!("interrupted; {} is as it was", common::shown(file)),
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

fn report(file: &Path, summary: &EditSummary) -> String {
    let thousands = common::thousands;
    format!(
        "{}: {} segments became {} edges, and their ends {} new vertices; {} constraint edges in all\n\
         regions    {}, of them {} holes with {} triangles\n\
         written    {} tiles anew, {} more; the file has {}\n\
         took       {:.2} s\n",
        common::shown(file),
        thousands(summary.segments),
        thousands(summary.edges),
        thousands(summary.vertices),
        thousands(summary.constraint_edges),
        thousands(summary.regions),
        thousands(summary.hole_regions),
        thousands(summary.hole_triangles),
        thousands(summary.tiles),
        common::bytes(summary.bytes_appended),
        common::bytes(summary.file_bytes),
        summary.seconds,
    )
}
