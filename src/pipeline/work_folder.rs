//! The folder `OUT.partial/`, in which a file is completed before it gets its name.
//!
//! ```text
//! lock      held while a build works here
//! tiles     the file that will be OUT
//! plan      the blocks, once all points came in          ┐ of a build that outgrew the memory and
//! journal   those that are finished                      ┘ whose inputs can be read again
//! spill     the path of the folder that the build was told to spill to, if it was
//! run-…     points of blocks that are not finished       ┐ here, or in a folder of their own where
//! borders   what the borders of tiles will be made of    ┘ the build was told to spill to
//! segments  segments; it loses its name as soon as it is there
//! ```

use std::ffi::OsString;
use std::fs::{File, TryLockError};
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::{fs, io};

use xxhash_rust::xxh3::xxh3_64;

use crate::constraints::segments::chunk_store::SEGMENTS;
use crate::io::{folder_of, is_named, output_target};
use crate::pipeline::error::BuildError;

const LOCK: &str = "lock";
const TILES: &str = "tiles";
/// Where [`TileReader::compact`](crate::store::TileReader::compact) writes `tiles` anew.
const COMPACTED: &str = ".tiles.partial";
const PLAN: &str = "plan";
const JOURNAL: &str = "journal";
const SPILL: &str = "spill";
const BORDERS: &str = "borders";
const RUN: &str = "run-";

/// A locked work folder; it goes away with this value, unless it is kept.
#[derive(Debug)]
pub(crate) struct WorkFolder {
    path: PathBuf,
    /// Where work is spilled to.
    spill: PathBuf,
    output: PathBuf,
    keep: AtomicBool,
    /// Whether the file has its name, so that there is nothing to keep.
    published: AtomicBool,
    /// Held, so that the lock lasts.
    _lock: File,
}

impl WorkFolder {
    /// Makes the folder, or takes over one that a dead build left. What is in that stays only if it is to be resumed.
    ///
    /// A folder with anything in it that no build leaves there is not touched.
    pub(crate) fn create(output: &Path, tmp: Option<&Path>, force: bool, resume: bool) -> Result<Self, BuildError> {
        if !force && output.exists() {
            return Err(BuildError::OutputExists(output.to_owned()));
        }
        let mut name = OsString::from(output);
        name.push(".partial");
        let path = PathBuf::from(name);
        let spill = match tmp {
            None => path.clone(),
            Some(tmp) => {
                let tmp = fs::canonicalize(tmp).map_err(|error| BuildError::io(tmp, "find the folder", error))?;
                tmp.join(spill_name(output)?)
            }
        };
        // A build that ends removes its folder and unlocks: whoever locked what it removed must try again.
        for _ in 0..100 {
            let Some(lock) = lock(&path)? else { continue };
            let this = Self {
                path,
                spill,
                output: output.to_owned(),
                // Until it is known that all of it is ours.
                keep: AtomicBool::new(true),
                published: AtomicBool::new(false),
                _lock: lock,
            };
            if !resume {
                this.forget_spill();
            }
            if let Err(error) = this.prepare_spill() {
                if !resume {
                    let _ = fs::remove_dir_all(&this.path);
                }
                return Err(error);
            }
            if !resume {
                this.empty()
                    .map_err(|e| BuildError::io(&this.path, "empty the work folder", e))?;
                this.keep(false);
            }
            this.note_spill()
                .map_err(|e| BuildError::io(&this.path, "write into the work folder", e))?;
            return Ok(this);
        }
        Err(BuildError::Locked(path))
    }

    /// Makes the folder to spill to, or takes over one that a build left.
    fn prepare_spill(&self) -> Result<(), BuildError> {
        if self.spill == self.path {
            return Ok(());
        }
        match fs::create_dir(&self.spill) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => match is_ours(&self.spill) {
                Ok(true) => Ok(()),
                _ => Err(BuildError::NotOurs(self.spill.clone())),
            },
            made => made.map_err(|error| BuildError::io(&self.spill, "make the folder to spill to", error)),
        }
    }

    /// Notes where work is spilled to, so that a later build of this output finds it.
    fn note_spill(&self) -> io::Result<()> {
        match self.spill == self.path {
            true => Ok(()),
            false => fs::write(self.path.join(SPILL), self.spill.as_os_str().as_bytes()),
        }
    }

    /// Removes the folder that a killed build spilled to, if this one spills elsewhere.
    fn forget_spill(&self) {
        let Ok(noted) = fs::read(self.path.join(SPILL)) else {
            return;
        };
        let noted = PathBuf::from(OsString::from_vec(noted));
        let is_its = spill_name(&self.output).is_ok_and(|name| noted.file_name() == Some(&name));
        // What somebody else put there is not touched.
        if noted != self.spill && is_its && is_ours(&noted).unwrap_or(false) {
            let _ = fs::remove_dir_all(&noted);
        }
    }

    /// Removes all that a build before has left.
    pub(crate) fn empty(&self) -> io::Result<()> {
        for folder in [&self.path, &self.spill] {
            for entry in fs::read_dir(folder)? {
                let entry = entry?;
                if entry.file_name() != LOCK {
                    match fs::remove_file(entry.path()) {
                        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                        _ => {}
                    }
                }
            }
        }
        Ok(())
    }

    /// Whether the folder outlives this value.
    pub(crate) fn keep(&self, keep: bool) {
        let published = self.published.load(Ordering::Relaxed);
        self.keep.store(keep && !published, Ordering::Relaxed);
    }

    /// The folder.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Where work is spilled to.
    pub(crate) fn spill(&self) -> &Path {
        &self.spill
    }

    /// Where the file is completed.
    pub(crate) fn file(&self) -> PathBuf {
        self.path.join(TILES)
    }

    /// Where the blocks stand.
    pub(crate) fn plan(&self) -> PathBuf {
        self.path.join(PLAN)
    }

    /// Where the finished blocks stand.
    pub(crate) fn journal(&self) -> PathBuf {
        self.path.join(JOURNAL)
    }

    /// Whether a build left this folder that was killed between giving its file the name and cleaning up.
    pub(crate) fn was_published(&self) -> bool {
        self.journal().exists() && !self.file().exists()
    }

    /// Where the border log is spilled to.
    pub(crate) fn borders(&self) -> PathBuf {
        self.spill.join(BORDERS)
    }

    /// Gives the completed file its name; the folder goes away.
    pub(crate) fn publish(&self) -> Result<(), BuildError> {
        let output = &self.output;
        let folder = folder_of(output);
        let cannot = |error| BuildError::io(folder, "sync the folder", error);
        // Before the file has its name, so that a refusal leaves what was there.
        let opened = File::open(folder).map_err(cannot)?;
        output_target(output)
            .and_then(|_| fs::rename(self.file(), output))
            .map_err(|e| BuildError::io(output, "rename the finished file to", e))?;
        self.published.store(true, Ordering::Relaxed);
        self.keep(false);
        opened.sync_all().map_err(cannot)
    }
}

impl Drop for WorkFolder {
    fn drop(&mut self) {
        if self.keep.load(Ordering::Relaxed) {
            return;
        }
        // Who is killed on the way must not leave a plan without what it speaks of.
        let _ = fs::remove_file(self.plan());
        let mut folders = vec![&self.path];
        if self.spill != self.path {
            folders.push(&self.spill);
        }
        for folder in folders {
            if let Err(error) = fs::remove_dir_all(folder) {
                tracing::warn!(folder = %folder.display(), %error, "the work folder could not be removed");
            }
        }
    }
}

/// The name of the folder for the work on an output, in the folder to spill to: always the same, and no other output's.
fn spill_name(output: &Path) -> Result<OsString, BuildError> {
    let parent = folder_of(output);
    let parent = fs::canonicalize(parent).map_err(|error| BuildError::io(parent, "find the folder", error))?;
    let output = parent.join(output.file_name().unwrap_or_default());
    let hash = xxh3_64(output.as_os_str().as_encoded_bytes());
    let mut name = output.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{hash:016x}.partial"));
    Ok(name)
}

/// Makes the folder, or takes over one that holds nothing but what a build leaves, and locks it. None: another build removed it
/// meanwhile.
fn lock(path: &Path) -> Result<Option<File>, BuildError> {
    match fs::create_dir(path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => match is_ours(path) {
            Ok(true) => {}
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Ok(false) | Err(_) => return Err(BuildError::NotOurs(path.to_owned())),
        },
        made => made.map_err(|error| BuildError::io(path, "make the work folder", error))?,
    }
    let cannot = |error| BuildError::io(path, "lock the work folder", error);
    let name = path.join(LOCK);
    let lock = match File::options().write(true).create(true).truncate(false).open(&name) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        opened => opened.map_err(cannot)?,
    };
    match lock.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => return Err(BuildError::Locked(path.to_owned())),
        Err(TryLockError::Error(error)) => return Err(cannot(error)),
    }
    let is_there = is_named(&lock, &name).map_err(cannot)?;
    Ok(is_there.then_some(lock))
}

/// Whether a folder holds nothing but files with the names that a build gives.
fn is_ours(path: &Path) -> io::Result<bool> {
    if !fs::symlink_metadata(path)?.is_dir() {
        return Ok(false);
    }
    for entry in fs::read_dir(path)? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_str().unwrap_or_default();
        let is_run = name
            .strip_prefix(RUN)
            .is_some_and(|number| number.parse::<u32>().is_ok());
        let is_known = [
            LOCK, TILES, COMPACTED, PLAN, "plan.new", JOURNAL, SPILL, BORDERS, SEGMENTS,
        ]
        .contains(&name);
        if !(is_run || is_known) || !entry.file_type()?.is_file() {
            return Ok(false);
        }
    }
    Ok(true)
}
