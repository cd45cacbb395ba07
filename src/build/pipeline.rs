//! The computing side of a build: divide, conquer and merge, borders.
//!
//! Runs on threads of its own; what is to be written goes through a bounded channel, in the order of the file.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;
use std::time::Instant;

use parking_lot::Mutex;

use super::border::assemble;
use super::conquest::Conquest;
use super::options::Phase;
use super::ordered::{Closed, Ordered};
use super::output::{Extent, Sender};
use super::{BuildError, GENERATION, TileState};
use crate::io::Buffers;
use crate::store::TileId;

/// When each phase began.
pub(super) type Began = Vec<(Phase, Instant)>;

/// Conquers and merges all blocks that the board gets, from tile `first_tile` on, and writes the borders. The channel closes
/// at the end.
///
/// Returns the tiles.
pub(super) fn run(
    conquest: &Conquest,
    first_tile: u32,
    threads: usize,
    sender: &Sender,
) -> Result<(Vec<TileState>, Began), BuildError> {
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
    write_borders(&mut tiles, conquest, threads, sender)?;
    if progress.is_cancelled() {
        return Err(BuildError::Cancelled);
    }
    began.push((Phase::Finish, Instant::now()));
    progress.start(Phase::Finish, 0);
    Ok((tiles, began))
}

/// Assembles the borders of all tiles, group by group, and sends them in order.
fn write_borders(
    tiles: &mut [TileState],
    conquest: &Conquest,
    threads: usize,
    sender: &Sender,
) -> Result<(), BuildError> {
    let progress = &conquest.options.progress;
    let mut log = conquest.log.lock();
    let borders = Ordered::new(0, 2 * threads as u32, |_, border| {
        sender.blocking_send(Extent::Border(border)).map_err(|_| Closed)
    });
    for number in 0..log.group_count() {
        let _span = tracing::debug_span!("borders", group = number).entered();
        if progress.is_cancelled() || sender.is_closed() {
            return Err(BuildError::Cancelled);
        }
        let group = log.take_group(number);
        let group = group.map_err(|error| BuildError::io(&conquest.spill, "read the border log in", error))?;
        let states = &mut tiles[group.tiles().start as usize..group.tiles().end as usize];
        let next = Mutex::new(group.tiles().zip(states));
        let buffers = Buffers::default();
        let work = || {
            loop {
                let Some((number, state)) = next.lock().next() else {
                    return;
                };
                if progress.is_cancelled() || borders.begin(number).is_err() {
                    borders.close();
                    return;
                }
                let tile = TileId(number);
                let (sides, late) = (group.sides_of(tile), group.triangles_of(tile));
                let border = assemble(tile, state.vertices, state.core_triangles, &sides, late);
                state.border_triangles = border.draft.triangles.len() as u32;
                state.owned_triangles = state.core_triangles + border.owned;
                state.constraint_edges += border.constraint_edges;
                state.bounds = state.bounds.union(border.bounds);
                if borders
                    .put(number, border.draft.encode(tile, GENERATION, &buffers))
                    .is_err()
                {
                    return;
                }
                progress.advance(1, u64::from(state.vertices));
            }
        };
        on_threads(threads, work, || borders.close())?;
    }
    Ok(())
}

/// Runs the same work on several threads. A panic in one calls `abort`, so that the others do not wait for it.
fn on_threads(threads: usize, work: impl Fn() + Sync, abort: impl Fn() + Sync) -> Result<(), BuildError> {
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
            let thread = thread::Builder::new().name(format!("tile-compute-{number}"));
            if let Err(error) = thread.spawn_scoped(scope, run) {
                // Without any thread of its own the work is done here.
                tracing::warn!(%error, "could not start a computing thread");
                if number == 0 {
                    work();
                }
            }
        }
    });
    match panicked.into_inner() {
        Some(text) => Err(BuildError::Internal(text)),
        None => Ok(()),
    }
}
