//! A hard limit to the memory of a process: by a cgroup where the system lets us have one, otherwise by watching it.
//!
//! A resource limit will not do: those that there are count memory that was asked for but never touched, which is no burden to anybody.

use std::ffi::OsStr;
use std::process::{Command, Stdio};

use crate::common;

/// How much memory a process may have resident, and what sees to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    pub bytes: u64,
    means: Means,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Means {
    /// A scope of the system's or of the user's systemd, which is a cgroup.
    Scope { is_users: bool },
    /// Whoever measures the process looks at it all the time, and kills it.
    Watch,
}

impl Limit {
    /// By the best means that there are.
    pub fn new(bytes: u64) -> Self {
        let scopes = [false, true].map(|is_users| Means::Scope { is_users });
        let works = |means: &Means| {
            let trial = Self { bytes, means: *means };
            let mut command = trial.command(OsStr::new("true"));
            command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
            command.status().is_ok_and(|status| status.success())
        };
        let means = scopes.into_iter().find(works).unwrap_or(Means::Watch);
        Self { bytes, means }
    }

    /// A command that runs a program within the limit, if whoever runs it kills it beyond [`watched`](Self::watched).
    pub fn command(&self, program: &OsStr) -> Command {
        let Means::Scope { is_users } = self.means else {
            return Command::new(program);
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
    pub fn watched(&self) -> Option<u64> {
        (self.means == Means::Watch).then_some(self.bytes)
    }

    /// What it is, in words.
    pub fn describe(&self) -> String {
        let bytes = common::bytes(self.bytes);
        match self.means {
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

    use super::super::child::{Ended, measure};
    use super::*;

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
