//! The memory in which overviews are made.

/// The shares of the memory in which overviews are made and proven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OverviewShares(pub(crate) u64);

impl OverviewShares {
    /// Returns the bytes for a pass over the tiles of the finer level.
    pub(crate) fn pass(self) -> u64 {
        self.0 / 4
    }

    /// Returns the bytes for tiles of one coarser level in its cache, if there are `levels`.
    pub(crate) fn coarser(self, levels: usize) -> u64 {
        self.0 / 4 / levels.max(1) as u64
    }

    /// Returns the bytes for chosen vertices; the rest of them goes to the disk.
    pub(crate) fn chosen(self) -> u64 {
        self.0 / 8
    }

    /// Returns the bytes for building a level, while the one before it is read back.
    pub(crate) fn build(self) -> u64 {
        self.0 / 2
    }
}
