//! The progress of an export: how many tiles are done, of those that its passes will read.

use parking_lot::Mutex;

use crate::store::PassReader;

/// Calls a function with the number of tiles done and the total after each tile.
pub(super) struct TilesDone<'a> {
    /// Behind a lock that is never contended, so that a future that holds it can move to other threads.
    progress: Mutex<&'a mut (dyn FnMut(u64, u64) + Send)>,
    done: u64,
    total: u64,
}

impl<'a> TilesDone<'a> {
    /// Starts before the pass that the surface may need, when the passes after it are not known: there
    /// is at least one.
    pub(super) fn new(progress: &'a mut (dyn FnMut(u64, u64) + Send), reader: &PassReader) -> Self {
        Self {
            progress: Mutex::new(progress),
            done: 0,
            total: 2 * u64::from(reader.metadata().tiles),
        }
    }

    /// Ends that pass: from now on, the total is what is done and what is [added](Self::add).
    pub(super) fn end_of_surface(&mut self) {
        self.total = self.done;
    }

    /// Adds tiles that will be read.
    pub(super) fn add(&mut self, tiles: u64) {
        self.total += tiles;
    }

    /// Reports that a tile is done.
    pub(super) fn advance(&mut self) {
        self.done += 1;
        self.progress.get_mut()(self.done, self.total);
    }
}
