//! The settings of the C library's allocator that `--memory` needs to hold.
//!
//! The library counts the bytes that it asks for. By default glibc has up to eight arenas for each processor, and each keeps what was
//! given back to it: memory that one thread has freed is of no use to the others. So there is one arena here. What is large is
//! mapped by itself, and so given back at once. These settings concern the whole process, so they are the program's and not the library's.
//!
//! Other allocators have no such settings, and are left as they are.

/// One arena for all threads. To be called before there are any.
pub fn begin() {
    set::arenas(1);
}

/// Has at most a 32nd of this memory, in bytes, kept by the allocator once it was given back, as far as a program can tell it.
pub fn keep_to(memory: u64) {
    /// From so many bytes on an allocation is a mapping of its own, at least and at most. Less costs time, and glibc takes no more.
    const MAPPED: (u64, u64) = (1 << 20, 32 << 20);
    let mapped = (memory / 64).clamp(MAPPED.0, MAPPED.1) as i32;
    set::mapped_from(mapped);
    set::trimmed_from(2 * mapped);
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[allow(unsafe_code, reason = "the C library has no other way to set it")]
mod set {
    use libc::{M_ARENA_MAX, M_MMAP_THRESHOLD, M_TRIM_THRESHOLD, mallopt};

    pub fn arenas(count: i32) {
        // SAFETY: it takes two numbers, and any thread may call it at any time.
        unsafe { mallopt(M_ARENA_MAX, count) };
    }

    pub fn mapped_from(bytes: i32) {
        // SAFETY: as above.
        unsafe { mallopt(M_MMAP_THRESHOLD, bytes) };
    }

    pub fn trimmed_from(bytes: i32) {
        // SAFETY: as above.
        unsafe { mallopt(M_TRIM_THRESHOLD, bytes) };
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
mod set {
    pub fn arenas(_: i32) {}
    pub fn mapped_from(_: i32) {}
    pub fn trimmed_from(_: i32) {}
}
