//! Thread pools for operations that block or compute for long, shared by all files of the process.
//!
//! A pool starts a thread when a job comes and no thread is idle. Where the system refuses another
//! thread, the existing threads do the job later. A job fails if there is no thread at all. A job
//! of a pool must therefore never wait for another job of the same pool.
//!
//! tokio's own pool is not used. It panics without a thread, and queues jobs for workers that never
//! started.

use std::collections::VecDeque;
use std::io;
use std::num::NonZero;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::LazyLock;
use std::thread::available_parallelism;
use std::time::Duration;

use futures::future::FutureExt;
use parking_lot::{Condvar, Mutex, MutexGuard};
use tokio::sync::oneshot;

use crate::io::start::start_thread;

/// The pool for reads and writes. It has enough threads for the queue of one disk, and few enough
/// to cost nothing while idle.
static IO: Pool = Pool::new("tile-io", 8);
/// The pool for computations. The callers limit how much is computed at once.
static WORK: Pool = Pool::new("tile-work", 512);
/// The pool for computations of which many may be requested at once: a thread per processor.
static TURNS: LazyLock<Pool> =
    LazyLock::new(|| Pool::new("tile-open", available_parallelism().map_or(1, NonZero::get)));

/// How long a thread waits for another job before it ends, unless it is the last one.
const IDLE: Duration = Duration::from_secs(10);

type Job = Box<dyn FnOnce() + Send>;

struct Pool {
    name: &'static str,
    /// The limit on the number of threads.
    most: usize,
    state: Mutex<PoolState>,
    waiting: Condvar,
}

struct PoolState {
    jobs: VecDeque<Job>,
    threads: usize,
    /// The number of threads that wait for a job.
    idle: usize,
}

impl Pool {
    const fn new(name: &'static str, most: usize) -> Self {
        let state = PoolState {
            jobs: VecDeque::new(),
            threads: 0,
            idle: 0,
        };
        Self {
            name,
            most,
            state: Mutex::new(state),
            waiting: Condvar::new(),
        }
    }

    /// Awaits the answer of a job. A panic of the job continues here.
    async fn run<T: Send + 'static>(answer: io::Result<oneshot::Receiver<std::thread::Result<T>>>) -> io::Result<T> {
        match answer?.await {
            Ok(Ok(done)) => Ok(done),
            Ok(Err(panic)) => resume_unwind(panic),
            Err(_) => Err(io::Error::other("a thread of the pool is gone")),
        }
    }

    /// Hands over a job. Fails if the pool has no thread and the system refuses one.
    fn ask<T: Send + 'static>(
        &'static self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> io::Result<oneshot::Receiver<std::thread::Result<T>>> {
        let (reply, answer) = oneshot::channel();
        // If the caller has dropped the receiver, nobody needs the answer.
        self.push(Box::new(move || drop(reply.send(catch_unwind(AssertUnwindSafe(work))))))?;
        Ok(answer)
    }

    fn push(&'static self, job: Job) -> io::Result<()> {
        let mut state = self.state.lock();
        if state.idle <= state.jobs.len() && state.threads < self.most {
            let name = format!("{}-{}", self.name, state.threads);
            match start_thread(&name, || self.work()) {
                Ok(_) => state.threads += 1,
                Err(error) if state.threads == 0 => return Err(error),
                Err(error) => tracing::debug!(%error, threads = state.threads, "a pool does with the threads it has"),
            }
        }
        state.jobs.push_back(job);
        self.waiting.notify_one();
        Ok(())
    }

    fn work(&self) {
        let mut state = self.state.lock();
        loop {
            if let Some(job) = state.jobs.pop_front() {
                MutexGuard::unlocked(&mut state, job);
                continue;
            }
            state.idle += 1;
            let waited = self.waiting.wait_for(&mut state, IDLE);
            state.idle -= 1;
            if waited.timed_out() && state.jobs.is_empty() && state.threads > 1 {
                state.threads -= 1;
                return;
            }
        }
    }
}

/// Runs an operation that waits for a disk.
pub(super) fn run<T: Send + 'static>(
    operation: impl FnOnce() -> io::Result<T> + Send + 'static,
) -> impl Future<Output = io::Result<T>> + Send + 'static {
    Pool::run(IO.ask(operation)).map(Result::flatten)
}

/// Runs long work beside the workers of a runtime. The work starts at once. A panic of the work
/// continues where the answer is awaited.
///
/// The answer is an error if the system refuses a thread and the pool has none.
pub(crate) fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> impl Future<Output = io::Result<T>> + Send + 'static {
    Pool::run(WORK.ask(work))
}

/// Runs work like [`blocking`], but in the order of the calls, one at a time on each processor.
///
/// If all that is requested shared the processors, all of it would end at about the same time, and
/// whoever waits for the first would wait for all.
pub(crate) fn in_turn<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> impl Future<Output = io::Result<T>> + Send + 'static {
    Pool::run(TURNS.ask(work))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn no_more_is_computed_in_turn_than_there_are_processors() {
        let processors = available_parallelism().map_or(1, NonZero::get);
        let running = Arc::new(AtomicUsize::new(0));
        let work = |_| {
            let running = Arc::clone(&running);
            in_turn(move || {
                let now = running.fetch_add(1, Ordering::SeqCst) + 1;
                std::thread::sleep(Duration::from_millis(2));
                running.fetch_sub(1, Ordering::SeqCst);
                now
            })
        };
        let answers: Vec<_> = (0..8 * processors).map(work).collect();
        for answer in answers {
            assert!(futures::executor::block_on(answer).unwrap() <= processors);
        }
    }

    #[test]
    fn a_job_that_panics_takes_no_thread_with_it() {
        static ONE: Pool = Pool::new("test", 1);
        let panics = Pool::run(ONE.ask(|| resume_unwind(Box::new("thrown"))));
        let thrown = catch_unwind(AssertUnwindSafe(|| {
            futures::executor::block_on(panics).unwrap();
        }));
        assert_eq!(thrown.unwrap_err().downcast_ref(), Some(&"thrown"));
        assert_eq!(futures::executor::block_on(Pool::run(ONE.ask(|| 7))).unwrap(), 7);
        assert_eq!(ONE.state.lock().threads, 1);
    }

    #[test]
    fn more_jobs_than_threads_are_all_done() {
        static TWO: Pool = Pool::new("test", 2);
        let answers: Vec<_> = (0..100).map(|number| TWO.ask(move || number)).collect();
        for (number, answer) in answers.into_iter().enumerate() {
            assert_eq!(futures::executor::block_on(Pool::run(answer)).unwrap(), number);
        }
        assert!(TWO.state.lock().threads <= 2);
    }
}
