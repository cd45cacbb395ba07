//! Buffers for tiles, kept to be used again once nobody reads what is in them.
//!
//! A scan reads thousands of tiles of about the same size. Were each buffer given back to the system's allocator, every thread
//! that reads would keep some for itself, several times what is in use; and pages that were just read would be cleared again.
//! So with tiles that are written.

use std::collections::VecDeque;
use std::ops::{Deref, Range};
use std::sync::Arc;

use bytes::Bytes;
use parking_lot::Mutex;

/// Reads of fewer bytes than this have buffers of their own.
pub(super) const SMALL: usize = 256 << 10;
/// The most buffers that are kept, if nothing else is said.
const KEPT: usize = 4;
/// Memory that nobody uses just now, the oldest first. Clones share it.
#[derive(Debug)]
pub(super) struct Kept<M> {
    free: Arc<Mutex<VecDeque<M>>>,
    most: usize,
}

impl<M> Clone for Kept<M> {
    fn clone(&self) -> Self {
        Self {
            free: Arc::clone(&self.free),
            most: self.most,
        }
    }
}

impl<M: Deref<Target = [u8]>> Kept<M> {
    /// Keeps no more than so many.
    pub(super) fn new(most: usize) -> Self {
        Self {
            free: Arc::default(),
            most,
        }
    }

    /// Memory of at least so many bytes, and not many more.
    pub(super) fn find(&self, length: usize) -> Option<M> {
        let mut free = self.free.lock();
        // What is much too large would take more than its length says.
        let fits = |memory: &M| (length..=rounded(length)).contains(&memory.len());
        match free.iter().position(fits) {
            Some(place) => free.remove(place),
            None => {
                // What does not fit now may never fit again; so there is never more than was in use at once.
                free.pop_front();
                None
            }
        }
    }

    /// Keeps it, unless there is enough.
    pub(super) fn give_back(&self, memory: M) {
        let mut free = self.free.lock();
        if free.len() < self.most {
            free.push_back(memory);
        }
    }

    /// Gives back to the system what is kept.
    pub(super) fn clear(&self) {
        self.free.lock().clear();
    }

    #[cfg(test)]
    pub(super) fn count(&self) -> usize {
        self.free.lock().len()
    }
}

/// Buffers that nobody uses just now, the oldest first. Clones share them.
#[derive(Clone, Debug)]
pub(crate) struct Buffers(Kept<Vec<u8>>);

impl Default for Buffers {
    fn default() -> Self {
        Self::keeping(KEPT)
    }
}

impl Buffers {
    /// Keeps no more buffers than so many.
    pub(crate) fn keeping(kept: usize) -> Self {
        Self(Kept::new(kept))
    }

    /// A buffer of this many bytes, whatever they are.
    pub(super) fn take(&self, length: usize) -> Buffer {
        let found = self.find(length);
        Buffer {
            bytes: found.unwrap_or_else(|| vec![0; rounded(length)]),
            part: 0..length,
            owner: self.clone(),
        }
    }

    /// At least so many bytes, all 0, for [`freeze`](Self::freeze) to take back.
    pub(crate) fn zeroed(&self, length: usize) -> Vec<u8> {
        match self.find(length) {
            Some(mut bytes) => {
                bytes.fill(0);
                bytes
            }
            None => vec![0; rounded(length)],
        }
    }

    /// Bytes for others to read; they are kept for another buffer when the last of these drops its part.
    pub(crate) fn freeze(&self, bytes: Vec<u8>) -> Bytes {
        let (part, owner) = (0..bytes.len(), self.clone());
        Buffer { bytes, part, owner }.freeze()
    }

    /// Gives back what is kept.
    pub(super) fn clear(&self) {
        self.0.clear();
    }

    fn find(&self, length: usize) -> Option<Vec<u8>> {
        if length < SMALL {
            return None;
        }
        self.0.find(length)
    }
}

/// So many bytes or up to an eighth more, so that tiles of nearly the same length take the same buffers. What is never
/// written takes no memory.
pub(super) fn rounded(length: usize) -> usize {
    if length < SMALL {
        return length;
    }
    length.next_multiple_of(length.next_power_of_two() / 16)
}

/// A buffer that goes back to where it came from.
#[derive(Debug)]
pub(super) struct Buffer {
    bytes: Vec<u8>,
    /// What is to be read into, or was.
    part: Range<usize>,
    owner: Buffers,
}

impl Buffer {
    /// The bytes, to read into.
    pub(super) fn as_mut(&mut self) -> &mut [u8] {
        &mut self.bytes[self.part.clone()]
    }

    /// The bytes for others to read, until the last of them drops its part.
    pub(super) fn freeze(self) -> Bytes {
        Bytes::from_owner(self)
    }
}

impl AsRef<[u8]> for Buffer {
    fn as_ref(&self) -> &[u8] {
        &self.bytes[self.part.clone()]
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        if self.bytes.len() < SMALL {
            return;
        }
        self.owner.0.give_back(std::mem::take(&mut self.bytes));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffers_come_back_once_nobody_reads_them() {
        let buffers = Buffers::default();
        let mut buffer = buffers.take(SMALL + 100);
        buffer.as_mut().fill(7);
        let bytes = buffer.freeze();
        assert_eq!(bytes.len(), SMALL + 100);
        let (place, part) = (bytes.as_ptr(), bytes.slice(10..20));
        drop(bytes);
        assert_ne!(buffers.take(SMALL + 50).bytes.as_ptr(), place, "a part is in use");
        drop(part);
        let (a, b) = (buffers.take(SMALL + 300), buffers.take(SMALL + 1));
        assert!([&a, &b].iter().any(|buffer| buffer.bytes.as_ptr() == place));
        assert_eq!(a.freeze().len(), SMALL + 300);
        assert_eq!(buffers.take(10).freeze(), [0; 10][..]);
    }

    #[test]
    fn few_are_kept_and_none_that_is_much_too_large() {
        let buffers = Buffers::default();
        drop((0..9).map(|_| buffers.take(SMALL)).collect::<Vec<_>>());
        assert_eq!(buffers.0.count(), KEPT);
        assert!(buffers.find(8 * SMALL).is_none());
        assert_eq!(buffers.0.count(), KEPT - 1, "what did not fit made room");
        drop(buffers.take(8 * SMALL));
        assert_eq!(buffers.0.count(), KEPT - 1, "and again, for one that does");
        assert!(buffers.find(8 * SMALL).is_some());
        drop(buffers.take(100));
        assert_eq!(buffers.0.count(), KEPT - 2);
        buffers.clear();
        assert_eq!(buffers.0.count(), 0);
        for length in [SMALL, SMALL + 1, 3_400_000, 15_000_000, 16 << 20] {
            assert!((length..=length + length / 8).contains(&rounded(length)), "{length}");
        }
    }
}
