//! Builds whose blocks are conquered by tasks.

use futures::future::FutureExt;

use crate::pipeline::builder::Builder;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::intake::Intake;
use crate::pipeline::records::FinishedBlocks;
use crate::pipeline::summary::BuildSummary;
use crate::pipeline::tasks::left::left_cores;
use crate::pipeline::tasks::{BlockTasks, TaskOptions};

/// What became of a build that was to leave its blocks to tasks.
#[derive(Debug)]
#[non_exhaustive]
pub enum Planned {
    /// All points fitted into memory, so there are no blocks, and the file was built at once.
    Built(Box<BuildSummary>),
    /// The blocks, which tasks may conquer now.
    Tasks(Box<BlockTasks>),
}

impl Builder {
    /// Plans the blocks in which the points are conquered, and leaves them to [tasks](BlockTasks), which
    /// any process may do that shares the work folder: the folder beside the output, and
    /// [`BuildOptions::work_folder`](crate::BuildOptions::work_folder) if that is set.
    /// [Resuming](crate::BuildOptions::resume) the build completes the file. If the build was planned
    /// before and is resumed, its tasks are returned.
    ///
    /// [`BuildOptions::memory`](crate::BuildOptions::memory) determines the blocks, and each task needs
    /// as much. Must be awaited within a tokio runtime.
    ///
    /// # Errors
    /// Returns [`BuildError::NotResumable`] if the build cannot be
    /// [resumed](crate::BuildOptions::resumable), [`BuildError::NoTasks`] if it was interrupted and its
    /// blocks were not left to tasks, and those of [`finish`](Self::finish).
    ///
    /// # Example
    ///
    /// ```
    /// use delaunay_tiles::input::PointBatch;
    /// use delaunay_tiles::{BlockTasks, BuildOptions, Builder, Planned, Point, TaskOptions};
    ///
    /// # tokio::runtime::Runtime::new()?.block_on(async {
    /// let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("grid.tiles");
    /// let grid = (0..100_000).map(|i| Point::new(f64::from(i % 400), f64::from(i / 400)));
    /// let batch = PointBatch { points: grid.collect(), z: Vec::new(), records: (0..100_000).collect() };
    /// let options = BuildOptions::default()
    ///     .memory(1_500_000)
    ///     .tile_vertices(1000)
    ///     .threads(1)
    ///     .resumable("a grid".to_owned());
    /// let mut builder = Builder::new(&path, options.clone())?;
    /// builder.push(&batch).await?;
    /// let Planned::Tasks(tasks) = builder.plan_tasks().await? else {
    ///     panic!("1.5 MB suffice");
    /// };
    /// // Any process may do this, for any block.
    /// let tasks = BlockTasks::open(&path)?;
    /// for block in 0..tasks.blocks() {
    ///     tasks.conquer(block, TaskOptions { memory: 1_500_000, threads: 1 }).await?;
    /// }
    /// let summary = Builder::new(&path, options.resume(true))?.finish().await?;
    /// assert_eq!((summary.vertices, summary.resumed_blocks), (100_000, u64::from(tasks.blocks())));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// # })?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn plan_tasks(mut self) -> impl Future<Output = Result<Planned, BuildError>> + Send {
        async move {
            let planned = self.plan().await;
            self.keep_after(planned)
        }
        .boxed()
    }

    async fn plan(&mut self) -> Result<Planned, BuildError> {
        if self.context.options.resumable.is_none() {
            return Err(BuildError::NotResumable);
        }
        self.check_store().await?;
        if self.needs_points() {
            self.complete_points().await?;
            let (assembly, points, segments) = self.assembly().await?;
            if let Some(built) = assembly.plan_tasks(points, segments).await? {
                return Ok(Planned::Built(Box::new(built)));
            }
        }
        let tasks = BlockTasks::open(&self.output)?;
        if let Some(store) = &self.context.options.store
            && !self.context.folder.has_cores_elsewhere()
        {
            store.put_tasks(&tasks).await?;
        }
        Ok(Planned::Tasks(Box::new(tasks)))
    }

    /// Takes the blocks that tasks conquered, and conquers the others, if the blocks were left to tasks.
    pub(super) async fn gather(&mut self) -> Result<(), BuildError> {
        let context = &self.context;
        let Intake::Resumed(_, finished) = &mut self.intake else {
            return Ok(());
        };
        if !context.folder.tasks().exists() {
            return Ok(());
        }
        let tasks = BlockTasks::open(&self.output)?.with_progress(&context.options.progress);
        match &context.options.store {
            Some(store) => store.fetch_blocks(&tasks).await?,
            None if context.folder.has_cores_elsewhere() => {
                return Err(BuildError::NoStore(context.folder.path().to_owned()));
            }
            None => {}
        }
        let options = TaskOptions {
            memory: context.options.memory,
            threads: context.options.threads,
        };
        tasks.gather(finished, options).await?;
        *finished = FinishedBlocks::read(&context.folder)?;
        if context.folder.is_in_parts() {
            finished.left = left_cores(finished, tasks.front_end());
        }
        match finished.blocks == tasks.blocks() {
            true => Ok(()),
            false => Err(BuildError::Internal(
                "a block that was gathered is not in the journal".to_owned(),
            )),
        }
    }
}
