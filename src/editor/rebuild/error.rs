//! Errors of builds, as those of edits.

use std::sync::Arc;

use crate::edit::EditError;
use crate::pipeline::BuildError;

/// Returns the error of an edit for that of a build.
pub(super) fn edit_error(error: BuildError) -> EditError {
    match error {
        BuildError::Cancelled => EditError::Cancelled,
        BuildError::Memory(shortage) => EditError::Memory(shortage),
        BuildError::Io { path, what, source } => EditError::io(&path, what, source),
        other => EditError::Build(Arc::new(other)),
    }
}
