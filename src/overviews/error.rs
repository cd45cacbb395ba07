//! Errors of making overviews.

use std::io;
use std::path::{Path, PathBuf};

use crate::edit::EditError;
use crate::pipeline::BuildError;
use crate::shown;
use crate::store::ReadError;

/// The reason why overviews could not be made. The file is unchanged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OverviewError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The file cannot be changed.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// A level cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// An operation failed.
    #[error("{path}: cannot {what}", path = shown::path(path))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The operation.
        what: &'static str,
        /// The system's error.
        source: io::Error,
    },
    /// There is a folder with the name of the work folder that has other files.
    #[error("{path} exists and is not a work folder of overviews; move it away", path = shown::path(.0))]
    NotOurs(PathBuf),
    /// It was cancelled.
    #[error("cancelled")]
    Cancelled,
}

impl OverviewError {
    pub(super) fn io(path: &Path, what: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io {
            path: path.to_owned(),
            what,
            source,
        }
    }
}
