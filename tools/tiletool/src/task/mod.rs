//! `tiletool task`: conquers blocks, or distributes inputs, of a build that left them to tasks.

mod inputs;
mod numbers;
pub mod reading;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use bytesize::ByteSize;
use clap::Args;
use delaunay_tiles::{BlockTasks, BuildError, ConqueredBlock, InputTasks, TaskOptions, TaskStore};
use serde::Serialize;

use crate::allocator;
use crate::common::{self, bytes, counted, shown, thousands};
pub use inputs::InputList;
use numbers::{left, ranges};

/// Conquer a block, or distribute an input, of a build
///
/// `tiletool build --tasks` reads the inputs, and plans blocks of points. Each block is triangulated by
/// itself then, by this command, on any machine that shares the folder of the file: in any order, at the
/// same time, and if need be again. What was done before is not done again. `tiletool build --resume`
/// completes the file, and conquers what is missing.
///
/// `tiletool build --tasks=inputs` leaves the inputs to this command, too: it distributes the points of each
/// to the cells of the plan. Then `tiletool build --tasks --resume` plans blocks of them.
///
/// Without --block and --input, the tasks are listed.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  tiletool build survey.laz -o survey.tiles --memory 4GiB --tasks
  tiletool task survey.tiles
  tiletool task survey.tiles --block 0
  tiletool task survey.tiles --block $SLURM_ARRAY_TASK_ID --threads $SLURM_CPUS_PER_TASK
  tiletool build survey.laz -o survey.tiles --memory 4GiB --resume
  tiletool build north.laz south.laz -o survey.tiles --memory 4GiB --tasks=inputs
  tiletool task survey.tiles --input 1")]
pub struct TaskArgs {
    /// Tile file that is being built, or its address in an object store
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Number of the block, from 0; may be given several times
    #[arg(long = "block", value_name = "NUMBER")]
    blocks: Vec<u32>,
    /// Number of the input, from 0; may be given several times
    #[arg(long = "input", value_name = "NUMBER", conflicts_with = "blocks")]
    inputs: Vec<u32>,
    /// Memory limit, such as 512MiB or 2GB; a task needs that of the build [default: the available
    /// memory]
    #[arg(long, value_name = "BYTES")]
    memory: Option<ByteSize>,
    /// Number of threads that compute, at most that of the build [default: one per processor]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Folder for temporary files, if FILE is in an object store [default: that of the system]
    #[arg(long, value_name = "DIR")]
    tmp: Option<PathBuf>,
    /// Print the result as one JSON object
    #[arg(long)]
    json: bool,
}

/// Where the tasks are.
enum Tasks {
    /// Those of inputs.
    Inputs(Box<InputTasks>),
    Folder(Box<BlockTasks>),
    /// The store, and the folder for temporary files.
    Store(TaskStore, PathBuf),
}

impl Tasks {
    fn of(args: &TaskArgs) -> anyhow::Result<Self> {
        Ok(match common::url(&args.file) {
            None if args.inputs.is_empty() => Self::in_folder(&args.file)?,
            None => Self::Inputs(Box::new(InputTasks::open(&args.file)?)),
            Some(_) if !args.inputs.is_empty() => bail!("tasks in an object store have no inputs; give --block"),
            Some(url) => Self::Store(TaskStore::at(url)?, args.tmp.clone().unwrap_or_else(std::env::temp_dir)),
        })
    }

    /// Opens the tasks of blocks, or those of inputs if there are no blocks yet.
    fn in_folder(file: &Path) -> anyhow::Result<Self> {
        match BlockTasks::open(file) {
            Ok(tasks) => Ok(Self::Folder(Box::new(tasks))),
            Err(error @ BuildError::NoTasks(_)) => match InputTasks::open(file) {
                Ok(tasks) => Ok(Self::Inputs(Box::new(tasks))),
                Err(_) => Err(error.into()),
            },
            Err(error) => Err(error.into()),
        }
    }

    /// Returns the bytes of memory that a task needs; 0 if that is not known before one is fetched.
    fn memory(&self) -> u64 {
        match self {
            Self::Inputs(tasks) => tasks.memory(),
            Self::Folder(tasks) => tasks.memory(),
            Self::Store(..) => 0,
        }
    }

    /// Prints the list of the tasks.
    async fn print(&self, file: &Path, is_json: bool) -> anyhow::Result<()> {
        if let Self::Inputs(tasks) = self {
            let list = InputList::of(tasks);
            return match is_json {
                true => common::print_json("the inputs", &list),
                false => common::print("the inputs", &list.report(file)),
            };
        }
        let list = self.list().await?;
        match is_json {
            true => common::print_json("the blocks", &list),
            false => common::print("the blocks", &list.report(file)),
        }
    }

    async fn list(&self) -> anyhow::Result<TaskList> {
        match self {
            Self::Inputs(_) => bail!("there are no blocks yet"),
            Self::Folder(tasks) => TaskList::of(tasks, None).await,
            Self::Store(store, tmp) => {
                let cannot = || format!("cannot make a folder in {}", shown(tmp));
                let folder = tempfile::tempdir_in(tmp).with_context(cannot)?;
                let tasks = store.tasks(folder.path()).await?;
                TaskList::of(&tasks, Some(store)).await
            }
        }
    }

    /// Conquers a block. Ctrl-C cancels it.
    async fn conquer(&self, block: u32, options: TaskOptions) -> anyhow::Result<ConqueredBlock> {
        match self {
            Self::Inputs(_) => bail!("there are no blocks yet: distribute the inputs, and plan blocks then"),
            Self::Folder(tasks) => {
                let conquering = async { Ok(tasks.conquer(block, options).await?) };
                common::until_interrupted(conquering, tasks.progress(), || {}).await
            }
            // Dropping the future of the other branch removes the temporary files. Until a block is complete, it
            // does not count.
            Self::Store(store, tmp) => tokio::select! {
                () = common::interrupted() => bail!("interrupted: block {block} is not conquered"),
                done = store.conquer(block, options, tmp) => Ok(done?),
            },
        }
    }
}

/// The output of `--json` for a block that was conquered.
#[derive(Serialize)]
struct BlockReport {
    block: u32,
    points: u64,
    tiles: u32,
    was_done: bool,
    bytes_read: u64,
    bytes_written: u64,
    seconds: f64,
}

#[derive(Serialize)]
struct BlocksReport {
    blocks: Vec<BlockReport>,
}

/// The tasks of a build: the output of `--json`, whose keys are stable, and the report for people.
#[derive(Serialize)]
pub struct TaskList {
    /// Bytes of memory that each needs.
    memory: u64,
    blocks: Vec<BlockEntry>,
}

#[derive(Serialize)]
struct BlockEntry {
    points: u64,
    is_done: bool,
}

impl TaskList {
    /// Lists tasks, whose output is in the store, if there is one, or in their folder.
    pub async fn of(tasks: &BlockTasks, store: Option<&TaskStore>) -> anyhow::Result<Self> {
        let are_done = match store {
            Some(store) => store.are_done(tasks).await?,
            None => (0..tasks.blocks()).map(|block| tasks.is_done(block)).collect(),
        };
        let entry = |(block, is_done)| BlockEntry {
            points: tasks.points(block),
            is_done,
        };
        Ok(Self {
            memory: tasks.memory(),
            blocks: (0..).zip(are_done).map(entry).collect(),
        })
    }

    /// Returns the report for people. `file` is that of the build.
    pub fn report(&self, file: &Path) -> String {
        let points: u64 = self.blocks.iter().map(|block| block.points).sum();
        let left = left(self.blocks.iter().map(|block| block.is_done));
        let head = format!(
            "{}: {} of {} in all, each conquered with {}\n",
            shown(file),
            counted(self.blocks.len() as u64, "block", "blocks"),
            counted(points, "point", "points"),
            bytes(self.memory),
        );
        let next = match left[..] {
            [] => {
                "all are conquered; tiletool build --resume, with the inputs and options of the build, completes the \
                   file\n"
                    .to_owned()
            }
            [first, ..] => format!(
                "{} left: {}\nconquer each on any machine that shares the {}, such as\n  tiletool task {} --block \
                 {first}\nand then complete the file by the command of the build with --resume in place of --tasks\n",
                thousands(left.len() as u64),
                ranges(&left),
                common::url(file).map_or("folder", |_| "object store"),
                shown(file),
            ),
        };
        head + &next
    }
}

/// Conquers blocks, or lists them.
pub fn run(args: TaskArgs) -> anyhow::Result<()> {
    let tasks = Tasks::of(&args)?;
    if args.blocks.is_empty() && args.inputs.is_empty() {
        return common::block_on(tasks.print(&args.file, args.json));
    }
    let available = TaskOptions::default();
    let options = TaskOptions {
        memory: args.memory.map_or(available.memory, |bytes| bytes.as_u64()),
        threads: args.threads.map_or(available.threads, usize::from),
    };
    allocator::keep_to(tasks.memory());
    if let Tasks::Inputs(tasks) = &tasks
        && !args.inputs.is_empty()
    {
        return inputs::run(&args.file, tasks, &args.inputs, options, args.json);
    }
    let mut report = BlocksReport { blocks: Vec::new() };
    common::block_on(async {
        for &block in &args.blocks {
            let done = tasks.conquer(block, options).await.with_context(|| shown(&args.file))?;
            if !args.json {
                common::print_summary("the result", &line(&done))?;
            }
            report.blocks.push(BlockReport::of(done));
        }
        Ok(())
    })?;
    match args.json {
        true => common::print_json("the result", &report),
        false => Ok(()),
    }
}

fn line(done: &ConqueredBlock) -> String {
    match done.was_done {
        true => format!("block {} was conquered before\n", done.block),
        false => format!(
            "block {}: {} in {}, {} written, {:.1} s\n",
            done.block,
            counted(done.points, "point", "points"),
            counted(done.tiles.into(), "tile", "tiles"),
            bytes(done.bytes_written),
            done.seconds
        ),
    }
}

impl BlockReport {
    fn of(done: ConqueredBlock) -> Self {
        Self {
            block: done.block,
            points: done.points,
            tiles: done.tiles,
            was_done: done.was_done,
            bytes_read: done.bytes_read,
            bytes_written: done.bytes_written,
            seconds: done.seconds,
        }
    }
}
