//! The service, in a process of its own.

use std::net::SocketAddr;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use anyhow::{Context, ensure};
use rustix::process::{Pid, Signal, kill_process};
use tokio::io::{AsyncBufReadExt, BufReader};
use tokio::process::{Child, Command};
use tokio::time::timeout;

use crate::client::get;
use crate::files::Files;

/// A running service.
pub struct Server {
    child: Child,
    /// Where it listens.
    pub address: SocketAddr,
}

impl Server {
    /// Starts a service of the files.
    pub async fn start(tiletool: &Path, files: &Files, cache: u64) -> anyhow::Result<Self> {
        let mut command = Command::new(tiletool);
        command
            .arg("serve")
            .args(["town.tiles", "survey.tiles"].map(|name| files.path(name)));
        command.args(["--raw", "--listen", "127.0.0.1:0", "--cache", &format!("{cache}MiB")]);
        let mut child = command.stdout(Stdio::piped()).kill_on_drop(true).spawn()?;
        let out = child.stdout.take().context("it has no output")?;
        let line = BufReader::new(out).lines().next_line().await?.unwrap_or_default();
        let address = line
            .split("http://")
            .nth(1)
            .and_then(|rest| rest.trim_end_matches('/').parse().ok());
        let address = address.with_context(|| format!("`{line}` has no address"))?;
        Ok(Self { child, address })
    }

    fn pid(&self) -> i32 {
        self.child.id().and_then(|id| i32::try_from(id).ok()).unwrap_or(0)
    }

    /// Returns its resident bytes.
    pub fn resident(&self) -> u64 {
        let text = std::fs::read_to_string(format!("/proc/{}/status", self.pid())).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let kib = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok());
        kib.unwrap_or(0) << 10
    }

    /// Returns a measurement of the service.
    pub async fn metric(&mut self, name: &str) -> anyhow::Result<u64> {
        ensure!(self.child.try_wait()?.is_none(), "the service has ended");
        let mut answer = get(self.address, "/metrics").await?;
        // The load may still be there.
        for _ in 0..100 {
            if answer.status == 200 {
                break;
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
            answer = get(self.address, "/metrics").await?;
        }
        let text = String::from_utf8_lossy(&answer.body).into_owned();
        let line = text
            .lines()
            .find_map(|line| line.strip_prefix(&format!("delaunay_tiles_{name} ")));
        line.and_then(|value| value.parse().ok())
            .with_context(|| format!("no {name} in {text}"))
    }

    /// Ends it, which must take at most 11 seconds.
    pub async fn stop(mut self) -> anyhow::Result<()> {
        let pid = Pid::from_raw(self.pid()).context("it has ended")?;
        kill_process(pid, Signal::TERM)?;
        let ended = timeout(Duration::from_secs(11), self.child.wait()).await;
        let status = ended.context("it does not end within 11 s")??;
        ensure!(status.success(), "it ended with {status}");
        Ok(())
    }
}
