//! One step of a wave.

use std::cmp::Reverse;

use super::found::{Found, Ready};
use super::goal::Goal;
use super::queue::Next;
use super::reached::Reached;
use super::task::Task;
use super::waiting::{JOINED_AFTER, ORDERED_AFTER};
use super::wave::{PAUSE, Wave};
use crate::query::free_space::Ground;
use crate::query::request::Contradiction;
use crate::store::{Tile, TileId};

/// What a step of the wave comes to.
#[derive(Debug)]
pub(crate) enum Step {
    /// It goes on in this tile.
    Need(TileId),
    /// It can go on in this tile, but has been at it for a while.
    Pause,
    /// The next nearest thing.
    Found(Found),
    /// There is nothing more to find.
    Done,
}

impl Wave {
    /// Goes on in a tile, or says which it needs; an error says how the tile contradicts itself or others.
    pub(crate) fn step(&mut self, tile: &Tile) -> Result<Step, Contradiction> {
        self.passed += u64::from(PAUSE - self.pause);
        self.joins |= self.passed >= JOINED_AFTER;
        if self.passed >= ORDERED_AFTER {
            self.queue.keep_order();
        }
        self.pause = PAUSE;
        let ground = Ground {
            tile,
            outside_is_free: self.outside_is_free,
        };
        self.come_to(ground);
        loop {
            let front = self.queue.front();
            let is_next = |ready: &Reverse<Ready>| f64::from_bits(ready.0.key.0) < front;
            if self.ready.peek().is_some_and(is_next)
                && let Some(Reverse(ready)) = self.ready.pop()
            {
                // A way that was found before may be longer.
                if self.told.insert(ready.key.1) {
                    return Ok(Step::Found(ready.value));
                }
                continue;
            }
            if self.pause == 0 {
                return Ok(Step::Pause);
            }
            let task = match self.queue.next() {
                Next::Task(task) => task,
                Next::In(tile) => return Ok(Step::Need(tile)),
                Next::Nothing => return Ok(Step::Done),
            };
            self.run(ground, task)?;
        }
    }

    /// Does a thing in the tile at hand.
    #[inline]
    fn run(&mut self, ground: Ground<'_>, task: Task) -> Result<(), Contradiction> {
        match task {
            Task::Cone {
                side,
                root,
                right,
                left,
                ..
            } => {
                let cone = self.cone(root, right, left);
                self.through(ground, root, side, cone)
            }
            Task::ConeOver {
                vertex,
                from,
                root,
                right,
                left,
                seam,
            } => {
                let cone = self.cone(root, right, left);
                self.enter(ground, vertex, from, root, cone, seam)
            }
            Task::Vertex {
                vertex,
                point,
                root,
                length,
                via,
            } => self.reach(ground, vertex, point, root, length, via),
            Task::Goal { goal, root, length } => {
                self.tell_place(goal, length, root);
                Ok(())
            }
            Task::Start { triangle } => self.start_in(ground, triangle),
            Task::StartOnEdge { vertex, from } => self.start_on_edge(ground, vertex, from),
            Task::StartVertex { vertex } => self.start_at(ground, vertex),
            Task::StartOnHull {
                vertex,
                forward,
                before,
            } => self.start_on_hull(ground, vertex, forward, before),
            Task::Nothing => Ok(()),
        }
    }

    /// Turns to what is known of a tile.
    fn come_to(&mut self, ground: Ground<'_>) {
        let id = ground.tile.id();
        if self.here_is == Some(id) {
            return;
        }
        let here = self.elsewhere.remove(&id).unwrap_or_else(|| match &self.goal {
            Goal::Places(places) => Reached::new(ground, places.triangles_in(id)),
            Goal::Sites | Goal::Vertices => Reached::new(ground, std::iter::empty()),
        });
        self.queue.come_to(id);
        let there = std::mem::replace(&mut self.here, here);
        if let Some(was) = self.here_is.replace(id) {
            self.elsewhere.insert(was, there);
        }
    }
}
