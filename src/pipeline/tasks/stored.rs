//! Tasks in an object store: what they need goes there and comes from there, and so do their outputs.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use futures::future::FutureExt;
use futures::stream::{self, StreamExt, TryStreamExt};

use crate::io::{Manifest, folder_of};
use crate::pipeline::error::BuildError;
use crate::pipeline::output::in_parts::remove_parts;
use crate::pipeline::records::LeftCores;
use crate::pipeline::task_store::TaskStore;
use crate::pipeline::tasks::block_tasks::BlockTasks;
use crate::pipeline::tasks::conquer::{ConqueredBlock, TaskOptions};
use crate::pipeline::work_folder::WorkFolder;

/// Returns the number of objects that are put or fetched at once: a store is far, rather than slow.
/// Each takes up to three requests of 8 MiB.
fn at_once(tasks: &BlockTasks) -> usize {
    (tasks.memory() >> 26).clamp(1, 8) as usize
}

impl TaskStore {
    /// Opens the tasks of the build. The plan is fetched into `folder`, which must not be that of
    /// the build.
    ///
    /// # Errors
    /// Returns [`BuildError::NoTasks`] if there are none, and an error if the store fails.
    pub async fn tasks(&self, folder: &Path) -> Result<BlockTasks, BuildError> {
        let output = folder.join(self.file_name());
        let cannot = |error| BuildError::io(folder, "fetch tasks into", error);
        let made = WorkFolder::shared(&output)?;
        fs::create_dir_all(made.path()).map_err(cannot)?;
        made.set_cores_elsewhere().map_err(cannot)?;
        for file in [made.plan(), made.tasks()] {
            if !self.fetch_work(file).await.map_err(cannot)? {
                return Err(BuildError::NoTasks(self.manifest().into()));
            }
        }
        BlockTasks::open(output)
    }

    /// Returns whether each block was conquered, by the objects in the store.
    ///
    /// # Errors
    /// Returns an error if the store fails.
    pub async fn are_done(&self, tasks: &BlockTasks) -> Result<Vec<bool>, BuildError> {
        let names = self.block_names(tasks.id).await;
        let names = names.map_err(tasks.cannot("look for the blocks of the tasks in"))?;
        let is_done = |block| names.iter().any(|name| tasks.folder.block(block).ends_with(name));
        Ok((0..tasks.blocks()).map(is_done).collect())
    }

    /// Conquers a block, as [`BlockTasks::conquer`] does, with the points from the store, and puts
    /// it there. `folder` gets a folder for temporary files.
    ///
    /// # Errors
    /// Those of [`BlockTasks::conquer`] and [`tasks`](Self::tasks).
    pub fn conquer<'a>(
        &'a self,
        block: u32,
        options: TaskOptions,
        folder: &'a Path,
    ) -> impl Future<Output = Result<ConqueredBlock, BuildError>> + Send + 'a {
        async move {
            let cannot = |error| BuildError::io(folder, "make a folder for a task in", error);
            let scratch = tempfile::tempdir_in(folder).map_err(cannot)?;
            let tasks = self.tasks(scratch.path()).await?;
            self.conquer_in(&tasks, block, options).await
        }
        .boxed()
    }

    async fn conquer_in(
        &self,
        tasks: &BlockTasks,
        block: u32,
        options: TaskOptions,
    ) -> Result<ConqueredBlock, BuildError> {
        let (cannot, folder) = (tasks.cannot("fetch a task into"), &tasks.folder);
        self.fetch_block(tasks.id, folder.block(block)).await.map_err(&cannot)?;
        if tasks.is_done(block) || block >= tasks.blocks() {
            return tasks.conquer(block, options).await;
        }
        for run in &tasks.plan.blocks[block as usize].runs {
            let run = run.path(folder.spill());
            if !self.fetch_work(run.clone()).await.map_err(&cannot)? {
                let error = io::Error::new(
                    io::ErrorKind::NotFound,
                    format!("{} is not in the store", run.display()),
                );
                return Err(cannot(error));
            }
        }
        // There may be none.
        self.fetch_work(folder.segments_of(block)).await.map_err(&cannot)?;
        if tasks.draping.is_some() {
            self.fetch_work(folder.surface()).await.map_err(&cannot)?;
        }
        let done = tasks.conquer(block, options).await?;
        let [cores, rest] = [folder.cores_of(block), folder.block(block)];
        let put = self.put_block(tasks.id, &cores, &rest).await;
        put.map_err(tasks.cannot("put a block into the store from"))?;
        Ok(done)
    }

    /// Puts what tasks need into the store.
    pub(crate) async fn put_tasks(&self, tasks: &BlockTasks) -> Result<(), BuildError> {
        let folder = &tasks.folder;
        let blocks = tasks.plan.blocks.iter().zip(0..);
        let of_blocks = blocks.flat_map(|(block, number)| {
            let runs = block.runs.iter().map(|run| run.path(folder.spill()));
            runs.chain([folder.segments_of(number)])
        });
        let surface = tasks.draping.is_some().then(|| folder.surface());
        let files: Vec<PathBuf> = of_blocks.chain(surface).filter(|file| file.exists()).collect();
        let put = async {
            self.clear_work().await?;
            let put = stream::iter(files).map(|file| async move { self.put_work(&file).await });
            put.buffer_unordered(at_once(tasks)).try_collect::<()>().await?;
            // Once they are there, so is all that they name.
            self.put_work(&folder.plan()).await?;
            self.put_work(&folder.tasks()).await?;
            folder.set_cores_elsewhere()
        };
        put.await.map_err(tasks.cannot("put tasks into the store from"))
    }

    /// Fetches what tasks left, without the cores.
    pub(crate) async fn fetch_blocks(&self, tasks: &BlockTasks) -> Result<(), BuildError> {
        let left = (0..tasks.blocks()).filter(|&block| !tasks.is_done(block));
        let fetch = stream::iter(left).map(|block| self.fetch_block(tasks.id, tasks.folder.block(block)));
        let fetched = fetch
            .buffer_unordered(at_once(tasks))
            .try_for_each(|_| async { Ok(()) });
        fetched.await.map_err(tasks.cannot("fetch blocks into"))
    }
}

/// Fetches cores that are not in the folder.
pub(crate) async fn fetch_cores(store: &TaskStore, folder: &WorkFolder, id: u64, left: &[LeftCores]) -> io::Result<()> {
    for &LeftCores { block, .. } in left {
        let cores = folder.cores_of(block);
        if !cores.exists() && !store.fetch_cores(id, cores).await? {
            return Err(io::Error::new(
                io::ErrorKind::NotFound,
                format!("the tiles of block {block} are lost"),
            ));
        }
    }
    Ok(())
}

/// Puts the finished file into the store. Its parts do not stay on disk; after an error they do,
/// for the next attempt.
pub(crate) async fn put_finished(store: &TaskStore, manifest: Manifest, output: &Path, id: u64) -> io::Result<()> {
    store.put_file(manifest, folder_of(output)).await?;
    remove_parts(output, id)
}
