//! `tiletool build`: from files of points and lines to a file of tiles.

mod report;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::available_parallelism;

use bytesize::ByteSize;
use clap::Args;
use delaunay_tiles::input::{InputError, PointBatch, PointSource, Reading, Returns};
use delaunay_tiles::io::output_target;
use delaunay_tiles::mesh::EngineKind;
use delaunay_tiles::store::Source;
use delaunay_tiles::{BuildError, BuildOptions, BuildSummary, Builder, Description, Duplicates, Progress};
use tokio::sync::{Notify, mpsc};

use crate::allocator;
use crate::common;
use crate::input_args::InputArgs;
use crate::lines::{LineArgs, LineRules, Lines, MissingZArgs};
use crate::progress::Bar;
use crate::unchanged::Unchanged;
use report::{Output, Read, report};

/// Triangulate points and write a tile file.
///
/// Points come from LAS and LAZ, text (.csv, .xyz, .txt, also .gz), raw little-endian f64 (.f64), Triangle's .node and .poly,
/// and GeoJSON; several inputs make one set, and - is standard input. Lines come from GeoJSON, text (x1,y1,x2,y2), and raw
/// pairs of record numbers (.u32, .u64); they become chains of edges, and must not cross. The segments of a .poly are walls,
/// and its hole points make holes. The file gets its name when it is complete.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool build survey.laz -o ground.tiles --class 2
  tiletool build survey.laz --segments breaklines.geojson -o ground.tiles
  tiletool build --obstacles houses.geojson --walls fences.geojson --sites shops.csv -o town.tiles
  zcat points.csv.gz | tiletool build - -o points.tiles --columns lon,lat,height")]
pub struct BuildArgs {
    /// The inputs, in order
    #[arg(required_unless_present_any = ["segments", "walls", "obstacles", "sites"], value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    lines: LineArgs,
    #[command(flatten)]
    rules: LineRules,
    #[command(flatten)]
    missing_z: MissingZArgs,
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
    /// Go on with a build that was interrupted, from the last finished block; not with lines or sites
    #[arg(long, conflicts_with_all = ["segments", "walls", "obstacles", "sites"])]
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
    let mut options = args.options();
    allocator::keep_to(options.memory);
    let input_options = args.input.options().missing_z(options.missing_z);
    let is_filtered = !args.input.classes.is_empty() || args.input.returns != Returns::All;
    let source = PointSource::open(&args.inputs, &input_options)?;
    let lines = args.lines.open(&args.inputs)?;
    // A .poly file is read for its points and for its segments.
    Unchanged::default().check(source.stamps().iter().chain(lines.stamps()))?;
    let has_lines = !args.lines.is_empty(&args.inputs) || options.exterior_is_hole;
    options.resumable = source.identity().filter(|_| !has_lines);
    if args.resume && has_lines {
        anyhow::bail!(
            "a build with the lines of a .poly file, or with --exterior hole, cannot be resumed; leave out --resume"
        );
    }
    let can_resume = options.resumable.is_some();
    let progress = Arc::clone(&options.progress);
    let readings: Arc<[Reading]> = lines.readings().chain([source.reading()]).cloned().collect();
    let bar = args.bar(&source, &lines, &progress, &readings);
    let output = args.output.clone();
    let cancelled = Arc::new(Notify::new());
    let built = common::block_on(async move {
        let builder = Builder::new(&output, options)?;
        if args.resume && builder.needs_points() && !args.quiet {
            common::say("note: there is no finished work to go on from; the build starts from the beginning");
        }
        let building = build(source, lines, builder, is_filtered, Arc::clone(&cancelled));
        until_interrupted(building, &progress, || {
            readings.iter().for_each(Reading::stop);
            cancelled.notify_one();
        })
        .await
    });
    drop(bar);
    let (summary, read) = built.map_err(|error| how_to_go_on(error, &args.output, can_resume))?;
    for note in read.notes.iter().filter(|_| !args.quiet) {
        common::say(format_args!("note: {note}"));
    }
    if args.json {
        common::print_json(&Output {
            summary: &summary,
            read: &read,
        })
    } else if args.quiet {
        Ok(())
    } else {
        common::print(&report(&args.output, &summary, &read))
    }
}

impl BuildArgs {
    /// The library's options.
    fn options(&self) -> BuildOptions {
        let mut options = BuildOptions::default()
            .tile_vertices(self.tile_vertices)
            .engine(self.engine)
            .duplicates(self.duplicates)
            .force(self.force)
            .work_folder(self.tmp.clone());
        options.threads = self
            .threads
            .unwrap_or_else(|| available_parallelism().map_or(1, usize::from));
        if let Some(memory) = self.memory {
            options.memory = memory.as_u64();
        }
        options.missing_z = self.missing_z.option();
        options.resume = self.resume;
        options.exterior_is_hole = self.rules.exterior_is_hole;
        options.crossings = self.rules.crossings;
        options.steiner = self.rules.steiner;
        options
    }

    /// The bar that shows how far the build is, unless nobody wants to see it.
    fn bar(
        &self,
        source: &PointSource,
        lines: &Lines,
        progress: &Arc<Progress>,
        readings: &Arc<[Reading]>,
    ) -> Option<Bar> {
        let of_lines: u64 = lines.stamps().map(|(_, stamp)| stamp.length).sum();
        let total = source.total_bytes().map(|of_points| of_points + of_lines);
        (!self.quiet && !self.json).then(|| {
            let readings = Arc::clone(readings);
            let read = move || readings.iter().map(Reading::bytes).sum();
            Bar::show(Arc::clone(progress), Arc::new(move || (read(), total)))
        })
    }
}

/// Waits for a build, which Ctrl-C cancels and `stop` then wakes up.
async fn until_interrupted<T>(
    building: impl Future<Output = anyhow::Result<T>>,
    progress: &Progress,
    stop: impl Fn(),
) -> anyhow::Result<T> {
    tokio::pin!(building);
    loop {
        tokio::select! {
            built = &mut building => break built,
            // Whoever asks twice does not want to wait until the work lies in order.
            _ = tokio::signal::ctrl_c() => if progress.is_cancelled() {
                anyhow::bail!("interrupted");
            } else {
                progress.cancel();
                stop();
            }
        }
    }
}

/// Says of a build that was stopped from without what became of its work.
fn how_to_go_on(error: anyhow::Error, output: &Path, can_resume: bool) -> anyhow::Error {
    let target = output_target(output);
    let mut folder = target.as_deref().unwrap_or(output).as_os_str().to_owned();
    folder.push(".partial");
    let folder = Path::new(&folder);
    let what = match error.downcast_ref() {
        Some(BuildError::Locked(_) | BuildError::NotOurs(_) | BuildError::OtherBuild { .. }) => return error,
        Some(BuildError::Cancelled) => "interrupted".to_owned(),
        _ if is_stopped(&error) => "interrupted".to_owned(),
        _ => format!("{error:#}"),
    };
    let shown = common::shown(folder);
    if !can_resume {
        // What is there is about to go away, or was there before.
        match what == "interrupted" {
            true => anyhow::anyhow!(
                "{what}; {} was not written, and its work is not kept",
                common::shown(output)
            ),
            false => error,
        }
    } else if folder.join("plan").exists() {
        anyhow::anyhow!("{what}; the work so far is kept in {shown}: the same command with --resume goes on with it")
    } else if folder.exists() {
        anyhow::anyhow!("{what}; {shown} is kept, but the input was not all there yet: --resume starts again")
    } else if what == "interrupted" {
        anyhow::anyhow!("{what}; {} was not written", common::shown(output))
    } else {
        error
    }
}

/// Whether reading was stopped.
fn is_stopped(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(InputError::Stopped))
}

/// Reads the input on a thread of its own, ahead of the builder.
async fn build(
    source: PointSource,
    lines: Lines,
    builder: Builder,
    is_filtered: bool,
    cancelled: Arc<Notify>,
) -> anyhow::Result<(BuildSummary, Read)> {
    if !builder.needs_points() {
        let read = serde_json::from_str(&builder.description().memo).unwrap_or_default();
        return Ok((builder.finish().await?, read));
    }
    let (builder, lines) = common::on_thread("lines", move || lines.feed(builder)).await?;
    let built = build_points(source, builder, &lines, is_filtered, cancelled).await;
    built.map_err(|error| lines.name_in(error))
}

/// Builds from the points, once the lines are there.
async fn build_points(
    source: PointSource,
    mut builder: Builder,
    lines: &Lines,
    is_filtered: bool,
    cancelled: Arc<Notify>,
) -> anyhow::Result<(BuildSummary, Read)> {
    let source = push_points(source, &mut builder, is_filtered, &cancelled).await?;
    let mut read = Read::new(&source, lines);
    let sources = source.sources().iter().map(|(name, records)| Source {
        name: name.clone(),
        records: *records,
    });
    builder.describe(Description {
        sources: sources.collect(),
        lines: lines.sources(),
        crs: source.crs().map(str::to_owned),
        memo: serde_json::to_string(&read)?,
    });
    let summary = builder.finish().await?;
    if let Some(first) = summary.first_inverted {
        read.notes.push(lines.inverted_note(summary.inverted_regions, first));
    }
    if summary.without_z > 0 {
        let vertices = common::thousands(summary.without_z);
        read.notes.push(format!("{vertices} vertices have no z, and got z = 0"));
    }
    Ok((summary, read))
}

/// Reads all points and gives them to the builder.
async fn push_points(
    mut source: PointSource,
    builder: &mut Builder,
    is_filtered: bool,
    cancelled: &Notify,
) -> anyhow::Result<PointSource> {
    let (sender, mut batches) = mpsc::channel::<PointBatch>(BATCHES_AHEAD);
    // A filter may leave few of the points that a file announces.
    if let Some(points) = source.expected_points().filter(|_| !is_filtered) {
        let sample;
        (sample, source) = common::on_thread("sample", move || Ok((source.sample(SAMPLE)?, source))).await?;
        builder.expect(points, sample)?;
    }
    let reading = common::begin("reading", move || {
        let mut batch = PointBatch::default();
        while source.next_batch(&mut batch)? {
            if sender.blocking_send(std::mem::take(&mut batch)).is_err() {
                break;
            }
        }
        Ok(source)
    })?;
    loop {
        let batch = tokio::select! {
            batch = batches.recv() => batch,
            // Whoever waits for a pipe must hear of it too; the builder does what is due.
            () = cancelled.notified() => Some(PointBatch::default()),
        };
        let Some(batch) = batch else { break };
        builder.push(&batch).await?;
    }
    match reading.await {
        // The builder knows what becomes of its work.
        Err(error) if is_stopped(&error) => {
            let pushed = builder.push(&PointBatch::default()).await;
            Err(pushed.err().map_or(error, Into::into))
        }
        source => source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The message looked at the work folder alone, which a build with lines leaves for a moment, or an earlier build for ever.
    #[test]
    fn a_build_that_cannot_be_resumed_never_speaks_of_resuming() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("out.tiles");
        let work = folder.path().join("out.tiles.partial");
        std::fs::create_dir(&work).unwrap();
        for has_plan in [false, true] {
            if has_plan {
                std::fs::write(work.join("plan"), "").unwrap();
            }
            for error in [BuildError::Cancelled, BuildError::PointsComplete] {
                let said = |can_resume| {
                    let error = match error {
                        BuildError::Cancelled => BuildError::Cancelled,
                        _ => BuildError::PointsComplete,
                    };
                    how_to_go_on(error.into(), &output, can_resume).to_string()
                };
                assert!(!said(false).contains("--resume"), "{}", said(false));
                assert!(said(true).contains("--resume"), "{}", said(true));
            }
        }
    }
}
