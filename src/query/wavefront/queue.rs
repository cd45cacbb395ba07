//! The tasks of the wavefront, nearest first.

use std::collections::HashMap;
use std::hash::BuildHasherDefault;

use super::heap::{Heap, HeapEntry};
use super::roots::Root;
use super::task::Task;
use crate::collections::mix::Mix;
use crate::collections::prefetch::prefetch;
use crate::store::TileId;

/// The number of entries of the tile heap that are examined for tiles needed soon: three levels of
/// the heap.
const TOP: usize = 21;
/// A task may run before another if its length is at most this factor longer. A much lower factor
/// makes more tasks wait; a much higher one does more work in vain.
const AHEAD: f64 = 1.0 + 1.0 / 128.0;
/// The same for a wavefront that is directed towards one goal. Its lengths include the rest of the
/// way, and grow by a per cent or less on the whole way: with 1/128, a path of 33 km through a city
/// took 2.4 times as long.
const DIRECTED_AHEAD: f64 = 1.0 + 1.0 / 8192.0;
/// The initial capacity, in tasks.
const ROOM: usize = 32;

/// Tasks ordered by length, separately for each tile. The length of a task is a lower bound of all
/// paths that continue from it. Tasks with equal lengths have no order.
///
/// The order is approximate: a task may run before others that are nearer. That is correct, because
/// a found target waits until nothing nearer can be found. A task of the current tile may run if
/// its length is ahead of the others by at most a small factor, which saves many moves through the
/// queue and from tile to tile. Where the front of the wavefront passes more tiles than the cache
/// can hold, tasks of the current tile may also be ahead by `lead`, which saves reading the tile
/// again for each task.
#[derive(Debug)]
pub(crate) struct Queue {
    /// The tasks of the current tile.
    here: Heap,
    current_tile: Option<TileId>,
    /// The tasks of other tiles, and those tiles ordered by their first task. The tile heap may
    /// have outdated entries, but not on top.
    elsewhere: HashMap<TileId, Heap, BuildHasherDefault<Mix>>,
    tiles: Heap,
    /// Tasks that need no tile.
    anywhere: Heap,
    tasks: Vec<Task>,
    unused: Vec<u32>,
    /// The length by which tasks of the current tile may be ahead, in addition to the factor.
    lead: f64,
    /// The factor by which tasks of the current tile may be ahead of those of others.
    tile_slack: f64,
    /// The factor by which they may be ahead of each other.
    slack: f64,
}

/// The outcome of [`Queue::next`].
pub(crate) enum Next {
    /// This task, which was removed from the queue.
    Task(Task),
    /// A task of this tile.
    In(TileId),
    Nothing,
}

impl Queue {
    /// Creates a queue, for a wavefront that is directed towards one goal or not.
    pub(crate) fn new(is_directed: bool) -> Self {
        let slack = if is_directed { DIRECTED_AHEAD } else { AHEAD };
        Self {
            here: Heap::with_capacity(ROOM),
            current_tile: None,
            elsewhere: HashMap::default(),
            tiles: Heap::new(),
            anywhere: Heap::new(),
            tasks: Vec::with_capacity(ROOM),
            unused: Vec::with_capacity(ROOM),
            lead: 0.0,
            tile_slack: slack,
            slack,
        }
    }

    /// Raises the length by which the current tile may be ahead, to at most `most`.
    pub(crate) fn lead(&mut self, most: f64) {
        self.tile_slack = AHEAD;
        self.lead = (2.0 * self.lead).max(most / 64.0).min(most);
    }

    /// From now on runs no task before a nearer one of the same tile.
    pub(crate) fn keep_order(&mut self) {
        self.slack = 1.0;
    }

    /// Makes `tile` the current tile.
    pub(crate) fn enter_tile(&mut self, tile: TileId) {
        if self.current_tile == Some(tile) {
            return;
        }
        let here = self.elsewhere.remove(&tile).unwrap_or(Heap::new());
        let there = std::mem::replace(&mut self.here, here);
        let was = self.current_tile.replace(tile);
        if let (Some(was), Some(&HeapEntry { length, .. })) = (was, there.first()) {
            self.tiles.push(tile_entry(length, was));
            self.elsewhere.insert(was, there);
        }
        self.settle();
    }

    /// Removes outdated entries from the top of the tile heap: those that are not the first task of
    /// a tile that still has tasks.
    fn settle(&mut self) {
        while let Some(&HeapEntry { length, slot, .. }) = self.tiles.first() {
            let tile = TileId(slot);
            if let Some(there) = self.elsewhere.get_mut(&tile)
                && let Some(&first) = there.first()
                && first.length == length
            {
                if !matches!(self.tasks[first.slot as usize], Task::Nothing) {
                    return;
                }
                there.pop();
                self.unused.push(first.slot);
                match there.first() {
                    Some(&HeapEntry { length, .. }) => self.tiles.push(tile_entry(length, tile)),
                    None => drop(self.elsewhere.remove(&tile)),
                }
            }
            self.tiles.pop();
        }
    }

    /// Adds a task, in a tile or without one. Returns the task's slot, which is valid while the
    /// task is in the queue.
    pub(super) fn push(&mut self, length: f64, tile: Option<TileId>, task: Task) -> u32 {
        let root = task.root();
        let slot = match self.unused.pop() {
            Some(slot) => {
                self.tasks[slot as usize] = task;
                slot
            }
            None => {
                self.tasks.push(task);
                self.tasks.len() as u32 - 1
            }
        };
        let length = length.max(0.0).to_bits();
        let entry = HeapEntry { length, slot, root };
        match tile {
            None => self.anywhere.push(entry),
            _ if tile == self.current_tile => self.here.push(entry),
            Some(tile) => {
                let there = self.elsewhere.entry(tile).or_insert(Heap::new());
                if there.first().is_none_or(|front| length < front.length) {
                    self.tiles.push(tile_entry(length, tile));
                }
                there.push(entry);
            }
        }
        slot
    }

    /// Returns an upper bound of the number of tasks.
    pub(super) fn len(&self) -> usize {
        self.tasks.len() - self.unused.len()
    }

    /// Returns the task in a slot. It may be another task if the one sought left the queue.
    pub(super) fn at(&mut self, slot: u32) -> Option<&mut Task> {
        self.tasks.get_mut(slot as usize)
    }

    /// Returns the least length of all tasks; infinite if there is none.
    #[inline]
    pub(crate) fn front(&self) -> f64 {
        self.here.front().min(self.tiles.front()).min(self.anywhere.front())
    }

    /// Returns the length up to which tasks of the current tile come before all other tasks.
    #[inline]
    fn ahead(&self) -> f64 {
        // Being ahead of tasks that need no tile saves nothing.
        (self.tiles.front() * self.tile_slack + self.lead).min(self.anywhere.front())
    }

    /// Returns whether a task of this length in the current tile may run next.
    #[inline]
    pub(crate) fn would_be_next(&self, length: f64) -> bool {
        length <= self.here.front() * self.slack && length <= self.ahead()
    }

    /// Returns tiles with tasks to run soon, in no order, each with the length of its first task:
    /// the top of the heap.
    pub(crate) fn top(&self) -> impl Iterator<Item = (f64, TileId)> {
        let is_first = |entry: &&HeapEntry| {
            let there = self.elsewhere.get(&TileId(entry.slot));
            there.is_some_and(|heap| heap.first().is_some_and(|first| first.length == entry.length))
        };
        let entries = self.tiles.top(TOP).filter(is_first);
        entries.map(|entry| (f64::from_bits(entry.length), TileId(entry.slot)))
    }

    /// Returns what to do next. A task of the current tile, or one without a tile, is removed from
    /// the queue.
    pub(crate) fn next(&mut self, roots: &[Root]) -> Next {
        loop {
            let (here, anywhere, tiles) = (self.here.front(), self.anywhere.front(), self.tiles.front());
            let from = if here < f64::INFINITY && here <= self.ahead() {
                &mut self.here
            } else if anywhere <= tiles {
                &mut self.anywhere
            } else {
                self.settle();
                match self.tiles.first() {
                    Some(top) if f64::from_bits(top.length) > tiles => continue,
                    Some(top) => return Next::In(TileId(top.slot)),
                    None if tiles < f64::INFINITY => continue,
                    None => return Next::Nothing,
                }
            };
            let Some(entry) = from.pop() else {
                return Next::Nothing;
            };
            // Most likely, the task that is first now is the next one.
            if let Some(soon) = from.first() {
                prefetch(&self.tasks, soon.slot as usize);
                prefetch(roots, soon.root as usize);
            }
            self.unused.push(entry.slot);
            let there = &mut self.tasks[entry.slot as usize];
            let task = *there;
            *there = Task::Nothing;
            if !matches!(task, Task::Nothing) {
                return Next::Task(task);
            }
        }
    }
}

/// Returns the entry of a tile whose first task has this length.
fn tile_entry(length: u64, tile: TileId) -> HeapEntry {
    HeapEntry {
        length,
        slot: tile.0,
        root: 0,
    }
}
