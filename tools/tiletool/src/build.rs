//! `tiletool build`: from files of points to a file of tiles.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::available_parallelism;

use bytesize::ByteSize;
use clap::Args;
use delaunay_tiles::build::{BuildError, BuildOptions, BuildSummary, Builder, Description, Duplicates, Phase};
use delaunay_tiles::input::{PointBatch, PointSource, Returns, SegmentBatch, SegmentSource};
use delaunay_tiles::mesh::EngineKind;
use delaunay_tiles::store::Source;
use serde::{Deserialize, Serialize};
use tokio::sync::{Notify, mpsc};

use crate::common;
use crate::input_args::InputArgs;
use crate::progress::Bar;

/// Triangulate points and write a tile file.
///
/// Points come from LAS and LAZ, text (.csv, .xyz, .txt, also .gz), raw little-endian f64 (.f64), Triangle's .node, and
/// GeoJSON; several inputs make one set, and - is standard input. Segments come from GeoJSON (lines, rings of polygons), text
/// (x1,y1,x2,y2), and raw pairs of record numbers (.u32, .u64); they become chains of edges. The file gets its name when
/// it is complete.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool build survey.laz -o ground.tiles --class 2
  tiletool build survey.laz --segments breaklines.geojson -o ground.tiles
  zcat points.csv.gz | tiletool build - -o points.tiles --columns lon,lat,height")]
pub struct BuildArgs {
    /// The inputs, in order
    #[arg(required_unless_present = "segments", value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// Files of segments, which become chains of edges: break lines, coast lines; may be given more than once
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    segments: Vec<PathBuf>,
    /// The tile file to write
    #[arg(short, long, value_name = "FILE.tiles")]
    output: PathBuf,
    /// Memory to use, as 512MiB or 2GB; by default a quarter of what there is
    #[arg(long, value_name = "SIZE")]
    memory: Option<ByteSize>,
    /// The most vertices of a tile
    #[arg(long, value_name = "N", default_value_t = BuildOptions::default().tile_vertices)]
    tile_vertices: usize,
    /// Computing threads; by default one for each processor
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// The in-core engine; all give the same triangles
    #[arg(long, value_name = "native|spade", default_value_t = EngineKind::default())]
    engine: EngineKind,
    /// Which of several points at one place to keep: first, lowest or highest; or error
    #[arg(long, value_name = "RULE", default_value_t = Duplicates::First)]
    duplicates: Duplicates,
    /// The folder to spill work to; by default one beside the output
    #[arg(long, value_name = "DIR")]
    tmp: Option<PathBuf>,
    /// Go on with a build that was interrupted, from the last finished block
    #[arg(long)]
    resume: bool,
    /// Replace the output if it exists
    #[arg(long)]
    force: bool,
    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    input: InputArgs,
}

/// Points that tell a build in advance how all lie.
const SAMPLE: usize = 1 << 16;

/// Batches that wait between the reader and the builder.
const BATCHES_AHEAD: usize = 8;

/// Builds a file.
pub fn run(args: BuildArgs) -> anyhow::Result<()> {
    let mut options = BuildOptions {
        tile_vertices: args.tile_vertices,
        engine: args.engine,
        duplicates: args.duplicates,
        force: args.force,
        work_folder: args.tmp.clone(),
        ..BuildOptions::default()
    };
    options.threads = args
        .threads
        .unwrap_or_else(|| available_parallelism().map_or(1, usize::from));
    if let Some(memory) = args.memory {
        options.memory = memory.as_u64();
    }
    let input_options = args.input.options();
    let is_filtered = !input_options.classes.is_empty() || input_options.returns != Returns::All;
    let source = PointSource::open(&args.inputs, &input_options)?;
    let segments = SegmentSource::open(&args.segments)?;
    options.resume = args.resume;
    options.resumable = source.identity().filter(|_| args.segments.is_empty());
    let progress = Arc::clone(&options.progress);
    let (read, total) = (Arc::new(AtomicU64::new(0)), source.total_bytes());
    let bar = (!args.quiet && !args.json).then(|| {
        let read = Arc::clone(&read);
        Bar::show(
            Arc::clone(&progress),
            Arc::new(move || (read.load(Ordering::Relaxed), total)),
        )
    });
    let output = args.output.clone();
    let cancelled = Arc::new(Notify::new());
    let built = common::block_on(async move {
        let builder = Builder::new(&output, options)?;
        if args.resume && builder.needs_points() && !args.quiet {
            eprintln!("note: there is no finished work to go on from; the build starts from the beginning");
        }
        let building = build(source, segments, builder, read, is_filtered, Arc::clone(&cancelled));
        tokio::pin!(building);
        loop {
            tokio::select! {
                built = &mut building => break built,
                // Whoever asks twice does not want to wait until the work lies in order.
                _ = tokio::signal::ctrl_c() => if progress.is_cancelled() {
                    anyhow::bail!("interrupted");
                } else {
                    progress.cancel();
                    cancelled.notify_one();
                }
            }
        }
    });
    drop(bar);
    let (summary, read) = built.map_err(|error| how_to_go_on(error, &args.output))?;
    for note in read.notes.iter().filter(|_| !args.quiet) {
        eprintln!("note: {note}");
    }
    if args.json {
        common::print_json(&Output::new(&summary, &read))
    } else if args.quiet {
        Ok(())
    } else {
        common::print(&report(&args, &summary, &read))
    }
}

/// Says of a build that was stopped from without what became of its work.
fn how_to_go_on(error: anyhow::Error, output: &Path) -> anyhow::Error {
    let mut folder = output.as_os_str().to_owned();
    folder.push(".partial");
    let folder = Path::new(&folder);
    let what = match error.downcast_ref() {
        Some(BuildError::Locked(_) | BuildError::NotOurs(_) | BuildError::OtherBuild { .. }) => return error,
        Some(BuildError::Cancelled) => "interrupted".to_owned(),
        _ => format!("{error:#}"),
    };
    let shown = folder.display();
    if folder.join("plan").exists() {
        anyhow::anyhow!("{what}; the work so far is kept in {shown}: the same command with --resume goes on with it")
    } else if folder.exists() {
        anyhow::anyhow!("{what}; {shown} is kept, but the input was not all there yet: --resume starts again")
    } else if what == "interrupted" {
        anyhow::anyhow!("{what}; {} was not written", output.display())
    } else {
        error
    }
}

/// What is known of the input once it was read; a build that is resumed has it from the build before.
#[derive(Debug, Default, Deserialize, Serialize)]
struct Read {
    records: u64,
    withheld: u64,
    filtered: u64,
    invalid: u64,
    #[serde(default)]
    segments: u64,
    input_bytes: u64,
    notes: Vec<String>,
}

/// Reads the input on a thread of its own, ahead of the builder.
async fn build(
    mut source: PointSource,
    mut segments: SegmentSource,
    mut builder: Builder,
    read: Arc<AtomicU64>,
    is_filtered: bool,
    cancelled: Arc<Notify>,
) -> anyhow::Result<(BuildSummary, Read)> {
    if !builder.needs_points() {
        let read = serde_json::from_str(&builder.description().memo).unwrap_or_default();
        return Ok((builder.finish().await?, read));
    }
    let (mut builder, segments) = tokio::task::spawn_blocking(move || {
        let mut batch = SegmentBatch::default();
        while segments.next_batch(&mut batch)? {
            builder.push_segments(&batch.ends)?;
            builder.push_segments_between(&batch.records)?;
        }
        anyhow::Ok((builder, segments.segments()))
    })
    .await??;
    let (sender, mut batches) = mpsc::channel::<PointBatch>(BATCHES_AHEAD);
    // A filter may leave few of the points that a file announces.
    if let Some(points) = source.expected_points().filter(|_| !is_filtered) {
        let sample;
        (sample, source) = tokio::task::spawn_blocking(move || (source.sample(SAMPLE), source)).await?;
        builder.expect(points, sample?)?;
    }
    let reading = tokio::task::spawn_blocking(move || {
        let mut batch = PointBatch::default();
        while source.next_batch(&mut batch)? {
            read.store(source.bytes_read(), Ordering::Relaxed);
            if sender.blocking_send(std::mem::take(&mut batch)).is_err() {
                break;
            }
        }
        anyhow::Ok(source)
    });
    loop {
        let batch = tokio::select! {
            batch = batches.recv() => batch,
            // Whoever waits for a pipe must hear of it too; the builder does what is due.
            () = cancelled.notified() => Some(PointBatch::default()),
        };
        let Some(batch) = batch else { break };
        builder.push(&batch).await?;
    }
    let source = reading.await??;
    let has_z = source.has_z();
    let sources = source.sources().iter().map(|(name, records)| Source {
        name: name.clone(),
        records: *records,
    });
    let counts = source.counts();
    let mut read = Read {
        records: counts.records,
        withheld: counts.withheld,
        filtered: counts.filtered,
        invalid: counts.invalid,
        segments,
        input_bytes: counts.bytes_read,
        notes: source.notes().to_vec(),
    };
    builder.describe(Description {
        sources: sources.collect(),
        crs: source.crs().map(str::to_owned),
        memo: serde_json::to_string(&read)?,
    });
    let summary = builder.finish().await?;
    if has_z && summary.ends > 0 {
        let ends = common::thousands(summary.ends);
        read.notes.push(format!(
            "{ends} ends of segments lie where no point does, and got z = 0"
        ));
    }
    Ok((summary, read))
}

/// The keys of `--json`, which are stable.
#[derive(Serialize)]
struct Output<'a> {
    records: u64,
    points: u64,
    withheld: u64,
    filtered: u64,
    invalid: u64,
    duplicates: u64,
    segments: u64,
    ends: u64,
    vertices: u64,
    triangles: u64,
    border_triangles: u64,
    hull_edges: u64,
    constraint_edges: u64,
    held_triangles: u64,
    tiles: u64,
    input_bytes: u64,
    file_bytes: u64,
    bytes_per_vertex: f64,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
    phases: Vec<PhaseOutput>,
    levels: Vec<LevelOutput>,
    blocks: u64,
    resumed_blocks: u64,
    waits: WaitsOutput,
    notes: &'a [String],
}

#[derive(Serialize)]
struct PhaseOutput {
    name: &'static str,
    seconds: f64,
    bytes_read: u64,
    bytes_written: u64,
}

/// Seconds, summed over the threads that waited.
#[derive(Serialize)]
struct WaitsOutput {
    computing_for_blocks: f64,
    computing_for_writing: f64,
    blocks_for_computing: f64,
}

#[derive(Serialize)]
struct LevelOutput {
    level: usize,
    nodes: u64,
    vertices: u64,
    settled_triangles: u64,
    seam_vertices: u64,
    seam_share: f64,
}

impl<'a> Output<'a> {
    fn new(summary: &BuildSummary, read: &'a Read) -> Self {
        let phases = summary.phases.iter().map(|phase| PhaseOutput {
            name: phase.phase.name(),
            seconds: phase.time.as_secs_f64(),
            bytes_read: phase.bytes_read
                + if phase.phase == Phase::Read && summary.resumed_blocks == 0 {
                    read.input_bytes
                } else {
                    0
                },
            bytes_written: phase.bytes_written,
        });
        let levels = summary.levels.iter().zip(0..).map(|(level, number)| LevelOutput {
            level: number,
            nodes: level.nodes,
            vertices: level.vertices,
            settled_triangles: level.settled,
            seam_vertices: level.seam_vertices,
            seam_share: share(level.seam_vertices, summary.vertices),
        });
        Self {
            records: read.records,
            points: summary.points,
            withheld: read.withheld,
            filtered: read.filtered,
            invalid: read.invalid,
            duplicates: summary.duplicates,
            segments: read.segments,
            ends: summary.ends,
            vertices: summary.vertices,
            triangles: summary.triangles,
            border_triangles: summary.border_triangles,
            hull_edges: summary.hull_edges,
            constraint_edges: summary.constraint_edges,
            held_triangles: summary.held_triangles,
            tiles: summary.tiles,
            input_bytes: read.input_bytes,
            file_bytes: summary.file_bytes,
            bytes_per_vertex: share(summary.file_bytes, summary.vertices),
            seconds: seconds(summary),
            peak_memory_bytes: summary.peak_memory,
            phases: phases.collect(),
            levels: levels.collect(),
            blocks: summary.blocks,
            resumed_blocks: summary.resumed_blocks,
            waits: WaitsOutput {
                computing_for_blocks: summary.waits.computing_for_blocks.as_secs_f64(),
                computing_for_writing: summary.waits.computing_for_writing.as_secs_f64(),
                blocks_for_computing: summary.waits.blocks_for_computing.as_secs_f64(),
            },
            notes: &read.notes,
        }
    }
}

fn seconds(summary: &BuildSummary) -> f64 {
    summary.phases.iter().map(|phase| phase.time.as_secs_f64()).sum()
}

/// A quotient that is 0 where there is nothing to divide by.
fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}

fn report(args: &BuildArgs, summary: &BuildSummary, read: &Read) -> String {
    let thousands = common::thousands;
    let mut text = format!(
        "{}: {} vertices, {} triangles, {} hull edges in {} tiles\n",
        args.output.display(),
        thousands(summary.vertices),
        thousands(summary.triangles),
        thousands(summary.hull_edges),
        thousands(summary.tiles)
    );
    let mut left_out = format!("{} points", thousands(summary.points));
    for (count, what) in [
        (summary.duplicates, "merged with others at the same place"),
        (read.withheld, "withheld"),
        (read.filtered, "not of the classes or returns asked for"),
        (read.invalid, "invalid"),
    ] {
        if count > 0 {
            left_out += &format!(", {} {what}", thousands(count));
        }
    }
    text += &format!("  input   {left_out}; {}\n", common::bytes(read.input_bytes));
    if read.segments > 0 {
        text += &format!(
            "  lines   {} segments, {} constraint edges, {} vertices at their ends; {:.2} % of the triangles held\n",
            thousands(read.segments),
            thousands(summary.constraint_edges),
            thousands(summary.ends),
            100.0 * share(summary.held_triangles, summary.triangles)
        );
    }
    text += &format!(
        "  output  {}, {:.1} bytes per vertex\n",
        common::bytes(summary.file_bytes),
        share(summary.file_bytes, summary.vertices)
    );
    let phases = summary
        .phases
        .iter()
        .map(|p| format!("{} {:.2} s", p.phase.name(), p.time.as_secs_f64()));
    text += &format!(
        "  time    {:.2} s: {}\n",
        seconds(summary),
        phases.collect::<Vec<_>>().join(", ")
    );
    let levels = summary
        .levels
        .iter()
        .filter(|level| level.seam_vertices > 0)
        .map(|level| format!("{:.2} %", 100.0 * share(level.seam_vertices, summary.vertices)));
    let levels: Vec<_> = levels.collect();
    if !levels.is_empty() {
        text += &format!("  seams   {} of the vertices, from the leaves up\n", levels.join(", "));
    }
    if let Some(peak) = summary.peak_memory {
        text += &format!("  memory  {} at the peak\n", common::bytes(peak));
    }
    text
}
