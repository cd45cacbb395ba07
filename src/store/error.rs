//! Errors of reading a tile file.

use std::io;
use std::sync::Arc;

use crate::store::format::ids::TileId;

/// The reason why a tile file could not be read.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The operating system returned an error.
    #[error("{file}: cannot read {what}")]
    Io {
        /// The name of the file.
        file: Arc<str>,
        /// The part that was read.
        what: String,
        /// The error of the operating system.
        source: Arc<io::Error>,
    },
    /// The file is no tile file, or has a format version or features that this library does not
    /// support, or its directory is damaged.
    #[error("{file}: {reason}")]
    Invalid {
        /// The name of the file.
        file: Arc<str>,
        /// What is wrong.
        reason: String,
    },
    /// A tile is damaged.
    #[error("{file}: tile {tile} at byte {offset} is damaged: {reason}")]
    Tile {
        /// The name of the file.
        file: Arc<str>,
        /// The tile.
        tile: TileId,
        /// The offset of its core in the file.
        offset: u64,
        /// What is wrong.
        reason: String,
    },
    /// The file has no tile of this number.
    #[error("{file}: there is no tile {tile}; the file has {tiles}, numbered from 0")]
    NoSuchTile {
        /// The name of the file.
        file: Arc<str>,
        /// The number of the requested tile.
        tile: TileId,
        /// The number of tiles in the file.
        tiles: usize,
    },
    /// The operation needs more memory than the reader may use.
    #[error(
        "{file}: this needs at least {needed} MiB of memory, but only {allowed} MiB are allowed; allow more",
        needed = needed.div_ceil(1 << 20), allowed = allowed >> 20
    )]
    Memory {
        /// The name of the file.
        file: Arc<str>,
        /// The memory needed, in bytes.
        needed: u64,
        /// The memory allowed, in bytes.
        allowed: u64,
    },
    /// The operating system refused to start a thread.
    #[error("cannot compute")]
    Thread(#[source] Arc<io::Error>),
    /// The load ended without a result.
    #[error("the load was cancelled: its task panicked, or the runtime is shutting down")]
    Cancelled,
}

impl ReadError {
    pub(crate) fn thread(error: io::Error) -> Self {
        Self::Thread(Arc::new(error))
    }
}
