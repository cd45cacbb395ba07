//! What can go wrong with an export.

use std::io;

use crate::geometry::VertexIndex;
use crate::store::{ReadError, VertexId};

/// Why an export failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The tile file cannot be read, or is damaged, or a tile does not fit in the memory that its reader may use.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// An output does not take what is written; [`source`](std::error::Error::source) says why.
    #[error("cannot write the .{suffix} output")]
    Write {
        /// Which of the format's outputs.
        suffix: &'static str,
        /// What the system says.
        source: io::Error,
    },
    /// The format has no room for the triangulation.
    #[error("{0}")]
    Limit(String),
    /// The runtime was shut down under the export.
    #[error("the export was cancelled, because the runtime is shutting down")]
    Cancelled,
}

/// How a tile contradicts the directory or other tiles, in a way that only shows when it is exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Contradiction {
    /// A corner is no vertex of the tile that is said to own it.
    #[error("it has a triangle with vertex {vertex}, but tile {} has {vertices} vertices", vertex.tile)]
    NoSuchVertex {
        /// The corner.
        vertex: VertexId,
        /// The vertices of its tile.
        vertices: u32,
    },
    /// No tile owns a corner.
    #[error("it has a triangle with vertex {vertex}, but the file has {tiles} tiles")]
    NoSuchTile {
        /// The corner.
        vertex: VertexId,
        /// The tiles of the file.
        tiles: usize,
    },
    /// The z of this vertex is no number.
    #[error("vertex {0} has no finite z")]
    InfiniteZ(VertexIndex),
    /// Either the tile or the directory says that vertices have a z.
    #[error("it and the directory disagree on whether there is a z")]
    HasZ,
    /// A vertex comes from a record beyond those of all sources.
    #[error("vertex {vertex} is of record {record}, which no source has, by the directory")]
    NoSuchRecord {
        /// The vertex.
        vertex: VertexIndex,
        /// Its record.
        record: u64,
    },
}
