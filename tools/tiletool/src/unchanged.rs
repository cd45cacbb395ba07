//! Files that a command opens more than once must be the same each time.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use delaunay_tiles::input::{FileStamp, InputError};

/// Files that were opened by now, as they were the first time.
#[derive(Debug, Default)]
pub struct Unchanged(Mutex<HashMap<PathBuf, FileStamp>>);

impl Unchanged {
    /// Notes files, and fails if one is not what it was before.
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
