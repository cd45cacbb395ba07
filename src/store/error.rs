//! What goes wrong when a tile file is read.

use std::io;
use std::sync::Arc;

use crate::store::format::ids::TileId;

/// Why a tile file could not be read.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The system refused.
    #[error("{file}: cannot read {what}")]
    Io {
        /// The file.
        file: Arc<str>,
        /// What was to be read.
        what: String,
        /// What the system says.
        source: Arc<io::Error>,
    },
    /// The file is no tile file, or not one that this library reads, or its directory is damaged.
    #[error("{file}: {reason}")]
    Invalid {
        /// The file.
        file: Arc<str>,
        /// What is wrong.
        reason: String,
    },
    /// A tile is damaged.
    #[error("{file}: tile {tile} at byte {offset} is damaged: {reason}")]
    Tile {
        /// The file.
        file: Arc<str>,
        /// The tile.
        tile: TileId,
        /// Where its core lies.
        offset: u64,
        /// What is wrong.
        reason: String,
    },
    /// The file has no tile of this number.
    #[error("{file}: there is no tile {tile}; the file has {tiles}, numbered from 0")]
    NoSuchTile {
        /// The file.
        file: Arc<str>,
        /// The number asked for.
        tile: TileId,
        /// Tiles in the file.
        tiles: usize,
    },
    /// What was asked for needs more memory than the reader may use.
    #[error(
        "{file}: this takes {needed} MiB of memory at least, and {allowed} MiB are allowed; allow more",
        needed = needed.div_ceil(1 << 20), allowed = allowed >> 20
    )]
    Memory {
        /// The file.
        file: Arc<str>,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        allowed: u64,
    },
    /// The system refused a thread to compute on.
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
