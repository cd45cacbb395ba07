//! Changes of a file: the editor that Python calls.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use delaunay_tiles::Point;
use delaunay_tiles::input::{MissingZ, PointBatch, SegmentBatch, SegmentSource, SiteBatch, SiteSource};
use delaunay_tiles::store::LineKind;
use numpy::PyReadonlyArray2;
use numpy::ndarray::ArrayView2;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use tokio::sync::Notify;

use tiletool::lines::{LineInput, LineSet};

use crate::build::batches;
use crate::build::options::Role;
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
    /// The lines that come, and those that go.
    lines: [LineInput; 2],
}

/// What becomes of lines.
#[derive(Clone, Copy)]
enum Lines {
    Come,
    Go,
}

impl Editor {
    fn with(&self, act: impl FnOnce(&mut State) -> Outcome<()>) -> PyResult<()> {
        let mut state = self.take()?;
        let done = act(&mut state);
        *self.state.lock().unwrap_or_else(PoisonError::into_inner) = Some(state);
        Ok(done?)
    }

    /// Passes lines to the editor. `open` opens them, given whether they are polygons.
    fn take_lines(&self, kind: &str, lines: Lines, open: impl FnOnce(bool) -> Outcome<SegmentSource>) -> PyResult<()> {
        let Role::Lines(kind) = Role::named(kind)? else {
            return Err(Failure::value("ponds are made by builds only").into());
        };
        let source = open(kind == LineKind::Obstacle)?;
        self.with(|State { editor, lines: all, .. }| {
            let input = &mut all[lines as usize];
            input.add(LineSet::files(kind, 0, source));
            let mut batch = SegmentBatch::default();
            while let Some((kind, first)) = input.next_batch(&mut batch).map_err(Failure::of_build)? {
                match lines {
                    Lines::Come => editor.push(kind, first, &batch)?,
                    Lines::Go => editor.remove(kind, first, &batch)?,
                }
            }
            Ok(())
        })
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
            "drape" => MissingZ::Drape,
            other => {
                let words = format!("missing_z must be 'drape', 'error' or 'zero', not {other:?}");
                return Err(Failure::value(words).into());
            }
        };
        let runtime = runtime()?;
        let open = || runtime.block_on(delaunay_tiles::Editor::open(file, memory));
        let mut editor = py.detach(open).map_err(Failure::from)?;
        editor.missing_z(missing_z);
        editor.skip_missing(skip_missing);
        editor.dry_run(dry_run);
        let lines = || -> Outcome<_> { Ok(LineInput::new(Vec::new(), SiteSource::open(&[], None)?)) };
        let state = State {
            editor,
            records: 0,
            lines: [lines()?, lines()?],
        };
        Ok(Self {
            state: Mutex::new(Some(state)),
        })
    }

    /// Inserts rows of x, y and perhaps z.
    fn insert(&self, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        self.with(|state| {
            let batch = batch(points.as_array(), state.records);
            state.records += batch.len() as u64;
            Ok(state.editor.insert(&batch)?)
        })
    }

    /// Deletes the points at rows of x and y.
    fn delete(&self, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        self.with(|state| Ok(state.editor.delete(&batch(points.as_array(), 0).points)?))
    }

    /// Moves points from rows of x and y to as many others.
    fn move_points(&self, starts: PyReadonlyArray2<'_, f64>, ends: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let [starts, ends] = [starts, ends].map(|points| batch(points.as_array(), 0).points);
        let pairs: Vec<[Point; 2]> = starts.into_iter().zip(ends).map(|(start, end)| [start, end]).collect();
        self.with(|state| Ok(state.editor.move_points(&pairs)?))
    }

    /// Gives the points at rows of x, y and z this z.
    fn set_z(&self, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        self.with(|state| Ok(state.editor.set_z(&batch(points.as_array(), 0))?))
    }

    /// Makes the lines of a file constraints, or removes them.
    fn line_file(&self, kind: &str, path: PathBuf, are_to_go: bool) -> PyResult<()> {
        let lines = if are_to_go { Lines::Go } else { Lines::Come };
        self.take_lines(kind, lines, |are_polygons| {
            Ok(match are_polygons {
                true => SegmentSource::open_obstacles(&[path])?,
                false => SegmentSource::open(&[path])?,
            })
        })
    }

    /// Makes geometries constraints, or removes them, given as well-known binary.
    fn line_wkb(&self, kind: &str, geometries: Vec<Vec<u8>>, are_to_go: bool) -> PyResult<()> {
        let lines = if are_to_go { Lines::Go } else { Lines::Come };
        self.take_lines(kind, lines, |are_polygons| {
            Ok(SegmentSource::from_wkb(kind, geometries.into_iter(), are_polygons)?)
        })
    }

    /// Removes lines by their numbers.
    fn remove_lines(&self, numbers: Vec<u64>) -> PyResult<()> {
        self.with(|state| {
            state.editor.remove_lines(&numbers);
            Ok(())
        })
    }

    /// Inserts the sites of a file.
    fn site_file(&self, path: PathBuf, id_field: Option<&str>) -> PyResult<()> {
        self.with(|state| {
            let mut source = SiteSource::open(&[path], id_field)?;
            let mut batch = SiteBatch::default();
            while source.next_batch(&mut batch)? {
                state.editor.insert_sites(&batch)?;
            }
            Ok(())
        })
    }

    /// Inserts sites at rows of x, y and perhaps z.
    fn insert_sites(&self, points: PyReadonlyArray2<'_, f64>, ids: Option<Vec<String>>) -> PyResult<()> {
        self.with(|state| {
            let batch = batches::sites(points.as_array(), ids, state.editor.next_site())?;
            Ok(state.editor.insert_sites(&batch)?)
        })
    }

    /// Deletes the sites at rows of x and y.
    fn delete_sites(&self, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        self.with(|state| Ok(state.editor.delete_sites(&batch(points.as_array(), 0).points)?))
    }

    /// Makes the changes. Returns the summary as JSON.
    fn finish(&self, py: Python<'_>, name: &str) -> PyResult<String> {
        let State {
            mut editor,
            records,
            lines: [lines, _],
        } = self.take()?;
        editor.add_sources(lines.sources());
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
