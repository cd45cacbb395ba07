//! Threads that decode and encode tiles.

use std::io;
use std::sync::{Arc, mpsc};

use tokio::sync::oneshot;

use crate::edit::error::EditError;
use crate::io::start_thread;

/// How much less urgent threads are that yield to others, as a nice value.
#[cfg(target_os = "linux")]
const LESS_URGENT: i32 = 10;

type Job = Box<dyn FnOnce() + Send>;

/// Threads for longer computations, at most as many as the system grants, besides the runtime's
/// workers. They are few, so that the allocator reuses freed memory instead of keeping some for
/// each of many threads.
pub(crate) struct Workers {
    jobs: mpsc::Sender<Job>,
    pub(crate) threads: usize,
}

impl Workers {
    /// Starts threads. If they are to `yield_first`, other threads that compute come first: those that
    /// read the file that is edited must not wait.
    pub(crate) fn new(threads: usize, yield_first: bool) -> io::Result<Self> {
        let (jobs, work) = mpsc::channel::<Job>();
        let work = Arc::new(parking_lot::Mutex::new(work));
        let start = |number| {
            let work = Arc::clone(&work);
            let next = move || work.lock().recv().ok();
            start_thread(&format!("tile-edit-desk-{number}"), move || {
                if yield_first {
                    lower_priority();
                }
                std::iter::from_fn(next).for_each(|job| job());
            })
        };
        start(0)?;
        let others = (1..threads).map_while(|number| start(number).ok()).count();
        Ok(Self {
            jobs,
            threads: 1 + others,
        })
    }

    pub(crate) async fn run<T: Send + 'static>(
        &self,
        compute: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, EditError> {
        let (reply, computed) = oneshot::channel();
        // If the receiver is gone, the result is not needed. If the thread is gone, there is none.
        let _ = self.jobs.send(Box::new(move || drop(reply.send(compute()))));
        computed
            .await
            .map_err(|_| EditError::Internal("a tile could not be computed".to_owned()))
    }
}

/// Makes the calling thread less urgent than others of the process.
#[cfg(target_os = "linux")]
fn lower_priority() {
    // Linux knows the nice value of each thread. If it refuses another one, the thread is as the others.
    let _ = rustix::process::nice(LESS_URGENT);
}

/// Elsewhere, a nice value is that of the whole process.
#[cfg(not(target_os = "linux"))]
fn lower_priority() {}
