//! A build that makes the next state of a file, instead of a new file.

use std::sync::Arc;

use crate::edit::{EditSummary, Target, Work};
use crate::store::{Directory, InForce, Metadata};

/// What makes a build the next state of a file.
pub(crate) struct NextState {
    /// The superblock of the state before.
    pub(crate) before: InForce,
    /// Makes the directory of the next state from that of the tiles that were built.
    pub(crate) directory: Box<dyn FnOnce(Directory) -> Directory + Send + Sync>,
    /// An edit of the file that was built, before it gets its name.
    pub(crate) work: Option<Arc<Work>>,
    /// Whether the file stays as it is.
    pub(crate) is_dry_run: bool,
}

/// The next state of a file.
pub(crate) struct NextStateSummary {
    pub(crate) metadata: Metadata,
    pub(crate) tiles: u64,
    pub(crate) file_bytes: u64,
    /// The result of the edit of the file that was built.
    pub(crate) edited: Option<EditSummary>,
    /// The file, locked since before it got its name; `None` after a dry run.
    pub(crate) locked: Option<Target>,
}
