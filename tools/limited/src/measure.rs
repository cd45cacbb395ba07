//! Runs a program to its end, and measures the whole process from outside: time, processor time,
//! memory, storage.
//!
//! What the system reports of a process is read after it has ended, before it is reaped. Its memory
//! is no longer reported then, so it is polled while the process lives.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use rustix::param::clock_ticks_per_second;
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process, waitid};

use crate::after_colon;

/// How a process ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// It succeeded.
    Done,
    /// It failed, with this exit code.
    Failed(i32),
    /// It was ended by this signal.
    Killed(i32),
}

/// The result and the resources of a process.
#[derive(Clone, Debug)]
pub struct Took {
    /// How it ended.
    pub ended: Ended,
    /// Seconds from its start to its end.
    pub seconds: f64,
    /// Processor time of all its threads in user mode, in steps of a clock tick.
    pub user_seconds: Option<f64>,
    /// Processor time of all its threads in the kernel.
    pub system_seconds: Option<f64>,
    /// The peak of its resident memory, in bytes.
    pub peak: Option<u64>,
    /// The largest observed memory that belongs to no file, in bytes: without the program's code.
    pub own_peak: Option<u64>,
    /// Bytes that storage had to read for it, without those in the page cache.
    pub storage_read: Option<u64>,
    /// Bytes that storage had to write for it.
    pub storage_written: Option<u64>,
    /// Its standard output.
    pub output: String,
    /// Its error output.
    pub errors: String,
}

impl Took {
    /// Returns its error output, without the leading `error: `.
    #[must_use]
    pub fn complaint(&self) -> &str {
        let errors = self.errors.trim();
        errors.strip_prefix("error: ").unwrap_or(errors)
    }
}

/// The interval between two polls of a process's memory.
const LOOK: Duration = Duration::from_millis(3);

/// Runs a program in a folder. It is killed if a poll finds more than `most` bytes in memory, not
/// counting files, or if `stop` is set, which is an error.
///
/// # Errors
/// If the program cannot be run, watched or waited for, or if `stop` was set.
pub fn measure(mut command: Command, folder: &Path, most: Option<u64>, stop: &AtomicBool) -> anyhow::Result<Took> {
    let name = command.get_program().to_string_lossy().into_owned();
    let [output, errors] = ["stdout", "stderr"].map(|name| folder.join(name));
    let create = |path: &Path| File::create(path).with_context(|| format!("cannot write {}", path.display()));
    command.current_dir(folder).stdin(Stdio::null());
    command.stdout(create(&output)?).stderr(create(&errors)?);
    let began = Instant::now();
    let mut child = command.spawn().with_context(|| format!("cannot run {name}"))?;
    let watched = watch(&child, most.unwrap_or(u64::MAX), stop);
    if watched.is_err() {
        // A process that cannot be waited for must not go on alone.
        let _ = child.kill();
    }
    let seconds = began.elapsed().as_secs_f64();
    let (times, storage) = (times(child.id()), storage(child.id()));
    let status = child.wait().with_context(|| format!("cannot wait for {name}"))?;
    let seen = watched.with_context(|| format!("cannot watch {name}"))?;
    if stop.load(Ordering::Relaxed) {
        bail!("interrupted; nothing was written");
    }
    let read = |path: &Path| fs::read(path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    Ok(Took {
        ended: ended(status),
        seconds,
        user_seconds: times.map(|times| times.0),
        system_seconds: times.map(|times| times.1),
        peak: seen.map(|memory| memory.peak),
        own_peak: seen.map(|memory| memory.own),
        storage_read: storage.map(|bytes| bytes.0),
        storage_written: storage.map(|bytes| bytes.1),
        output: read(&output).unwrap_or_default(),
        errors: read(&errors).unwrap_or_default(),
    })
}

/// Waits until a process has ended, without reaping it. Returns the largest memory that was
/// observed.
fn watch(child: &Child, most: u64, stop: &AtomicBool) -> anyhow::Result<Option<Memory>> {
    let (is_over, pid) = (AtomicBool::new(false), Pid::from_child(child));
    thread::scope(|scope| {
        let look = || {
            let mut most_seen: Option<Memory> = None;
            while !is_over.load(Ordering::Relaxed) {
                let memory = Memory::of(child.id());
                most_seen = memory.map_or(most_seen, |memory| Some(memory.or_more(most_seen)));
                let has_more = memory.is_some_and(|memory| memory.own > most);
                if has_more || stop.load(Ordering::Relaxed) {
                    // The process may have ended by itself meanwhile.
                    let _ = kill_process(pid, Signal::KILL);
                }
                thread::sleep(LOOK);
            }
            most_seen
        };
        let looking = thread::Builder::new()
            .spawn_scoped(scope, look)
            .context("cannot start a thread")?;
        let ended = loop {
            match waitid(WaitId::Pid(pid), WaitIdOptions::EXITED | WaitIdOptions::NOWAIT) {
                Err(rustix::io::Errno::INTR) => {}
                other => break other,
            }
        };
        is_over.store(true, Ordering::Relaxed);
        let most_seen = looking.join().unwrap_or(None);
        ended?;
        Ok(most_seen)
    })
}

fn ended(status: ExitStatus) -> Ended {
    use std::os::unix::process::ExitStatusExt;

    match (status.code(), status.signal()) {
        (Some(0), _) => Ended::Done,
        (Some(code), _) => Ended::Failed(code),
        (None, signal) => Ended::Killed(signal.unwrap_or(0)),
    }
}

/// The memory of a process, in bytes.
#[derive(Clone, Copy)]
struct Memory {
    /// The peak of its resident memory so far.
    peak: u64,
    /// Its resident memory that belongs to no file.
    own: u64,
}

impl Memory {
    /// Returns the larger of each number.
    fn or_more(self, other: Option<Self>) -> Self {
        other.map_or(self, |other| Self {
            peak: self.peak.max(other.peak),
            own: self.own.max(other.own),
        })
    }

    fn of(pid: u32) -> Option<Self> {
        let text = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
        let bytes = |name| {
            let kibibytes: u64 = after_colon(&text, name)?.strip_suffix(" kB")?.trim().parse().ok()?;
            kibibytes.checked_mul(1024)
        };
        Some(Self {
            peak: bytes("VmHWM")?,
            own: bytes("RssAnon")?,
        })
    }
}

/// Returns the seconds of processor time in user mode and in the kernel.
fn times(pid: u32) -> Option<(f64, f64)> {
    let text = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The program's name may contain blanks and brackets; the fields behind it contain none.
    let (_, fields) = text.rsplit_once(')')?;
    let mut ticks = fields
        .split_whitespace()
        .skip(11)
        .map(|field| field.parse::<u64>().ok());
    let per_second = clock_ticks_per_second() as f64;
    let mut next = || Some(ticks.next()?? as f64 / per_second);
    Some((next()?, next()?))
}

/// Returns the bytes read from storage and written to it.
fn storage(pid: u32) -> Option<(u64, u64)> {
    let text = fs::read_to_string(format!("/proc/{pid}/io")).ok()?;
    let bytes = |name| after_colon(&text, name)?.parse::<u64>().ok();
    Some((bytes("read_bytes")?, bytes("write_bytes")?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn a_process_is_measured_to_its_end() {
        let folder = tempfile::tempdir().unwrap();
        let go = AtomicBool::new(false);
        let script = "i=0; while [ $i -lt 30000 ]; do i=$((i+1)); done; echo out; echo err >&2";
        let took = measure(shell(script), folder.path(), None, &go).unwrap();
        assert_eq!(
            (took.ended, took.output.as_str(), took.errors.as_str()),
            (Ended::Done, "out\n", "err\n")
        );
        assert!(took.seconds > 0.0 && took.user_seconds.is_some() && took.system_seconds.is_some());
        assert!(took.peak.is_some_and(|bytes| bytes > 100_000), "{took:?}");
    }

    #[test]
    fn a_failed_process_and_a_killed_one_are_distinguished() {
        let folder = tempfile::tempdir().unwrap();
        let go = AtomicBool::new(false);
        for (script, ended) in [("exit 3", Ended::Failed(3)), ("kill -9 $$", Ended::Killed(9))] {
            let took = measure(shell(script), folder.path(), None, &go).unwrap();
            assert_eq!(took.ended, ended);
        }
        assert!(measure(Command::new("./no-such-program"), folder.path(), None, &go).is_err());
    }

    #[test]
    fn an_interrupted_measurement_kills_its_process() {
        let folder = tempfile::tempdir().unwrap();
        let began = Instant::now();
        let error = measure(shell("exec sleep 60"), folder.path(), None, &AtomicBool::new(true)).unwrap_err();
        assert!(error.to_string().contains("interrupted"), "{error}");
        assert!(began.elapsed() < Duration::from_secs(30));
    }
}
