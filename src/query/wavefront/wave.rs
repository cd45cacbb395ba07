//! A wave on its way.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};
use std::hash::BuildHasherDefault;

use super::found::{Found, Ready, What};
use super::goal::Goal;
use super::parts::{Part, Shape, Side};
use super::queue::Queue;
use super::reached::Reached;
use super::roots::{Root, SeenVertices};
use super::task::Task;
use super::waiting::Waiting;
use crate::collections::mix::Mix;
use crate::geometry::Point;
use crate::query::free_space::Mark;
use crate::store::{TileId, VertexId};

/// Triangles that one step passes through at most, more or less.
pub(super) const PAUSE: u32 = 1 << 12;

/// A wave on its way.
#[derive(Debug)]
pub(crate) struct Wave {
    pub(super) source: Point,
    pub(super) outside_is_free: bool,
    pub(super) goal: Goal,
    /// The only place to be found, which the wave hurries to.
    pub(super) towards: Option<Point>,
    /// Nothing farther away is wanted.
    pub(super) limit: f64,
    pub(super) queue: Queue,
    pub(super) waiting: Waiting,
    /// Whether cones that wait next to each other are joined.
    pub(super) joins: bool,
    /// Triangles that it went through before this step.
    pub(super) passed: u64,
    pub(super) roots: Vec<Root>,
    pub(super) seen: SeenVertices,
    /// What it knows of the tile that it is in, and of those where it was.
    pub(super) here: Reached,
    pub(super) here_is: Option<TileId>,
    pub(super) elsewhere: HashMap<TileId, Reached, BuildHasherDefault<Mix>>,
    pub(super) ready: BinaryHeap<Reverse<Ready>>,
    /// The numbers of what was told.
    pub(super) told: HashSet<u64, BuildHasherDefault<Mix>>,
    /// Triangles that this step may still pass.
    pub(super) pause: u32,
    /// What was seen, if someone asks for it.
    pub(super) parts: Option<Vec<Part>>,
    /// What of the outside the source was seen to see already.
    pub(super) beside: Option<Side>,
}

impl Wave {
    /// A length that all ways to what was not told yet have at least.
    pub(crate) fn front(&self) -> f64 {
        let ready = self.ready.peek().map(|ready| f64::from_bits(ready.0.key.0));
        ready.map_or(self.queue.front(), |ready| ready.min(self.queue.front()))
    }

    /// How many points it spread from: no way has more legs than that and one.
    pub(crate) fn root_count(&self) -> usize {
        self.roots.len()
    }

    /// The vertices and points on the way to a root, the source first.
    pub(crate) fn way(&self, root: u32) -> Vec<(Point, Option<VertexId>)> {
        let mut way = Vec::new();
        let mut at = Some(root);
        while let Some(root) = at.map(|at| &self.roots[at as usize]) {
            way.push((root.point, root.vertex));
            at = root.parent;
        }
        way.reverse();
        way
    }

    /// The vertex that a root is, unless it is the source.
    pub(crate) fn root_vertex(&self, root: u32) -> Option<VertexId> {
        self.roots.get(root as usize).and_then(|root| root.vertex)
    }

    /// The vertices that it came to.
    #[cfg(feature = "baselines")]
    pub(crate) fn reached(&self) -> impl Iterator<Item = VertexId> {
        let reached = self.seen.iter().filter(|(_, seen)| seen.mark.is_some());
        reached.map(|(&vertex, _)| vertex)
    }

    /// Lets it stay in a tile for longer, up to where that is ahead of others by so much: it has come to a tile again that was read before.
    pub(crate) fn lead(&mut self, most: f64) {
        self.queue.lead(most);
    }

    /// The tiles that it will most likely need after this one, the likeliest first.
    pub(crate) fn ahead(&self, after: TileId) -> Vec<TileId> {
        let mut soon: Vec<(f64, TileId)> = self.queue.top().filter(|&(_, tile)| tile != after).collect();
        soon.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut tiles: Vec<TileId> = Vec::new();
        for (_, tile) in soon {
            if !tiles.contains(&tile) {
                tiles.push(tile);
            }
        }
        tiles
    }

    pub(super) fn push(&mut self, length: f64, tile: Option<TileId>, task: Task) {
        if length <= self.limit {
            self.queue.push(length, tile, task);
        }
    }

    pub(super) fn tell(&mut self, what: What, number: u64, length: f64, root: u32) {
        if self.told.contains(&number) {
            return;
        }
        self.ready.push(Reverse(Ready {
            key: (length.to_bits(), number),
            value: Found { what, length, root },
        }));
    }

    pub(super) fn tell_place(&mut self, goal: u32, length: f64, root: u32) {
        self.tell(What::Place(goal), goal.into(), length, root);
    }

    /// Whether a vertex of this mark is one of those that are looked for.
    pub(super) fn is_told_of(&self, mark: Mark) -> bool {
        match self.goal {
            Goal::Sites => mark.has_site(),
            Goal::Places(_) => false,
            Goal::Vertices => true,
        }
    }

    /// Keeps parts from now on.
    pub(crate) fn keep_parts(&mut self) {
        self.parts.get_or_insert_default();
    }

    /// The parts seen since they were taken last.
    pub(crate) fn parts(&self) -> &[Part] {
        self.parts.as_deref().unwrap_or_default()
    }

    /// Takes the parts seen since this was asked last.
    pub(crate) fn take_parts(&mut self) -> Vec<Part> {
        self.parts.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Where a root is, and how long the way to it is.
    pub(crate) fn root_at(&self, root: u32) -> (Point, f64) {
        let root = &self.roots[root as usize];
        (root.point, root.length)
    }

    /// Keeps a part, if parts are asked for.
    #[inline]
    pub(crate) fn keep(&mut self, root: u32, shape: Shape) {
        if let Some(parts) = &mut self.parts {
            parts.push(Part { root, shape });
        }
    }
}
