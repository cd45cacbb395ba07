//! Changes of a file: the editor that Python calls.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use delaunay_tiles::input::{MissingZ, PointBatch};
use delaunay_tiles::{EditError, Point};
use numpy::PyReadonlyArray2;
use numpy::ndarray::ArrayView2;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use tokio::sync::Notify;

use crate::build::batches;
use crate::error::{Failure, Outcome};
use crate::runtime::{is_orphan, runtime, work_or_cancel};

/// An edit in progress. Each method takes the editor out, and returns it when it is done.
#[pyclass(frozen, module = "delaunay_tiles._core")]
pub struct Editor {
    state: Mutex<Option<State>>,
}

struct State {
    editor: delaunay_tiles::Editor,
    /// The number of points that were inserted so far.
    records: u64,
}

impl Editor {
    fn with(&self, act: impl FnOnce(&mut State) -> Result<(), EditError>) -> PyResult<()> {
        let mut state = self.take()?;
        let done = act(&mut state);
        *self.state.lock().unwrap_or_else(PoisonError::into_inner) = Some(state);
        Ok(done.map_err(Failure::from)?)
    }

    fn take(&self) -> PyResult<State> {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner).take();
        state.ok_or_else(|| PyRuntimeError::new_err("the edit has finished, or another thread is using it"))
    }
}

#[pymethods]
impl Editor {
    #[new]
    fn new(
        py: Python<'_>,
        file: PathBuf,
        memory: u64,
        missing_z: &str,
        skip_missing: bool,
        dry_run: bool,
    ) -> PyResult<Self> {
        let missing_z = match missing_z {
            "error" => MissingZ::Error,
            "zero" => MissingZ::Zero,
            other => {
                let words = format!("missing_z must be 'error' or 'zero', not {other:?}");
                return Err(Failure::value(words).into());
            }
        };
        let runtime = runtime()?;
        let open = || runtime.block_on(delaunay_tiles::Editor::open(file, memory));
        let mut editor = py.detach(open).map_err(Failure::from)?;
        editor.missing_z(missing_z);
        editor.skip_missing(skip_missing);
        editor.dry_run(dry_run);
        let state = State { editor, records: 0 };
        Ok(Self {
            state: Mutex::new(Some(state)),
        })
    }

    /// Inserts rows of x, y and perhaps z.
    fn insert(&self, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        self.with(|state| {
            let batch = batch(points.as_array(), state.records);
            state.records += batch.len() as u64;
            state.editor.insert(&batch)
        })
    }

    /// Deletes the points at rows of x and y.
    fn delete(&self, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        self.with(|state| state.editor.delete(&batch(points.as_array(), 0).points))
    }

    /// Moves points from rows of x and y to as many others.
    fn move_points(&self, starts: PyReadonlyArray2<'_, f64>, ends: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let [starts, ends] = [starts, ends].map(|points| batch(points.as_array(), 0).points);
        let pairs: Vec<[Point; 2]> = starts.into_iter().zip(ends).map(|(start, end)| [start, end]).collect();
        self.with(|state| state.editor.move_points(&pairs))
    }

    /// Gives the points at rows of x, y and z this z.
    fn set_z(&self, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        self.with(|state| state.editor.set_z(&batch(points.as_array(), 0)))
    }

    /// Makes the changes. Returns the summary as JSON.
    fn finish(&self, py: Python<'_>, name: &str) -> PyResult<String> {
        let State { mut editor, records } = self.take()?;
        if records > 0 {
            editor.add_point_sources(&[(name.to_owned(), records)]);
        }
        let stop = Notify::new();
        let finish = async {
            tokio::select! {
                done = editor.finish() => done,
                () = stop.notified() => Err(EditError::Cancelled),
            }
        };
        let work = |runtime: &tokio::runtime::Runtime| -> Outcome<_> { Ok(runtime.block_on(finish)?) };
        let summary = work_or_cancel(py, work, |_| Ok(()), || stop.notify_one())?;
        Ok(serde_json::to_string(&summary).map_err(|error| Failure::other(error.to_string()))?)
    }

    /// Discards the changes.
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

fn batch(rows: ArrayView2<'_, f64>, first: u64) -> PointBatch {
    let mut batch = PointBatch::default();
    batches::fill(&mut batch, rows, first);
    batch
}
