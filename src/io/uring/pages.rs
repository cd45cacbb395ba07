//! Memory that is read into past the page cache: whole pages, huge ones for much, kept to be used again.
//!
//! A disk is handed memory page by page, some hundred at a time. So huge pages make reads faster: blocks of 1 MiB of one file on a
//! virtual disk came with 3.7 GB/s into huge pages and with 1.3 into others, at any queue depth.

use std::io;
use std::ops::Range;

use bytes::Bytes;
use memmap2::{Advice, MmapMut};
use tokio_uring::buf::{IoBuf, IoBufMut};

use crate::io::buffers::{Kept, SMALL, rounded};
use crate::io::file::{HUGE_PAGE, in_huge_pages};

/// What reads past the page cache ask of memory and offsets, at most, in bytes.
pub(super) const ALIGNMENT: usize = 4096;

/// Memory that nobody reads just now, the oldest first. Clones share it.
#[derive(Clone, Debug)]
pub(super) struct PagePool(Kept<MmapMut>);

/// Memory, and where in it what is aligned to [`ALIGNMENT`] begins.
#[derive(Debug)]
pub(super) struct Pages {
    memory: Memory,
    start: usize,
}

#[derive(Debug)]
enum Memory {
    /// What is short is not kept.
    Short(Vec<u8>),
    Long(MmapMut),
}

impl PagePool {
    /// Keeps no more than so many.
    pub(super) fn keeping(kept: usize) -> Self {
        Self(Kept::new(kept))
    }

    /// Memory of which so many bytes are aligned, whatever they are.
    pub(super) fn take(&self, length: usize) -> io::Result<Pages> {
        if length < SMALL {
            let bytes = vec![0; length + ALIGNMENT];
            let address = bytes.as_ptr().addr();
            return Ok(Pages {
                start: address.next_multiple_of(ALIGNMENT) - address,
                memory: Memory::Short(bytes),
            });
        }
        let huge = in_huge_pages(length);
        let alignment = if huge > 0 { HUGE_PAGE } else { ALIGNMENT };
        let size = length.max(huge) + alignment;
        let mut memory = match self.0.find(size) {
            Some(memory) => memory,
            None => MmapMut::map_anon(rounded(size))?,
        };
        let address = memory.as_mut_ptr().addr();
        let start = address.next_multiple_of(alignment) - address;
        if huge > 0 {
            // Where there are none, the others have to do.
            let _ = memory.advise_range(Advice::HugePage, start, huge);
        }
        Ok(Pages {
            memory: Memory::Long(memory),
            start,
        })
    }

    /// Bytes for others to read, from the aligned ones; the memory is kept when the last of these drops its part.
    pub(super) fn freeze(&self, pages: Pages, part: Range<usize>) -> Bytes {
        let part = pages.start + part.start..pages.start + part.end;
        assert!(
            part.end <= pages.bytes().len(),
            "a part of {} bytes",
            pages.bytes().len()
        );
        match pages.memory {
            Memory::Short(bytes) => Bytes::from(bytes).slice(part),
            Memory::Long(memory) => Bytes::from_owner(Lent {
                memory: Some(memory),
                part,
                pool: self.clone(),
            }),
        }
    }

    /// Gives back what is kept.
    pub(super) fn clear(&self) {
        self.0.clear();
    }
}

impl Pages {
    fn bytes(&self) -> &[u8] {
        match &self.memory {
            Memory::Short(bytes) => bytes,
            Memory::Long(memory) => memory,
        }
    }

    /// Where what is aligned begins.
    pub(super) fn start(&self) -> usize {
        self.start
    }
}

// SAFETY: the bytes stay where they are when the value moves, since they lie on the heap or in a mapping of their own; and all of them
// have a value from the beginning.
#[allow(unsafe_code, reason = "the ring reads into memory by its address")]
unsafe impl IoBuf for Pages {
    fn stable_ptr(&self) -> *const u8 {
        self.bytes().as_ptr()
    }

    fn bytes_init(&self) -> usize {
        self.bytes().len()
    }

    fn bytes_total(&self) -> usize {
        self.bytes().len()
    }
}

// SAFETY: as above; there is nothing to note of what was read, as all bytes have a value already.
#[allow(unsafe_code, reason = "the ring reads into memory by its address")]
unsafe impl IoBufMut for Pages {
    fn stable_mut_ptr(&mut self) -> *mut u8 {
        match &mut self.memory {
            Memory::Short(bytes) => bytes.as_mut_ptr(),
            Memory::Long(memory) => memory.as_mut_ptr(),
        }
    }

    unsafe fn set_init(&mut self, _: usize) {}
}

/// A part of memory that goes back to where it came from.
struct Lent {
    memory: Option<MmapMut>,
    part: Range<usize>,
    pool: PagePool,
}

impl AsRef<[u8]> for Lent {
    fn as_ref(&self) -> &[u8] {
        self.memory.as_ref().map_or(&[], |memory| &memory[self.part.clone()])
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        if let Some(memory) = self.memory.take() {
            self.pool.0.give_back(memory);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONG: usize = 3_400_000;

    #[test]
    fn memory_is_aligned_and_comes_back_once_nobody_reads_it() {
        let pool = PagePool::keeping(2);
        for length in [1, SMALL - 1, SMALL, LONG] {
            let mut pages = pool.take(length).unwrap();
            let start = pages.start();
            let place = pages.bytes().as_ptr();
            assert!(place.addr().wrapping_add(start).is_multiple_of(ALIGNMENT));
            assert!(start + length <= pages.bytes().len());
            match &mut pages.memory {
                Memory::Short(bytes) => bytes[start] = 9,
                Memory::Long(memory) => memory[start] = 9,
            }
            let bytes = pool.freeze(pages, 0..1);
            assert_eq!(bytes, [9][..]);
            let part = bytes.slice(0..1);
            drop(bytes);
            if length >= SMALL {
                assert_ne!(pool.take(length).unwrap().bytes().as_ptr(), place, "a part is in use");
                drop(part);
                assert_eq!(pool.take(length).unwrap().bytes().as_ptr(), place);
            }
        }
    }

    #[test]
    fn little_is_kept_and_nothing_that_is_much_too_large() {
        let pool = PagePool::keeping(4);
        let frozen = |length| pool.freeze(pool.take(length).unwrap(), 0..length);
        drop((0..9).map(|_| frozen(SMALL)).collect::<Vec<_>>());
        assert_eq!(pool.0.count(), 4);
        drop(frozen(LONG));
        assert_eq!(pool.0.count(), 4, "what did not fit made room for one that does");
        drop(frozen(10));
        assert_eq!(pool.0.count(), 4);
        pool.clear();
        assert_eq!(pool.0.count(), 0);
    }
}
