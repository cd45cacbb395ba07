//! The folder `OUT.partial/`, in which a file is completed before it gets its name.
//!
//! ```text
//! lock      locked while a build works here
//! tiles     the file that will be OUT
//! surface   the triangulation of the points alone, where lines or sites take their z from it
//! plan      the blocks, once all points arrived        ┐ of a build that outgrew the memory and
//! journal   the finished blocks                        │ whose inputs can be read again
//! lines     all segments, in the spill folder          ┘
//! inputs    the plan of the tasks that distribute the inputs, if any do
//! tasks     the settings of the tasks that conquer the blocks, if any do
//! spill     the path of the spill folder, if the build was given one
//! run-…     points of unfinished blocks                ┐ here, or in a folder of their own in the
//! borders   the border log                             ┘ spill folder that the build was given
//! segments  segments; its name is removed as soon as the file exists
//! input-…   an input that was distributed to runs    ┐ of tasks, where the runs are
//! segments-… segments of a block                     │
//! block-…   a block that was conquered               │
//! cores-…   the cores of its tiles                   ┘
//! elsewhere says that these cores are in an object store
//! ```

use std::ffi::OsString;
use std::fs::{File, Permissions, TryLockError};
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::{fs, io};

use tempfile::NamedTempFile;
use xxhash_rust::xxh3::xxh3_64;

use crate::constraints::segments::chunk_store::SEGMENTS;
use crate::io::{folder_of, is_manifest, is_named, output_target};
use crate::pipeline::error::BuildError;

const LOCK: &str = "lock";
const TILES: &str = "tiles";
/// Where [`TileReader::compact`](crate::store::TileReader::compact) rewrites `tiles`.
const COMPACTED: &str = ".tiles.partial";
const SURFACE: &str = "surface";
const PLAN: &str = "plan";
const JOURNAL: &str = "journal";
const SPILL: &str = "spill";
const BORDERS: &str = "borders";
const LINES: &str = "lines";
const INPUTS: &str = "inputs";
const INPUT: &str = "input-";
const TASKS: &str = "tasks";
const RUN: &str = "run-";
const BLOCK: &str = "block-";
const CORES: &str = "cores-";
const ELSEWHERE: &str = "elsewhere";
const SEGMENTS_OF: &str = "segments-";

/// A work folder: locked by the build that writes the file, or shared by tasks. It is removed on drop,
/// unless it is to be kept.
#[derive(Debug)]
pub(crate) struct WorkFolder {
    path: PathBuf,
    /// Where work is spilled to.
    spill: PathBuf,
    output: PathBuf,
    keep: AtomicBool,
    /// Whether the file has its name, so that nothing is left to keep.
    published: AtomicBool,
    /// Keeps the lock, if the folder is locked.
    _lock: Option<File>,
}

impl WorkFolder {
    /// Creates the folder, or takes over the one of a build that died. Removes its content unless
    /// `resume` is set. Work that could be resumed is removed only with `discard`: it may have taken
    /// hours.
    ///
    /// Does not touch a folder that contains anything but the files of a build.
    pub(crate) fn create(output: &Path, tmp: Option<&Path>, discard: bool, resume: bool) -> Result<Self, BuildError> {
        let path = path_for(output);
        let spill = match tmp {
            None => path.clone(),
            Some(tmp) => {
                let tmp = fs::canonicalize(tmp).map_err(|error| BuildError::io(tmp, "find the folder", error))?;
                tmp.join(spill_name(output)?)
            }
        };
        // A build that ends removes its folder and unlocks it. A build that locked the removed file
        // must try again.
        for _ in 0..100 {
            let Some(lock) = lock(&path)? else { continue };
            let this = Self {
                path,
                spill,
                output: output.to_owned(),
                // Until it is known that all the content is a build's.
                keep: AtomicBool::new(true),
                published: AtomicBool::new(false),
                _lock: Some(lock),
            };
            if !resume && !discard && this.can_be_resumed() {
                return Err(this.kept());
            }
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

    /// Opens the folder for tasks, beside other processes.
    pub(crate) fn shared(output: &Path) -> Result<Self, BuildError> {
        let path = path_for(output);
        let noted = fs::read(path.join(SPILL));
        let spill = match noted {
            Ok(noted) => PathBuf::from(OsString::from_vec(noted)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => path.clone(),
            Err(error) => return Err(BuildError::io(&path, "read the tasks in", error)),
        };
        Ok(Self {
            path,
            spill,
            output: output.to_owned(),
            keep: AtomicBool::new(true),
            published: AtomicBool::new(false),
            _lock: None,
        })
    }

    /// Creates the folder to spill to, or takes over the one of an earlier build.
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

    /// Returns whether the folder holds the work of an interrupted build that could be resumed.
    fn can_be_resumed(&self) -> bool {
        (self.plan().exists() || self.inputs().exists()) && !self.was_published()
    }

    /// Returns the error about work that is kept.
    fn kept(&self) -> BuildError {
        let noted = fs::read(self.path.join(SPILL)).map(|path| PathBuf::from(OsString::from_vec(path)));
        let folders = [Some(self.path.clone()), noted.ok()];
        let entries = folders.into_iter().flatten().flat_map(fs::read_dir).flatten().flatten();
        BuildError::WorkKept {
            path: self.path.clone(),
            bytes: entries.filter_map(|entry| Some(entry.metadata().ok()?.len())).sum(),
        }
    }

    /// Saves the path of the spill folder, so that a later build of this output finds it.
    fn note_spill(&self) -> io::Result<()> {
        match self.spill == self.path {
            true => Ok(()),
            false => fs::write(self.path.join(SPILL), self.spill.as_os_str().as_bytes()),
        }
    }

    /// Removes the folder that a killed build spilled to, if this build spills elsewhere.
    fn forget_spill(&self) {
        let Ok(noted) = fs::read(self.path.join(SPILL)) else {
            return;
        };
        let noted = PathBuf::from(OsString::from_vec(noted));
        let is_its = spill_name(&self.output).is_ok_and(|name| noted.file_name() == Some(&name));
        // Other files in the spill folder are not touched.
        if noted != self.spill && is_its && is_ours(&noted).unwrap_or(false) {
            let _ = fs::remove_dir_all(&noted);
        }
    }

    /// Removes everything that an earlier build left.
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

    /// Sets whether the folder is kept on drop.
    pub(crate) fn keep(&self, keep: bool) {
        let published = self.published.load(Ordering::Relaxed);
        self.keep.store(keep && !published, Ordering::Relaxed);
    }

    /// Returns the path of the output.
    pub(crate) fn output(&self) -> &Path {
        &self.output
    }

    /// Returns the path of the folder.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the folder that work is spilled to.
    pub(crate) fn spill(&self) -> &Path {
        &self.spill
    }

    /// Returns the path of the file that is being built.
    pub(crate) fn file(&self) -> PathBuf {
        self.path.join(TILES)
    }

    /// Makes the file that was built the surface, so that another file can be built. Returns its
    /// path.
    pub(crate) fn set_surface_aside(&self) -> io::Result<PathBuf> {
        let surface = self.surface();
        fs::rename(self.file(), &surface)?;
        Ok(surface)
    }

    /// Returns the path of the surface.
    pub(crate) fn surface(&self) -> PathBuf {
        self.path.join(SURFACE)
    }

    /// Returns the path of the saved segments.
    pub(crate) fn lines(&self) -> PathBuf {
        self.spill.join(LINES)
    }

    /// Returns the path of the plan of blocks.
    pub(crate) fn plan(&self) -> PathBuf {
        self.path.join(PLAN)
    }

    /// Returns the path of the plan of input tasks.
    pub(crate) fn inputs(&self) -> PathBuf {
        self.path.join(INPUTS)
    }

    /// Returns the path of the output of an input task.
    pub(crate) fn input(&self, input: u32) -> PathBuf {
        self.spill.join(format!("{INPUT}{input}"))
    }

    /// Removes the plan of blocks, and what belongs to it.
    pub(crate) fn forget_plan(&self) {
        for file in [self.plan(), self.journal(), self.tasks()] {
            // It may not be there.
            let _ = fs::remove_file(file);
        }
    }

    /// Returns the path of the settings of tasks.
    pub(crate) fn tasks(&self) -> PathBuf {
        self.path.join(TASKS)
    }

    /// Returns the path of the segments of a block, for its task.
    pub(crate) fn segments_of(&self, block: u32) -> PathBuf {
        self.spill.join(format!("{SEGMENTS_OF}{block}"))
    }

    /// Returns the path of a block that a task conquered.
    pub(crate) fn block(&self, block: u32) -> PathBuf {
        self.spill.join(format!("{BLOCK}{block}"))
    }

    /// Returns the path of the cores of a block that a task conquered.
    pub(crate) fn cores_of(&self, block: u32) -> PathBuf {
        self.spill.join(Self::cores_name(block))
    }

    /// Returns the file name of the cores of a block, here and among the parts of the file.
    pub(crate) fn cores_name(block: u32) -> String {
        format!("{CORES}{block}")
    }

    /// Removes a block that a task conquered.
    pub(crate) fn remove_block(&self, block: u32) -> io::Result<()> {
        fs::remove_file(self.block(block))?;
        match fs::remove_file(self.cores_of(block)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
            removed => removed,
        }
    }

    /// Returns whether the cores of blocks need not be here, since they are in an object store.
    pub(crate) fn has_cores_elsewhere(&self) -> bool {
        self.path.join(ELSEWHERE).exists()
    }

    /// Notes that the cores of blocks are in an object store.
    pub(crate) fn set_cores_elsewhere(&self) -> io::Result<()> {
        File::create(self.path.join(ELSEWHERE)).map(drop)
    }

    /// Returns whether the output will be in parts: a manifest of files, of which the cores of blocks stay
    /// as they are.
    pub(crate) fn is_in_parts(&self) -> bool {
        is_manifest(&self.output)
    }

    /// Makes a file that will take the place of another one in the folder, once it is complete.
    pub(crate) fn replace(path: &Path) -> io::Result<NamedTempFile> {
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(".");
        // It may stay, and is then readable as other files are.
        let mut builder = tempfile::Builder::new();
        builder.prefix(&name).permissions(Permissions::from_mode(0o666));
        builder.tempfile_in(folder_of(path))
    }

    /// Returns the path of the journal of finished blocks.
    pub(crate) fn journal(&self) -> PathBuf {
        self.path.join(JOURNAL)
    }

    /// Returns whether the folder is of a build that was killed after it had given its file its
    /// name and before it cleaned up.
    pub(crate) fn was_published(&self) -> bool {
        self.journal().exists() && !self.file().exists()
    }

    /// Returns the path of the border log.
    pub(crate) fn borders(&self) -> PathBuf {
        self.spill.join(BORDERS)
    }

    /// Gives the completed file its name, and brings the name onto the medium if `sync` is set. The
    /// folder is then removed on drop.
    pub(crate) fn publish(&self, sync: bool) -> Result<(), BuildError> {
        let output = &self.output;
        let folder = folder_of(output);
        let cannot = |error| BuildError::io(folder, "sync the folder", error);
        // The folder is opened before the rename, so that a failure leaves an existing output in
        // place.
        let opened = File::open(folder).map_err(cannot)?;
        output_target(output)
            .and_then(|_| fs::rename(self.file(), output))
            .map_err(|e| BuildError::io(output, "rename the finished file to", e))?;
        self.set_published();
        match sync {
            true => opened.sync_all().map_err(cannot),
            false => Ok(()),
        }
    }

    /// Notes that the completed file has its name. The folder is then removed on drop.
    pub(crate) fn set_published(&self) {
        // Where it has a name here too, a build that is killed now must not be resumed.
        let _ = fs::remove_file(self.file());
        self.published.store(true, Ordering::Relaxed);
        self.keep(false);
    }
}

impl Drop for WorkFolder {
    fn drop(&mut self) {
        if self.keep.load(Ordering::Relaxed) {
            return;
        }
        // A build that is killed while it cleans up must not leave a plan without the files that it
        // names.
        for plan in [self.plan(), self.inputs()] {
            let _ = fs::remove_file(plan);
        }
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

/// Opens a file for reading and for writing after its first `length` bytes. Truncates it to
/// `length` bytes.
pub(crate) fn open_at(path: &Path, length: u64, what: &'static str) -> Result<File, BuildError> {
    let mut options = File::options();
    options.read(true).write(true).create(true).truncate(false);
    let file = options.open(path).and_then(|file| {
        file.set_len(length)?;
        Ok(file)
    });
    file.map_err(|error| BuildError::io(path, what, error))
}

/// Returns the path of the work folder of an output.
fn path_for(output: &Path) -> PathBuf {
    let mut name = OsString::from(output);
    name.push(".partial");
    PathBuf::from(name)
}

/// Returns the name of an output's folder within the folder to spill to. It is always the same, and
/// no other output has it.
fn spill_name(output: &Path) -> Result<OsString, BuildError> {
    let parent = folder_of(output);
    let parent = fs::canonicalize(parent).map_err(|error| BuildError::io(parent, "find the folder", error))?;
    let output = parent.join(output.file_name().unwrap_or_default());
    let hash = xxh3_64(output.as_os_str().as_encoded_bytes());
    let mut name = output.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{hash:016x}.partial"));
    Ok(name)
}

/// Creates the folder, or takes over one that contains only files of a build, and locks it. Returns
/// `None` if another build removed it meanwhile.
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

/// Returns whether a folder contains only files with names that a build uses.
fn is_ours(path: &Path) -> io::Result<bool> {
    if !fs::symlink_metadata(path)?.is_dir() {
        return Ok(false);
    }
    for entry in fs::read_dir(path)? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_str().unwrap_or_default();
        // Those of tasks have another name while they are incomplete.
        let complete = name.split_once('.').map_or(name, |(complete, _)| complete);
        let is_number = |number: &str| number.parse::<u32>().is_ok();
        let is_numbered = [RUN, INPUT, BLOCK, CORES, SEGMENTS_OF]
            .iter()
            .any(|of| complete.strip_prefix(of).is_some_and(is_number));
        let is_known = [
            LOCK, TILES, SURFACE, COMPACTED, PLAN, "plan.new", JOURNAL, SPILL, BORDERS, LINES, SEGMENTS, ELSEWHERE,
        ]
        .contains(&name);
        if !(is_numbered || is_known || [TASKS, INPUTS].contains(&complete)) || !entry.file_type()?.is_file() {
            return Ok(false);
        }
    }
    Ok(true)
}
