//! The tiles that queries used, for those who want to know what an answer took.

use std::sync::Arc;

use foldhash::HashSet;
use parking_lot::Mutex;

use crate::store::TileId;

/// Collects the different tiles that queries use, from the file or from the cache: see
/// [`QueryOptions::tiles_used`](crate::query::request::options::QueryOptions::tiles_used).
#[derive(Clone, Debug, Default)]
pub struct TilesUsed(Arc<Mutex<HashSet<TileId>>>);

impl TilesUsed {
    /// Returns the number of different tiles.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.0.lock().len() as u64
    }

    /// Returns the tiles, in ascending order.
    #[must_use]
    pub fn tiles(&self) -> Vec<TileId> {
        let mut tiles: Vec<_> = self.0.lock().iter().copied().collect();
        tiles.sort_unstable();
        tiles
    }

    pub(crate) fn add(&self, id: TileId) {
        self.0.lock().insert(id);
    }
}
