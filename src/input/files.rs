//! Files one after the other, for the sources of segments and of sites.
//!
//! On open every file is opened, so that its reader can be asked about it, and closed again, but the first one and those
//! that can be read only once (pipes). Reading goes through [`Files::current`] and [`Files::next_file`].

use super::InputError;
use super::bytes::{ByteInput, open_file};
use std::collections::VecDeque;
use std::fs::Metadata;
use std::path::{Path, PathBuf};

/// Starts the reader of a file.
type Start<R> = Box<dyn Fn(&Path, ByteInput) -> Result<R, InputError> + Send + Sync>;

pub(super) struct Files<R> {
    waiting: VecDeque<(PathBuf, Option<R>)>,
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
            unzip,
            start,
        };
        for path in paths {
            let (reader, once) = files.open_one(path)?;
            look(&reader);
            let keep = once || files.waiting.is_empty();
            files.waiting.push_back((path.clone(), keep.then_some(reader)));
        }
        Ok(files)
    }

    /// The reader of a file, and whether the file can be read only once.
    fn open_one(&self, path: &Path) -> Result<(R, bool), InputError> {
        let (file, metadata) = open_file(path)?;
        let size = metadata.as_ref().map(Metadata::len);
        let input = ByteInput::new(path.into(), Box::new(file), size, (self.unzip)(path))?;
        Ok(((self.start)(path, input)?, metadata.is_none()))
    }

    /// The file at hand; `None` after the last one.
    pub fn current(&mut self) -> Result<Option<(&Path, &mut R)>, InputError> {
        if let Some((path, None)) = self.waiting.front() {
            let (reader, _) = self.open_one(&path.clone())?;
            if let Some((_, waiting)) = self.waiting.front_mut() {
                *waiting = Some(reader);
            }
        }
        Ok(match self.waiting.front_mut() {
            Some((path, Some(reader))) => Some((path, reader)),
            _ => None,
        })
    }

    /// Goes to the next file.
    pub fn next_file(&mut self) {
        self.waiting.pop_front();
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
