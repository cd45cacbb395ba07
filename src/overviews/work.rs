//! What all steps share: the options, the shares of the memory, and the work folder.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{fs, io};

use crate::io::{Backend, output_target};
use crate::memory::OverviewShares;
use crate::overviews::error::OverviewError;
use crate::overviews::options::{OverviewOptions, OverviewProgress};
use crate::pipeline::BuildOptions;
use crate::store::{Cache, OpenOptions, ReadError, TileReader};

/// What the names of all files in the folder begin with.
const PREFIX: &str = "level-";

/// The work of making overviews.
pub(super) struct Work {
    pub(super) shares: OverviewShares,
    pub(super) threads: usize,
    pub(super) progress: Arc<OverviewProgress>,
    folder: PathBuf,
    /// How all levels are built.
    build: BuildOptions,
}

impl Work {
    /// Creates the work folder, whose path [`clear`] returned.
    pub(super) fn new(folder: PathBuf, options: &OverviewOptions, build: BuildOptions) -> Result<Self, OverviewError> {
        match fs::create_dir(&folder) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => return Err(OverviewError::NotOurs(folder)),
            made => made.map_err(OverviewError::io(&folder, "make the work folder"))?,
        }
        let shares = OverviewShares(options.memory);
        Ok(Self {
            shares,
            threads: options.threads,
            progress: Arc::clone(&options.progress),
            folder,
            build: BuildOptions {
                is_draft: true,
                ..build
            }
            .memory(shares.build())
            .threads(options.threads)
            .progress(Arc::clone(&options.progress.builds)),
        })
    }

    /// Returns the options of a build.
    pub(super) fn build_options(&self) -> BuildOptions {
        self.build.clone()
    }

    /// Returns the most vertices of a tile.
    pub(super) fn tile_vertices(&self) -> u64 {
        self.build.tile_vertices as u64
    }

    /// Returns the path of the file of a level after a round.
    pub(super) fn level(&self, level: u32, round: u32) -> PathBuf {
        self.folder.join(format!("{PREFIX}{level}-{round}"))
    }

    /// Returns the path of the candidates of a level.
    pub(super) fn spill(&self, level: u32) -> PathBuf {
        self.folder.join(format!("{PREFIX}{level}-candidates"))
    }

    /// Fails if that was asked for.
    pub(super) fn check(&self) -> Result<(), OverviewError> {
        match self.progress.is_cancelled() {
            true => Err(OverviewError::Cancelled),
            false => Ok(()),
        }
    }

    /// Opens the file of a level, for passes and for lookups, as one of `levels` that are open.
    pub(super) async fn open(&self, path: &Path, levels: usize) -> Result<TileReader, ReadError> {
        let cache = Cache::new(usize::try_from(self.shares.coarser(levels)).unwrap_or(usize::MAX));
        let options = OpenOptions::default().memory(self.shares.pass()).cache(&cache);
        // It is in the page cache, which a ring may bypass.
        TileReader::open(path, options.backend(Backend::Threads)).await
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        if let Err(error) = fs::remove_dir_all(&self.folder) {
            tracing::warn!(folder = %self.folder.display(), %error, "the work folder could not be removed");
        }
    }
}

/// Returns the path of the work folder of a file, which must be locked. Removes what an attempt that was
/// killed has left there. A folder of others stays.
pub(super) fn clear(file: &Path) -> Result<PathBuf, OverviewError> {
    let mut name = OsString::from(output_target(file).map_err(OverviewError::io(file, "open it"))?);
    name.push(".overviews.partial");
    let folder = PathBuf::from(name);
    // One that cannot be read is of others, or not there.
    if is_ours(&folder).unwrap_or(false) {
        fs::remove_dir_all(&folder).map_err(OverviewError::io(&folder, "empty the work folder"))?;
    }
    Ok(folder)
}

/// Returns whether a folder has nothing but the files of this work.
fn is_ours(folder: &Path) -> io::Result<bool> {
    if !fs::symlink_metadata(folder)?.is_dir() {
        return Ok(false);
    }
    for entry in fs::read_dir(folder)? {
        if !entry?.file_name().to_string_lossy().starts_with(PREFIX) {
            return Ok(false);
        }
    }
    Ok(true)
}
