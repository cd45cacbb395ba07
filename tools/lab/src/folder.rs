//! The folder that an experiment fills, and a scratch folder for temporary files.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use tempfile::TempDir;

use tiletool::common;
use tiletool::output;
use tiletool::plot;

/// The prefix of the names of scratch folders.
const PREFIX: &str = ".experiment-";
/// The name of a file in each scratch folder.
const LOCK: &str = "lock";

/// The folder for an experiment's results.
pub struct Folder {
    path: PathBuf,
    /// Removed with its content when the experiment ends. If the experiment was killed, the next
    /// one that fills the folder removes it.
    scratch: TempDir,
    /// A file in the scratch folder, locked while the experiment runs.
    _lock: File,
    results: Vec<(String, Vec<u8>)>,
}

impl Folder {
    /// Opens the folder; creates it if it does not exist.
    ///
    /// Fails, before anything is measured, if the folder cannot be created, is not a folder, or
    /// cannot be written to.
    pub fn create(path: &Path) -> anyhow::Result<Self> {
        let shown = path.display();
        if path.exists() && !path.is_dir() {
            bail!("{shown} is not a folder; -o names the folder for the results");
        }
        fs::create_dir_all(path).with_context(|| format!("{shown}: cannot make the folder for the results"))?;
        remove_dead(path);
        let scratch = tempfile::Builder::new().prefix(PREFIX).tempdir_in(path);
        let locked = scratch.and_then(|scratch| {
            let lock = File::create_new(scratch.path().join(LOCK))?;
            lock.try_lock()?;
            Ok((scratch, lock))
        });
        let (scratch, lock) =
            locked.with_context(|| format!("{shown}: cannot write into the folder for the results"))?;
        Ok(Self {
            path: path.to_owned(),
            scratch,
            _lock: lock,
            results: Vec::new(),
        })
    }

    /// Returns the folder for temporary files.
    pub fn scratch(&self) -> &Path {
        self.scratch.path()
    }

    /// Fails if fewer than `bytes` bytes are free on the disk. If the system does not report them,
    /// a later write fails instead.
    pub fn require(&self, bytes: u64) -> anyhow::Result<()> {
        let Ok(room) = rustix::fs::statvfs(self.scratch()) else {
            return Ok(());
        };
        let free = room.f_bavail.saturating_mul(room.f_frsize);
        if free < bytes {
            bail!(
                "{}: the experiment needs about {} of disk, and {} are free there; take smaller sizes or another folder",
                self.path.display(),
                common::bytes(bytes),
                common::bytes(free)
            );
        }
        Ok(())
    }

    /// Keeps a file, to be written at the end.
    pub fn keep(&mut self, name: &str, bytes: impl Into<Vec<u8>>) {
        self.results.push((name.to_owned(), bytes.into()));
    }

    /// Keeps a picture, to be written at the end; the suffix of `name` is its format: `.svg` or
    /// `.png`.
    pub fn keep_picture(&mut self, name: &str, svg: String) -> anyhow::Result<()> {
        let picture = plot::encode(Path::new(name), svg)?;
        self.keep(name, picture);
        Ok(())
    }

    /// Writes the kept files in the order in which they were kept, each as a whole or not at all,
    /// and prints their names.
    pub fn publish(self) -> anyhow::Result<()> {
        let mut written = String::new();
        for (name, bytes) in &self.results {
            let path = self.path.join(name);
            output::write(&path, bytes).with_context(|| format!("cannot write {}", path.display()))?;
            written += &format!("{}\n", path.display());
        }
        common::print("the names of the files", &written)
    }
}

/// Removes the scratch folders of killed experiments.
fn remove_dead(path: &Path) {
    let entries = fs::read_dir(path).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(PREFIX)) {
        let lock = File::open(entry.path().join(LOCK));
        if lock.is_ok_and(|lock| lock.try_lock().is_ok()) {
            // If it stays, the next experiment tries again.
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the names in a folder, sorted.
    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort_unstable();
        names
    }

    #[test]
    fn results_are_written_at_the_end_and_nothing_else_stays() {
        let outer = tempfile::tempdir().unwrap();
        let path = outer.path().join("a/b");
        let mut folder = Folder::create(&path).unwrap();
        fs::write(folder.scratch().join("large"), "x").unwrap();
        folder.keep("t.csv", "1\n");
        assert_eq!(names(&path).len(), 1);
        folder.publish().unwrap();
        assert_eq!(names(&path), ["t.csv"]);
        assert_eq!(fs::read(path.join("t.csv")).unwrap(), b"1\n");

        let mut folder = Folder::create(&path).unwrap();
        folder.keep("t.csv", "2\n");
        drop(folder);
        assert_eq!(names(&path), ["t.csv"]);
        assert_eq!(fs::read(path.join("t.csv")).unwrap(), b"1\n");
    }

    #[test]
    fn the_scratch_folder_of_a_killed_experiment_is_removed_and_that_of_a_running_one_stays() {
        let outer = tempfile::tempdir().unwrap();
        let dead = outer.path().join(".experiment-dead");
        fs::create_dir(&dead).unwrap();
        for name in [LOCK, "large"] {
            fs::write(dead.join(name), "x").unwrap();
        }
        let running = Folder::create(outer.path()).unwrap();
        assert!(!dead.exists());
        let other = Folder::create(outer.path()).unwrap();
        assert!(running.scratch().join(LOCK).exists());
        drop((running, other));
        assert!(names(outer.path()).is_empty());
    }

    #[test]
    fn an_unusable_folder_or_too_little_disk_is_refused() {
        let outer = tempfile::tempdir().unwrap();
        let file = outer.path().join("file");
        fs::write(&file, "").unwrap();
        let error = Folder::create(&file).err().unwrap();
        assert!(error.to_string().contains("is not a folder"), "{error}");
        assert!(Folder::create(&file.join("below")).is_err());
        let folder = Folder::create(outer.path()).unwrap();
        folder.require(1).unwrap();
        let error = folder.require(u64::MAX).unwrap_err();
        assert!(error.to_string().contains("of disk"), "{error}");
    }
}
