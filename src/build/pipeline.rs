//! The computing side of a build: divide, conquer and merge, borders.
//!
//! Runs on threads of its own; what is to be written goes through a bounded channel, in the order of the file.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;
use std::time::Instant;

use parking_lot::Mutex;

use super::borders::{RegionTotals, write_borders};
use super::conquest::Conquest;
use super::options::Phase;
use super::ordered::{Closed, Ordered};
use super::output::{Extent, Sender};
use super::{BuildError, TileState};
use crate::io::start_scoped;

/// When each phase began.
pub(super) type Began = Vec<(Phase, Instant)>;

/// Conquers and merges all blocks that the board gets, from tile `first_tile` on, and writes the borders. The channel closes
/// at the end.
///
/// Returns the tiles, and what regions they have.
pub(super) fn run(
    conquest: &Conquest,
    first_tile: u32,
    threads: usize,
    sender: &Sender,
) -> Result<(Vec<TileState>, RegionTotals, Began), BuildError> {
    let progress = &conquest.options.progress;
    let window = 2 * threads as u32;
    let cores = Ordered::new(first_tile, window, |_, core| {
        sender.blocking_send(Extent::Core(core)).map_err(|_| Closed)
    });
    let mut began = vec![(Phase::Divide, Instant::now())];
    let abort = || {
        conquest.board.stop();
        cores.close();
    };
    on_threads(threads, || conquest.work(&cores, sender), abort)?;
    conquest.outcome()?;
    // If it was stopped for a failed write, whoever writes tells that.
    if progress.is_cancelled() || conquest.board.is_stopped() {
        return Err(BuildError::Cancelled);
    }
    let mut tiles: Vec<TileState> = {
        let mut found = conquest.found.lock();
        began.extend(found.conquer_began.map(|instant| (Phase::Conquer, instant)));
        found
            .blocks
            .iter_mut()
            .flat_map(|block| std::mem::take(&mut block.tiles))
            .collect()
    };
    began.push((Phase::Borders, Instant::now()));
    progress.start(Phase::Borders, tiles.len() as u64);
    let regions = write_borders(&mut tiles, conquest, threads, sender)?;
    if progress.is_cancelled() {
        return Err(BuildError::Cancelled);
    }
    began.push((Phase::Finish, Instant::now()));
    progress.start(Phase::Finish, 0);
    Ok((tiles, regions, began))
}

/// Runs the same work on several threads. A panic in one calls `abort`, so that the others do not wait for it.
pub(super) fn on_threads(threads: usize, work: impl Fn() + Sync, abort: impl Fn() + Sync) -> Result<(), BuildError> {
    let panicked = Mutex::new(None);
    thread::scope(|scope| {
        for number in 0..threads.max(1) {
            let (work, abort, panicked) = (&work, &abort, &panicked);
            let run = move || {
                if let Err(panic) = catch_unwind(AssertUnwindSafe(work)) {
                    let text = panic.downcast_ref::<String>().map(String::as_str);
                    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
                    *panicked.lock() = Some(text.unwrap_or("a thread panicked").to_owned());
                    abort();
                }
            };
            if let Err(error) = start_scoped(scope, &format!("tile-compute-{number}"), run) {
                tracing::warn!(%error, "could not start a computing thread");
                if number == 0 {
                    // Without any thread of its own the work is done here.
                    run();
                }
                break;
            }
        }
    });
    match panicked.into_inner() {
        Some(text) => Err(BuildError::Internal(text)),
        None => Ok(()),
    }
}
