//! A file whose n-th operation fails.

use std::io;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::time::Duration;

use bytes::Bytes;
use delaunay_tiles::io::{ReadAt, WriteAt};
use futures::future::{BoxFuture, FutureExt};

/// The way in which an operation fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// It fails with this error number of the system.
    System(i32),
    /// The bytes to be read are not there any more.
    Short,
    /// Half of the bytes are written.
    Torn,
    /// It succeeds, but later than the operations after it.
    Delay,
}

impl Fault {
    pub const EIO: Self = Self::System(5);
    pub const ENOSPC: Self = Self::System(28);
    pub const EINTR: Self = Self::System(4);

    /// The faults of a read.
    pub const OF_READS: [Self; 5] = [Self::EIO, Self::ENOSPC, Self::EINTR, Self::Short, Self::Delay];
    /// The faults of a write; a sync fails as reads do.
    pub const OF_WRITES: [Self; 5] = [Self::EIO, Self::ENOSPC, Self::EINTR, Self::Torn, Self::Delay];

    fn error(self) -> Option<io::Error> {
        match self {
            Self::System(number) => Some(io::Error::from_raw_os_error(number)),
            Self::Short => Some(io::ErrorKind::UnexpectedEof.into()),
            Self::Torn => Some(io::ErrorKind::WriteZero.into()),
            Self::Delay => None,
        }
    }
}

/// A file one of whose operations fails, once. Clones share the count of operations.
#[derive(Clone)]
pub struct Faulty<T> {
    file: T,
    fault: Fault,
    /// The number of the operation that fails, counted from 0.
    number: usize,
    operations: Arc<AtomicUsize>,
}

impl<T> Faulty<T> {
    pub fn new(file: T, fault: Fault, number: usize) -> Self {
        Self {
            file,
            fault,
            number,
            operations: Arc::default(),
        }
    }

    /// Wraps a file without a fault, to count its operations.
    pub fn sound(file: T) -> Self {
        Self::new(file, Fault::Delay, usize::MAX)
    }

    /// Returns the number of operations so far.
    pub fn operations(&self) -> usize {
        self.operations.load(SeqCst)
    }

    fn next(&self) -> Option<Fault> {
        (self.operations.fetch_add(1, SeqCst) == self.number).then_some(self.fault)
    }
}

/// Runs the operation with the fault, if there is one.
fn done<R: Send + 'static>(
    fault: Option<Fault>,
    operation: BoxFuture<'static, io::Result<R>>,
) -> BoxFuture<'static, io::Result<R>> {
    async move {
        match fault {
            None => operation.await,
            Some(fault) => {
                tokio::time::sleep(Duration::from_millis(2)).await;
                match fault.error() {
                    Some(error) => Err(error),
                    None => operation.await,
                }
            }
        }
    }
    .boxed()
}

impl<T: ReadAt> ReadAt for Faulty<T> {
    fn length(&self) -> u64 {
        self.file.length()
    }

    fn backend(&self) -> &'static str {
        "faulty"
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        done(self.next(), self.file.read_at(range))
    }
}

impl<T: WriteAt> WriteAt for Faulty<T> {
    fn write_at(&self, offset: u64, data: Bytes) -> BoxFuture<'static, io::Result<()>> {
        match self.next() {
            None => self.file.write_at(offset, data),
            Some(Fault::Delay) => done(Some(Fault::Delay), self.file.write_at(offset, data)),
            Some(Fault::Torn) => {
                let half = self.file.write_at(offset, data.slice(..data.len() / 2));
                half.map(|_| Err(io::ErrorKind::WriteZero.into())).boxed()
            }
            // Nothing is written.
            fault => done(fault, self.file.write_at(offset, Bytes::new())),
        }
    }

    fn sync(&self) -> BoxFuture<'static, io::Result<()>> {
        done(self.next(), self.file.sync())
    }
}
