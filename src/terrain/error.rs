//! The errors of questions about a surface.

use super::levels::LevelsError;
use crate::store::ReadError;

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
    /// The surface has too many levels.
    #[error(transparent)]
    Levels(#[from] LevelsError),
}
