//! Reading cold: what the system keeps of the file in memory is thrown out.

use std::fs::{self, File};
use std::path::Path;

use anyhow::Context;
use rustix::fs::{Advice, fadvise};

/// Where Linux drops all caches; only its owner may.
const DROP_CACHES: &str = "/proc/sys/vm/drop_caches";

/// Throws the file out of the page cache, and with it all other files if we may. Whether we could is the answer.
pub fn drop_for(path: &Path) -> anyhow::Result<bool> {
    drop_file(path)?;
    Ok(fs::write(DROP_CACHES, "1").is_ok())
}

/// Throws the file out of the page cache.
pub fn drop_file(path: &Path) -> anyhow::Result<()> {
    let file = File::open(path).with_context(|| format!("cannot open {}", crate::common::shown(path)))?;
    // What is not on the medium cannot be thrown out.
    let _ = file.sync_all();
    let advised = fadvise(&file, 0, None, Advice::DontNeed);
    advised.with_context(|| format!("cannot throw {} out of the page cache", crate::common::shown(path)))
}
