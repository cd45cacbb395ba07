//! The lock by which a reader keeps edits from overwriting what it reads.
//!
//! An edit overwrites what neither the state in force refers to, nor any earlier one that somebody
//! reads. A reader locks the number of the generation that it finds in force. If that generation is
//! still in force after this, every later edit sees the lock. Where files cannot be locked, edits
//! overwrite nothing.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::Arc;

use bytes::Bytes;
use futures::future::BoxFuture;

use crate::io::{ReadAt, lock_shared};
use crate::store::format::limits::FIRST_EXTENT;
use crate::store::format::superblock::Superblock;

/// A file with the lock of a reader. The lock ends when nobody reads the file any more.
struct Locked {
    source: Arc<dyn ReadAt>,
    _lock: File,
}

/// Returns a source for readers of the file at a path, or the same one if the file cannot be locked
/// or is no tile file.
pub(super) fn locked(source: Arc<dyn ReadAt>, path: &Path) -> Arc<dyn ReadAt> {
    match lock(path) {
        Ok(Some(lock)) => Arc::new(Locked { source, _lock: lock }),
        Ok(None) => source,
        Err(error) => {
            tracing::debug!(file = %path.display(), %error, "cannot lock the state that is read");
            source
        }
    }
}

/// Locks the generation of a file that is in force.
fn lock(path: &Path) -> io::Result<Option<File>> {
    loop {
        // An attempt that came too late releases its lock by closing the file.
        let file = File::open(path)?;
        let Some(superblock) = in_force(&file)? else {
            return Ok(None);
        };
        lock_shared(&file, superblock.generation)?;
        if in_force(&file)? == Some(superblock) {
            return Ok(Some(file));
        }
    }
}

fn in_force(file: &File) -> io::Result<Option<Superblock>> {
    let mut head = [0; FIRST_EXTENT as usize];
    match file.read_exact_at(&mut head, 0) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        read => read?,
    }
    Ok(Superblock::choose(&head).ok().map(|in_force| in_force.superblock))
}

impl ReadAt for Locked {
    fn length(&self) -> u64 {
        self.source.length()
    }

    fn backend(&self) -> &'static str {
        self.source.backend()
    }

    fn note(&self) -> Option<&str> {
        self.source.note()
    }

    fn read_at(&self, range: Range<u64>) -> BoxFuture<'static, io::Result<Bytes>> {
        self.source.read_at(range)
    }

    fn read_many(&self, ranges: &[Range<u64>]) -> BoxFuture<'static, io::Result<Vec<Bytes>>> {
        self.source.read_many(ranges)
    }

    fn rest(&self) {
        self.source.rest();
    }
}
