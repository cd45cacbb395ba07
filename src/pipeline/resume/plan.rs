//! The plan of a build: its blocks, and all of its input but points and segments.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::{io, iter};

use parking_lot::Mutex;

use crate::pipeline::context::Given;
use crate::pipeline::error::BuildError;
use crate::pipeline::ingest::drape::Draping;
use crate::pipeline::plan::{Block, BlockPlan, NodeLimits};
use crate::pipeline::records::FinishedBlocks;
use crate::pipeline::resume::checked_file;
use crate::pipeline::resume::codec::{Stored, decoded, stored};
use crate::pipeline::threads::on_threads;
use crate::pipeline::work_folder::WorkFolder;

/// A plan, and the build that it belongs to.
#[derive(Debug)]
pub(crate) struct SavedPlan {
    pub(crate) settings: SavedSettings,
    pub(crate) given: Given,
    pub(crate) plan: BlockPlan,
    /// How vertices take their z from the surface, if there is one.
    pub(crate) draping: Option<Draping>,
}

/// The settings of a build, and the sizes of what has arrived.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SavedSettings {
    /// Inputs, and options that determine the output.
    pub(crate) identity: String,
    /// The memory budget in bytes.
    pub(crate) memory: u64,
    /// Bytes that segments keep, and sites and seeds.
    pub(crate) arrivals: [u64; 2],
    pub(crate) limits: NodeLimits,
    /// First record number of segment ends and sites.
    pub(crate) first_end: u64,
    /// Number of segments, which are in a file of their own.
    pub(crate) segments: u64,
}

stored! {
    SavedSettings { identity, memory, arrivals, limits, first_end, segments }
}

const MAGIC: &[u8; 8] = b"dtplan06";

/// Syncs all that a build of these blocks reads again when it is resumed, and the names of its files.
pub(crate) fn sync_inputs(folder: &WorkFolder, blocks: &[Block]) -> io::Result<()> {
    let runs = blocks.iter().flat_map(|block| &block.runs);
    let runs = runs.filter(|run| run.length > 0).map(|run| run.path(folder.spill()));
    sync_files(&runs.collect::<Vec<_>>())?;
    [folder.spill(), folder.path()].into_iter().try_for_each(sync)
}

/// Syncs files, several at once: for many small ones, a disk takes little longer than for one.
fn sync_files(files: &[PathBuf]) -> io::Result<()> {
    const AT_ONCE: usize = 16;
    let (left, failed) = (Mutex::new(files.iter()), Mutex::new(None));
    let sync_left = || {
        let next = || left.lock().next();
        if let Err(error) = iter::from_fn(next).try_for_each(|file| sync(file)) {
            failed.lock().get_or_insert(error);
        }
    };
    on_threads(AT_ONCE.min(files.len()), sync_left, || ()).map_err(io::Error::other)?;
    failed.into_inner().map_or(Ok(()), Err)
}

fn sync(path: &Path) -> io::Result<()> {
    File::open(path)?.sync_all()
}

/// Writes a plan to `path` atomically: the file is renamed to `path` once it is complete and
/// synced.
pub(crate) fn save(
    path: &Path,
    settings: &SavedSettings,
    given: &Given,
    plan: &BlockPlan,
    draping: Option<&Draping>,
) -> io::Result<()> {
    let mut out = Vec::new();
    settings.put(&mut out);
    given.put(&mut out);
    plan.put(&mut out);
    draping.is_some().put(&mut out);
    if let Some(draping) = draping {
        draping.put(&mut out);
    }
    checked_file::write(path, MAGIC, &out)
}

impl SavedPlan {
    /// Returns the blocks that the build finished, or `None` if a file that the other blocks need is
    /// lost or cut short. The content of these files is checked when they are read.
    pub(crate) fn finished(&self, folder: &WorkFolder) -> Result<Option<FinishedBlocks>, BuildError> {
        let finished = FinishedBlocks::read(folder)?;
        let Some(unfinished) = self.plan.blocks.get(finished.blocks as usize..) else {
            return Ok(None);
        };
        let runs = unfinished.iter().flat_map(|block| &block.runs);
        let runs = runs.map(|run| (run.path(folder.spill()), run.length));
        let lines = (self.settings.segments > 0).then(|| (folder.lines(), 1));
        let surface = self.draping.is_some().then(|| (folder.surface(), 1));
        let lost = runs.chain(lines).chain(surface).find(|(path, length)| {
            let found = path.metadata().map_or(0, |metadata| metadata.len());
            found < *length
        });
        if let Some((path, _)) = &lost {
            tracing::warn!(path = %path.display(), "lost or cut short, so the build cannot be resumed");
        }
        Ok(lost.is_none().then_some(finished))
    }

    /// Reads a plan. Returns `None` if `path` does not exist or holds no valid plan.
    pub(crate) fn load(path: &Path) -> io::Result<Option<Self>> {
        let parts = checked_file::read(path, MAGIC)?.and_then(|body| decoded(&body));
        Ok(parts.map(|((settings, given), (plan, draping))| Self {
            settings,
            given,
            plan,
            draping,
        }))
    }
}
