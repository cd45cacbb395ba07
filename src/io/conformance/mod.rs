//! What every backend promises, run for each of them. A backend is added to the end of this file.

mod reads;
mod shared;
mod writes;

use std::fs;
use std::future::Future;
use std::path::PathBuf;

use tempfile::TempDir;

use super::{MemoryFile, ReadAt, ThreadsFile, WriteAt};

/// A backend under test, and a folder for its files.
trait Subject: Default {
    type File: ReadAt + WriteAt + Clone + 'static;

    /// A new, empty file, to write and read.
    fn create(&self) -> Self::File;

    /// A file with these bytes, opened to read it.
    fn holding(&self, bytes: &[u8]) -> Self::File;

    /// Where the file lies that [`holding`](Self::holding) made last, if on disk.
    fn path(&self) -> Option<PathBuf> {
        None
    }
}

/// Bytes that are different everywhere.
fn pattern(length: usize) -> Vec<u8> {
    let word = |i: usize| (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15).to_le_bytes();
    let mut bytes: Vec<u8> = (0..length.div_ceil(8)).flat_map(word).collect();
    bytes.truncate(length);
    bytes
}

/// Awaits without any runtime.
fn wait<T>(future: impl Future<Output = T>) -> T {
    futures::executor::block_on(future)
}

#[derive(Default)]
struct Memory;

impl Subject for Memory {
    type File = MemoryFile;

    fn create(&self) -> MemoryFile {
        MemoryFile::default()
    }

    fn holding(&self, bytes: &[u8]) -> MemoryFile {
        MemoryFile::new(bytes.to_vec())
    }
}

/// A folder with the one file of a test.
struct Folder(TempDir);

impl Default for Folder {
    fn default() -> Self {
        // Not in the folder for temporary files, which may be one that lies in memory.
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

    fn create(&self) -> ThreadsFile {
        ThreadsFile::create(&self.0.file()).unwrap()
    }

    fn holding(&self, bytes: &[u8]) -> ThreadsFile {
        ThreadsFile::open(&self.0.with(bytes)).unwrap()
    }

    fn path(&self) -> Option<PathBuf> {
        Some(self.0.file())
    }
}

#[cfg(target_os = "linux")]
#[derive(Default)]
struct Uring(Folder);

#[cfg(target_os = "linux")]
impl Subject for Uring {
    type File = super::UringFile;

    fn create(&self) -> super::UringFile {
        super::UringFile::create(&self.0.file()).unwrap()
    }

    fn holding(&self, bytes: &[u8]) -> super::UringFile {
        super::UringFile::open(&self.0.with(bytes)).unwrap()
    }

    fn path(&self) -> Option<PathBuf> {
        Some(self.0.file())
    }
}

/// The suite for a backend, unless the system has none.
macro_rules! promises {
    ($name:ident, $subject:ty, if $available:expr) => {
        mod $name {
            use super::*;

            promises!($subject, $available, reads: ranges_are_read_exactly);
            promises!($subject, $available, reads: no_bytes_are_there_wherever_they_are_asked_for);
            promises!($subject, $available, reads: what_is_not_there_takes_no_memory);
            promises!($subject, $available, reads: long_ranges_are_read_whole);
            promises!($subject, $available, reads: answers_come_in_the_order_of_the_ranges);
            promises!($subject, $available, reads: a_short_file_is_read_to_its_last_byte);
            promises!($subject, $available, writes: files_grow_as_they_are_written);
            promises!($subject, $available, writes: gaps_read_as_zeros);
            promises!($subject, $available, writes: impossible_places_are_errors);
            promises!($subject, $available, writes: many_writers_at_once);
            promises!($subject, $available, writes: a_dropped_write_is_done_all_the_same);
            promises!($subject, $available, shared: thousands_of_reads_at_once);
            promises!($subject, $available, shared: dropped_reads_disturb_no_others);
            promises!($subject, $available, shared: runtimes_come_and_go);
            promises!($subject, $available, shared: bytes_outlive_their_file);
            promises!($subject, $available, shared: an_open_file_stays_what_it_was);
        }
    };
    ($subject:ty, $available:expr, $part:ident: $promise:ident) => {
        #[test]
        fn $promise() {
            if $available {
                $part::$promise(&<$subject>::default());
            } else {
                eprintln!("skipped: this system refuses the backend");
            }
        }
    };
}

promises!(memory, Memory, if true);
promises!(threads, Threads, if true);
#[cfg(target_os = "linux")]
promises!(uring, Uring, if crate::io::uring::Ring::shared().is_ok());
