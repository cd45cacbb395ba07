//! Detects changes of files that a command opens more than once.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use delaunay_tiles::input::{FileStamp, InputError};

/// The files that were opened so far, each with its stamp of the first time.
#[derive(Debug, Default)]
pub struct Unchanged(Mutex<HashMap<PathBuf, FileStamp>>);

impl Unchanged {
    /// Records the stamps of files.
    ///
    /// # Errors
    /// Fails if a file changed since it was first recorded.
    pub fn check<'a>(&self, files: impl IntoIterator<Item = &'a (PathBuf, FileStamp)>) -> Result<(), InputError> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for (path, stamp) in files {
            let before = *known.entry(path.clone()).or_insert(*stamp);
            if let Some(what) = stamp.change_since(&before) {
                let path = path.clone();
                return Err(InputError::Changed { path, what });
            }
        }
        Ok(())
    }
}
