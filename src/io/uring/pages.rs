//! Memory for reads that bypass the page cache: whole pages, huge pages for long reads, kept for
//! reuse.
//!
//! A disk gets memory page by page, a few hundred pages at a time, so huge pages make reads faster:
//! blocks of 1 MiB of one file on a virtual disk arrived at 3.7 GB/s in huge pages and at 1.3 GB/s
//! in others, at any queue depth.

use std::io;
use std::ops::Range;

use bytes::Bytes;
use memmap2::{Advice, MmapMut};
use tokio_uring::buf::{IoBuf, IoBufMut};

use crate::io::buffers::{FreeList, SMALL, rounded};
use crate::io::file::{HUGE_PAGE, in_huge_pages};

/// The alignment in bytes of memory and offsets that suffices for reads that bypass the page cache.
pub(super) const ALIGNMENT: usize = 4096;

/// The memory that is not in use, oldest first. Clones share it.
#[derive(Clone, Debug)]
pub(super) struct PagePool(FreeList<MmapMut>);

/// Memory, and the position in it where the part aligned to [`ALIGNMENT`] begins.
#[derive(Debug)]
pub(super) struct Pages {
    memory: Memory,
    start: usize,
}

#[derive(Debug)]
enum Memory {
    /// Short memory, which is not kept for reuse.
    Short(Vec<u8>),
    Long(MmapMut),
}

impl PagePool {
    /// Creates a pool that keeps at most `kept` mappings.
    pub(super) fn keeping(kept: usize) -> Self {
        Self(FreeList::new(kept))
    }

    /// Returns memory with `length` aligned bytes of arbitrary content.
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
            // If no huge pages are available, other pages are used.
            let _ = memory.advise_range(Advice::HugePage, start, huge);
        }
        Ok(Pages {
            memory: Memory::Long(memory),
            start,
        })
    }

    /// Returns `part` of the aligned bytes for reading. The memory is kept for reuse when the last
    /// part of these bytes is dropped.
    pub(super) fn freeze(&self, pages: Pages, part: Range<usize>) -> Bytes {
        let part = pages.start + part.start..pages.start + part.end;
        assert!(
            part.end <= pages.bytes().len(),
            "a part of {} bytes",
            pages.bytes().len()
        );
        match pages.memory {
            Memory::Short(bytes) => Bytes::from(bytes).slice(part),
            Memory::Long(memory) => Bytes::from_owner(LentPages {
                memory: Some(memory),
                part,
                pool: self.clone(),
            }),
        }
    }

    /// Releases the kept memory.
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

    /// Returns the position where the aligned part begins.
    pub(super) fn start(&self) -> usize {
        self.start
    }
}

// SAFETY: the bytes do not move when the value moves, since they are on the heap or in a mapping of
// their own, and all of them are initialized.
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

// SAFETY: as above. There is nothing to record about what was read, as all bytes are already
// initialized.
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

/// A part of memory that goes back to its pool when it is dropped.
struct LentPages {
    memory: Option<MmapMut>,
    part: Range<usize>,
    pool: PagePool,
}

impl AsRef<[u8]> for LentPages {
    fn as_ref(&self) -> &[u8] {
        self.memory.as_ref().map_or(&[], |memory| &memory[self.part.clone()])
    }
}

impl Drop for LentPages {
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
    fn memory_is_aligned_and_is_reused_once_no_reader_is_left() {
        let pool = PagePool::keeping(2);
        for length in [1, SMALL - 1, SMALL, LONG] {
            let mut pages = pool.take(length).unwrap();
            let start = pages.start();
            let address = pages.bytes().as_ptr();
            assert!(address.addr().wrapping_add(start).is_multiple_of(ALIGNMENT));
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
                assert_ne!(pool.take(length).unwrap().bytes().as_ptr(), address, "a part is in use");
                drop(part);
                assert_eq!(pool.take(length).unwrap().bytes().as_ptr(), address);
            }
        }
    }

    #[test]
    fn the_pool_keeps_a_limited_number_and_no_memory_that_is_much_too_large() {
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
