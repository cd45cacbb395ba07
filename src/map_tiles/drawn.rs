//! What a drawing may take, what it gives, and why it may fail.

use std::time::Instant;

use bytes::Bytes;

use crate::map_tiles::layer::Layer;
use crate::store::ReadError;

/// What a drawing may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawLimits {
    /// The maximum number of tiles of the file and its overviews that may be opened.
    pub max_tiles: u32,
    /// When the drawing ends with an error. It is checked between steps, each of which takes
    /// milliseconds.
    pub deadline: Option<Instant>,
}

impl Default for DrawLimits {
    /// Returns 64 tiles, and no deadline.
    fn default() -> Self {
        Self {
            max_tiles: 64,
            deadline: None,
        }
    }
}

impl DrawLimits {
    /// Fails if the deadline has passed.
    pub(super) fn check(&self) -> Result<(), DrawError> {
        match self.deadline {
            Some(deadline) if Instant::now() >= deadline => Err(DrawError::TimedOut),
            _ => Ok(()),
        }
    }
}

/// A map tile.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Drawn {
    /// The tile in its format; empty if the file has nothing there.
    pub bytes: Bytes,
    /// The number of tiles of the file and its overviews that were needed. Some may have come from
    /// the cache.
    pub tiles: u32,
}

impl Drawn {
    /// The tile where nothing is.
    pub(super) const NOTHING: Self = Self {
        bytes: Bytes::new(),
        tiles: 0,
    };

    /// Returns whether the file has nothing there.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }
}

/// The reason why a file has no tiles in a grid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoGrid {
    /// The file is not known to be on Earth.
    #[error("the file names no coordinate reference system, so its place on Earth is unknown")]
    NoCrs,
    /// The coordinate reference system cannot be transformed.
    #[error("the coordinate reference system of the file, {crs}, cannot be transformed: {reason}")]
    Unsupported {
        /// The system in a few words.
        crs: String,
        /// Why it cannot be.
        reason: String,
    },
    /// The coordinates do not fit the coordinate reference system.
    #[error("the coordinates of the file are outside its coordinate reference system, {crs}")]
    Outside {
        /// The system in a few words.
        crs: String,
    },
    /// The file has no vertices.
    #[error("the file is empty")]
    Empty,
    /// Terrain needs heights.
    #[error("the vertices of the file have no z")]
    NoHeights,
}

/// The reason why a map tile was not drawn.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DrawError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The tile needs more tiles of the file than it may.
    #[error(
        "this needs at least {needed} tiles of the file, but only {allowed} are allowed; zoom in, or store overviews in the file"
    )]
    OutOfBudget {
        /// The number of tiles needed is at least this.
        needed: u32,
        /// The number of tiles allowed.
        allowed: u32,
    },
    /// The file has no tiles in the grid.
    #[error(transparent)]
    NoGrid(#[from] NoGrid),
    /// The file has no such layer.
    #[error("the file has no layer {0}, because its vertices have no z")]
    NoLayer(Layer),
    /// The deadline has passed.
    #[error("the drawing took longer than it may")]
    TimedOut,
}
