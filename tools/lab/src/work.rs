//! The asynchronous part of experiments.

use std::future::Future;

use anyhow::bail;
use tiletool::common;

/// Runs the asynchronous part of an experiment, until it is done or Ctrl-C ends it.
pub fn block_on<T>(work: impl Future<Output = anyhow::Result<T>>) -> anyhow::Result<T> {
    common::block_on(async {
        tokio::select! {
            done = work => done,
            _ = tokio::signal::ctrl_c() => bail!("interrupted; nothing was written"),
        }
    })
}
