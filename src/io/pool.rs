//! A few threads that do blocking I/O, shared by all files of the process.

use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, OnceLock};
use std::thread;

use futures::future::{BoxFuture, FutureExt};
use parking_lot::{Condvar, Mutex};
use tokio::sync::oneshot;

/// Reads in flight at once. Enough for the queue of one disk, few enough to cost nothing while idle.
const THREADS: usize = 8;

type Job = Box<dyn FnOnce() + Send>;

#[derive(Default)]
struct Queue {
    jobs: Mutex<VecDeque<Job>>,
    waiting: Condvar,
}

/// Runs a blocking operation on the pool.
pub(super) fn run<T: Send + 'static>(
    operation: impl FnOnce() -> io::Result<T> + Send + 'static,
) -> BoxFuture<'static, io::Result<T>> {
    let (reply, answer) = oneshot::channel();
    let job: Job = Box::new(move || {
        // Whoever asked may have gone away; then nobody needs the answer.
        let _ = reply.send(operation());
    });
    let queue = match queue() {
        Ok(queue) => queue,
        Err(error) => return futures::future::ready(Err(error)).boxed(),
    };
    queue.jobs.lock().push_back(job);
    queue.waiting.notify_one();
    async move {
        answer
            .await
            .unwrap_or_else(|_| Err(io::Error::other("the thread that did the I/O is gone")))
    }
    .boxed()
}

/// The one queue, with its threads, which live as long as the process.
fn queue() -> io::Result<&'static Arc<Queue>> {
    static QUEUE: OnceLock<Result<Arc<Queue>, io::ErrorKind>> = OnceLock::new();
    QUEUE
        .get_or_init(|| {
            let queue = Arc::<Queue>::default();
            for number in 0..THREADS {
                let queue = Arc::clone(&queue);
                thread::Builder::new()
                    .name(format!("tile-io-{number}"))
                    .spawn(move || work(&queue))
                    .map_err(|error| error.kind())?;
            }
            Ok(queue)
        })
        .as_ref()
        .map_err(|&kind| kind.into())
}

fn work(queue: &Queue) {
    loop {
        let job = {
            let mut jobs = queue.jobs.lock();
            loop {
                match jobs.pop_front() {
                    Some(job) => break job,
                    None => queue.waiting.wait(&mut jobs),
                }
            }
        };
        job();
    }
}
