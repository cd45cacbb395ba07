//! The memory of an open file: its cache, and the passes over its tiles.

/// Bytes of a reader's own cache, if the reader may use at least eight times as much memory.
const DEFAULT_CACHE: u64 = 64 << 20;

/// Bytes for a pass with lookups, if there is no limit.
const LOOKUP_MEMORY: u64 = 512 << 20;

/// The memory that the reader of a file may use, in bytes, and its shares. `None` means no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FileShares(pub(crate) Option<u64>);

impl FileShares {
    /// Returns the bytes of the reader's own cache.
    pub(crate) fn cache(self) -> usize {
        self.0.map_or(DEFAULT_CACHE, |memory| DEFAULT_CACHE.min(memory / 8)) as usize
    }

    /// Returns the bytes that a pass may take for tiles and for what it computes from them, or
    /// `None` without a limit. The rest is for results in transit, for input that is read, and for
    /// fragmentation of the heap.
    pub(crate) fn pass(self) -> Option<u64> {
        self.0.map(|memory| memory - memory / 16)
    }

    /// Returns the bytes of the lookups that a pass does at once, if the pass itself needs `least`
    /// bytes. More lookups at once mean fewer passes, but tiles that are read ahead make the passes
    /// faster.
    pub(crate) fn lookups(self, least: u64) -> u64 {
        let tiles = Self(self.0.or(Some(LOOKUP_MEMORY))).pass().unwrap_or(LOOKUP_MEMORY);
        tiles.saturating_sub(least) / 4 * 3
    }
}
