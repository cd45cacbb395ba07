//! The builder that Python calls.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use arrow_array::RecordBatch;
use delaunay_tiles::input::{MissingZ, PointBatch, PointSource, SiteSource};
use delaunay_tiles::{BuildSummary, InputTasks, Planned, Progress, TaskStore};
use numpy::PyReadonlyArray2;
use numpy::ndarray::s;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3_arrow::PyRecordBatchReader;
use tiletool::input_args::InputArgs;
use tiletool::lines::MissingZArgs;
use tiletool::task::reading::{self, PointArgs};
use tokio::runtime::Runtime;

use super::batches::{self, ROWS};
use super::options::{BuildArguments, ReadArguments, Role};
use super::work::{Stop, Work, is_poly};
use crate::error::{Failure, Outcome};
use crate::reader::url_of;
use crate::runtime::{is_orphan, runtime, work_or_cancel};

/// The summary of a build as JSON, and notes.
type Finished = (String, Vec<String>);

/// Returns what identifies the points of a file, and lines and sites of others, to a build that is
/// resumed; `None` if they cannot be read again, or lines come with the points.
///
/// `beside` has the path of each other file, after "sites" or the kind of its lines.
#[pyfunction]
pub fn identity(
    py: Python<'_>,
    path: PathBuf,
    arguments: ReadArguments,
    beside: Vec<(String, PathBuf)>,
    site_id: Option<&str>,
) -> PyResult<Option<String>> {
    if is_poly(&path) {
        return Ok(None);
    }
    let options = arguments.options(MissingZ::Drape)?;
    let of_all = py.detach(|| -> Outcome<Option<String>> {
        let Some(mut text) = PointSource::open(&[path], &options)?.identity() else {
            return Ok(None);
        };
        _ = write!(text, "\nsite id: {site_id:?}");
        for (role, path) in &beside {
            let Some(of_file) = identity_beside(role, path, site_id)? else {
                return Ok(None);
            };
            text += &of_file;
        }
        Ok(Some(text))
    });
    Ok(of_all?)
}

/// Returns what identifies a file of lines or sites; `None` if it cannot be read again.
fn identity_beside(role: &str, path: &Path, site_id: Option<&str>) -> Outcome<Option<String>> {
    let file = [path.to_owned()];
    let stamps = match role {
        "sites" => SiteSource::open(&file, site_id)?.stamps().to_vec(),
        _ => Role::named(role)?.open(&file)?.stamps().to_vec(),
    };
    if !stamps.iter().any(|(stamped, _)| stamped == path) {
        return Ok(None);
    }
    let mut text = String::new();
    for (path, stamp) in stamps {
        let path = std::path::absolute(&path).unwrap_or(path);
        _ = write!(text, "\n{role}: {path:?} {} {}", stamp.length, stamp.modified);
    }
    Ok(Some(text))
}

/// A build in progress. Each method takes the work out, and returns it when it is done.
#[pyclass(frozen, module = "delaunay_tiles._core")]
pub struct Builder {
    work: Mutex<Option<Work>>,
    /// The number of threads that decode files.
    threads: usize,
    progress: Arc<Progress>,
    stop: Arc<Stop>,
    /// What is called with the phase, its finished steps and their number while the build works.
    observer: Option<Py<PyAny>>,
}

impl Builder {
    /// Does something with the work, with the interpreter released. After an error of the input, the
    /// work goes on; after Ctrl-C, it is discarded.
    fn with<T: Send>(&self, py: Python<'_>, act: impl FnOnce(&mut Work, &Runtime) -> Outcome<T> + Send) -> PyResult<T> {
        let mut work = self.take()?;
        let done = self.wait(py, |runtime| Ok(act(&mut work, runtime)))?;
        *self.locked() = Some(work);
        Ok(done?)
    }

    fn wait<T: Send>(&self, py: Python<'_>, act: impl FnOnce(&Runtime) -> Outcome<T> + Send) -> PyResult<T> {
        let look = |py: Python<'_>| match &self.observer {
            None => Ok(()),
            Some(observer) => {
                let (phase, done, total) = self.progress.state();
                observer.call1(py, (phase.name(), done, total)).map(drop)
            }
        };
        work_or_cancel(py, act, look, || {
            self.progress.cancel();
            self.stop.now();
        })
    }

    fn locked(&self) -> MutexGuard<'_, Option<Work>> {
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take(&self) -> PyResult<Work> {
        // Before the work is taken, which would be dropped, with its files, if this failed afterwards.
        runtime()?;
        let work = self.locked().take();
        work.ok_or_else(|| PyRuntimeError::new_err("the builder has finished, or another thread is using it"))
    }
}

#[pymethods]
impl Builder {
    #[new]
    fn new(
        py: Python<'_>,
        output: PathBuf,
        arguments: BuildArguments,
        crs: Option<String>,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let progress = Arc::<Progress>::default();
        let stop = Arc::<Stop>::default();
        let mut options = arguments.options(&progress)?;
        let mut output = output;
        if let Some(url) = url_of(&output) {
            let store = TaskStore::at(url)?;
            // The folder that the build works in.
            output = options.work_folder.clone().unwrap_or_default().join(store.file_name());
            options = options.store(store);
        }
        let threads = options.threads;
        let runtime = runtime()?;
        let work = py.detach(|| -> Outcome<Work> {
            let _inside = runtime.enter();
            let builder = delaunay_tiles::Builder::new(output, options)?;
            Work::new(builder, crs.as_deref(), Arc::clone(&stop))
        })?;
        Ok(Self {
            work: Mutex::new(Some(work)),
            threads,
            progress,
            stop,
            observer,
        })
    }

    /// Returns whether points must be pushed. A build that was resumed has all its points.
    fn needs_points(&self) -> bool {
        self.locked().as_ref().is_some_and(|work| work.builder.needs_points())
    }

    /// Tells the builder that `rows` points will come, and no others, and how some of them are distributed.
    fn expect(&self, py: Python<'_>, rows: u64, sample: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let mut some = PointBatch::default();
        batches::fill(&mut some, sample.as_array(), 0);
        self.with(py, |work, _| Ok(work.builder.expect(rows, some.points)?))
    }

    /// Pushes rows of x, y and perhaps z.
    fn add_points(&self, py: Python<'_>, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let rows = points.as_array();
        self.with(py, |work, runtime| {
            let mut batch = PointBatch::default();
            for start in (0..rows.nrows()).step_by(ROWS) {
                let end = rows.nrows().min(start + ROWS);
                batches::fill(&mut batch, rows.slice(s![start..end, ..]), work.records);
                runtime.block_on(work.push_points(&batch))?;
            }
            Ok(())
        })
    }

    /// Notes that the last `records` points came from one input, which is no file.
    fn note_source(&self, name: &str, records: u64) -> PyResult<()> {
        let mut work = self.take()?;
        work.note_source(name, records);
        *self.locked() = Some(work);
        Ok(())
    }

    /// Pushes the points of an Arrow stream. Returns their number.
    fn add_arrow(&self, py: Python<'_>, stream: PyRecordBatchReader) -> PyResult<u64> {
        let stream = stream.into_reader()?;
        self.with(py, |work, runtime| {
            let first = work.records;
            let mut batch = PointBatch::default();
            // A stream without rows may have no batch, in which wrong columns would be found.
            batches::fill_from_arrow(&mut batch, &RecordBatch::new_empty(stream.schema()), first)?;
            for records in stream {
                let records = records.map_err(|error| Failure::input(error.to_string()))?;
                for start in (0..records.num_rows()).step_by(ROWS) {
                    let some = records.slice(start, ROWS.min(records.num_rows() - start));
                    batches::fill_from_arrow(&mut batch, &some, work.records)?;
                    runtime.block_on(work.push_points(&batch))?;
                }
            }
            Ok(work.records - first)
        })
    }

    /// Pushes the points of a file. `are_all` tells whether no other points come.
    fn add_point_file(
        &self,
        py: Python<'_>,
        path: PathBuf,
        arguments: ReadArguments,
        keep_edges: bool,
        are_all: bool,
    ) -> PyResult<()> {
        let options = arguments.options(MissingZ::Drape)?.threads(self.threads);
        self.with(py, |work, runtime| {
            if is_poly(&path) {
                work.push_segments_of(&path)?;
            } else if keep_edges {
                work.push_edges(&path)?;
            }
            let are_all = are_all && !options.is_filtered();
            let source = PointSource::open(&[path], &options)?;
            runtime.block_on(work.push_point_files(source, are_all))
        })
    }

    /// Pushes the lines of a file.
    fn add_line_file(&self, py: Python<'_>, kind: &str, path: PathBuf) -> PyResult<()> {
        let role = Role::named(kind)?;
        self.with(py, |work, _| work.push_line_file(role, path))
    }

    /// Pushes geometries, as well-known binary.
    fn add_wkb(&self, py: Python<'_>, kind: &str, geometries: Vec<Vec<u8>>) -> PyResult<()> {
        let role = Role::named(kind)?;
        self.with(py, |work, _| work.push_wkb(role, kind, geometries))
    }

    /// Takes the coordinate reference system of an input.
    fn take_crs(&self, py: Python<'_>, input: PathBuf, text: &str) -> PyResult<()> {
        self.with(py, |work, _| work.take_crs(&input, text))
    }

    /// Pushes the sites of a file.
    fn add_site_file(&self, py: Python<'_>, path: PathBuf, id_field: Option<&str>) -> PyResult<()> {
        self.with(py, |work, _| work.push_site_file(path, id_field))
    }

    /// Pushes rows of x, y and perhaps z as sites.
    fn add_sites(&self, py: Python<'_>, points: PyReadonlyArray2<'_, f64>, ids: Option<Vec<String>>) -> PyResult<()> {
        let rows = points.as_array();
        self.with(py, |work, _| {
            let batch = batches::sites(rows, ids, work.sites)?;
            work.push_sites(&batch)
        })
    }

    /// Pushes hole points: the regions around them are holes.
    fn add_holes(&self, py: Python<'_>, points: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let mut seeds = PointBatch::default();
        batches::fill(&mut seeds, points.as_array(), 0);
        self.with(py, |work, _| Ok(work.builder.push_seeds(&seeds.points)?))
    }

    /// Builds the file. Returns the summary as JSON, and notes.
    fn finish(&self, py: Python<'_>) -> PyResult<Finished> {
        let work = self.take()?;
        let (summary, notes) = self.wait(py, |runtime| runtime.block_on(work.finish()))?;
        Ok((json_of(&summary)?, notes))
    }

    /// Leaves the blocks to tasks, and returns the number of points of each. If all points are in memory,
    /// builds the file, and returns the summary as JSON, and notes.
    fn plan(&self, py: Python<'_>) -> PyResult<(Vec<u64>, Option<Finished>)> {
        let work = self.take()?;
        let (planned, notes) = self.wait(py, |runtime| runtime.block_on(work.plan()))?;
        match planned {
            Planned::Built(summary) => Ok((Vec::new(), Some((json_of(&summary)?, notes)))),
            Planned::Tasks(tasks) => Ok(((0..tasks.blocks()).map(|block| tasks.points(block)).collect(), None)),
            _ => Err(Failure::other("internal error: the build has an unknown outcome").into()),
        }
    }

    /// Leaves reading these files to tasks. Returns the number of records of each, or `None` if all points fit
    /// into memory. The builder is used up.
    fn plan_inputs(&self, py: Python<'_>, paths: Vec<PathBuf>, arguments: ReadArguments) -> PyResult<Option<Vec<u64>>> {
        let work = self.take()?;
        let input = arguments.of_tool()?;
        self.wait(py, |_| plan_inputs(work, &paths, &input))
    }

    /// Returns whether tasks read the points of the build that goes on.
    fn has_inputs(&self) -> bool {
        self.locked()
            .as_ref()
            .is_some_and(|work| work.builder.input_tasks().is_some())
    }

    /// Takes the points that tasks distributed, and distributes those of inputs that are left.
    fn take_inputs(&self, py: Python<'_>) -> PyResult<()> {
        let work = self.take()?;
        let work = self.wait(py, |_| work.take_inputs())?;
        *self.locked() = Some(work);
        Ok(())
    }

    /// Discards the work.
    fn close(&self, py: Python<'_>) {
        let work = self.locked().take();
        py.detach(|| discard(work));
    }
}

impl Drop for Builder {
    fn drop(&mut self) {
        discard(self.locked().take());
    }
}

/// Plans the tasks that read files.
fn plan_inputs(mut work: Work, paths: &[PathBuf], input: &InputArgs) -> Outcome<Option<Vec<u64>>> {
    let args = PointArgs {
        inputs: paths,
        input,
        missing_z: MissingZArgs::from(MissingZ::Drape),
    };
    let source = PointSource::open(paths, &input.options().missing_z(MissingZ::Drape))?;
    // Before tasks read for hours.
    work.take_systems(source.crs_of_files())?;
    let tasks = reading::plan(&args, &source, work.builder).map_err(Failure::of_build)?;
    let records = |tasks: InputTasks| {
        (0..tasks.inputs())
            .map(|input| tasks.records(input))
            .map(|r| r.end - r.start)
            .collect()
    };
    Ok(tasks.map(records))
}

fn json_of(summary: &BuildSummary) -> Outcome<String> {
    serde_json::to_string(summary).map_err(|error| Failure::other(error.to_string()))
}

/// Drops work, and its files. In a child of a fork they belong to the parent, which goes on with them.
fn discard(work: Option<Work>) {
    if is_orphan() {
        std::mem::forget(work);
    }
}
