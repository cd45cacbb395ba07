//! A library to preload (`LD_PRELOAD`), which makes one I/O call of a program fail: the nth one on
//! files, in one way.
//!
//! The environment says which call, in which way, and where to report. At its end the program
//! writes a file with the number of calls and whether one failed. The library replaces functions of
//! the C library, so a program is tested unchanged, with everything that it does to files.
//!
//! | variable | meaning |
//! |---|---|
//! | `FAULTS_AT` | the number of the call, from 1; 0: none |
//! | `FAULTS_WAY` | `eio`, `enospc`, `eintr`: it does nothing and returns this error; `short`: it moves half of the bytes; `torn`: it writes half of them, and returns `EIO`; `delay`: it succeeds late |
//! | `FAULTS_REPORT` | the file that gets, when the program ends, the number of calls, and 1 if one failed (else 0) |
//! | `FAULTS_THREADS` | the maximum number of threads beside the first; more are refused with `EAGAIN` |
//! | `FAULTS_LOG`, `FAULTS_LOG_ROOT` | the file to append a record to for each change to the files below the folder (`log.rs`) |

#![cfg(target_os = "linux")]
#![allow(unsafe_code, reason = "it replaces functions of the C library")]

mod log;
mod real;

use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::os::unix::ffi::OsStringExt;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use libc::{mode_t, off64_t, pthread_attr_t, pthread_t, size_t, ssize_t};
use real::StartRoutine;

static CALLS: AtomicU64 = AtomicU64::new(0);
static IS_DONE: AtomicBool = AtomicBool::new(false);

/// The way in which a call fails.
#[derive(Clone, Copy, PartialEq, Eq)]
enum FailureMode {
    Error(c_int),
    Short,
    Torn,
    Delay,
}

/// The kind of a call, which decides how it can fail.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Operation {
    Read,
    Write,
    Sync,
    /// Calls on names in folders: programs do not retry these after a signal.
    Name,
    Remove,
}

struct FaultPlan {
    at: u64,
    mode: FailureMode,
    report: Option<CString>,
}

fn plan() -> &'static FaultPlan {
    static PLAN: OnceLock<FaultPlan> = OnceLock::new();
    PLAN.get_or_init(|| {
        let text = |name| std::env::var(name).unwrap_or_default();
        let mode = match text("FAULTS_WAY").as_str() {
            "enospc" => FailureMode::Error(libc::ENOSPC),
            "eintr" => FailureMode::Error(libc::EINTR),
            "short" => FailureMode::Short,
            "torn" => FailureMode::Torn,
            "delay" => FailureMode::Delay,
            _ => FailureMode::Error(libc::EIO),
        };
        let report = std::env::var_os("FAULTS_REPORT").and_then(|path| CString::new(path.into_vec()).ok());
        // SAFETY: `write_report` has no arguments, and exists as long as the program does.
        unsafe { libc::atexit(write_report) };
        FaultPlan {
            at: text("FAULTS_AT").parse().unwrap_or(0),
            mode,
            report,
        }
    })
}

/// Writes the report.
extern "C" fn write_report() {
    let Some(path) = &plan().report else { return };
    let is_done = u8::from(IS_DONE.load(Ordering::SeqCst));
    let text = format!("{} {is_done}\n", CALLS.load(Ordering::SeqCst));
    // SAFETY: the path ends with a zero, the text has the given length, and the file is closed
    // once.
    unsafe {
        let file = real::open64()(path.as_ptr(), libc::O_WRONLY | libc::O_CREAT | libc::O_TRUNC, 0o600);
        if file >= 0 {
            real::write()(file, text.as_ptr().cast(), text.len());
            libc::close(file);
        }
    }
}

/// Returns whether it is a file or a folder on a disk.
fn is_file(fd: c_int) -> bool {
    if fd <= libc::STDERR_FILENO {
        return false;
    }
    // SAFETY: both structures are plain numbers, and the calls fill them.
    unsafe {
        let (mut stat, mut system) = (std::mem::zeroed::<libc::stat64>(), std::mem::zeroed::<libc::statfs64>());
        let is_known = libc::fstat64(fd, &raw mut stat) == 0 && libc::fstatfs64(fd, &raw mut system) == 0;
        let kind = stat.st_mode & libc::S_IFMT;
        let is_of_the_kernel = [
            libc::PROC_SUPER_MAGIC,
            libc::SYSFS_MAGIC,
            libc::CGROUP2_SUPER_MAGIC,
            libc::CGROUP_SUPER_MAGIC,
        ];
        is_known && (kind == libc::S_IFREG || kind == libc::S_IFDIR) && !is_of_the_kernel.contains(&system.f_type)
    }
}

/// Returns whether a path is the program's own, and not one of the system.
fn is_own(path: *const c_char) -> bool {
    // SAFETY: callers of the C library pass a path that ends with a zero.
    let path = unsafe { CStr::from_ptr(path) }.to_bytes();
    let others: [&[u8]; 5] = [b"/proc/", b"/sys/", b"/dev/", b"/etc/", b"/usr/"];
    !others.iter().any(|other| path.starts_with(other))
}

/// Counts a call, and returns how it fails, if it does.
fn counted(operation: Operation) -> Option<FailureMode> {
    let plan = plan();
    if CALLS.fetch_add(1, Ordering::SeqCst) + 1 != plan.at {
        return None;
    }
    let can = match plan.mode {
        FailureMode::Error(libc::ENOSPC) => operation != Operation::Read && operation != Operation::Remove,
        FailureMode::Error(libc::EINTR) => operation != Operation::Name && operation != Operation::Remove,
        FailureMode::Error(_) | FailureMode::Delay => true,
        FailureMode::Short => operation == Operation::Read || operation == Operation::Write,
        FailureMode::Torn => operation == Operation::Write,
    };
    IS_DONE.store(can, Ordering::SeqCst);
    can.then_some(plan.mode)
}

fn fail(error: c_int) {
    // SAFETY: the location is this thread's own.
    unsafe { *libc::__errno_location() = error };
}

/// Runs a call that moves bytes; `call` moves the number of bytes that it is given.
fn moved(fd: c_int, bytes: size_t, operation: Operation, call: impl Fn(size_t) -> ssize_t) -> ssize_t {
    if !is_file(fd) {
        return call(bytes);
    }
    match counted(operation) {
        None => call(bytes),
        Some(FailureMode::Error(error)) => {
            fail(error);
            -1
        }
        Some(FailureMode::Short) => call(bytes.div_ceil(2)),
        Some(FailureMode::Torn) => {
            call(bytes / 2);
            fail(libc::EIO);
            -1
        }
        Some(FailureMode::Delay) => {
            std::thread::sleep(Duration::from_millis(30));
            call(bytes)
        }
    }
}

/// Runs a call that takes effect as a whole or not at all.
fn done(operation: Operation, call: impl Fn() -> c_int) -> c_int {
    match counted(operation) {
        Some(FailureMode::Error(error)) => {
            fail(error);
            return -1;
        }
        Some(FailureMode::Delay) => std::thread::sleep(Duration::from_millis(30)),
        _ => {}
    }
    call()
}

/// # Safety
/// The requirements of `read`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn read(fd: c_int, to: *mut c_void, bytes: size_t) -> ssize_t {
    // SAFETY: the caller guarantees this number of bytes or more.
    moved(fd, bytes, Operation::Read, |bytes| unsafe {
        real::read()(fd, to, bytes)
    })
}

/// # Safety
/// The requirements of `write`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn write(fd: c_int, from: *const c_void, bytes: size_t) -> ssize_t {
    // SAFETY: the caller guarantees this number of bytes or more.
    moved(fd, bytes, Operation::Write, |bytes| {
        logged(fd, None, from, || unsafe { real::write()(fd, from, bytes) })
    })
}

/// # Safety
/// The requirements of `pread64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pread64(fd: c_int, to: *mut c_void, bytes: size_t, at: off64_t) -> ssize_t {
    // SAFETY: the caller guarantees this number of bytes or more.
    moved(fd, bytes, Operation::Read, |bytes| unsafe {
        real::pread64()(fd, to, bytes, at)
    })
}

/// # Safety
/// The requirements of `pwrite64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pwrite64(fd: c_int, from: *const c_void, bytes: size_t, at: off64_t) -> ssize_t {
    // SAFETY: the caller guarantees this number of bytes or more.
    moved(fd, bytes, Operation::Write, |bytes| {
        logged(fd, Some(at), from, || unsafe { real::pwrite64()(fd, from, bytes, at) })
    })
}

/// Runs a call that writes bytes, and logs it.
fn logged(fd: c_int, at: Option<off64_t>, from: *const c_void, call: impl Fn() -> ssize_t) -> ssize_t {
    // A thread that waits for a pipe must not hold the log.
    let log = if is_file(fd) { log::begin() } else { None };
    let written = call();
    if let (Some(log), Ok(bytes)) = (log, usize::try_from(written)) {
        log.written(fd, at, from.cast(), bytes);
    }
    written
}

/// # Safety
/// The requirements of `pthread_create`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pthread_create(
    thread: *mut pthread_t,
    attributes: *const pthread_attr_t,
    start: StartRoutine,
    argument: *mut c_void,
) -> c_int {
    static MOST: OnceLock<Option<u64>> = OnceLock::new();
    let most = *MOST.get_or_init(|| std::env::var("FAULTS_THREADS").ok()?.parse().ok());
    let Some(most) = most else {
        // SAFETY: the arguments are the caller's.
        return unsafe { real::pthread_create()(thread, attributes, start, argument) };
    };
    let is_free = |threads| (threads < most).then_some(threads + 1);
    if THREADS
        .fetch_update(Ordering::SeqCst, Ordering::SeqCst, is_free)
        .is_err()
    {
        return libc::EAGAIN;
    }
    let counted = Box::into_raw(Box::new((start, argument)));
    // SAFETY: the thread takes the box; if there is no thread, the box is taken back here.
    unsafe {
        let refused = real::pthread_create()(thread, attributes, run_counted, counted.cast());
        if refused != 0 {
            THREADS.fetch_sub(1, Ordering::SeqCst);
            drop(Box::from_raw(counted));
        }
        refused
    }
}

/// The number of running threads beside the first, if it is limited.
static THREADS: AtomicU64 = AtomicU64::new(0);

/// Runs the start routine of a thread, and then makes room for another thread.
extern "C" fn run_counted(counted: *mut c_void) -> *mut c_void {
    // SAFETY: `pthread_create` made a box of it for this thread alone.
    let counted = unsafe { Box::from_raw(counted.cast::<(StartRoutine, *mut c_void)>()) };
    let done = counted.0(counted.1);
    THREADS.fetch_sub(1, Ordering::SeqCst);
    done
}

/// Defines a function of the C library that changes files or folders.
macro_rules! operation {
    ($($name:ident($($argument:ident: $type:ty),*) is $operation:ident if $counts:expr, |$log:ident, $done:ident| $record:expr;)*) => {
        $(
            /// # Safety
            /// The requirements of the function of this name.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name($($argument: $type),*) -> c_int {
                let call = || {
                    let log = log::begin();
                    // SAFETY: the arguments are the caller's.
                    let $done = unsafe { real::$name()($($argument),*) };
                    if let Some($log) = log && $done >= 0 {
                        $record
                    }
                    $done
                };
                if $counts { done(Operation::$operation, call) } else { call() }
            }
        )*
    };
}

operation! {
    fsync(fd: c_int) is Sync if is_file(fd), |log, done| log.synced(fd);
    fdatasync(fd: c_int) is Sync if is_file(fd), |log, done| log.synced(fd);
    ftruncate64(fd: c_int, length: off64_t) is Sync if is_file(fd), |log, done| log.truncated(fd, length);
    open64(path: *const c_char, flags: c_int, mode: c_uint) is Sync if is_own(path), |log, done| log.opened(done, path, flags);
    rename(from: *const c_char, to: *const c_char) is Name if is_own(to), |log, done| log.renamed(from, to);
    unlink(path: *const c_char) is Remove if is_own(path), |log, done| log.removed(path);
    mkdir(path: *const c_char, mode: mode_t) is Name if is_own(path), |log, done| log.made(path);
    rmdir(path: *const c_char) is Remove if false, |log, done| log.removed(path);
    unlinkat(folder: c_int, path: *const c_char, flags: c_int) is Remove if false, |log, done| log.removed_at(folder, path);
}
