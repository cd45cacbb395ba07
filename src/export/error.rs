//! The errors of an export.

use std::io;

use crate::geometry::VertexIndex;
use crate::store::{ReadError, VertexId};
use crate::terrain::TerrainError;

/// The error of a failed export.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The tile file cannot be read or is damaged, or a tile does not fit in the memory that its
    /// reader may use.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// An output failed; [`source`](std::error::Error::source) has the reason.
    #[error("cannot write the .{suffix} output")]
    Write {
        /// The suffix of the format's output that failed.
        suffix: &'static str,
        /// The operating system's error.
        source: io::Error,
    },
    /// A surface cannot be exported.
    #[error(transparent)]
    Terrain(TerrainError),
    /// The temporary file of an export failed.
    #[error("cannot write a temporary file: {source}")]
    Scratch {
        /// The operating system's error.
        source: io::Error,
    },
    /// The triangulation exceeds a limit of the format.
    #[error("{0}")]
    Limit(String),
    /// The runtime was shut down during the export.
    #[error("the export was cancelled, because the runtime is shutting down")]
    Cancelled,
}

impl From<TerrainError> for ExportError {
    fn from(error: TerrainError) -> Self {
        match error {
            TerrainError::Read(error) => Self::Read(error),
            error @ (TerrainError::NoZ { .. } | TerrainError::Levels(_)) => Self::Terrain(error),
        }
    }
}

/// A contradiction of a tile to the directory or to other tiles that only an export detects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Contradiction {
    /// A corner is not a vertex of the tile that should own it.
    #[error("it has a triangle with vertex {vertex}, but tile {} has {vertices} vertices", vertex.tile)]
    NoSuchVertex {
        /// The corner.
        vertex: VertexId,
        /// The number of vertices of that tile.
        vertices: u32,
    },
    /// No tile owns a corner.
    #[error("it has a triangle with vertex {vertex}, but the file has {tiles} tiles")]
    NoSuchTile {
        /// The corner.
        vertex: VertexId,
        /// The number of tiles in the file.
        tiles: usize,
    },
    /// Only one of the tile and the directory says that vertices have a z.
    #[error("it and the directory disagree on whether there is a z")]
    HasZ,
    /// A vertex comes from a record beyond those of all sources.
    #[error("vertex {vertex} is of record {record}, but the directory has no source with that record")]
    NoSuchRecord {
        /// The vertex.
        vertex: VertexIndex,
        /// The number of its record.
        record: u64,
    },
    /// A number exceeds what signed numbers of 64 bits hold, of which no sound file comes near.
    #[cfg(any(feature = "flatgeobuf", feature = "parquet"))]
    #[error("it has the number {0}")]
    TooLarge(u64),
}
