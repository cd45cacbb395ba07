//! The thread that owns the ring and runs nothing else.
//!
//! The thread's runtime submits operations to the kernel only when it has nothing left to do.
//! Computations must not run there: they would stall the I/O of all files. Requests come in by a
//! channel, and each answer goes out by another. The number of operations in flight, and of their
//! bytes, is limited; further requests wait in the channel, without a buffer.

use std::collections::HashMap;
use std::fs::File;
use std::io;
use std::rc::Rc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Arc, LazyLock};
use std::time::Duration;

use bytes::Bytes;
use parking_lot::Mutex;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::sync::{Semaphore, oneshot};

use crate::io::start::start_thread;
use crate::io::uring::pages::PagePool;
use crate::io::uring::transfer;

/// The number of entries of the ring.
const ENTRIES: u32 = 256;
/// The limit on operations in flight: below the number of entries, and enough for the queue of any
/// one disk. A long operation counts as one for each [`UNIT`].
///
/// A disk serves all operations in flight at once. With dozens of long ones, all of them end at
/// about the same time: then the processors have everything to do, and the disk nothing.
const IN_FLIGHT: usize = 128;
/// The bytes of an operation that count once. All in flight are 8 MiB, a few milliseconds of a fast
/// disk.
const UNIT: usize = 64 << 10;
/// The number of files that the process must still be able to open when a ring is made. Half of
/// them are for the ring and its runtime.
const DESCRIPTORS: usize = 24;
/// How long a new ring may take to answer. Some sandboxes permit making a ring, but not submitting
/// anything to it.
const PATIENCE: Duration = Duration::from_secs(1);

/// The channel for an answer. If the receiver was dropped, nobody needs the answer.
type Reply<T> = oneshot::Sender<io::Result<T>>;

/// An operation of a ring on a file.
pub(super) enum Operation {
    /// Reads all of `length` bytes, or none, into memory of `pool`.
    Read {
        offset: u64,
        length: usize,
        is_direct: bool,
        pool: PagePool,
        reply: Reply<Bytes>,
    },
    /// Writes all the bytes.
    Write { offset: u64, data: Bytes, reply: Reply<()> },
    /// Brings everything written before onto the medium.
    Sync { reply: Reply<()> },
}

impl Operation {
    /// Returns how often the operation counts among those in flight.
    fn units(&self) -> u32 {
        let bytes = match self {
            Self::Read { length, .. } => *length,
            Self::Write { data, .. } => data.len(),
            Self::Sync { .. } => 0,
        };
        bytes.div_ceil(UNIT).clamp(1, IN_FLIGHT) as u32
    }
}

/// A request to the thread of a ring. Files are identified by number.
enum Request {
    Open(u64, File),
    Close(u64),
    Do(u64, Operation),
}

/// A ring, driven by a thread of its own. The thread ends when the ring is dropped.
#[derive(Debug)]
pub(in crate::io) struct Ring {
    requests: UnboundedSender<Request>,
    opened: AtomicU64,
}

impl Ring {
    /// Returns the ring that all files of the process share. It is made at the first call, and
    /// again if its thread has ended.
    ///
    /// # Errors
    /// Fails with the system's error if it refuses a ring, as in many containers.
    pub(in crate::io) fn shared() -> io::Result<Arc<Self>> {
        static SHARED: LazyLock<Mutex<SharedRing>> = LazyLock::new(Mutex::default);
        let mut shared = SHARED.lock();
        if let SharedRing::Ring(ring) = &*shared
            && !ring.requests.is_closed()
        {
            return Ok(Arc::clone(ring));
        }
        if let SharedRing::Silent = *shared {
            return Err(silent());
        }
        let ring = Self::start();
        match &ring {
            Ok(ring) => *shared = SharedRing::Ring(Arc::clone(ring)),
            // No caller waits for such a ring twice.
            Err(error) if error.kind() == io::ErrorKind::TimedOut => *shared = SharedRing::Silent,
            Err(_) => (),
        }
        ring
    }

    fn start() -> io::Result<Arc<Self>> {
        let (requests, incoming) = unbounded_channel();
        let (ready, started) = sync_channel(1);
        start_thread("tile-ring", move || {
            // `start` would panic where a ring is refused, and the runtime where a descriptor is
            // refused.
            if let Err(error) = descriptors() {
                return drop(ready.send(Err(error)));
            }
            let runtime = match tokio_uring::Runtime::new(tokio_uring::builder().entries(ENTRIES)) {
                Ok(runtime) => runtime,
                Err(error) => return drop(ready.send(Err(error))),
            };
            runtime.block_on(async {
                let answered = tokio_uring::no_op().await;
                let works = answered.is_ok();
                drop(ready.send(answered));
                if works {
                    serve(incoming).await;
                }
            });
        })?;
        match started.recv_timeout(PATIENCE) {
            Ok(works) => works?,
            Err(RecvTimeoutError::Timeout) => return Err(silent()),
            Err(RecvTimeoutError::Disconnected) => return Err(gone()),
        }
        Ok(Arc::new(Self {
            requests,
            opened: AtomicU64::new(0),
        }))
    }

    /// Hands over a file; returns the number that identifies it.
    pub(super) fn open(&self, file: File) -> io::Result<u64> {
        let number = self.opened.fetch_add(1, Ordering::Relaxed);
        self.send(Request::Open(number, file))?;
        Ok(number)
    }

    /// Closes a file when its last operation is done.
    pub(super) fn close(&self, number: u64) {
        // If the thread has ended, its files are closed too.
        let _ = self.send(Request::Close(number));
    }

    /// Requests an operation on a file.
    pub(super) fn ask(&self, number: u64, operation: Operation) -> io::Result<()> {
        self.send(Request::Do(number, operation))
    }

    fn send(&self, request: Request) -> io::Result<()> {
        self.requests.send(request).map_err(|_| gone())
    }
}

/// The state of the ring that the process shares.
#[derive(Default)]
enum SharedRing {
    #[default]
    NotMade,
    Ring(Arc<Ring>),
    /// A ring was made, but did not answer.
    Silent,
}

/// Returns the error for the case that the thread of the ring ended early.
pub(super) fn gone() -> io::Error {
    io::Error::other("the thread that drives the io_uring is gone")
}

fn silent() -> io::Error {
    let message = format!(
        "the system made a ring, but did nothing with it for {} s",
        PATIENCE.as_secs()
    );
    io::Error::new(io::ErrorKind::TimedOut, message)
}

/// Fails unless the process can open enough files for a ring beside others.
fn descriptors() -> io::Result<()> {
    (0..DESCRIPTORS)
        .map(|_| File::open("/"))
        .collect::<io::Result<Vec<_>>>()
        .map(drop)
}

/// Performs requests until no sender is left and all operations are done.
async fn serve(mut incoming: UnboundedReceiver<Request>) {
    let mut files = HashMap::new();
    let slots = Arc::new(Semaphore::new(IN_FLIGHT));
    while let Some(request) = incoming.recv().await {
        let (number, operation) = match request {
            Request::Open(number, file) => {
                files.insert(number, Rc::new(tokio_uring::fs::File::from_std(file)));
                continue;
            }
            Request::Close(number) => {
                files.remove(&number);
                continue;
            }
            Request::Do(number, operation) => (number, operation),
        };
        // A file that receives a request is still open.
        let Some(file) = files.get(&number).map(Rc::clone) else {
            continue;
        };
        let units = operation.units();
        let Ok(slot) = Arc::clone(&slots).acquire_many_owned(units).await else {
            return;
        };
        tokio_uring::spawn(async move {
            perform(&file, operation).await;
            drop(slot);
        });
    }
    let _ = slots.acquire_many(IN_FLIGHT as u32).await;
}

async fn perform(file: &tokio_uring::fs::File, operation: Operation) {
    match operation {
        Operation::Read {
            offset,
            length,
            is_direct,
            pool,
            reply,
        } => {
            // Nobody can observe whether a read without a receiver was done.
            if !reply.is_closed() {
                let _ = reply.send(transfer::read(file, offset, length, is_direct, &pool).await);
            }
        }
        Operation::Write { offset, data, reply } => {
            let _ = reply.send(transfer::write(file, offset, data).await);
        }
        Operation::Sync { reply } => {
            let _ = reply.send(file.sync_all().await);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_read_counts_as_several() {
        for (length, units) in [
            (1, 1),
            (UNIT, 1),
            (UNIT + 1, 2),
            (1_700_000, 26),
            (usize::MAX, IN_FLIGHT),
        ] {
            let read = Operation::Read {
                offset: 0,
                length,
                is_direct: false,
                pool: PagePool::keeping(0),
                reply: oneshot::channel().0,
            };
            assert_eq!(read.units() as usize, units, "{length}");
        }
    }
}
