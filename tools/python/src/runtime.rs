//! Waiting for futures: blocking with Ctrl-C, or as awaitables of asyncio; and forks.
//!
//! One runtime serves the process. It is started by the first question. Its threads do not exist in a
//! child that the process forks afterwards, so everything is an error there.

use std::pin::{Pin, pin};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll, Wake, Waker};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

use delaunay_tiles::EditError;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use tokio::runtime::{Builder, Runtime};
use tokio::sync::{Notify, oneshot};

use crate::error::{Failure, Outcome};

/// The longest time for which Ctrl-C is not looked for.
const PATIENCE: Duration = Duration::from_millis(100);

static RUNTIME: OnceLock<Runtime> = OnceLock::new();

/// Whether this process was forked from one that had started the runtime.
static IS_ORPHAN: AtomicBool = AtomicBool::new(false);

/// Tells this module that it is in a child process, just after a fork.
#[pyfunction]
pub fn in_child_of_fork() {
    IS_ORPHAN.store(RUNTIME.get().is_some(), Ordering::Relaxed);
}

/// Returns whether this process is a child of a fork, in which the threads of the runtime do not exist.
pub fn is_orphan() -> bool {
    IS_ORPHAN.load(Ordering::Relaxed)
}

/// Returns the runtime.
///
/// # Errors
/// Fails in a child of a fork, and if the system refuses threads.
pub fn runtime() -> PyResult<&'static Runtime> {
    if is_orphan() {
        return Err(PyRuntimeError::new_err(
            "this process was forked after delaunay_tiles had started its threads, which do not exist here; start \
             processes with the method 'spawn' or 'forkserver' (multiprocessing.get_context), or use delaunay_tiles \
             only after the fork",
        ));
    }
    if let Some(runtime) = RUNTIME.get() {
        return Ok(runtime);
    }
    let new = Builder::new_multi_thread()
        .thread_name("delaunay-tiles")
        .enable_all()
        .build();
    let new = new.map_err(|error| PyRuntimeError::new_err(format!("cannot start threads: {error}")))?;
    let runtime = RUNTIME.get_or_init(|| new);
    // It fails if another module did this before, with its runtime, which serves as well.
    let _ = pyo3_async_runtimes::tokio::init_with_runtime(runtime);
    Ok(runtime)
}

/// Waits for a future, with the interpreter released. On Ctrl-C, the future is dropped and the
/// exception returned.
///
/// # Errors
/// Returns the error of the future, `KeyboardInterrupt`, or what a signal handler raised.
fn wait<T: Send>(py: Python<'_>, future: impl Future<Output = Outcome<T>> + Send) -> PyResult<T> {
    let _entered = runtime()?.enter();
    let waker = Waker::from(Arc::new(Alarm(thread::current())));
    let mut future = pin!(future);
    loop {
        match py.detach(|| poll_for_a_while(future.as_mut(), &waker)) {
            Some(done) => return Ok(done?),
            None => py.check_signals()?,
        }
    }
}

/// Wakes the thread that waits.
struct Alarm(Thread);

impl Wake for Alarm {
    fn wake(self: Arc<Self>) {
        self.0.unpark();
    }
}

/// Returns the output of a future, or `None` if [`PATIENCE`] ends before.
///
/// The runtime's own timers would not do: they stand still while all its threads compute.
fn poll_for_a_while<F: Future>(mut future: Pin<&mut F>, waker: &Waker) -> Option<F::Output> {
    let end = Instant::now() + PATIENCE;
    let mut context = Context::from_waker(waker);
    loop {
        if let Poll::Ready(output) = future.as_mut().poll(&mut context) {
            return Some(output);
        }
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return None;
        }
        thread::park_timeout(left);
    }
}

/// Answers a question: runs the future on the threads of the runtime, and waits for it, or returns an
/// awaitable. An awaitable that is cancelled drops the future, and so does Ctrl-C.
///
/// # Errors
/// As [`wait`].
pub fn ask<'py, T>(
    py: Python<'py>,
    is_awaited: bool,
    future: impl Future<Output = Outcome<T>> + Send + 'static,
) -> PyResult<Bound<'py, PyAny>>
where
    T: for<'a> IntoPyObject<'a> + Send + 'static,
{
    let runtime = runtime()?;
    if is_awaited {
        return pyo3_async_runtimes::tokio::future_into_py(py, async { Ok(future.await?) });
    }
    let task = runtime.spawn(future);
    let stop = Stop(task.abort_handle());
    let answer = wait(py, async { Ok(task.await) })?;
    drop(stop);
    match answer {
        Ok(answer) => answer?.into_bound_py_any(py),
        Err(failed) => Err(PyRuntimeError::new_err(format!("internal error: {failed}"))),
    }
}

/// Does `work` on a thread of its own, with the interpreter released, and calls `look` while it lasts. On
/// Ctrl-C, or if `look` raises an exception, calls `cancel`, waits until the work has ended, and returns
/// the exception.
///
/// # Errors
/// Returns the error of the work, `KeyboardInterrupt`, or the exception of `look`.
pub fn work_or_cancel<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&Runtime) -> Outcome<T> + Send,
    mut look: impl FnMut(Python<'_>) -> PyResult<()>,
    cancel: impl Fn(),
) -> PyResult<T> {
    let runtime = runtime()?;
    let is_done = AtomicBool::new(false);
    let waiting = thread::current();
    thread::scope(|scope| {
        let begun = thread::Builder::new()
            .name("delaunay-tiles".to_owned())
            .spawn_scoped(scope, || {
                let _bell = Bell(&is_done, &waiting);
                work(runtime)
            });
        let worker = begun.map_err(|error| PyRuntimeError::new_err(format!("cannot start a thread: {error}")))?;
        let mut raised = None;
        while !is_done.load(Ordering::Acquire) {
            py.detach(|| thread::park_timeout(PATIENCE));
            if raised.is_none()
                && let Err(exception) = py.check_signals().and_then(|()| look(py))
            {
                cancel();
                raised = Some(exception);
            }
        }
        let done = py.detach(|| worker.join());
        match (raised, done) {
            (Some(exception), _) => Err(exception),
            (None, Ok(done)) => Ok(done?),
            (None, Err(_)) => Err(PyRuntimeError::new_err("internal error: the work panicked")),
        }
    })
}

/// Waits for an edit, with the interpreter released. On Ctrl-C the edit is dropped.
///
/// # Errors
/// Returns the error of the edit, or `KeyboardInterrupt`.
pub fn wait_for_edit<T: Send>(py: Python<'_>, edit: impl Future<Output = Result<T, EditError>> + Send) -> PyResult<T> {
    let stop = Notify::new();
    let edit = async {
        tokio::select! {
            done = edit => done,
            () = stop.notified() => Err(EditError::Cancelled),
        }
    };
    work_or_cancel(
        py,
        |runtime| Ok(runtime.block_on(edit)?),
        |_| Ok(()),
        || stop.notify_one(),
    )
}

/// Does asynchronous work on a thread for blocking work, from which it cannot move. Dropping the future drops
/// the work.
pub async fn in_place<T, F>(work: impl FnOnce() -> F + Send + 'static) -> Outcome<T>
where
    T: Send + 'static,
    F: Future<Output = Outcome<T>>,
{
    let runtime = tokio::runtime::Handle::current();
    let (_keep, dropped) = oneshot::channel::<()>();
    let done = runtime.clone().spawn_blocking(move || {
        runtime.block_on(async {
            tokio::select! {
                done = work() => done,
                _ = dropped => Err(Failure::other("cancelled")),
            }
        })
    });
    done.await
        .unwrap_or_else(|failed| Err(Failure::other(format!("internal error: {failed}"))))
}

/// Wakes the thread that waits for some work when the work ends, by a panic too.
struct Bell<'a>(&'a AtomicBool, &'a Thread);

impl Drop for Bell<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
        self.1.unpark();
    }
}

/// Stops a task when it is dropped.
struct Stop(tokio::task::AbortHandle);

impl Drop for Stop {
    fn drop(&mut self) {
        self.0.abort();
    }
}
