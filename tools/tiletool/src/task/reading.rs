//! Inputs that tasks read: planned by `build --tasks=inputs`, read by `task --input`, taken by the build
//! that goes on.

use std::path::{Path, PathBuf};
use std::slice;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, bail, ensure};
use clap::{CommandFactory, FromArgMatches, Parser};
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::{FileStamp, PointBatch, PointSource};
use delaunay_tiles::{Builder, DistributedInput, InputPlan, InputTasks};
use serde::{Deserialize, Serialize};

use crate::common::shown;
use crate::input_args::InputArgs;
use crate::lines::MissingZArgs;
use crate::points::{PointsRead, SAMPLE};

/// How a task reads its input: the arguments of the build that concern points.
#[derive(Parser)]
#[command(no_binary_name = true)]
struct ReadingArgs {
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    missing_z: MissingZArgs,
}

/// What the plan says of the inputs to the tasks.
#[derive(Deserialize, Serialize)]
struct Memo {
    /// The arguments of [`ReadingArgs`].
    arguments: Vec<String>,
    has_z: bool,
    files: Vec<FileState>,
}

/// The state of a file, so that a change of it is found.
#[derive(Deserialize, PartialEq, Serialize)]
struct FileState {
    path: PathBuf,
    length: u64,
    modified: i128,
}

impl FileState {
    /// Returns the states of the files of a source when it was opened.
    fn all_of(source: &PointSource) -> anyhow::Result<Vec<Self>> {
        let state = |(path, stamp): &(PathBuf, FileStamp)| {
            Ok(Self {
                path: absolute(path)?,
                length: stamp.length,
                modified: stamp.modified,
            })
        };
        source.stamps().iter().map(state).collect()
    }
}

fn absolute(path: &Path) -> anyhow::Result<PathBuf> {
    std::path::absolute(path).with_context(|| format!("cannot find {}", shown(path)))
}

/// What a task says of its input to the build.
#[derive(Deserialize, Serialize)]
struct Said {
    read: PointsRead,
    /// The lowest and the highest corner of the points, if there are any.
    extent: Option<[f64; 4]>,
}

/// The arguments of a build that concern its points.
pub struct PointArgs<'a> {
    pub inputs: &'a [PathBuf],
    pub input: &'a InputArgs,
    pub missing_z: MissingZArgs,
}

/// Plans the tasks of inputs, which are open. Returns `None` if all points fit into memory.
pub fn plan(args: &PointArgs<'_>, source: &PointSource, builder: Builder) -> anyhow::Result<Option<InputTasks>> {
    source
        .total_bytes()
        .context("only files can be read by tasks; standard input cannot")?;
    let counted = args.inputs.iter().zip(source.expected_records());
    let records = counted.map(|(path, records)| {
        let unknown = || {
            let path = shown(path);
            format!("{path} does not say how many records it has, so tasks cannot read the inputs: give --tasks alone")
        };
        records.with_context(unknown)
    });
    let mut sample = source.sample(SAMPLE)?;
    if sample.is_empty() {
        sample = source.expected_positions(SAMPLE);
    }
    let plan = InputPlan {
        records: records.collect::<anyhow::Result<_>>()?,
        has_z: source.has_z(),
        sample,
        memo: serde_json::to_string(&Memo {
            arguments: args.arguments()?,
            has_z: source.has_z(),
            files: FileState::all_of(source)?,
        })?,
    };
    Ok(builder.plan_inputs(plan)?)
}

impl PointArgs<'_> {
    /// Returns them as text, with absolute paths.
    fn arguments(&self) -> anyhow::Result<Vec<String>> {
        let mut arguments = self.input.arguments();
        arguments.extend(self.missing_z.arguments());
        arguments.push("--".to_owned());
        for path in self.inputs {
            let path = absolute(path)?;
            let text = path.to_str();
            let text =
                text.with_context(|| format!("{} has a name that is no UTF-8, so tasks cannot find it", shown(&path)));
            arguments.push(text?.to_owned());
        }
        Ok(arguments)
    }
}

/// Distributes the points of an input. `stop` ends it early.
pub fn distribute(
    tasks: &InputTasks,
    input: u32,
    (memory, threads): (u64, usize),
    stop: &AtomicBool,
) -> anyhow::Result<DistributedInput> {
    let memo: Memo = serde_json::from_str(tasks.memo()).context("the plan was made by another program")?;
    let matches = ReadingArgs::command().try_get_matches_from(&memo.arguments);
    let args = matches.and_then(|matches| ReadingArgs::from_arg_matches(&matches));
    let args = args.context("the plan was made by another version of this program")?;
    let options = args.input.options().missing_z(args.missing_z.option()).threads(threads);
    let mut task = tasks.start(input, memory)?;
    let records = tasks.records(input);
    // Of the others, of which there may be thousands, nothing is opened.
    let path = args.inputs.get(input as usize).context("an input is missing")?;
    let source = PointSource::open(slice::from_ref(path), &options)?;
    ensure!(
        FileState::all_of(&source)?.iter().all(|file| memo.files.contains(file)),
        "{} has changed since the tasks were planned; plan them again",
        shown(path)
    );
    let mut source = source.as_part(records.start, memo.has_z);
    let (mut batch, mut extent) = (PointBatch::default(), Rect::EMPTY);
    while source.next_batch(&mut batch)? {
        if stop.load(Ordering::Relaxed) {
            bail!("interrupted: input {input} is not distributed");
        }
        extent = extent.union(Rect::around(batch.points.iter().copied()));
        task.push(&batch)?;
    }
    let read = PointsRead::of(&source);
    ensure!(
        read.records == records.end - records.start,
        "{} has {} records, and announced {}; build without tasks for inputs",
        shown(path),
        read.records,
        records.end - records.start
    );
    let said = Said {
        read,
        extent: (!extent.is_empty()).then_some([extent.min_x, extent.min_y, extent.max_x, extent.max_y]),
    };
    Ok(task.finish(&serde_json::to_string(&said)?)?)
}

/// Takes the inputs, after it has distributed those that are left. Returns what was read, and corners of
/// the points' extents. `stop` ends it early.
pub fn take(mut builder: Builder, stop: &AtomicBool) -> anyhow::Result<(Builder, PointsRead, Vec<Point>)> {
    if let Some(tasks) = builder.input_tasks() {
        for input in (0..tasks.inputs()).filter(|&input| !tasks.is_done(input)) {
            distribute(&tasks, input, (tasks.memory(), 0), stop)?;
        }
    }
    let (mut read, mut corners) = (PointsRead::default(), Vec::new());
    for text in builder.take_inputs()? {
        let said: Said = serde_json::from_str(&text).context("a task was done by another program")?;
        read.add(said.read);
        if let Some([min_x, min_y, max_x, max_y]) = said.extent {
            corners.extend([Point::new(min_x, min_y), Point::new(max_x, max_y)]);
        }
    }
    Ok((builder, read, corners))
}

/// Returns the names of the inputs of tasks, for people; none if another program planned them.
pub fn names(tasks: &InputTasks) -> Vec<String> {
    let memo = serde_json::from_str(tasks.memo());
    let arguments = memo.map_or_else(|_| Vec::new(), |memo: Memo| memo.arguments);
    arguments
        .into_iter()
        .skip_while(|argument| argument != "--")
        .skip(1)
        .collect()
}
