//! Drops the system's caches of a file, so that it is read cold.

use std::fs::{self, File};
use std::io;
use std::path::Path;

use anyhow::Context;

/// The file that makes Linux drop all caches. Only root may write it.
const DROP_CACHES: &str = "/proc/sys/vm/drop_caches";

/// Drops the file from the page cache, and also all other files if this process may do so. Returns
/// whether it may.
pub fn drop_for(path: &Path) -> anyhow::Result<bool> {
    drop_file(path)?;
    Ok(fs::write(DROP_CACHES, "1").is_ok())
}

/// Drops the file from the page cache. Fails where the system has no way to do that, as that of Apple.
pub fn drop_file(path: &Path) -> anyhow::Result<()> {
    let file = File::open(path).with_context(|| format!("cannot open {}", crate::common::shown(path)))?;
    // Pages that are not yet on the disk cannot be dropped.
    let _ = file.sync_all();
    drop_pages(&file).with_context(|| format!("cannot drop {} from the page cache", crate::common::shown(path)))
}

#[cfg(not(target_vendor = "apple"))]
fn drop_pages(file: &File) -> io::Result<()> {
    Ok(rustix::fs::fadvise(file, 0, None, rustix::fs::Advice::DontNeed)?)
}

#[cfg(target_vendor = "apple")]
fn drop_pages(_: &File) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
