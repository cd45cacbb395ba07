//! The errors of questions about a surface.

use super::levels::LevelsError;
use crate::store::{ReadError, TileReader};

/// The error of a question about the surface of a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TerrainError {
    /// The tile file cannot be read or is damaged, or the memory that its reader may use does not
    /// suffice.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The file has no z.
    #[error("{file} has no z; build it from points that have z")]
    NoZ {
        /// The name of the file.
        file: String,
    },
    /// A line has no profile.
    #[error("the line has no profile: {reason}")]
    Line {
        /// What is wrong with the line.
        reason: String,
    },
    /// A sum is too large for a number, or is none because a height is infinite.
    #[error("{file}: the volume is too large to be a number; the heights of the file are too large")]
    TooLarge {
        /// The name of the file.
        file: String,
    },
    /// The surface has too many levels.
    #[error(transparent)]
    Levels(#[from] LevelsError),
}

impl TerrainError {
    /// Returns the error for a file that has no z.
    pub(crate) fn no_z(reader: &TileReader) -> Self {
        Self::NoZ {
            file: reader.name().to_owned(),
        }
    }
}
