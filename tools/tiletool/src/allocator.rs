//! Settings of the C library's allocator, without which a process would exceed `--memory`.
//!
//! The delaunay-tiles library counts the bytes that it allocates. By default glibc has up to eight
//! arenas per processor. Each arena keeps the memory that was freed to it, so memory that one
//! thread freed is of no use to other threads: with the default, arenas held up to 75 MiB that
//! nobody used. Therefore this module sets a single arena. Large
//! allocations are separate mappings, which are returned to the system at once. These settings
//! concern the whole process, so they belong to the program and not to the library.
//!
//! Other allocators do not have such settings and are left unchanged.

/// Sets one arena for all threads. Must be called before threads are started.
pub fn begin() {
    set::arenas(1);
}

/// Limits the freed memory that the allocator keeps to 1/32 of `memory` bytes, as far as a program
/// can control it.
pub fn keep_to(memory: u64) {
    /// Minimum and maximum of the size in bytes from which an allocation is a mapping of its own. A
    /// smaller threshold costs time, and glibc accepts no larger one.
    const MAPPED: (u64, u64) = (1 << 20, 32 << 20);
    let mapped = (memory / 64).clamp(MAPPED.0, MAPPED.1) as i32;
    set::mapped_from(mapped);
    set::trimmed_from(2 * mapped);
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[allow(unsafe_code, reason = "the C library offers no safe way to set it")]
mod set {
    use libc::{M_ARENA_MAX, M_MMAP_THRESHOLD, M_TRIM_THRESHOLD, mallopt};

    pub fn arenas(count: i32) {
        // SAFETY: `mallopt` takes two numbers, and any thread may call it at any time.
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
