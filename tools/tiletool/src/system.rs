//! What the system does to a process that reaches a limit: each ends the tool with one line and exit code 1.
//!
//! A process ends here without clean-up, so files may stay under their unfinished names. The next run that makes the same output
//! removes them.

#![allow(unsafe_code, reason = "an allocator and signal handlers are unsafe to provide")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, Ordering};

/// The system's allocator, except that a refusal ends the process with an error rather than with SIGABRT.
#[derive(Debug)]
pub struct Ending;

// SAFETY: all calls go to `System` as they come, and what it returns is returned unless it is null.
unsafe impl GlobalAlloc for Ending {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller vouches for the layout.
        given(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller vouches for the layout.
        given(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller vouches for memory and layout.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller vouches for memory, layout and size.
        given(unsafe { System.realloc(memory, layout, size) }, size)
    }
}

#[inline]
fn given(memory: *mut u8, bytes: usize) -> *mut u8 {
    if memory.is_null() {
        refused(bytes);
    }
    memory
}

/// Ends the process for want of memory, without allocating any.
#[cold]
fn refused(mut bytes: usize) -> ! {
    let mut digits = [0; 20];
    let mut at = digits.len();
    while bytes > 0 || at == digits.len() {
        at -= 1;
        digits[at] = b'0' + (bytes % 10) as u8;
        bytes /= 10;
    }
    end(&[
        b"error: the system refuses ",
        &digits[at..],
        b" bytes of memory; lower --memory or raise the limit (ulimit -v)\n",
    ])
}

/// Prints a line and ends the process at once, for the first thread that comes here; others wait for that. May be called in a
/// signal handler.
fn end(parts: &[&[u8]]) -> ! {
    static IS_ENDING: AtomicBool = AtomicBool::new(false);
    while IS_ENDING.swap(true, Ordering::SeqCst) {
        // SAFETY: it takes nothing, and returns after a signal.
        unsafe { libc::pause() };
    }
    for part in parts {
        // SAFETY: the pointer and the length are those of a slice.
        unsafe { libc::write(libc::STDERR_FILENO, part.as_ptr().cast(), part.len()) };
    }
    // SAFETY: it takes any number, and does not return.
    unsafe { libc::_exit(1) }
}

/// Ends the process since a thread cannot have its stack.
pub fn refuse_stack() -> ! {
    end(&[b"error: the system refuses memory for a thread; lower --memory or raise the limit (ulimit -v)\n"])
}

extern "C" fn processor_time_is_over(_: libc::c_int) {
    end(&[b"error: the processor time that this process may take is over (ulimit -t)\n"]);
}

extern "C" fn aborted(_: libc::c_int) {
    end(&[b"error: the C library had no memory; lower --memory or raise the limit (ulimit -v)\n"]);
}

/// Prepares for limits: a write beyond the largest length of a file is an error, processor time that is over is told, and where memory
/// is limited the allocator reserves less of it.
pub fn prepare(is_memory_limited: bool) {
    let handler = |handler: extern "C" fn(libc::c_int)| handler as libc::sighandler_t;
    // SAFETY: the handlers call nothing but `write` and `_exit`, which signal handlers may call, and no other thread runs yet.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
        libc::signal(libc::SIGXCPU, handler(processor_time_is_over));
        if is_memory_limited {
            // The C library aborts where it cannot do without memory.
            libc::signal(libc::SIGABRT, handler(aborted));
            #[cfg(target_env = "gnu")]
            {
                // Larger steps: it is then rarely the C library that is refused the next one.
                libc::mallopt(libc::M_TOP_PAD, 1 << 20);
            }
        }
    }
}
