//! Changes of a file: the transaction that Python fills and commits.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use delaunay_tiles::Point;
use delaunay_tiles::crs::{Agreement, Crs};
use delaunay_tiles::input::{PointBatch, SegmentBatch, SegmentSource, SiteBatch, SiteSource};
use delaunay_tiles::store::LineKind;
use numpy::PyReadonlyArray2;
use numpy::ndarray::ArrayView2;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use tiletool::lines::{LineInput, LineSet};

use crate::build::{Role, batches};
use crate::error::{Failure, Outcome};
use crate::runtime::{is_orphan, wait_for_edit};

/// An edit in progress. Each method takes its state out, and returns it when it is done.
#[pyclass(frozen, module = "delaunay_tiles._core")]
pub struct Transaction {
    state: Mutex<Option<State>>,
}

struct State {
    transaction: delaunay_tiles::Transaction,
    /// The number of points that were inserted so far.
    records: u64,
    /// The number of lines that were pushed, of those that come and of those that go.
    lines: [u64; 2],
    agreement: Agreement,
    /// Whether a call failed after it had had effects.
    is_broken: bool,
    /// Whether it may go to the log, which has no names of sources.
    has_log: bool,
    /// Tells the editor that a transaction is in progress.
    in_use: Arc<()>,
}

impl State {
    /// Takes the coordinate reference system of an input, which must be that of the file.
    fn take_crs(&mut self, input: &Path, text: &str) -> Outcome<()> {
        let agreed = self.agreement.add(input, Crs::new(text));
        agreed.map_err(|conflict| Failure::input(conflict.to_string()))
    }

    fn take_systems(&mut self, systems: &[(PathBuf, String)]) -> Outcome<()> {
        systems.iter().try_for_each(|(path, text)| self.take_crs(path, text))
    }

    /// Passes lines to the transaction. They are read before, so that an error in them has no effect.
    fn take_lines(&mut self, kind: LineKind, lines: Lines, source: SegmentSource) -> Outcome<()> {
        self.take_systems(source.crs_of_files())?;
        let set = LineSet::files(kind, 0, source);
        let mut input = LineInput::new(vec![set], SiteSource::open(&[], None)?);
        let (mut batches, mut batch) = (Vec::new(), SegmentBatch::default());
        while let Some((_, first)) = input.next_batch(&mut batch).map_err(Failure::of_build)? {
            batches.push((first, std::mem::take(&mut batch)));
        }
        let before = self.lines[lines as usize];
        self.is_broken = true;
        for (first, batch) in batches {
            match lines {
                Lines::Come => self.transaction.constrain(kind, before + first, &batch)?,
                Lines::Go => self.transaction.unconstrain(kind, before + first, &batch)?,
            }
        }
        let mut sources = input.sources();
        self.lines[lines as usize] += sources.iter().map(|source| source.lines).sum::<u64>();
        if let Lines::Come = lines {
            sources.iter_mut().for_each(|source| source.first += before);
            self.transaction.add_sources(sources);
        }
        self.is_broken = false;
        Ok(())
    }

    /// Inserts the sites of a file.
    fn take_sites(&mut self, path: PathBuf, id_field: Option<&str>) -> Outcome<()> {
        let mut source = SiteSource::open(&[path], id_field)?;
        let (mut batches, mut batch) = (Vec::new(), SiteBatch::default());
        while source.next_batch(&mut batch)? {
            batches.push(std::mem::take(&mut batch));
        }
        self.take_systems(source.crs_of_files())?;
        self.is_broken = true;
        batches
            .iter()
            .try_for_each(|batch| self.transaction.insert_sites(batch))?;
        self.is_broken = false;
        Ok(())
    }
}

/// What becomes of lines.
#[derive(Clone, Copy)]
enum Lines {
    Come,
    Go,
}

impl Transaction {
    /// Takes a transaction of a file. `in_use` is kept until it ends. `has_log` says whether it may go
    /// to the log of the file.
    pub fn new(
        file: &Path,
        transaction: delaunay_tiles::Transaction,
        has_log: bool,
        in_use: Arc<()>,
    ) -> PyResult<Self> {
        let mut state = State {
            transaction,
            records: 0,
            lines: [0; 2],
            agreement: Agreement::default(),
            is_broken: false,
            has_log,
            in_use,
        };
        if let Some(crs) = state.transaction.crs().map(str::to_owned) {
            state.take_crs(file, &crs)?;
        }
        Ok(Self {
            state: Mutex::new(Some(state)),
        })
    }

    fn with(&self, act: impl FnOnce(&mut State) -> Outcome<()>) -> PyResult<()> {
        let mut state = self.take()?;
        let done = act(&mut state);
        *self.state.lock().unwrap_or_else(PoisonError::into_inner) = Some(state);
        Ok(done?)
    }

    /// Passes lines to the transaction. `open` opens them, given whether they are polygons.
    fn take_lines(&self, kind: &str, lines: Lines, open: impl FnOnce(bool) -> Outcome<SegmentSource>) -> PyResult<()> {
        let Role::Lines(kind) = Role::named(kind)? else {
            return Err(Failure::value("ponds are made by builds only").into());
        };
        let source = open(kind == LineKind::Obstacle)?;
        self.with(|state| state.take_lines(kind, lines, source))
    }

    fn take(&self) -> PyResult<State> {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner).take();
        state.ok_or_else(|| PyRuntimeError::new_err("the edit has finished, or another thread is using it"))
    }
}

#[pymethods]
impl Transaction {
    /// Inserts rows of x, y and perhaps z.
    fn insert(&self, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        self.with(|state| {
            let batch = batch(points.as_array(), state.records);
            state.records += batch.len() as u64;
            Ok(state.transaction.insert(&batch)?)
        })
    }

    /// Deletes the points at rows of x and y.
    fn delete(&self, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        self.with(|state| Ok(state.transaction.delete(&batch(points.as_array(), 0).points)?))
    }

    /// Moves points from rows of x and y to as many others.
    fn move_points(&self, starts: PyReadonlyArray2<'_, f64>, ends: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let [starts, ends] = [starts, ends].map(|points| batch(points.as_array(), 0).points);
        let pairs: Vec<[Point; 2]> = starts.into_iter().zip(ends).map(|(start, end)| [start, end]).collect();
        self.with(|state| Ok(state.transaction.move_points(&pairs)?))
    }

    /// Gives the points at rows of x, y and z this z.
    fn set_z(&self, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        self.with(|state| Ok(state.transaction.set_z(&batch(points.as_array(), 0))?))
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
            state.transaction.remove_lines(&numbers);
            Ok(())
        })
    }

    /// Takes the coordinate reference system of an input.
    fn take_crs(&self, input: PathBuf, text: &str) -> PyResult<()> {
        self.with(|state| state.take_crs(&input, text))
    }

    /// Inserts the sites of a file.
    fn site_file(&self, path: PathBuf, id_field: Option<&str>) -> PyResult<()> {
        self.with(|state| state.take_sites(path, id_field))
    }

    /// Inserts sites at rows of x, y and perhaps z.
    fn insert_sites(&self, points: PyReadonlyArray2<'_, f64>, ids: Option<Vec<String>>) -> PyResult<()> {
        self.with(|state| {
            let batch = batches::sites(points.as_array(), ids, state.transaction.next_site())?;
            Ok(state.transaction.insert_sites(&batch)?)
        })
    }

    /// Deletes the sites at rows of x and y.
    fn delete_sites(&self, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        self.with(|state| Ok(state.transaction.delete_sites(&batch(points.as_array(), 0).points)?))
    }

    /// Makes the changes. Returns the summary as JSON.
    fn finish(&self, py: Python<'_>, name: &str) -> PyResult<String> {
        let State {
            mut transaction,
            records,
            is_broken,
            has_log,
            in_use: _in_use,
            ..
        } = self.take()?;
        if is_broken {
            return Err(Failure::other("an earlier call failed halfway; the file is unchanged").into());
        }
        if records > 0 && !has_log {
            transaction.add_point_sources(&[(name.to_owned(), records)]);
        }
        let summary = wait_for_edit(py, transaction.commit())?;
        Ok(serde_json::to_string(&summary).map_err(|error| Failure::other(error.to_string()))?)
    }

    /// Discards the changes.
    fn close(&self) {
        drop(self.take());
    }
}

impl Drop for Transaction {
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
