//! The promises of every backend, tested for each of them. New backends are added at the end of
//! this file.

mod reads;
mod shared;
mod writes;

use std::fs;
use std::future::Future;
use std::path::PathBuf;

use bytes::Bytes;
use tempfile::TempDir;

use crate::io::file::{ReadAt, WriteAt};
use crate::io::memory::MemoryFile;
use crate::io::section::Section;
use crate::io::threads::ThreadsFile;

/// A backend under test, and a folder for its files.
trait Subject: Default {
    type File: ReadAt + Clone + 'static;

    /// Creates a file with these bytes, opened for reading.
    fn holding(&self, bytes: &[u8]) -> Self::File;

    /// Returns the path of the file that [`holding`](Self::holding) made last, if it is on disk.
    fn path(&self) -> Option<PathBuf> {
        None
    }
}

/// A backend that writes.
trait Writing: Subject<File: WriteAt> {
    /// Creates a new, empty file for writing and reading.
    fn create(&self) -> Self::File;
}

/// Returns bytes in which no two parts are equal.
fn pattern(length: usize) -> Vec<u8> {
    let word = |i: usize| (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15).to_le_bytes();
    let mut bytes: Vec<u8> = (0..length.div_ceil(8)).flat_map(word).collect();
    bytes.truncate(length);
    bytes
}

/// Awaits a future without any runtime.
fn wait<T>(future: impl Future<Output = T>) -> T {
    futures::executor::block_on(future)
}

#[derive(Default)]
struct Memory;

impl Subject for Memory {
    type File = MemoryFile;

    fn holding(&self, bytes: &[u8]) -> MemoryFile {
        MemoryFile::new(bytes.to_vec())
    }
}

impl Writing for Memory {
    fn create(&self) -> MemoryFile {
        MemoryFile::default()
    }
}

#[derive(Default)]
struct Unchanging;

impl Subject for Unchanging {
    type File = Bytes;

    fn holding(&self, bytes: &[u8]) -> Bytes {
        Bytes::copy_from_slice(bytes)
    }
}

/// A folder with the one file of a test.
struct Folder(TempDir);

impl Default for Folder {
    fn default() -> Self {
        // Not in the folder for temporary files, which may be in memory.
        let target = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("target");
        Self(
            fs::create_dir_all(&target)
                .and_then(|()| tempfile::tempdir_in(target))
                .unwrap(),
        )
    }
}

impl Folder {
    fn file(&self) -> PathBuf {
        self.0.path().join("file")
    }

    fn with(&self, bytes: &[u8]) -> PathBuf {
        fs::write(self.file(), bytes).unwrap();
        self.file()
    }
}

#[derive(Default)]
struct Threads(Folder);

impl Subject for Threads {
    type File = ThreadsFile;

    fn holding(&self, bytes: &[u8]) -> ThreadsFile {
        ThreadsFile::open(&self.0.with(bytes)).unwrap()
    }

    fn path(&self) -> Option<PathBuf> {
        Some(self.0.file())
    }
}

impl Writing for Threads {
    fn create(&self) -> ThreadsFile {
        ThreadsFile::create(&self.0.file()).unwrap()
    }
}

#[cfg(target_os = "linux")]
#[derive(Default)]
struct Uring(Folder);

#[cfg(target_os = "linux")]
impl Subject for Uring {
    type File = crate::io::uring::UringFile;

    fn holding(&self, bytes: &[u8]) -> crate::io::uring::UringFile {
        crate::io::uring::UringFile::open(&self.0.with(bytes)).unwrap()
    }

    fn path(&self) -> Option<PathBuf> {
        Some(self.0.file())
    }
}

#[cfg(target_os = "linux")]
impl Writing for Uring {
    fn create(&self) -> crate::io::uring::UringFile {
        crate::io::uring::UringFile::create(&self.0.file()).unwrap()
    }
}

/// Objects in memory, standing for those of any store.
#[cfg(feature = "object-store")]
#[derive(Default)]
struct Object;

#[cfg(feature = "object-store")]
impl Subject for Object {
    type File = crate::io::object::ObjectFile;

    fn holding(&self, bytes: &[u8]) -> crate::io::object::ObjectFile {
        use std::sync::Arc;

        use object_store::memory::InMemory;
        use object_store::{ObjectStore, ObjectStoreExt};

        let store: Arc<dyn ObjectStore> = Arc::new(InMemory::new());
        wait(store.put(&"file".into(), bytes.to_vec().into())).unwrap();
        wait(crate::io::object::ObjectFile::open_in(store, "file")).unwrap()
    }
}

/// A part of a file in memory.
#[derive(Default)]
struct Part;

impl Subject for Part {
    type File = Section<MemoryFile>;

    fn holding(&self, bytes: &[u8]) -> Self::File {
        Section::new(MemoryFile::new(among_others(bytes)), BEFORE, bytes.len() as u64)
    }
}

impl Writing for Part {
    fn create(&self) -> Self::File {
        Section::from(MemoryFile::default(), BEFORE)
    }
}

/// A part of a file that a ring reads.
#[cfg(target_os = "linux")]
#[derive(Default)]
struct PartOnRing(Uring);

#[cfg(target_os = "linux")]
impl Subject for PartOnRing {
    type File = Section<crate::io::uring::UringFile>;

    fn holding(&self, bytes: &[u8]) -> Self::File {
        Section::new(self.0.holding(&among_others(bytes)), BEFORE, bytes.len() as u64)
    }
}

/// A file in parts of three objects in memory, with others before and behind them.
#[derive(Default)]
struct Parts;

impl Subject for Parts {
    type File = crate::io::parts::PartsFile;

    fn holding(&self, bytes: &[u8]) -> Self::File {
        use std::sync::Arc;

        use futures::future::{FutureExt, ready};

        use crate::io::parts::PartsFile;
        use crate::io::parts::manifest::{Manifest, Part};

        let length = bytes.len().div_ceil(7).max(1);
        let part = |(index, part): (usize, &[u8])| {
            let start = (index * length) as u64;
            Part {
                range: start..start + part.len() as u64,
                from: BEFORE + start,
                name: format!("object {}", index % 3),
            }
        };
        let parts = bytes.chunks(length).enumerate().map(part).collect();
        let object = MemoryFile::new(among_others(bytes));
        let open = move |_: &str| ready(Ok(Arc::new(object.clone()) as Arc<dyn ReadAt>)).boxed();
        PartsFile::new(Manifest { parts }.text().as_bytes(), open).unwrap()
    }
}

/// The bytes before a part.
const BEFORE: u64 = 8192;

/// Returns bytes with others before and behind them.
fn among_others(bytes: &[u8]) -> Vec<u8> {
    let others = [0xee; BEFORE as usize];
    [&others, bytes, &others[..777]].concat()
}

/// Defines a test for each promise. The tests are skipped if the system has no such backend.
macro_rules! promises {
    ($subject:ty, if $available:expr, $($part:ident: $promise:ident,)*) => {
        $(#[test]
        fn $promise() {
            if $available {
                $part::$promise(&<$subject>::default());
            } else {
                eprintln!("skipped: this system refuses the backend");
            }
        })*
    };
}

/// Defines the suite for a backend that reads.
macro_rules! reading {
    ($subject:ty, if $available:expr) => {
        promises! {
            $subject, if $available,
            reads: ranges_are_read_exactly,
            reads: an_empty_range_reads_nothing_at_any_offset,
            reads: ranges_beyond_the_end_fail_without_allocation,
            reads: long_ranges_are_read_whole,
            reads: answers_come_in_the_order_of_the_ranges,
            reads: a_short_file_is_read_to_its_last_byte,
            shared: thousands_of_reads_run_at_once,
            shared: dropped_reads_disturb_no_others,
            shared: numbers_are_unlocked_when_nobody_awaits_a_read,
            shared: reads_work_in_any_runtime,
            shared: bytes_outlive_their_file,
            shared: an_open_file_keeps_its_bytes_when_its_name_is_replaced,
        }
    };
}

/// Defines the suite for a backend that writes.
macro_rules! writing {
    ($subject:ty, if $available:expr) => {
        promises! {
            $subject, if $available,
            writes: files_grow_as_they_are_written,
            writes: gaps_read_as_zeros,
            writes: impossible_offsets_are_errors,
            writes: many_writes_run_at_once,
            writes: a_dropped_write_is_still_performed,
        }
    };
}

mod memory {
    use super::*;

    reading!(Memory, if true);
    writing!(Memory, if true);
}

mod unchanging {
    use super::*;

    reading!(Unchanging, if true);
}

mod threads {
    use super::*;

    reading!(Threads, if true);
    writing!(Threads, if true);
}

mod part {
    use super::*;

    reading!(Part, if true);
    writing!(Part, if true);
}

mod parts {
    use super::*;

    reading!(Parts, if true);
}

#[cfg(target_os = "linux")]
mod part_on_ring {
    use super::*;
    use crate::io::uring::ring::Ring;

    reading!(PartOnRing, if Ring::shared().is_ok());
}

#[cfg(target_os = "linux")]
mod uring {
    use super::*;
    use crate::io::uring::ring::Ring;

    reading!(Uring, if Ring::shared().is_ok());
    writing!(Uring, if Ring::shared().is_ok());
}

#[cfg(feature = "object-store")]
mod object {
    use super::*;

    reading!(Object, if true);
}
