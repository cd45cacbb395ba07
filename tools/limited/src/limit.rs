//! A hard limit to the memory of a process: by a cgroup where the system lets us have one, otherwise by watching it.
//!
//! A resource limit will not do: those that there are count memory that was asked for but never touched, which is no burden to anybody.

use std::ffi::OsStr;
use std::process::{Command, Stdio};
use std::sync::Arc;

use bytesize::ByteSize;

use crate::cgroup::Group;

/// How much memory a process may have resident, and what sees to it. Processes that run at the same time by clones of one limit may
/// share it.
#[derive(Clone, Debug)]
pub struct Limit {
    /// In bytes.
    pub bytes: u64,
    means: Means,
}

#[derive(Clone, Debug)]
enum Means {
    /// A cgroup that was made by hand.
    Group(Arc<Group>),
    /// A scope of the system's or of the user's systemd, which is a cgroup.
    Scope { is_users: bool },
    /// Whoever measures the process looks at it all the time, and kills it.
    Watch,
}

impl Limit {
    /// By the best means that there are.
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

    /// A command that runs a program within the limit, if whoever runs it kills it beyond [`watched`](Self::watched).
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

    /// Bytes of resident memory, beyond which the process is to be killed, as nobody else does.
    #[must_use]
    pub fn watched(&self) -> Option<u64> {
        matches!(self.means, Means::Watch).then_some(self.bytes)
    }

    /// What it is, in words.
    #[must_use]
    pub fn describe(&self) -> String {
        let bytes = ByteSize::b(self.bytes).display().iec();
        match self.means {
            Means::Group(_) => format!("{bytes} for each process, by a cgroup"),
            Means::Scope { .. } => {
                format!("{bytes} for each process, by a cgroup (`systemd-run --scope -p MemoryMax`)")
            }
            Means::Watch => format!(
                "{bytes} for each process: no cgroup was to be had, so each was looked at every few milliseconds, and killed \
                 when it had more in memory, files that it reads apart"
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
    fn who_needs_more_is_ended_and_who_needs_less_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let go = AtomicBool::new(false);
        let watching = Limit {
            bytes: 64 << 20,
            means: Means::Watch,
        };
        for limit in [Limit::new(64 << 20), watching] {
            for (bytes, ends_well) in [("1000000", true), ("100000000", false)] {
                let mut command = limit.command(OsStr::new("sh"));
                // The shell copies what it is given, and holds it for a while.
                let script = format!("x=$(head -c {bytes} /dev/zero | tr '\\0' x); sleep 0.1; [ ${{#x}} -eq {bytes} ]");
                command.args(["-c", &script]);
                let took = measure(command, folder.path(), limit.watched(), &go).unwrap();
                assert_eq!(took.ended == Ended::Done, ends_well, "{limit:?} {bytes} {took:?}");
            }
        }
    }
}
