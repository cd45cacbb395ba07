//! Limits of the process. They are checked before a command starts, so that exceeding one is an
//! error and not a panic.

use std::fs::{self, File};
use std::hint::black_box;
use std::io;
use std::panic;
use std::sync::{Arc, Mutex};
use std::thread::{self, Builder};
use std::time::Duration;

use anyhow::Context;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::system;

/// File descriptors that a command needs: those of the runtime, which panics if it gets fewer, and
/// two for files of the command.
const DESCRIPTORS: usize = 9;
/// Bytes of the main thread's stack that are touched at the start. Where the address space is
/// limited, the stack may be unable to grow later.
const STACK: usize = 512 << 10;
/// Number of threads that a command needs besides the runtime's workers.
const OTHER_THREADS: usize = 8;

/// Prepares the process. Must be called before any thread is started.
///
/// # Errors
/// Fails if the limit on open files is too low.
pub fn prepare() -> anyhow::Result<()> {
    let is_limited = [Resource::As, Resource::Data].map(|resource| getrlimit(resource).current.is_some());
    let is_limited = is_limited.contains(&true);
    system::prepare(is_limited);
    if is_limited {
        // A failed allocation is an error, but a stack that cannot grow is a signal. So this
        // allocation comes first and fails if memory is too short for the stack.
        drop(black_box(Vec::<u8>::with_capacity(4 * STACK)));
        take_stack();
    }
    report_refused_stacks();
    let files = getrlimit(Resource::Nofile);
    if files.current < files.maximum {
        // If the system refuses, the limit stays unchanged.
        let _ = setrlimit(
            Resource::Nofile,
            Rlimit {
                current: files.maximum,
                maximum: files.maximum,
            },
        );
    }
    let opened: io::Result<Vec<File>> = (0..DESCRIPTORS).map(|_| File::open("/")).collect();
    opened
        .map(drop)
        .context("the system allows too few open files; raise the limit (ulimit -n)")
}

#[inline(never)]
fn take_stack() {
    black_box([0u8; STACK]);
}

/// Reports in one line that a thread's signal stack was refused. Such a thread panics and takes the
/// process down with it.
fn report_refused_stacks() {
    let others = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        let is_refused = info
            .payload_as_str()
            .is_some_and(|text| text.contains("alternative stack"));
        if is_refused {
            system::refuse_stack();
        }
        others(info);
    }));
}

/// Returns whether the system can start `threads` threads at once, and the others that a command
/// needs.
pub fn can_start(threads: usize) -> bool {
    let before = threads_now();
    let gate = Arc::new(Mutex::new(()));
    let closed = gate.lock();
    let start = || {
        let gate = Arc::clone(&gate);
        Builder::new().spawn(move || drop(gate.lock())).ok()
    };
    let wanted = threads + OTHER_THREADS;
    let started: Vec<_> = (0..wanted).map_while(|_| start()).collect();
    drop(closed);
    let count = started.len();
    started.into_iter().for_each(|thread| drop(thread.join()));
    // A joined thread counts until the system has cleaned it up.
    for _ in 0..100 {
        if threads_now() <= before {
            break;
        }
        thread::sleep(Duration::from_micros(100));
    }
    count == wanted
}

fn threads_now() -> Option<usize> {
    fs::read_dir("/proc/self/task").ok().map(Iterator::count)
}
