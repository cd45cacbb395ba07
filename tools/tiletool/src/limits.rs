//! Limits of the process: what is checked before a command begins, so that a refusal is an error and no panic.

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

/// Files that the runtime has open: it panics where it gets fewer. Two for files of the command.
const DESCRIPTORS: usize = 9;
/// Bytes of the main thread's stack that are taken at once: where the address space ends, it cannot grow later.
const STACK: usize = 256 << 10;
/// Threads that a command needs beside the runtime's workers.
const OTHER_THREADS: usize = 8;

/// Prepares the process. Must be called before any thread is started.
pub fn prepare() -> anyhow::Result<()> {
    let is_limited = [Resource::As, Resource::Data].map(|resource| getrlimit(resource).current.is_some());
    let is_limited = is_limited.contains(&true);
    system::prepare(is_limited);
    if is_limited {
        // A refused allocation is an error, whereas a stack that cannot grow is a signal: the allocator asks first.
        drop(black_box(Vec::<u8>::with_capacity(4 * STACK)));
        take_stack();
    }
    tell_of_refused_stacks();
    let files = getrlimit(Resource::Nofile);
    if files.current < files.maximum {
        // It stays as it is where the system does not want it.
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
        .context("a command needs more open files than the system allows (ulimit -n)")
}

#[inline(never)]
fn take_stack() {
    black_box([0u8; STACK]);
}

/// A new thread panics, and takes the process with it, if its stack for signals is refused. Says so in one line.
fn tell_of_refused_stacks() {
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

/// Whether the system starts so many threads at once, and those that a command needs beside them.
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
    // A thread counts until the system has cleaned up behind it.
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
