//! One step of a wavefront.

use std::cmp::Reverse;

use super::found::{FoundTarget, Ready, Target};
use super::goal::Goal;
use super::queue::Next;
use super::reached::Reached;
use super::state::{PAUSE, Wavefront};
use super::task::Task;
use super::waiting::{JOINED_AFTER, ORDERED_AFTER};
use crate::query::free_space::FreeSpace;
use crate::query::request::Contradiction;
use crate::store::{Tile, TileId};

/// The outcome of a step.
#[derive(Debug)]
pub(crate) enum WavefrontStep {
    /// The wavefront continues in this tile.
    Need(TileId),
    /// The wavefront can continue in this tile, but yields to other tasks.
    Pause,
    /// The next nearest target.
    Found(FoundTarget),
    /// There are no more targets.
    Done,
}

impl Wavefront {
    /// Continues in a tile until a target is found, another tile is needed, or it is time to yield.
    /// Fails if the tile contradicts itself or others.
    pub(crate) fn step(&mut self, tile: &Tile) -> Result<WavefrontStep, Contradiction> {
        self.passed += u64::from(PAUSE - self.pause);
        self.joins |= self.passed >= JOINED_AFTER;
        if self.passed >= ORDERED_AFTER {
            self.queue.keep_order();
        }
        self.pause = PAUSE;
        let space = FreeSpace {
            tile,
            outside_is_free: self.outside_is_free,
        };
        self.enter_tile(space);
        let step = self.advance(space);
        space.passages().count_passed(PAUSE - self.pause);
        step
    }

    /// Runs tasks in the current tile until it is time for the next step.
    fn advance(&mut self, space: FreeSpace<'_>) -> Result<WavefrontStep, Contradiction> {
        loop {
            let front = self.queue.front();
            let is_next = |ready: &Reverse<Ready>| f64::from_bits(ready.0.key.0) < front;
            if self.ready.peek().is_some_and(is_next)
                && let Some(Reverse(ready)) = self.ready.pop()
            {
                // The target may have been found before, on a shorter path.
                if self.reported.insert(ready.key.1) {
                    if let Target::Point(found) = ready.value.target {
                        self.aims.forget(found);
                    }
                    return Ok(WavefrontStep::Found(ready.value));
                }
                continue;
            }
            if self.pause == 0 {
                return Ok(WavefrontStep::Pause);
            }
            let task = match self.queue.next(&self.roots) {
                Next::Task(task) => task,
                Next::In(tile) => return Ok(WavefrontStep::Need(tile)),
                Next::Nothing => return Ok(WavefrontStep::Done),
            };
            self.run(space, task)?;
        }
    }

    /// Runs a task in the current tile.
    #[inline]
    fn run(&mut self, space: FreeSpace<'_>, task: Task) -> Result<(), Contradiction> {
        match task {
            Task::Window {
                half_edge,
                root,
                right,
                left,
                ..
            } => {
                let window = self.window(root, right, left);
                self.through(space, root, half_edge, window)
            }
            Task::IncomingWindow {
                vertex,
                from,
                root,
                right,
                left,
                seam,
            } => {
                let window = self.window(root, right, left);
                self.enter(space, vertex, from, root, window, seam)
            }
            Task::Vertex {
                vertex,
                point,
                root,
                length,
                via,
            } => self.reach(space, vertex, point, root, length, via),
            Task::Goal { goal, root, length } => {
                self.report_point(goal, length, root);
                Ok(())
            }
            Task::Start { triangle } => self.start_in(space, triangle),
            Task::StartOnEdge { vertex, from } => self.start_on_edge(space, vertex, from),
            Task::StartVertex { vertex } => self.start_at(space, vertex),
            Task::StartOnHull {
                vertex,
                forward,
                before,
            } => self.start_on_hull(space, vertex, forward, before),
            Task::Nothing => Ok(()),
        }
    }

    /// Makes the tile current, and loads what is known of it.
    fn enter_tile(&mut self, space: FreeSpace<'_>) {
        let id = space.tile.id();
        if self.current_tile == Some(id) {
            return;
        }
        let here = self.elsewhere.remove(&id).unwrap_or_else(|| match &self.goal {
            Goal::Points(points) => Reached::new(space, points.triangles_in(id)),
            Goal::Sites | Goal::Vertices => Reached::new(space, std::iter::empty()),
        });
        self.queue.enter_tile(id);
        let there = std::mem::replace(&mut self.here, here);
        if let Some(was) = self.current_tile.replace(id) {
            self.elsewhere.insert(was, there);
        }
    }
}
