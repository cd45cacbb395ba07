//! `tiletool build`: builds a tile file from files of points and lines.

mod feed;
mod report;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::available_parallelism;

use bytesize::ByteSize;
use clap::builder::{PathBufValueParser, TypedValueParser};
use clap::{Args, ValueEnum};
use delaunay_tiles::input::{PointSource, Reading};
use delaunay_tiles::io::output_target;
use delaunay_tiles::mesh::EngineKind;
use delaunay_tiles::overviews::OverviewOptions;
use delaunay_tiles::store::{OpenOptions, TileEntry};
use delaunay_tiles::{
    BlockTasks, BuildError, BuildOptions, BuildSummary, Builder, Duplicates, Planned, Progress, TaskStore,
};
use tokio::sync::Notify;

use crate::allocator;
use crate::common;
use crate::crs::CrsArgs;
use crate::input_args::InputArgs;
use crate::lines::{LineArgs, LineInput, LineRules, MissingZArgs};
use crate::overviews::MadeOverviews;
use crate::plot::{self, PlotFile, Plotted, TitleArgs};
use crate::points::is_stopped;
use crate::progress::Bar;
use crate::task::reading::{self, PointArgs};
use crate::task::{InputList, TaskList};
use crate::unchanged::Unchanged;
use feed::Inputs;
use report::{BuildReport, InputCounts, report};

/// Build a tile file from points and lines
///
/// Points come from LAS and LAZ, text (.csv, .xyz, .txt, also .gz), raw little-endian f64 (.f64),
/// Triangle's .node and .poly, PLY, OBJ, GeoJSON, FlatGeobuf (.fgb), shapefiles (.shp), Parquet and
/// GeoPackage (.gpkg, or FILE.gpkg:LAYER where there are several layers). Several inputs are joined
/// to one set of points.
///
/// Lines come from GeoJSON, FlatGeobuf, shapefiles, GeoPackage, text (x1,y1,x2,y2), and raw pairs of
/// record numbers (.u32, .u64). They become chains of edges, and must not cross unless --crossings
/// split is given. The segments of a .poly file are walls, and its hole points make holes.
/// --keep-edges makes break lines of the edges of an existing triangulation.
///
/// The file appears under its name when it is complete.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool build survey.laz -o ground.tiles --class 2
  tiletool build survey.laz -o survey.tiles --overviews
  tiletool build survey.laz --segments breaklines.shp -o ground.tiles
  tiletool build survey.laz --segments survey.gpkg:ridges -o ground.tiles
  tiletool build --obstacles houses.geojson --walls fences.geojson --sites shops.csv -o town.tiles
  tiletool build --obstacles islands.geojson -o islands.tiles --plot islands.png
  zcat points.csv.gz | tiletool build - -o points.tiles --columns lon,lat,height")]
pub struct BuildArgs {
    /// Files of points, in the order of their records; - is standard input
    #[arg(required_unless_present_any = ["segments", "walls", "obstacles", "sites"], value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    lines: LineArgs,
    #[command(flatten)]
    rules: LineRules,
    #[command(flatten)]
    missing_z: MissingZArgs,
    /// Tile file to write
    ///
    /// A name that ends with .parts makes a file in parts, in the folder FILE.d beside it: tiles that
    /// `tiletool task` made are not copied. An address s3://BUCKET/NAME.parts puts the parts into an object
    /// store, and so does `tiletool task`; the build works in --tmp, or else in the current folder.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Memory limit, such as 512MiB or 2GB [default: a quarter of the available memory]
    ///
    /// The available memory is the smallest of the machine's memory, the limit of the cgroup and
    /// the limits of the process.
    #[arg(long, value_name = "BYTES")]
    memory: Option<ByteSize>,
    /// Maximum number of vertices per tile
    #[arg(long, value_name = "COUNT", default_value_t = BuildOptions::default().tile_vertices)]
    tile_vertices: usize,
    /// Number of threads that compute, and that decode LAZ and text [default: one per processor]
    #[arg(long, value_name = "COUNT")]
    threads: Option<usize>,
    /// In-core triangulation engine; all engines give the same triangles
    #[arg(long, value_name = "native|spade", default_value_t = EngineKind::default())]
    engine: EngineKind,
    /// Which of several points at one position to keep: first, lowest or highest; 'error' rejects
    /// them
    #[arg(long, value_name = "first|lowest|highest|error", default_value_t = Duplicates::First)]
    duplicates: Duplicates,
    /// Folder for spilled data [default: a folder beside the output]
    #[arg(long, value_name = "DIR")]
    tmp: Option<PathBuf>,
    /// Resume an interrupted build from its last finished block
    #[arg(long)]
    resume: bool,
    /// Read the inputs and plan blocks of points, which `tiletool task` then triangulates, on any machines
    /// that share the folder of the output; --resume completes the file
    ///
    /// --memory determines the size of blocks, and each task needs as much. Points that fit into it make
    /// no blocks: the file is built at once. With --tasks=inputs, `tiletool task` reads the inputs, too: files
    /// that say how many records they have, such as LAZ, LAS and raw numbers. --tasks --resume plans the
    /// blocks then.
    #[arg(
        long,
        value_name = "blocks|inputs",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "blocks",
        hide_possible_values = true,
        conflicts_with_all = ["overviews", "plot"]
    )]
    tasks: Option<TaskStage>,
    /// Compress the tiles; the file takes half to a quarter of the space, and tiles take longer to
    /// load
    #[arg(long)]
    compress: bool,
    /// Make overviews when the file is complete, as `tiletool overviews` does
    ///
    /// The file has its name by then. If this is interrupted, it is a file without overviews.
    #[arg(long)]
    overviews: bool,
    /// Replace the output if it exists, and discard the work of an interrupted build
    #[arg(long)]
    force: bool,
    /// Draw a map of the finished triangulation, as .svg or .png
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(PlotFile::new))]
    plot: Option<PlotFile>,
    #[command(flatten)]
    title: TitleArgs,
    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    crs: CrsArgs,
}

/// What a build leaves to tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TaskStage {
    Blocks,
    Inputs,
}

/// Builds a tile file.
pub fn run(args: BuildArgs) -> anyhow::Result<()> {
    let (mut options, output) = args.options()?;
    let memory = options.memory;
    allocator::keep_to(memory);
    let input_options = args
        .input
        .options()
        .missing_z(options.missing_z)
        .threads(options.threads);
    args.plot.as_ref().map_or(Ok(()), PlotFile::check)?;
    let source = PointSource::open(&args.inputs, &input_options)?;
    let lines = args.lines.open(&args.inputs)?;
    args.crs
        .agree(source.crs_of_files().iter().chain(lines.crs_of_files()))?;
    // A .poly file is read twice: for its points and for its segments.
    Unchanged::default().check(source.stamps().iter().chain(lines.stamps()))?;
    let of_lines = args.lines.identity(&lines);
    options.resumable = source.identity().zip(of_lines).map(|(points, lines)| points + &lines);
    let can_resume = options.resumable.is_some();
    let progress = Arc::clone(&options.progress);
    let readings: Arc<[Reading]> = lines.readings().chain([source.reading()]).cloned().collect();
    let bar = args.bar(&source, &lines, &progress, &readings);
    let cancelled = Arc::new(Notify::new());
    let inputs = Inputs {
        source,
        lines,
        is_filtered: input_options.is_filtered(),
        crs: args.crs.clone(),
    };
    if args.left_inputs(&inputs.source, &output, &options)? {
        return Ok(());
    }
    let built = common::block_on(async {
        let has_work = has_work(&work_folder(&output));
        let builder = Builder::new(&output, options)?;
        if has_work && !args.resume {
            common::note("the work of an interrupted build is discarded (--force without --resume)");
        }
        if args.resume && builder.needs_points() && builder.input_tasks().is_none() {
            common::note("there is no finished work to resume; the build starts from the beginning");
        }
        let building = inputs.build(builder, args.tasks.is_some(), Arc::clone(&cancelled));
        common::until_interrupted(building, &progress, || {
            readings.iter().for_each(Reading::stop);
            cancelled.notify_one();
        })
        .await
    });
    drop(bar);
    let (planned, read) = built.map_err(|error| how_to_resume(error, &output, can_resume))?;
    read.notes.iter().for_each(common::note);
    match planned {
        Planned::Tasks(tasks) => args.print_tasks(&tasks),
        Planned::Built(summary) => {
            if args.tasks.is_some() {
                common::note("all points fit into memory, so there are no tasks, and the file is complete");
            }
            let overviews = args.make_overviews(memory)?;
            args.print(memory, &summary, &read, overviews)
        }
        _ => anyhow::bail!("internal error: the build has an unknown outcome"),
    }
}

impl BuildArgs {
    /// Returns the options for the library, and the output on disk, in whose folder the build works.
    fn options(&self) -> anyhow::Result<(BuildOptions, PathBuf)> {
        let is_in_parts = self.output.as_os_str().as_encoded_bytes().ends_with(b".parts");
        anyhow::ensure!(
            !(self.overviews && is_in_parts),
            "a file in parts has no overviews; make it one file with `tiletool compact`, and then its overviews"
        );
        let store = common::url(&self.output).map(TaskStore::at).transpose()?;
        let output = match &store {
            Some(store) => self.tmp.clone().unwrap_or_default().join(store.file_name()),
            None => self.output.clone(),
        };
        let mut options = BuildOptions::default()
            .tile_vertices(self.tile_vertices)
            .engine(self.engine)
            .duplicates(self.duplicates)
            .compress(self.compress)
            .force(self.force)
            .work_folder(self.tmp.clone())
            .store(store);
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
        Ok((options, output))
    }

    /// Leaves the inputs to tasks, if the options ask for that and the points do not fit into memory. Returns
    /// whether it did, and prints the tasks then.
    fn left_inputs(&self, source: &PointSource, output: &Path, options: &BuildOptions) -> anyhow::Result<bool> {
        if self.tasks != Some(TaskStage::Inputs) {
            return Ok(false);
        }
        anyhow::ensure!(
            common::url(&self.output).is_none(),
            "tasks read inputs only where they share the folder of the output; give --tasks alone"
        );
        let args = PointArgs {
            inputs: &self.inputs,
            input: &self.input,
            missing_z: self.missing_z,
        };
        let builder = Builder::new(output, options.clone()).map_err(anyhow::Error::from);
        let planned = builder.and_then(|builder| reading::plan(&args, source, builder));
        let planned = planned.map_err(|error| how_to_resume(error, output, options.resumable.is_some()))?;
        let Some(tasks) = planned else { return Ok(false) };
        let list = InputList::of(&tasks);
        match self.json {
            true => common::print_json("the inputs", &list)?,
            false => common::print_summary("the inputs", &list.report(&self.output))?,
        }
        Ok(true)
    }

    /// Makes the overviews of the finished file, if the options ask for them.
    fn make_overviews(&self, memory: u64) -> anyhow::Result<Option<MadeOverviews>> {
        if !self.overviews {
            return Ok(None);
        }
        let mut options = OverviewOptions::default().memory(memory);
        if let Some(threads) = self.threads {
            options = options.threads(threads);
        }
        common::block_on(MadeOverviews::of(&self.output, options)).map(Some)
    }

    /// Draws the map, and prints the summary, as the options ask for.
    fn print(
        &self,
        memory: u64,
        summary: &BuildSummary,
        read: &InputCounts,
        overviews: Option<MadeOverviews>,
    ) -> anyhow::Result<()> {
        let raw_bytes = self.raw_bytes()?;
        let plotted = self.draw(memory)?;
        if self.json {
            return common::print_json(
                "the summary",
                &BuildReport {
                    summary,
                    read,
                    raw_bytes,
                    plot: plotted.as_ref(),
                    overviews: overviews.as_ref(),
                },
            );
        }
        let overviews = overviews.map(|made| made.report(&self.output)).unwrap_or_default();
        let plotted = plotted.map(|plotted| plotted.report()).unwrap_or_default();
        common::print_summary(
            "the summary",
            &(report(&self.output, summary, read, raw_bytes) + &plotted + &overviews),
        )
    }

    /// Prints the tasks to which the blocks were left.
    fn print_tasks(&self, tasks: &BlockTasks) -> anyhow::Result<()> {
        let store = common::url(&self.output).map(TaskStore::at).transpose()?;
        let list = common::block_on(TaskList::of(tasks, store.as_ref()))?;
        match self.json {
            true => common::print_json("the tasks", &list),
            false => common::print_summary("the tasks", &list.report(&self.output)),
        }
    }

    /// Returns the bytes of the tiles of the finished file before they were compressed, if they were.
    fn raw_bytes(&self) -> anyhow::Result<Option<u64>> {
        if !self.compress {
            return Ok(None);
        }
        common::block_on(async {
            let reader = common::open(&self.output, OpenOptions::default()).await?;
            let directory = reader.directory().await?;
            Ok(Some(directory.tiles.iter().map(TileEntry::decoded_bytes).sum()))
        })
    }

    /// Draws the map of the finished file, if the options ask for one.
    fn draw(&self, memory: u64) -> anyhow::Result<Option<Plotted>> {
        let Some(file) = &self.plot else { return Ok(None) };
        common::block_on(async {
            let reader = common::open(
                &self.output,
                OpenOptions::default().memory(plot::memory_of_reader(memory)),
            )
            .await?;
            plot::draw(&reader, &self.title.of(file)).await.map(Some)
        })
    }

    /// Returns a progress bar of the build.
    fn bar(&self, source: &PointSource, lines: &LineInput, progress: &Arc<Progress>, readings: &Arc<[Reading]>) -> Bar {
        let of_lines: u64 = lines.stamps().map(|(_, stamp)| stamp.length).sum();
        let total = source.total_bytes().map(|of_points| of_points + of_lines);
        let readings = Arc::clone(readings);
        let read = move || readings.iter().map(Reading::bytes).sum();
        Bar::of_build(Arc::clone(progress), Arc::new(move || (read(), total)))
    }
}

/// Returns the folder in which the library keeps the work of a build.
fn work_folder(output: &Path) -> PathBuf {
    let target = output_target(output);
    let mut folder = target.unwrap_or_else(|_| output.to_owned()).into_os_string();
    folder.push(".partial");
    folder.into()
}

/// Returns whether a folder holds work of a build that can go on.
fn has_work(folder: &Path) -> bool {
    ["plan", "inputs"].iter().any(|name| folder.join(name).exists())
}

/// Returns whether the work of an interrupted build could be read, but is not what was written.
fn is_of_damaged_work(error: &anyhow::Error) -> bool {
    let source = match error.downcast_ref() {
        Some(BuildError::Io { source, .. }) => source,
        _ => return false,
    };
    matches!(source.kind(), io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof)
}

/// Adds to the error of a stopped build whether its work was kept and how to resume it.
fn how_to_resume(error: anyhow::Error, output: &Path, can_resume: bool) -> anyhow::Error {
    let folder = &work_folder(output);
    let what = match error.downcast_ref() {
        Some(BuildError::WorkKept { path, bytes }) => {
            return anyhow::anyhow!(
                "{} holds the work of an interrupted build, {}: continue that build with --resume, or give --force to \
                 discard its work and start again",
                common::shown(path),
                common::bytes(*bytes)
            );
        }
        Some(BuildError::OtherBuild { path, what }) => {
            return anyhow::anyhow!(
                "{} holds the work of a build with other inputs or options, which cannot be resumed with these ({what}): \
                 repeat that build's command with --resume, or give --force without --resume to discard its work and \
                 start again",
                common::shown(path)
            );
        }
        Some(BuildError::Locked(_) | BuildError::NotOurs(_)) => return error,
        Some(BuildError::Cancelled) => "interrupted".to_owned(),
        _ if is_stopped(&error) => "interrupted".to_owned(),
        _ => format!("{error:#}"),
    };
    let shown = common::shown(folder);
    if !can_resume {
        // The work folder is about to be removed, or comes from an earlier build.
        match what == "interrupted" {
            true => anyhow::anyhow!(
                "{what}; {} was not written, and the unfinished work is not kept",
                common::shown(output)
            ),
            false => error,
        }
    } else if is_of_damaged_work(&error) {
        anyhow::anyhow!("{what}; repeat the command with --force, without --resume, to discard {shown}")
    } else if has_work(folder) {
        anyhow::anyhow!("{what}; the finished work is kept in {shown}: repeat the command with --resume to continue")
    } else if folder.exists() {
        anyhow::anyhow!(
            "{what}; {shown} is kept, but the input was not read completely: --resume starts from the beginning"
        )
    } else if what == "interrupted" {
        anyhow::anyhow!("{what}; {} was not written", common::shown(output))
    } else {
        error
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A regression test: the message once depended only on the work folder, which a build with
    /// lines leaves for a moment, and an earlier build for ever.
    #[test]
    fn the_error_of_a_build_without_resume_does_not_mention_resume() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("out.tiles");
        let work = folder.path().join("out.tiles.partial");
        std::fs::create_dir(&work).unwrap();
        for has_plan in [false, true] {
            if has_plan {
                std::fs::write(work.join("plan"), "").unwrap();
            }
            for error in [BuildError::Cancelled, BuildError::PointsComplete] {
                let message = |can_resume| {
                    let error = match error {
                        BuildError::Cancelled => BuildError::Cancelled,
                        _ => BuildError::PointsComplete,
                    };
                    how_to_resume(error.into(), &output, can_resume).to_string()
                };
                assert!(!message(false).contains("--resume"), "{}", message(false));
                assert!(message(true).contains("--resume"), "{}", message(true));
            }
        }
    }

    /// Such work cannot be resumed, however often one tries.
    #[test]
    fn the_error_of_damaged_work_says_how_to_start_again() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("out.tiles");
        std::fs::create_dir(work_folder(&output)).unwrap();
        std::fs::write(work_folder(&output).join("plan"), "").unwrap();
        for (kind, is_damaged) in [
            (io::ErrorKind::InvalidData, true),
            (io::ErrorKind::UnexpectedEof, true),
            (io::ErrorKind::StorageFull, false),
        ] {
            let error = BuildError::Io {
                path: output.clone(),
                what: "read",
                source: kind.into(),
            };
            let message = how_to_resume(error.into(), &output, true).to_string();
            assert_eq!(message.contains("--force"), is_damaged, "{message}");
            assert_eq!(message.contains("with --resume to continue"), !is_damaged, "{message}");
        }
    }
}
