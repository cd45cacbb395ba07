//! Handlers for a process that reaches a limit of the system. Each ends the tool with one line and
//! exit code 1.
//!
//! The process ends without clean-up, so files may remain under their temporary names. The next run
//! that writes the same output removes them.

#![allow(unsafe_code, reason = "allocators and signal handlers are unsafe to implement")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, Ordering};

/// The system's allocator, except that a failed allocation ends the process with an error instead
/// of SIGABRT.
#[derive(Debug)]
pub struct Ending;

// SAFETY: all calls are forwarded to `System` unchanged, and its result is returned unless it is
// null.
unsafe impl GlobalAlloc for Ending {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller guarantees a valid layout.
        checked(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller guarantees a valid layout.
        checked(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller guarantees valid memory and layout.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller guarantees valid memory, layout and size.
        checked(unsafe { System.realloc(memory, layout, size) }, size)
    }
}

#[inline]
fn checked(memory: *mut u8, bytes: usize) -> *mut u8 {
    if memory.is_null() {
        end_without_memory(bytes);
    }
    memory
}

/// Ends the process with an error that says how many bytes were refused, without allocating memory.
#[cold]
fn end_without_memory(mut bytes: usize) -> ! {
    let mut digits = [0; 20];
    let mut at = digits.len();
    while bytes > 0 || at == digits.len() {
        at -= 1;
        digits[at] = b'0' + (bytes % 10) as u8;
        bytes /= 10;
    }
    end(&[
        b"error: out of memory: the system refused ",
        &digits[at..],
        b" bytes; lower --memory or raise the limit (ulimit -v)\n",
    ])
}

/// Prints a line and ends the process at once. If several threads call this, the first prints and
/// the others wait for the end. May be called in a signal handler.
fn end(parts: &[&[u8]]) -> ! {
    static IS_ENDING: AtomicBool = AtomicBool::new(false);
    while IS_ENDING.swap(true, Ordering::SeqCst) {
        // SAFETY: `pause` has no arguments, and returns after a signal.
        unsafe { libc::pause() };
    }
    for part in parts {
        // SAFETY: the pointer and the length are those of a slice.
        unsafe { libc::write(libc::STDERR_FILENO, part.as_ptr().cast(), part.len()) };
    }
    // SAFETY: `_exit` accepts any number and does not return.
    unsafe { libc::_exit(1) }
}

/// Ends the process because the system refused the stack of a thread.
pub fn refuse_stack() -> ! {
    end(&[b"error: out of memory: the system refused the stack of a thread; lower --memory or raise the limit (ulimit -v)\n"])
}

extern "C" fn processor_time_is_over(_: libc::c_int) {
    end(&[b"error: the limit on processor time is reached (ulimit -t)\n"]);
}

extern "C" fn aborted(_: libc::c_int) {
    end(&[b"error: out of memory in the C library; lower --memory or raise the limit (ulimit -v)\n"]);
}

/// Installs the handlers. A write beyond the maximum file length becomes an error, and the end of
/// the allowed processor time is reported. Where memory is limited, an abort of the C library is
/// reported too, and the allocator requests memory in larger steps.
pub fn prepare(is_memory_limited: bool) {
    let handler = |handler: extern "C" fn(libc::c_int)| handler as libc::sighandler_t;
    // SAFETY: the handlers call only `write`, `pause` and `_exit`, which are async-signal-safe, and
    // no other thread runs yet.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
        libc::signal(libc::SIGXCPU, handler(processor_time_is_over));
        if is_memory_limited {
            // The C library aborts if it cannot continue without memory.
            libc::signal(libc::SIGABRT, handler(aborted));
            #[cfg(target_env = "gnu")]
            {
                // With larger steps it is rarely the C library itself whose request is refused.
                libc::mallopt(libc::M_TOP_PAD, 1 << 20);
            }
        }
    }
}
