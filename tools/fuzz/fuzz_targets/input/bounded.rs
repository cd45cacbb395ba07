//! An allocator with a limit, since the fuzzer's own limits need a sanitizer.

use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr::null_mut;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The limit on the bytes that are allocated at a time: far above what a file of some 100 KB needs.
const MOST: usize = 128 << 20;

static ALLOCATED: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, which refuses what exceeds the limit. The process then aborts.
#[derive(Debug)]
pub struct Bounded;

impl Bounded {
    /// Counts `bytes`, unless they exceed the limit. Returns whether they were counted.
    fn take(bytes: usize) -> bool {
        let is_within = ALLOCATED.fetch_add(bytes, Relaxed).saturating_add(bytes) <= MOST;
        if !is_within {
            ALLOCATED.fetch_sub(bytes, Relaxed);
        }
        is_within
    }
}

// SAFETY: all calls are forwarded to `System` unchanged, or refused.
unsafe impl GlobalAlloc for Bounded {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        match Self::take(layout.size()) {
            // SAFETY: the caller guarantees a valid layout.
            true => unsafe { System.alloc(layout) },
            false => null_mut(),
        }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        match Self::take(layout.size()) {
            // SAFETY: the caller guarantees a valid layout.
            true => unsafe { System.alloc_zeroed(layout) },
            false => null_mut(),
        }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        ALLOCATED.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller guarantees valid memory and layout.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if !Self::take(size) {
            return null_mut();
        }
        ALLOCATED.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller guarantees valid memory, layout and size.
        unsafe { System.realloc(memory, layout, size) }
    }
}
