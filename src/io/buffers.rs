//! Buffers for tiles, kept for reuse once no reader is left.
//!
//! A scan reads thousands of tiles of about the same size. If each buffer went back to the system's
//! allocator, every reading thread would keep some memory for itself, several times what is in use,
//! and pages that were just read would be cleared again. The same holds for tiles that are written.

use std::collections::VecDeque;
use std::ops::{Deref, Range};
use std::sync::Arc;

use bytes::Bytes;
use parking_lot::Mutex;

/// Reads of fewer bytes than this get buffers of their own, which are not kept.
pub(super) const SMALL: usize = 256 << 10;
/// The default limit on the buffers that are kept.
const KEPT: usize = 4;
/// Memory that is not in use, oldest first. Clones share it.
#[derive(Debug)]
pub(super) struct FreeList<M> {
    free: Arc<Mutex<VecDeque<M>>>,
    most: usize,
}

impl<M> Clone for FreeList<M> {
    fn clone(&self) -> Self {
        Self {
            free: Arc::clone(&self.free),
            most: self.most,
        }
    }
}

impl<M: Deref<Target = [u8]>> FreeList<M> {
    /// Creates a list that keeps at most `most` entries.
    pub(super) fn new(most: usize) -> Self {
        Self {
            free: Arc::default(),
            most,
        }
    }

    /// Takes memory of at least `length` bytes, and not many more.
    pub(super) fn find(&self, length: usize) -> Option<M> {
        let mut free = self.free.lock();
        // Memory that is much too large would occupy more than its length suggests.
        let fits = |memory: &M| (length..=rounded(length)).contains(&memory.len());
        // What was used last may still be in the processor's caches.
        match free.iter().rposition(fits) {
            Some(index) => free.remove(index),
            None => {
                // Memory that does not fit now may never fit again. Dropping it ensures that there
                // is never more memory than was in use at once.
                free.pop_front();
                None
            }
        }
    }

    /// Keeps the memory, unless the list is full.
    pub(super) fn give_back(&self, memory: M) {
        let mut free = self.free.lock();
        if free.len() < self.most {
            free.push_back(memory);
        }
    }

    /// Releases the kept memory.
    pub(super) fn clear(&self) {
        self.free.lock().clear();
    }

    #[cfg(test)]
    pub(super) fn count(&self) -> usize {
        self.free.lock().len()
    }
}

/// Buffers that are not in use, oldest first. Clones share them.
#[derive(Clone, Debug)]
pub(crate) struct Buffers(FreeList<Vec<u8>>);

impl Default for Buffers {
    fn default() -> Self {
        Self::keeping(KEPT)
    }
}

impl Buffers {
    /// Creates a pool that keeps at most `kept` buffers.
    pub(crate) fn keeping(kept: usize) -> Self {
        Self(FreeList::new(kept))
    }

    /// Returns a buffer of `length` bytes of arbitrary content.
    pub(super) fn take(&self, length: usize) -> Buffer {
        let found = self.find(length);
        Buffer {
            bytes: found.unwrap_or_else(|| vec![0; rounded(length)]),
            part: 0..length,
            owner: self.clone(),
        }
    }

    /// Returns at least `length` bytes, all 0, which [`freeze`](Self::freeze) can take back.
    pub(crate) fn zeroed(&self, length: usize) -> Vec<u8> {
        match self.find(length) {
            Some(mut bytes) => {
                bytes.fill(0);
                bytes
            }
            None => vec![0; rounded(length)],
        }
    }

    /// Returns bytes for reading. They are kept for reuse when the last part of these bytes is
    /// dropped.
    pub(crate) fn freeze(&self, bytes: Vec<u8>) -> Bytes {
        let (part, owner) = (0..bytes.len(), self.clone());
        Buffer { bytes, part, owner }.freeze()
    }

    /// Releases the kept buffers.
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

/// Rounds `length` up by at most an eighth, so that tiles of nearly the same length use the same
/// buffers. Memory that is never written occupies none.
pub(super) fn rounded(length: usize) -> usize {
    if length < SMALL {
        return length;
    }
    length.next_multiple_of(length.next_power_of_two() / 16)
}

/// A buffer that goes back to its pool when it is dropped.
#[derive(Debug)]
pub(super) struct Buffer {
    bytes: Vec<u8>,
    /// The part that is read into.
    part: Range<usize>,
    owner: Buffers,
}

impl Buffer {
    /// Returns the bytes, to read into.
    pub(super) fn as_mut(&mut self) -> &mut [u8] {
        &mut self.bytes[self.part.clone()]
    }

    /// Returns the bytes for reading. The buffer is kept for reuse when the last part of them is
    /// dropped.
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
    fn buffers_are_reused_once_no_reader_is_left() {
        let buffers = Buffers::default();
        let mut buffer = buffers.take(SMALL + 100);
        buffer.as_mut().fill(7);
        let bytes = buffer.freeze();
        assert_eq!(bytes.len(), SMALL + 100);
        let (address, part) = (bytes.as_ptr(), bytes.slice(10..20));
        drop(bytes);
        assert_ne!(buffers.take(SMALL + 50).bytes.as_ptr(), address, "a part is in use");
        drop(part);
        let (a, b) = (buffers.take(SMALL + 300), buffers.take(SMALL + 1));
        assert!([&a, &b].iter().any(|buffer| buffer.bytes.as_ptr() == address));
        assert_eq!(a.freeze().len(), SMALL + 300);
        assert_eq!(buffers.take(10).freeze(), [0; 10][..]);
    }

    #[test]
    fn the_pool_keeps_few_buffers_and_none_that_is_much_too_large() {
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
