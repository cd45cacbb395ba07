//! A hard limit on the memory of a process: by a cgroup if the system allows one, otherwise by
//! watching the process.
//!
//! A resource limit (`ulimit`) does not suffice: it counts memory that was requested but never
//! touched.

use std::ffi::OsStr;
use std::process::{Command, Stdio};
use std::sync::Arc;

use bytesize::ByteSize;

use crate::cgroup::Group;

/// The resident memory that a process may have, and the means that enforces it. Processes that run
/// at the same time by clones of one limit may share it.
#[derive(Clone, Debug)]
pub struct Limit {
    /// The limit in bytes.
    pub bytes: u64,
    means: Means,
}

#[derive(Clone, Debug)]
enum Means {
    /// A cgroup that was made by hand.
    Group(Arc<Group>),
    /// A scope of the system's or the user's systemd, which is a cgroup.
    Scope { is_users: bool },
    /// The code that measures the process polls its memory, and kills it.
    Watch,
}

impl Limit {
    /// Creates a limit by the best available means.
    #[must_use]
    pub fn new(bytes: u64) -> Self {
        let group = Group::new(bytes).ok().map(|group| Means::Group(Arc::new(group)));
        let scopes = [false, true].map(|is_users| Means::Scope { is_users });
        let works = |means: &Means| {
            let trial = Self {
                bytes,
                means: means.clone(),
            };
            let mut command = trial.command(OsStr::new("true"));
            command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
            command.status().is_ok_and(|status| status.success())
        };
        let means = group.into_iter().chain(scopes).find(works).unwrap_or(Means::Watch);
        Self { bytes, means }
    }

    /// Returns a command that runs a program within the limit, provided that the caller kills it
    /// beyond [`watched`](Self::watched).
    pub fn command(&self, program: &OsStr) -> Command {
        let is_users = match &self.means {
            Means::Watch => return Command::new(program),
            Means::Group(group) => {
                let mut command = Command::new("sh");
                command.args(["-c", "echo $$ > \"$0\" && exec \"$@\""]);
                command.arg(group.processes()).arg(program);
                return command;
            }
            Means::Scope { is_users } => *is_users,
        };
        let mut command = Command::new("systemd-run");
        if is_users {
            command.arg("--user");
        }
        let most = format!("MemoryMax={}", self.bytes);
        command.args([
            "--scope",
            "--quiet",
            "--collect",
            "-p",
            &most,
            "-p",
            "MemorySwapMax=0",
            "--",
        ]);
        command.arg(program);
        command
    }

    /// Returns the bytes of resident memory beyond which the caller must kill the process, or
    /// `None` if the system does.
    #[must_use]
    pub fn watched(&self) -> Option<u64> {
        matches!(self.means, Means::Watch).then_some(self.bytes)
    }

    /// Describes the limit in words.
    #[must_use]
    pub fn describe(&self) -> String {
        let bytes = ByteSize::b(self.bytes).display().iec();
        match self.means {
            Means::Group(_) => format!("{bytes} for each process, by a cgroup"),
            Means::Scope { .. } => {
                format!("{bytes} for each process, by a cgroup (`systemd-run --scope -p MemoryMax`)")
            }
            Means::Watch => format!(
                "{bytes} for each process: no cgroup was available, so each was polled every few milliseconds, and killed \
                 when it had more in memory, not counting files"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::{Ended, measure};

    #[test]
    fn a_process_above_the_limit_is_killed_and_one_below_it_completes() {
        let folder = tempfile::tempdir().unwrap();
        let go = AtomicBool::new(false);
        let watching = Limit {
            bytes: 64 << 20,
            means: Means::Watch,
        };
        for limit in [Limit::new(64 << 20), watching] {
            for (bytes, ends_well) in [("1000000", true), ("100000000", false)] {
                let mut command = limit.command(OsStr::new("sh"));
                // The shell copies its argument, and keeps it for a while.
                let script = format!("x=$(head -c {bytes} /dev/zero | tr '\\0' x); sleep 0.1; [ ${{#x}} -eq {bytes} ]");
                command.args(["-c", &script]);
                let took = measure(command, folder.path(), limit.watched(), &go).unwrap();
                assert_eq!(took.ended == Ended::Done, ends_well, "{limit:?} {bytes} {took:?}");
            }
        }
    }
}
