//! Editors of files, which make one transaction after another.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use delaunay_tiles::{Durability, EditOptions};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::build::{MISSING_Z, choice};
use crate::edit::Transaction;
use crate::error::Failure;
use crate::runtime::{is_orphan, wait_for_edit};

/// A file that is locked for edits. Each method takes the editor out, and returns it when it is done.
#[pyclass(frozen, module = "delaunay_tiles._core")]
pub struct Editor {
    file: PathBuf,
    state: Mutex<Option<State>>,
}

struct State {
    editor: delaunay_tiles::Editor,
    has_log: bool,
    /// The transaction in progress has a clone.
    in_use: Arc<()>,
}

impl Editor {
    fn with<T>(&self, act: impl FnOnce(&State) -> PyResult<T>) -> PyResult<T> {
        let state = self.take();
        let state =
            state.ok_or_else(|| PyRuntimeError::new_err("the editor is closed, or another thread is using it"))?;
        let done = match Arc::strong_count(&state.in_use) {
            1 => act(&state),
            _ => Err(Failure::edit("an edit of this editor is in progress: finish or close it first").into()),
        };
        *self.state.lock().unwrap_or_else(PoisonError::into_inner) = Some(state);
        done
    }

    fn take(&self) -> Option<State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

#[pymethods]
impl Editor {
    #[new]
    fn new(py: Python<'_>, file: PathBuf, memory: u64, durability: &str) -> PyResult<Self> {
        let choices = [("file", Durability::File), ("log", Durability::Log)];
        let durability = choice("durability", durability, &choices)?;
        let options = EditOptions::default().memory(memory).durability(durability);
        let editor = wait_for_edit(py, delaunay_tiles::Editor::open(&file, options))?;
        Ok(Self {
            file,
            state: Mutex::new(Some(State {
                editor,
                has_log: durability == Durability::Log,
                in_use: Arc::default(),
            })),
        })
    }

    /// Begins a transaction.
    fn begin(&self, py: Python<'_>, missing_z: &str, skip_missing: bool, dry_run: bool) -> PyResult<Transaction> {
        let missing_z = choice("missing_z", missing_z, &MISSING_Z)?;
        self.with(|state| {
            let mut transaction = wait_for_edit(py, state.editor.begin())?;
            transaction.missing_z(missing_z);
            transaction.skip_missing(skip_missing);
            transaction.dry_run(dry_run);
            Transaction::new(&self.file, transaction, state.has_log, Arc::clone(&state.in_use))
        })
    }

    /// Makes the changes in the log in the file. Returns the summary as JSON, if there were any.
    fn checkpoint(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let summary = self.with(|state| wait_for_edit(py, state.editor.checkpoint()))?;
        let text = summary.map(|summary| serde_json::to_string(&summary)).transpose();
        Ok(text.map_err(|error| Failure::other(error.to_string()))?)
    }

    /// Unlocks the file.
    fn close(&self) {
        drop(self.take());
    }
}

impl Drop for Editor {
    fn drop(&mut self) {
        // In a child of a fork, the lock belongs to the parent, which goes on with it.
        if is_orphan() {
            std::mem::forget(self.take());
        }
    }
}
