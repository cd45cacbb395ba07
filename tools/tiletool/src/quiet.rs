//! Whether the tool says only what it was asked for.
//!
//! One value for the process, as for its log: what is quiet is standard error, which all commands share.

use std::sync::atomic::{AtomicBool, Ordering};

static QUIET: AtomicBool = AtomicBool::new(false);

/// Says whether notes, progress and summaries are left out.
pub fn set(is_quiet: bool) {
    QUIET.store(is_quiet, Ordering::Relaxed);
}

/// Returns whether notes, progress and summaries are left out.
pub fn is_set() -> bool {
    QUIET.load(Ordering::Relaxed)
}
