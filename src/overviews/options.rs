//! How overviews are made.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::thread::available_parallelism;

use crate::memory::default_memory;
use crate::pipeline::Progress;

/// How overviews are made. Nothing of it affects which vertices they have.
#[derive(Clone, Debug)]
pub struct OverviewOptions {
    pub(super) memory: u64,
    pub(super) threads: usize,
    pub(super) again: bool,
    pub(super) progress: Arc<OverviewProgress>,
}

impl Default for OverviewOptions {
    fn default() -> Self {
        Self {
            memory: default_memory(),
            threads: available_parallelism().map_or(1, usize::from),
            again: false,
            progress: Arc::default(),
        }
    }
}

impl OverviewOptions {
    /// Sets the bytes of memory that may be used; by default as for a build.
    #[must_use]
    pub fn memory(self, memory: u64) -> Self {
        Self { memory, ..self }
    }

    /// Sets the number of threads that compute; by default as many as the machine can run at once.
    #[must_use]
    pub fn threads(self, threads: usize) -> Self {
        Self {
            threads: threads.max(1),
            ..self
        }
    }

    /// Sets whether overviews are made again even if those of the file are not stale; false by default.
    #[must_use]
    pub fn again(self, again: bool) -> Self {
        Self { again, ..self }
    }

    /// Sets where the progress is noted.
    #[must_use]
    pub fn progress(self, progress: Arc<OverviewProgress>) -> Self {
        Self { progress, ..self }
    }
}

/// How far overviews are, shared between those who make them and those who look on.
#[derive(Debug, Default)]
pub struct OverviewProgress {
    level: AtomicU32,
    done: AtomicU64,
    total: AtomicU64,
    /// Cancels builds too.
    pub(super) builds: Arc<Progress>,
}

impl OverviewProgress {
    /// Returns the level in work, from 1; 0 while the errors of all levels are measured. Also returns
    /// the number of tiles that the pass in work has done, and of all its tiles. There are several passes
    /// for each level.
    #[must_use]
    pub fn state(&self) -> (u32, u64, u64) {
        let read = |number: &AtomicU64| number.load(Ordering::Relaxed);
        (self.level.load(Ordering::Relaxed), read(&self.done), read(&self.total))
    }

    /// Asks to stop. [`make`](super::make) then returns
    /// [`OverviewError::Cancelled`](super::OverviewError::Cancelled).
    pub fn cancel(&self) {
        self.builds.cancel();
    }

    pub(super) fn is_cancelled(&self) -> bool {
        self.builds.is_cancelled()
    }

    pub(super) fn start(&self, level: u32, tiles: u64) {
        self.level.store(level, Ordering::Relaxed);
        self.done.store(0, Ordering::Relaxed);
        self.total.store(tiles, Ordering::Relaxed);
    }

    pub(super) fn advance(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }
}
