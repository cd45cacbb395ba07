//! Options of an editor.

use crate::memory::default_memory;

/// Where a transaction is on the medium when its commit returns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Durability {
    /// In the file. A commit writes each tile that the changes touch, and the directory.
    #[default]
    File,
    /// In a log beside the file, `NAME.log`, where it takes a few dozen bytes for each change. The
    /// changes are made in the file by a [checkpoint](crate::Editor::checkpoint), many at once. Until
    /// then readers do not see them. If the process ends before, the next editor of the file makes
    /// them as it opens it.
    ///
    /// Only small transactions that change points of files with nothing but points, and with
    /// triangles, go to the log. Any other one makes a checkpoint, and then its changes in the file.
    Log,
}

/// Options of an [`Editor`](crate::Editor).
///
/// # Example
///
/// ```
/// use delaunay_tiles::{Durability, EditOptions};
///
/// let options = EditOptions::default().memory(64 << 20).durability(Durability::Log);
/// assert_eq!(options.memory, 64 << 20);
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct EditOptions {
    /// Bytes of memory for each transaction.
    pub memory: u64,
    /// Where a transaction is on the medium when its commit returns.
    pub durability: Durability,
}

impl Default for EditOptions {
    fn default() -> Self {
        Self {
            memory: default_memory(),
            durability: Durability::default(),
        }
    }
}

impl EditOptions {
    /// Sets the bytes of memory for each transaction. By default it is the same as for builds.
    #[must_use]
    pub fn memory(mut self, bytes: u64) -> Self {
        self.memory = bytes;
        self
    }

    /// Sets where a transaction is on the medium when its commit returns.
    #[must_use]
    pub fn durability(mut self, durability: Durability) -> Self {
        self.durability = durability;
        self
    }
}
