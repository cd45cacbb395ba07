//! A library to preload (`LD_PRELOAD`), which has one call for I/O of a program go wrong: the nth one on files, in one way.
//!
//! In: the environment says which call, in which way, and where to report. Out: a file that says how many calls there were, and
//! whether one went wrong. It stands in for functions of the C library, so a program is tried as it is, with all that it does to files.
//!
//! | variable | meaning |
//! |---|---|
//! | `FAULTS_AT` | the number of the call, from 1 on; 0: none |
//! | `FAULTS_WAY` | `eio`, `enospc`, `eintr`: it does nothing and says so; `short`: it moves half of the bytes; `torn`: it writes half of them, and says `EIO`; `delay`: it takes its time |
//! | `FAULTS_REPORT` | the file to write to when the program ends: the number of calls, and 1 if one went wrong |
//! | `FAULTS_THREADS` | the number of threads that the program may have beside the first; more are refused with `EAGAIN` |
//! | `FAULTS_LOG`, `FAULTS_LOG_ROOT` | the file to append a record to for each change to the files below the folder (`log.rs`) |

#![cfg(target_os = "linux")]
#![allow(unsafe_code, reason = "it stands in for functions of the C library")]

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

/// How a call goes wrong.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Way {
    Error(c_int),
    Short,
    Torn,
    Delay,
}

/// What a call does, which says how it can go wrong.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Deed {
    Read,
    Write,
    Sync,
    /// To folders: of these, nobody asks again after a signal.
    Name,
    Remove,
}

struct Plan {
    at: u64,
    way: Way,
    report: Option<CString>,
}

fn plan() -> &'static Plan {
    static PLAN: OnceLock<Plan> = OnceLock::new();
    PLAN.get_or_init(|| {
        let text = |name| std::env::var(name).unwrap_or_default();
        let way = match text("FAULTS_WAY").as_str() {
            "enospc" => Way::Error(libc::ENOSPC),
            "eintr" => Way::Error(libc::EINTR),
            "short" => Way::Short,
            "torn" => Way::Torn,
            "delay" => Way::Delay,
            _ => Way::Error(libc::EIO),
        };
        let report = std::env::var_os("FAULTS_REPORT").and_then(|path| CString::new(path.into_vec()).ok());
        // SAFETY: `tell` takes nothing, and stays as long as the program does.
        unsafe { libc::atexit(tell) };
        Plan {
            at: text("FAULTS_AT").parse().unwrap_or(0),
            way,
            report,
        }
    })
}

/// Writes the report.
extern "C" fn tell() {
    let Some(path) = &plan().report else { return };
    let is_done = u8::from(IS_DONE.load(Ordering::SeqCst));
    let text = format!("{} {is_done}\n", CALLS.load(Ordering::SeqCst));
    // SAFETY: the path ends with a zero, the text has as many bytes as it says, and the file is closed once.
    unsafe {
        let file = real::open64()(path.as_ptr(), libc::O_WRONLY | libc::O_CREAT | libc::O_TRUNC, 0o600);
        if file >= 0 {
            real::write()(file, text.as_ptr().cast(), text.len());
            libc::close(file);
        }
    }
}

/// Whether it is a file or a folder on a disk.
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

/// Whether a path is one of the program's own business.
fn is_own(path: *const c_char) -> bool {
    // SAFETY: whoever calls the C library gives it a path that ends with a zero.
    let path = unsafe { CStr::from_ptr(path) }.to_bytes();
    let others: [&[u8]; 5] = [b"/proc/", b"/sys/", b"/dev/", b"/etc/", b"/usr/"];
    !others.iter().any(|other| path.starts_with(other))
}

/// Counts a call, and says how it goes wrong, if it does.
fn counted(deed: Deed) -> Option<Way> {
    let plan = plan();
    if CALLS.fetch_add(1, Ordering::SeqCst) + 1 != plan.at {
        return None;
    }
    let can = match plan.way {
        Way::Error(libc::ENOSPC) => deed != Deed::Read && deed != Deed::Remove,
        Way::Error(libc::EINTR) => deed != Deed::Name && deed != Deed::Remove,
        Way::Error(_) | Way::Delay => true,
        Way::Short => deed == Deed::Read || deed == Deed::Write,
        Way::Torn => deed == Deed::Write,
    };
    IS_DONE.store(can, Ordering::SeqCst);
    can.then_some(plan.way)
}

fn fail(error: c_int) {
    // SAFETY: it is this thread's own.
    unsafe { *libc::__errno_location() = error };
}

/// A call that moves bytes, of which `call` moves as many as it is told.
fn moved(fd: c_int, bytes: size_t, deed: Deed, call: impl Fn(size_t) -> ssize_t) -> ssize_t {
    if !is_file(fd) {
        return call(bytes);
    }
    match counted(deed) {
        None => call(bytes),
        Some(Way::Error(error)) => {
            fail(error);
            -1
        }
        Some(Way::Short) => call(bytes.div_ceil(2)),
        Some(Way::Torn) => {
            call(bytes / 2);
            fail(libc::EIO);
            -1
        }
        Some(Way::Delay) => {
            std::thread::sleep(Duration::from_millis(30));
            call(bytes)
        }
    }
}

/// A call that does something or does not.
fn done(deed: Deed, call: impl Fn() -> c_int) -> c_int {
    match counted(deed) {
        Some(Way::Error(error)) => {
            fail(error);
            return -1;
        }
        Some(Way::Delay) => std::thread::sleep(Duration::from_millis(30)),
        _ => {}
    }
    call()
}

/// # Safety
/// That of `read`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn read(fd: c_int, to: *mut c_void, bytes: size_t) -> ssize_t {
    // SAFETY: the caller vouches for as many bytes or more.
    moved(fd, bytes, Deed::Read, |bytes| unsafe { real::read()(fd, to, bytes) })
}

/// # Safety
/// That of `write`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn write(fd: c_int, from: *const c_void, bytes: size_t) -> ssize_t {
    // SAFETY: the caller vouches for as many bytes or more.
    moved(fd, bytes, Deed::Write, |bytes| {
        logged(fd, None, from, || unsafe { real::write()(fd, from, bytes) })
    })
}

/// # Safety
/// That of `pread64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pread64(fd: c_int, to: *mut c_void, bytes: size_t, at: off64_t) -> ssize_t {
    // SAFETY: the caller vouches for as many bytes or more.
    moved(fd, bytes, Deed::Read, |bytes| unsafe {
        real::pread64()(fd, to, bytes, at)
    })
}

/// # Safety
/// That of `pwrite64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pwrite64(fd: c_int, from: *const c_void, bytes: size_t, at: off64_t) -> ssize_t {
    // SAFETY: the caller vouches for as many bytes or more.
    moved(fd, bytes, Deed::Write, |bytes| {
        logged(fd, Some(at), from, || unsafe { real::pwrite64()(fd, from, bytes, at) })
    })
}

/// A call that writes bytes, with its record.
fn logged(fd: c_int, at: Option<off64_t>, from: *const c_void, call: impl Fn() -> ssize_t) -> ssize_t {
    // Whoever waits for a pipe must not hold the log.
    let log = if is_file(fd) { log::begin() } else { None };
    let written = call();
    if let (Some(log), Ok(bytes)) = (log, usize::try_from(written)) {
        log.written(fd, at, from.cast(), bytes);
    }
    written
}

/// # Safety
/// That of `pthread_create`.
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
    // SAFETY: the thread takes the box; if there is none, it is taken back here.
    unsafe {
        let refused = real::pthread_create()(thread, attributes, run_counted, counted.cast());
        if refused != 0 {
            THREADS.fetch_sub(1, Ordering::SeqCst);
            drop(Box::from_raw(counted));
        }
        refused
    }
}

/// Threads that run, beside the first, where their number is limited.
static THREADS: AtomicU64 = AtomicU64::new(0);

/// Runs what a thread is for; then there is room for another.
extern "C" fn run_counted(counted: *mut c_void) -> *mut c_void {
    // SAFETY: `pthread_create` made a box of it for this thread alone.
    let counted = unsafe { Box::from_raw(counted.cast::<(StartRoutine, *mut c_void)>()) };
    let done = counted.0(counted.1);
    THREADS.fetch_sub(1, Ordering::SeqCst);
    done
}

/// A function of the C library that does something to files or folders.
macro_rules! deed {
    ($($name:ident($($argument:ident: $type:ty),*) is $deed:ident if $counts:expr, |$log:ident, $done:ident| $record:expr;)*) => {
        $(
            /// # Safety
            /// That of the function of this name.
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
                if $counts { done(Deed::$deed, call) } else { call() }
            }
        )*
    };
}

deed! {
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
