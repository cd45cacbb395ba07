//! The functions of the C library that this library replaces.

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::sync::OnceLock;

use libc::{mode_t, off64_t, pthread_attr_t, pthread_t, size_t, ssize_t};

/// The start routine of a thread.
pub type StartRoutine = extern "C" fn(*mut c_void) -> *mut c_void;

macro_rules! real {
    ($($name:ident: $type:ty;)*) => {
        $(pub fn $name() -> $type {
            static FOUND: OnceLock<usize> = OnceLock::new();
            let found = *FOUND.get_or_init(|| {
                let name = concat!(stringify!($name), "\0");
                // SAFETY: the name ends with a zero.
                unsafe { libc::dlsym(libc::RTLD_NEXT, name.as_ptr().cast()) as usize }
            });
            assert_ne!(found, 0, "the C library has no {}", stringify!($name));
            // SAFETY: it is the function of this name, whose type POSIX defines.
            unsafe { std::mem::transmute::<usize, $type>(found) }
        })*
    };
}

real! {
    read: unsafe extern "C" fn(c_int, *mut c_void, size_t) -> ssize_t;
    write: unsafe extern "C" fn(c_int, *const c_void, size_t) -> ssize_t;
    pread64: unsafe extern "C" fn(c_int, *mut c_void, size_t, off64_t) -> ssize_t;
    pwrite64: unsafe extern "C" fn(c_int, *const c_void, size_t, off64_t) -> ssize_t;
    fsync: unsafe extern "C" fn(c_int) -> c_int;
    fdatasync: unsafe extern "C" fn(c_int) -> c_int;
    ftruncate64: unsafe extern "C" fn(c_int, off64_t) -> c_int;
    open64: unsafe extern "C" fn(*const c_char, c_int, c_uint) -> c_int;
    rename: unsafe extern "C" fn(*const c_char, *const c_char) -> c_int;
    unlink: unsafe extern "C" fn(*const c_char) -> c_int;
    mkdir: unsafe extern "C" fn(*const c_char, mode_t) -> c_int;
    rmdir: unsafe extern "C" fn(*const c_char) -> c_int;
    unlinkat: unsafe extern "C" fn(c_int, *const c_char, c_int) -> c_int;
    pthread_create: unsafe extern "C" fn(*mut pthread_t, *const pthread_attr_t, StartRoutine, *mut c_void) -> c_int;
}
