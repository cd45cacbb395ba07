//! The computing side of a build: divide, conquer and merge, borders.
//!
//! It runs on its own threads. Results to be written pass through a bounded channel, in the order
//! of the file.

use std::time::Instant;

use crate::pipeline::conquer::conquest::Conquest;
use crate::pipeline::error::BuildError;
use crate::pipeline::finish::borders::{RegionTotals, write_borders};
use crate::pipeline::options::Phase;
use crate::pipeline::output::ordered::{Closed, Ordered};
use crate::pipeline::output::writer::{Sender, ToWrite};
use crate::pipeline::records::TileState;
use crate::pipeline::threads::on_threads;

/// The tiles, the totals of their regions, and when each phase began.
pub(crate) type Computed = Result<(Vec<TileState>, RegionTotals, Began), BuildError>;

pub(crate) type Began = Vec<(Phase, Instant)>;

/// Conquers and merges all blocks that the board gets, from tile `first_tile` on, and writes the
/// borders. The channel closes at the end.
///
/// Returns the tiles and the totals of their regions.
pub(crate) fn run(conquest: &Conquest, first_tile: u32, threads: usize, sender: &Sender) -> Computed {
    let progress = &conquest.options.progress;
    let window = 2 * threads as u32;
    let cores = Ordered::new(first_tile, window, |_, core| {
        sender.blocking_send(ToWrite::Core(core)).map_err(|_| Closed)
    });
    let mut began = vec![(Phase::Divide, Instant::now())];
    let abort = || {
        conquest.board.stop();
        cores.close();
    };
    on_threads(threads, || conquest.work(&cores, sender), abort)?;
    conquest.outcome()?;
    // After a failed write, the writing task reports the cause.
    if progress.is_cancelled() || conquest.board.is_stopped() {
        return Err(BuildError::Cancelled);
    }
    let mut tiles: Vec<TileState> = {
        let mut state = conquest.state.lock();
        began.extend(state.conquer_began.map(|instant| (Phase::Conquer, instant)));
        state
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
