//! Files one after the other, for the sources of segments and of sites.
//!
//! On open every file is opened, so that its reader can be asked about it, and closed again, but the first one and those
//! that can be read only once (pipes). Reading goes through [`Files::current`] and [`Files::next_file`].

use super::InputError;
use super::bytes::ByteInput;
use super::watch::{FileStamp, Reading, Watch, Watched, note};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Starts the reader of a file.
type Start<R> = Box<dyn Fn(&Path, ByteInput) -> Result<R, InputError> + Send + Sync>;

/// A file that is being read.
struct Opened<R> {
    reader: R,
    watch: Arc<Watch>,
}

/// A file that is not done, and what it was when it was looked at.
struct Waiting<R> {
    path: PathBuf,
    stamp: Option<FileStamp>,
    opened: Option<Opened<R>>,
}

pub(super) struct Files<R> {
    waiting: VecDeque<Waiting<R>>,
    stamps: Vec<(PathBuf, FileStamp)>,
    reading: Reading,
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
            stamps: Vec::new(),
            reading: Reading::default(),
            done_bytes: 0,
            unzip,
            start,
        };
        for path in paths {
            let opened = files.open_one(path, None)?;
            look(&opened.reader);
            let stamp = opened.watch.stamp();
            note(&mut files.stamps, &opened.watch);
            // What can be read only once stays open.
            let keep = stamp.is_none() || files.waiting.is_empty();
            files.waiting.push_back(Waiting {
                path: path.clone(),
                stamp,
                opened: keep.then_some(opened),
            });
        }
        Ok(files)
    }

    fn open_one(&self, path: &Path, before: Option<FileStamp>) -> Result<Opened<R>, InputError> {
        let file = Watched::open(path, &self.reading, before)?;
        let watch = Arc::clone(&file.watch);
        let input = ByteInput::new(file, (self.unzip)(path));
        let reader = input.and_then(|input| (self.start)(path, input));
        let reader = reader.map_err(|error| watch.explain(error))?;
        Ok(Opened { reader, watch })
    }

    /// The file at hand; `None` after the last one.
    pub fn current(&mut self) -> Result<Option<(&Path, &mut R)>, InputError> {
        self.reading.check()?;
        if let Some(Waiting {
            path,
            stamp,
            opened: None,
        }) = self.waiting.front()
        {
            let opened = self.open_one(path, *stamp)?;
            if let Some(waiting) = self.waiting.front_mut() {
                waiting.opened = Some(opened);
            }
        }
        Ok(match self.waiting.front_mut() {
            Some(Waiting {
                path,
                opened: Some(opened),
                ..
            }) => Some((path, &mut opened.reader)),
            _ => None,
        })
    }

    fn watch(&self) -> Option<&Watch> {
        let opened = self.waiting.front().and_then(|waiting| waiting.opened.as_ref());
        opened.map(|opened| &*opened.watch)
    }

    /// Goes to the next file. Fails if the one at hand has changed since it was opened.
    pub fn next_file(&mut self) -> Result<(), InputError> {
        self.watch().map_or(Ok(()), Watch::check)?;
        self.done_bytes = self.bytes_read();
        self.waiting.pop_front();
        Ok(())
    }

    /// The error that an error of the reader at hand comes from.
    pub fn explain(&self, error: InputError) -> InputError {
        match self.watch() {
            Some(watch) => watch.explain(error),
            None => error,
        }
    }

    /// Bytes read of the files so far, as they are on the disk; what was read ahead counts.
    pub fn bytes_read(&self) -> u64 {
        self.done_bytes + self.watch().map_or(0, Watch::taken)
    }

    /// How far the reading is, and the way to stop it.
    pub fn reading(&self) -> &Reading {
        &self.reading
    }

    /// All regular files, as they were when they were looked at.
    pub fn stamps(&self) -> &[(PathBuf, FileStamp)] {
        &self.stamps
    }

    /// Leaves out all files that are left.
    pub fn clear(&mut self) {
        self.waiting.clear();
    }

    /// The files that are left.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.waiting.iter().map(|waiting| waiting.path.as_path())
    }
}

/// The name of a file without its folder.
pub(super) fn name_of(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}
