//! Drops the system's caches of a file, so that it is read cold.

use std::fs::{self, File};
use std::path::Path;

use anyhow::Context;
use rustix::fs::{Advice, fadvise};

/// The file that makes Linux drop all caches. Only root may write it.
const DROP_CACHES: &str = "/proc/sys/vm/drop_caches";

/// Drops the file from the page cache, and also all other files if this process may do so. Returns
/// whether it may.
pub fn drop_for(path: &Path) -> anyhow::Result<bool> {
    drop_file(path)?;
    Ok(fs::write(DROP_CACHES, "1").is_ok())
}

/// Drops the file from the page cache.
pub fn drop_file(path: &Path) -> anyhow::Result<()> {
    let file = File::open(path).with_context(|| format!("cannot open {}", crate::common::shown(path)))?;
    // Pages that are not yet on the disk cannot be dropped.
    let _ = file.sync_all();
    let advised = fadvise(&file, 0, None, Advice::DontNeed);
    advised.with_context(|| format!("cannot drop {} from the page cache", crate::common::shown(path)))
}
