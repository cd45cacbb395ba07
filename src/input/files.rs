//! Files one after the other, for the sources of segments and of sites.
//!
//! On open every file is opened, so that its reader can be asked about it, and closed again, but the first one and those
//! that can be read only once (pipes). Reading goes through [`Files::current`] and [`Files::next_file`].

use super::InputError;
use super::bytes::{ByteInput, open_file};
use std::collections::VecDeque;
use std::fs::Metadata;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Starts the reader of a file.
type Start<R> = Box<dyn Fn(&Path, ByteInput) -> Result<R, InputError> + Send + Sync>;

/// A file that is being read.
struct Opened<R> {
    reader: R,
    /// Bytes that were read of it.
    bytes: Arc<AtomicU64>,
}

/// Counts what is read.
struct Counted<T> {
    read: T,
    bytes: Arc<AtomicU64>,
}

impl<T: Read> Read for Counted<T> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.read.read(buffer)?;
        self.bytes.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

pub(super) struct Files<R> {
    waiting: VecDeque<(PathBuf, Option<Opened<R>>)>,
    /// Bytes of the files that are done.
    done_bytes: u64,
    /// Whether the bytes of this file tell that it is gzip.
    unzip: fn(&Path) -> bool,
    start: Start<R>,
}

impl<R> Files<R> {
    /// Opens the files in this order, and shows each one's reader to `look`.
    pub fn open(
        paths: &[PathBuf],
        unzip: fn(&Path) -> bool,
        start: Start<R>,
        mut look: impl FnMut(&R),
    ) -> Result<Self, InputError> {
        let mut files = Self {
            waiting: VecDeque::new(),
            done_bytes: 0,
            unzip,
            start,
        };
        for path in paths {
            let (opened, once) = files.open_one(path)?;
            look(&opened.reader);
            let keep = once || files.waiting.is_empty();
            files.waiting.push_back((path.clone(), keep.then_some(opened)));
        }
        Ok(files)
    }

    /// The reader of a file, and whether the file can be read only once.
    fn open_one(&self, path: &Path) -> Result<(Opened<R>, bool), InputError> {
        let (file, metadata) = open_file(path)?;
        let size = metadata.as_ref().map(Metadata::len);
        let bytes = Arc::default();
        let read = Counted {
            read: file,
            bytes: Arc::clone(&bytes),
        };
        let input = ByteInput::new(path.into(), Box::new(read), size, (self.unzip)(path))?;
        let reader = (self.start)(path, input)?;
        Ok((Opened { reader, bytes }, metadata.is_none()))
    }

    /// The file at hand; `None` after the last one.
    pub fn current(&mut self) -> Result<Option<(&Path, &mut R)>, InputError> {
        if let Some((path, None)) = self.waiting.front() {
            let (opened, _) = self.open_one(&path.clone())?;
            if let Some((_, waiting)) = self.waiting.front_mut() {
                *waiting = Some(opened);
            }
        }
        Ok(match self.waiting.front_mut() {
            Some((path, Some(opened))) => Some((path, &mut opened.reader)),
            _ => None,
        })
    }

    /// Goes to the next file.
    pub fn next_file(&mut self) {
        self.done_bytes = self.bytes_read();
        self.waiting.pop_front();
    }

    /// Bytes read of the files so far, as they are on the disk; what was read ahead counts.
    pub fn bytes_read(&self) -> u64 {
        let current = self.waiting.front().and_then(|(_, opened)| opened.as_ref());
        self.done_bytes + current.map_or(0, |opened| opened.bytes.load(Ordering::Relaxed))
    }

    /// Leaves out all files that are left.
    pub fn clear(&mut self) {
        self.waiting.clear();
    }

    /// The files that are left.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.waiting.iter().map(|(path, _)| path.as_path())
    }
}

/// The name of a file without its folder.
pub(super) fn name_of(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}
