//! Files that must not change while they are read, and reading whose progress is visible and that
//! can be stopped.
//!
//! In: a path or a stream. Out: a [`Watched`] reader of the bytes, and its [`Watch`], which checks
//! at the end whether the file is the same as at opening. All readers of this module get their
//! bytes from here.
//!
//! A regular file has changed if its length or its time of modification differs, if it ended before
//! or after its length, or if a path that is opened again names another file. Streams have no
//! length, so nothing is compared.

use crate::input::error::InputError;
use crate::input::layer;
use parking_lot::Mutex;
use std::fs::{File, Metadata};
use std::io;
use std::io::{Read, Seek, SeekFrom};
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The identity of a file and its state at one time, to detect changes.
/// [`Source::stamps`](crate::input::Source::stamps) returns the stamps of a source.
///
/// ```
/// use delaunay_tiles::input::SegmentSource;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let dir = tempfile::tempdir()?;
/// let path = dir.path().join("walls.u32");
/// std::fs::write(&path, [0u32, 7].map(u32::to_le_bytes).concat())?;
/// let first = SegmentSource::open(&[path.clone()])?;
///
/// std::fs::write(&path, [0u32, 7, 7, 3].map(u32::to_le_bytes).concat())?;
/// let second = SegmentSource::open(&[path])?;
/// let change = second.stamps()[0].1.change_since(&first.stamps()[0].1);
/// assert_eq!(change.as_deref(), Some("it had 8 bytes, and has 16"));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct FileStamp {
    /// The length in bytes.
    pub length: u64,
    /// The time of the last modification, in nanoseconds since 1970.
    pub modified: i128,
    /// The number of the file system.
    pub device: u64,
    /// The number of the file in its file system.
    pub inode: u64,
}

impl FileStamp {
    fn of(metadata: &Metadata) -> Self {
        Self {
            length: metadata.len(),
            modified: i128::from(metadata.mtime()) * 1_000_000_000 + i128::from(metadata.mtime_nsec()),
            device: metadata.dev(),
            inode: metadata.ino(),
        }
    }

    /// Describes how the file changed from the stamp `before` to this one; `None` if it did not
    /// change.
    #[must_use]
    pub fn change_since(&self, before: &Self) -> Option<String> {
        if (self.device, self.inode) != (before.device, before.inode) {
            Some("another file has taken its place".to_owned())
        } else if self.length != before.length {
            Some(format!("it had {} bytes, and has {}", before.length, self.length))
        } else if self.modified != before.modified {
            Some("it was written to".to_owned())
        } else {
            None
        }
    }
}

/// The progress of the reading of a source, and a way to stop it. Clones share their state.
///
/// ```
/// use delaunay_tiles::input::{InputError, InputOptions, PointBatch, PointSource};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let bytes = [0; 1600];
/// let options = InputOptions::default().format(delaunay_tiles::input::Format::F64);
/// let mut source = PointSource::from_reader("zeros", Box::new(std::io::Cursor::new(bytes)), &options)?;
///
/// let reading = source.reading().clone();
/// std::thread::spawn(move || reading.stop()).join().expect("nothing panics there");
/// assert!(matches!(source.next_batch(&mut PointBatch::default()), Err(InputError::Stopped)));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Reading(Arc<ReadingState>);

#[derive(Debug, Default)]
struct ReadingState {
    bytes: AtomicU64,
    is_stopped: AtomicBool,
}

impl Reading {
    /// Returns the number of bytes read so far. In compressed files, compressed bytes count; the
    /// beginnings of files count twice.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.0.bytes.load(Ordering::Relaxed)
    }

    /// Makes the source fail with [`InputError::Stopped`], after reading at most about 256 KiB
    /// more.
    pub fn stop(&self) {
        self.0.is_stopped.store(true, Ordering::Relaxed);
    }

    /// Returns whether the reading was stopped.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.0.is_stopped.load(Ordering::Relaxed)
    }

    /// Fails if the reading was stopped.
    pub(super) fn check(&self) -> Result<(), InputError> {
        match self.is_stopped() {
            true => Err(InputError::Stopped),
            false => Ok(()),
        }
    }

    /// Fails if the reading was stopped. For readers of bytes; [`Watch::explain`] turns the error
    /// into the one that a caller gets.
    pub(super) fn check_io(&self) -> io::Result<()> {
        match self.is_stopped() {
            true => Err(io::Error::other("reading was stopped")),
            false => Ok(()),
        }
    }
}

/// The state of an input while it is read.
pub struct Watch {
    pub path: Arc<Path>,
    pub reading: Reading,
    /// The file and its stamp at opening, if it is a regular file.
    file: Option<(Arc<File>, FileStamp)>,
    taken: AtomicU64,
    /// The smallest offset at which there were no more bytes; `u64::MAX` if the end was not
    /// reached.
    end: AtomicU64,
    /// The files beside it that are read with it.
    beside: Mutex<Vec<Arc<Watch>>>,
}

/// A reader that counts the bytes it hands out, and that can be stopped.
pub struct Watched<R> {
    inner: R,
    position: u64,
    pub watch: Arc<Watch>,
}

impl Watched<Arc<File>> {
    /// Opens a file. If it was opened before, it must be the same file and unchanged.
    pub fn open(path: &Path, reading: &Reading, before: Option<FileStamp>) -> Result<Self, InputError> {
        let (file, metadata) = open_file(path)?;
        let file = Arc::new(file);
        let stamp = metadata.as_ref().map(FileStamp::of);
        if let Some(before) = before {
            let change = stamp.map_or_else(
                || Some("it is no longer a regular file".to_owned()),
                |stamp| stamp.change_since(&before),
            );
            if let Some(what) = change {
                return Err(changed(path, what));
            }
        }
        Ok(Self::new(
            Arc::clone(&file),
            path,
            reading,
            stamp.map(|stamp| (file, stamp)),
        ))
    }
}

impl Watched<Arc<File>> {
    /// Returns the first bytes of a regular file, without reading on; none if that fails.
    pub fn head(&self) -> Vec<u8> {
        let mut head = vec![0; 512];
        let read = self.watch.size().and_then(|_| self.inner.read_at(&mut head, 0).ok());
        head.truncate(read.unwrap_or(0));
        head
    }
}

impl<R> Watched<R> {
    /// Wraps a stream; messages use `name` as its name.
    pub fn stream(inner: R, name: &Path, reading: &Reading) -> Self {
        Self::new(inner, name, reading, None)
    }

    fn new(inner: R, path: &Path, reading: &Reading, file: Option<(Arc<File>, FileStamp)>) -> Self {
        Self {
            inner,
            position: 0,
            watch: Arc::new(Watch {
                path: path.into(),
                reading: reading.clone(),
                file,
                taken: AtomicU64::new(0),
                end: AtomicU64::new(u64::MAX),
                beside: Mutex::new(Vec::new()),
            }),
        }
    }
}

impl<R: Read> Read for Watched<R> {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        let watch = &self.watch;
        watch.reading.check_io()?;
        let n = self.inner.read(buf)?;
        if n == 0 && !buf.is_empty() {
            watch.end.fetch_min(self.position, Ordering::Relaxed);
        }
        self.position += n as u64;
        watch.taken.fetch_add(n as u64, Ordering::Relaxed);
        watch.reading.0.bytes.fetch_add(n as u64, Ordering::Relaxed);
        Ok(n)
    }
}

impl<R: Seek> Seek for Watched<R> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.position = self.inner.seek(to)?;
        Ok(self.position)
    }
}

impl Watch {
    /// Opens a file beside this one, which must then not change either.
    pub fn open_beside(&self, path: &Path) -> Result<Watched<Arc<File>>, InputError> {
        let file = Watched::open(path, &self.reading, None)?;
        self.beside.lock().push(Arc::clone(&file.watch));
        Ok(file)
    }

    /// Returns the files beside this one that were opened, with their stamps.
    pub fn stamps_beside(&self) -> Vec<(PathBuf, FileStamp)> {
        let mut stamps = Vec::new();
        self.beside.lock().iter().for_each(|watch| note(&mut stamps, watch));
        stamps
    }

    /// Fails if a file beside this one has changed since it had the stamp `before`.
    pub fn check_beside(&self, before: &[(PathBuf, FileStamp)]) -> Result<(), InputError> {
        for (path, now) in self.stamps_beside() {
            let before = before.iter().find(|(of, _)| *of == path);
            if let Some(what) = before.and_then(|(_, before)| now.change_since(before)) {
                return Err(changed(&path, what));
            }
        }
        Ok(())
    }

    /// Returns the stamp of the file at opening; `None` for streams.
    pub fn stamp(&self) -> Option<FileStamp> {
        self.file.as_ref().map(|(_, stamp)| *stamp)
    }

    /// Returns the length of the file at opening; `None` for streams.
    pub fn size(&self) -> Option<u64> {
        self.stamp().map(|stamp| stamp.length)
    }

    /// Counts bytes that were read from the file in another way.
    pub fn advance(&self, bytes: u64) {
        self.taken.fetch_add(bytes, Ordering::Relaxed);
        self.reading.0.bytes.fetch_add(bytes, Ordering::Relaxed);
    }

    /// Returns the number of bytes handed out so far.
    pub fn taken(&self) -> u64 {
        self.taken.load(Ordering::Relaxed)
    }

    /// Fails if the file has changed since it was opened. To be called after everything was read.
    pub fn check(&self) -> Result<(), InputError> {
        self.beside.lock().iter().try_for_each(|watch| watch.check())?;
        let Some((file, before)) = &self.file else {
            return Ok(());
        };
        let metadata = file
            .metadata()
            .map_err(|source| InputError::read(&self.path, self.taken(), source))?;
        if let Some(what) = FileStamp::of(&metadata).change_since(before) {
            return Err(changed(&self.path, what));
        }
        match self.end.load(Ordering::Relaxed) {
            u64::MAX => Ok(()),
            end if end == before.length => Ok(()),
            end => Err(changed(
                &self.path,
                format!("it had {} bytes, and ended after {end}", before.length),
            )),
        }
    }

    /// Returns the cause of a reader's error: that the reading was stopped, that the file changed,
    /// or else `error` itself.
    pub fn explain(&self, error: InputError) -> InputError {
        let checked = self.reading.check().and_then(|()| self.check());
        checked.err().unwrap_or(error)
    }
}

fn changed(path: &Path, what: String) -> InputError {
    InputError::Changed {
        path: path.to_owned(),
        what,
    }
}

/// Adds the stamp of a regular file to `stamps`, and those of the files beside it.
pub fn note(stamps: &mut Vec<(PathBuf, FileStamp)>, watch: &Watch) {
    stamps.extend(watch.stamp().map(|stamp| (watch.path.to_path_buf(), stamp)));
    stamps.extend(watch.stamps_beside());
}

/// Opens a file, and returns its metadata if it is a regular file: pipes and devices have no size.
/// Where the path names a layer, the file that has it is opened.
pub fn open_file(path: &Path) -> Result<(File, Option<Metadata>), InputError> {
    let open = || {
        let file = File::open(layer::file(path))?;
        let metadata = file.metadata()?;
        Ok((file, metadata.is_file().then_some(metadata)))
    };
    open().map_err(|source| InputError::Open {
        path: path.to_owned(),
        source,
    })
}
