//! What the wave has still to do, nearest first.

use std::collections::HashMap;
use std::hash::BuildHasherDefault;

use super::heap::{Entry, Heap};
use super::task::Task;
use crate::collections::mix::Mix;
use crate::store::TileId;

/// Tiles that are looked at for what comes soon: three levels of the heap.
const TOP: usize = 21;
/// The part by which something may be longer than another and be done before it, and one. Much less, and more has to wait; much more, and
/// more is done in vain.
const AHEAD: f64 = 1.0 + 1.0 / 128.0;
/// Tasks for which there is room from the start.
const ROOM: usize = 32;

/// Items by what they promise, those of each tile by themselves: no way that goes on from one is shorter. Of equal ones any may be first.
///
/// They are done in order, more or less: something may be done before others that are nearer. That is right as well, for what is found waits
/// until nothing nearer can be found. Whatever is at hand may be ahead by a small part of its length, which saves much going in and
/// out of the queue, and from tile to tile. Where the wave's front goes through more tiles than the cache holds, what lies in the tile at
/// hand may besides be ahead by `lead`, which saves reading the tile again for each item.
#[derive(Debug)]
pub(crate) struct Queue {
    /// What there is to do in the tile at hand.
    here: Heap,
    here_is: Option<TileId>,
    /// What there is to do in others, and these by the first thing of each. What is not the first one any more may stand there still, but
    /// not on top.
    elsewhere: HashMap<TileId, Heap, BuildHasherDefault<Mix>>,
    tiles: Heap,
    /// What needs no tile.
    anywhere: Heap,
    tasks: Vec<Task>,
    unused: Vec<u32>,
    /// By how much the tile at hand may be ahead, besides.
    lead: f64,
    /// [`AHEAD`], or 1 if nothing may be done before what is nearer in the same tile.
    slack: f64,
}

/// What comes next.
pub(crate) enum Next {
    /// This, which is not in the queue any more.
    Task(Task),
    /// Something in this tile.
    In(TileId),
    Nothing,
}

impl Queue {
    pub(crate) fn new() -> Self {
        Self {
            here: Heap::with_capacity(ROOM),
            here_is: None,
            elsewhere: HashMap::default(),
            tiles: Heap::new(),
            anywhere: Heap::new(),
            tasks: Vec::with_capacity(ROOM),
            unused: Vec::with_capacity(ROOM),
            lead: 0.0,
            slack: AHEAD,
        }
    }

    /// Lets the tile at hand be further ahead, but not by more than `most`.
    pub(crate) fn lead(&mut self, most: f64) {
        self.lead = (2.0 * self.lead).max(most / 64.0).min(most);
    }

    /// Lets nothing more be done before what is nearer in the same tile.
    pub(crate) fn keep_order(&mut self) {
        self.slack = 1.0;
    }

    /// Turns to a tile.
    pub(crate) fn come_to(&mut self, tile: TileId) {
        if self.here_is == Some(tile) {
            return;
        }
        let here = self.elsewhere.remove(&tile).unwrap_or(Heap::new());
        let there = std::mem::replace(&mut self.here, here);
        let was = self.here_is.replace(tile);
        if let (Some(was), Some(&Entry { length, .. })) = (was, there.first()) {
            self.tiles.push(Entry { length, place: was.0 });
            self.elsewhere.insert(was, there);
        }
        self.settle();
    }

    /// Takes away what is on top of the tiles without being the first thing of one that there is still.
    fn settle(&mut self) {
        while let Some(&Entry { length, place }) = self.tiles.first() {
            let tile = TileId(place);
            if let Some(there) = self.elsewhere.get_mut(&tile)
                && let Some(&first) = there.first()
                && first.length == length
            {
                if !matches!(self.tasks[first.place as usize], Task::Nothing) {
                    return;
                }
                there.pop();
                self.unused.push(first.place);
                match there.first() {
                    Some(&Entry { length, .. }) => self.tiles.push(Entry { length, place }),
                    None => drop(self.elsewhere.remove(&tile)),
                }
            }
            self.tiles.pop();
        }
    }

    /// Adds something to do in a tile, or what needs none. Returns the task's place while it is in the queue.
    pub(super) fn push(&mut self, length: f64, tile: Option<TileId>, task: Task) -> u32 {
        let place = match self.unused.pop() {
            Some(place) => {
                self.tasks[place as usize] = task;
                place
            }
            None => {
                self.tasks.push(task);
                self.tasks.len() as u32 - 1
            }
        };
        let length = length.max(0.0).to_bits();
        let entry = Entry { length, place };
        match tile {
            None => self.anywhere.push(entry),
            _ if tile == self.here_is => self.here.push(entry),
            Some(tile) => {
                let there = self.elsewhere.entry(tile).or_insert(Heap::new());
                if there.first().is_none_or(|front| length < front.length) {
                    self.tiles.push(Entry { length, place: tile.0 });
                }
                there.push(entry);
            }
        }
        place
    }

    /// How many tasks there may be.
    pub(super) fn len(&self) -> usize {
        self.tasks.len() - self.unused.len()
    }

    /// A task by its place, or another one if it is not in the queue any more.
    pub(super) fn at(&mut self, place: u32) -> Option<&mut Task> {
        self.tasks.get_mut(place as usize)
    }

    /// The least length of all; infinite if there is nothing to do.
    #[inline]
    pub(crate) fn front(&self) -> f64 {
        self.here.front().min(self.tiles.front()).min(self.anywhere.front())
    }

    /// The length up to which something in the tile at hand comes before what is out of it.
    #[inline]
    fn ahead(&self) -> f64 {
        // Nobody gains by being ahead of what needs no tile.
        (self.tiles.front() * AHEAD + self.lead).min(self.anywhere.front())
    }

    /// Whether something of such a length in the tile at hand may come next.
    #[inline]
    pub(crate) fn would_be_next(&self, length: f64) -> bool {
        length <= self.here.front() * self.slack && length <= self.ahead()
    }

    /// The tiles where something is to be done soon, in no order, each with the length of it: the top of the heap.
    pub(crate) fn top(&self) -> impl Iterator<Item = (f64, TileId)> {
        let is_first = |entry: &&Entry| {
            let there = self.elsewhere.get(&TileId(entry.place));
            there.is_some_and(|heap| heap.first().is_some_and(|first| first.length == entry.length))
        };
        let entries = self.tiles.top(TOP).filter(is_first);
        entries.map(|entry| (f64::from_bits(entry.length), TileId(entry.place)))
    }

    /// What is to be done next; a task of the tile at hand, or one that needs none, is taken.
    pub(crate) fn next(&mut self) -> Next {
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
                    Some(top) => return Next::In(TileId(top.place)),
                    None if tiles < f64::INFINITY => continue,
                    None => return Next::Nothing,
                }
            };
            let Some(entry) = from.pop() else {
                return Next::Nothing;
            };
            self.unused.push(entry.place);
            let there = &mut self.tasks[entry.place as usize];
            let task = *there;
            *there = Task::Nothing;
            if !matches!(task, Task::Nothing) {
                return Next::Task(task);
            }
        }
    }
}
