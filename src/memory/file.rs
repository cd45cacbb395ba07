//! The memory of an open file: its cache, and passes over its tiles.

/// Bytes of the cache that a reader makes for itself, if it may use eight times as much memory.
const DEFAULT_CACHE: u64 = 64 << 20;

/// Bytes that a pass which looks things up uses if there is no limit.
const LOOKUP_MEMORY: u64 = 512 << 20;

/// Who gets how much of the memory that the reader of a file may use; `None` is no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FileShares(pub(crate) Option<u64>);

impl FileShares {
    /// Bytes of the reader's own cache.
    pub(crate) fn cache(self) -> usize {
        self.0.map_or(DEFAULT_CACHE, |memory| DEFAULT_CACHE.min(memory / 8)) as usize
    }

    /// Bytes that a pass may take for tiles and what is computed with them. The rest is for what was computed and is on its
    /// way, input that is read, and holes in the heap.
    pub(crate) fn pass(self) -> Option<u64> {
        self.0.map(|memory| memory - memory / 16)
    }

    /// Bytes of what is looked up at once, in a pass that takes `least` in any case. The more at once, the fewer passes; but
    /// tiles that are read ahead make these faster.
    pub(crate) fn lookups(self, least: u64) -> u64 {
        let tiles = Self(self.0.or(Some(LOOKUP_MEMORY))).pass().unwrap_or(LOOKUP_MEMORY);
        tiles.saturating_sub(least) / 4 * 3
    }
}
