//! Shortest paths over the visibility graph (Dijkstra's algorithm), which is built during the
//! search.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::edges::{LocalGraph, NONE};
use super::sweep::{Range, Seen, Side, Sweep};
use crate::geometry::{Orientation, orient2d};
use crate::query::answer::WayPoint;

/// Paths whose lengths differ by less than this factor may be equally long except for rounding, so
/// neither excludes the other.
const TIE: f64 = 1.0 + 1e-12;

/// A target that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ReachedTarget {
    pub(crate) node: u32,
    /// The length of the path.
    pub(crate) length: f64,
    /// The last turn of the path.
    turn: u32,
}

/// A turn at a node, to the left or to the right: number `2 · node + side`.
#[derive(Clone, Copy, Debug)]
struct Turn {
    length: f64,
    /// The previous turn, or [`NONE`].
    before: u32,
    is_done: bool,
}

/// The knowledge of the sector in which paths turn at a node.
#[derive(Clone, Copy, Debug)]
struct Sector {
    /// The ends of the sector, once they were computed; `Some(None)` if no path turns at the node.
    bounds: Option<Option<[u32; 2]>>,
    /// The length of the shortest path into the sector.
    length: f64,
}

/// A target, with the number of wanted items at it.
#[derive(Clone, Copy, Debug)]
struct Target {
    node: u32,
    count: usize,
    length: f64,
    turn: u32,
    is_found: bool,
}

/// A search from a node to targets, nearest first.
#[derive(Debug)]
pub(crate) struct VisibilitySearch<'g> {
    graph: &'g LocalGraph,
    source: u32,
    /// Targets that are farther away are not wanted. The limit decreases as targets are seen.
    limit: f64,
    wanted: usize,
    targets: Vec<Target>,
    /// The target at a node, or [`NONE`].
    target_at: Vec<u32>,
    turns: Vec<Turn>,
    sectors: Vec<Sector>,
    /// The queue, by the bits of the length: turns, followed by targets, whose numbers come after
    /// those of all turns.
    queue: BinaryHeap<Reverse<(u64, u32)>>,
    sweep: Sweep,
    /// Nodes without edges that are targets.
    points: Vec<u32>,
    /// The number of wanted items at all targets.
    there: usize,
    /// The targets that were found; `count` is the number of items at them.
    found: Vec<ReachedTarget>,
    count: usize,
    /// The number of nodes that were swept.
    pub(crate) swept: u64,
    /// The number of nodes that those see: edges of the visibility graph.
    pub(crate) links: u64,
}

impl<'g> VisibilitySearch<'g> {
    /// Creates a search for the nearest targets, until `wanted` items are found or none is within
    /// the limit. Each target is a node and the number of wanted items at it.
    pub(crate) fn new(
        graph: &'g LocalGraph,
        source: u32,
        targets: impl IntoIterator<Item = (u32, usize)>,
        wanted: usize,
        limit: f64,
    ) -> Self {
        let nodes = graph.nodes.len();
        let mut this = Self {
            graph,
            source,
            limit,
            wanted,
            targets: Vec::new(),
            target_at: vec![NONE; nodes],
            turns: vec![
                Turn {
                    length: f64::INFINITY,
                    before: NONE,
                    is_done: false,
                };
                2 * nodes
            ],
            sectors: vec![
                Sector {
                    bounds: None,
                    length: f64::INFINITY,
                };
                nodes
            ],
            queue: BinaryHeap::new(),
            sweep: Sweep::default(),
            points: Vec::new(),
            there: 0,
            found: Vec::new(),
            count: 0,
            swept: 0,
            links: 0,
        };
        for (node, count) in targets {
            this.there += count;
            let index = &mut this.target_at[node as usize];
            if *index != NONE {
                this.targets[*index as usize].count += count;
                continue;
            }
            *index = this.targets.len() as u32;
            this.targets.push(Target {
                node,
                count,
                length: f64::INFINITY,
                turn: NONE,
                is_found: false,
            });
            if graph.rays(node).next().is_none() {
                this.points.push(node);
            }
        }
        this
    }

    /// Continues for `sweeps` sweeps, or to the end. Returns whether the end is reached.
    pub(crate) fn go(&mut self, sweeps: u64) -> bool {
        if self.swept == 0 {
            self.reach_target(self.source, 0.0, NONE);
            self.sweep_from(self.source, Range::All, 0.0, NONE);
        }
        let end = self.swept.saturating_add(sweeps);
        while self.swept < end {
            let Some(Reverse((bits, what))) = self.queue.pop() else {
                return true;
            };
            let length = f64::from_bits(bits);
            let is_enough = self.count >= self.wanted && self.found.last().is_some_and(|found| found.length < length);
            if length > self.limit || is_enough {
                self.queue.clear();
                return true;
            }
            match what.checked_sub(self.turns.len() as u32) {
                Some(target) => {
                    let target = &mut self.targets[target as usize];
                    if !std::mem::replace(&mut target.is_found, true) {
                        self.count += target.count;
                        self.found.push(ReachedTarget {
                            node: target.node,
                            length,
                            turn: target.turn,
                        });
                    }
                }
                None => self.settle(what, length),
            }
        }
        false
    }

    /// Returns the nearest targets, in order, with all targets that are as far away as the last
    /// one.
    pub(crate) fn found(&self) -> &[ReachedTarget] {
        &self.found
    }

    /// Returns the path to a target: the source, the nodes at which it turns, and the target.
    pub(crate) fn way(&self, found: &ReachedTarget) -> Vec<WayPoint> {
        let mut way = vec![self.graph.way_point(found.node)];
        let mut turn = found.turn;
        while turn != NONE {
            way.push(self.graph.way_point(turn / 2));
            turn = self.turns[turn as usize].before;
        }
        way.push(self.graph.way_point(self.source));
        way.reverse();
        way
    }

    fn settle(&mut self, turn: u32, length: f64) {
        let node = turn / 2;
        let sector = self.sectors[node as usize];
        let known = &mut self.turns[turn as usize];
        if known.is_done || length > sector.length * TIE {
            return;
        }
        known.is_done = true;
        let Some(Some(bounds)) = sector.bounds else { return };
        let to = if turn.is_multiple_of(2) {
            Side::Left
        } else {
            Side::Right
        };
        self.sweep_from(node, Range::Turn { to, bounds }, length, turn);
    }

    fn sweep_from(&mut self, node: u32, range: Range, length: f64, turn: u32) {
        let mut sweep = std::mem::take(&mut self.sweep);
        // The factor exceeds the rounding errors.
        let reach = self.limit * TIE - length;
        sweep.run(self.graph, node, range, reach, &self.points);
        self.swept += 1;
        self.links += sweep.seen.len() as u64;
        for &seen in &sweep.seen {
            let length = length + self.graph.length(node, seen.node);
            if length <= self.limit {
                self.reach_target(seen.node, length, turn);
                self.reach_turn(seen, node, length, turn);
            }
        }
        self.sweep = sweep;
        self.lower_limit();
    }

    fn reach_target(&mut self, node: u32, length: f64, turn: u32) {
        let index = self.target_at[node as usize];
        if let Some(target) = self.targets.get_mut(index as usize)
            && length < target.length
        {
            (target.length, target.turn) = (length, turn);
            self.queue
                .push(Reverse((length.to_bits(), self.turns.len() as u32 + index)));
        }
    }

    /// Reaches a node from another one; paths may turn there.
    fn reach_turn(&mut self, seen: Seen, from: u32, length: f64, before: u32) {
        let node = seen.node;
        let sector = &mut self.sectors[node as usize];
        if length > sector.length * TIE {
            return;
        }
        let Some([right, left]) = *sector.bounds.get_or_insert_with(|| self.graph.turning_bounds(node)) else {
            return;
        };
        if seen.turns == [false; 2] {
            // The path faces the obstacle. In the same sector, no longer path needs to turn.
            let [at, from, right, left] = [node, from, right, left].map(|node| self.graph.point(node));
            let is_in_sector = right == left
                || orient2d(at, left, from) == Orientation::Clockwise
                || orient2d(at, right, from) == Orientation::CounterClockwise;
            if is_in_sector && !seen.is_along_edge {
                sector.length = sector.length.min(length);
            }
            return;
        }
        sector.length = sector.length.min(length);
        for (turns, turn) in seen.turns.into_iter().zip(2 * node..) {
            let known = &mut self.turns[turn as usize];
            if turns && length < known.length {
                (known.length, known.before) = (length, before);
                self.queue.push(Reverse((length.to_bits(), turn)));
            }
        }
    }

    /// Lowers the limit to the distance within which there are as many items as wanted.
    fn lower_limit(&mut self) {
        if self.there < self.wanted {
            return;
        }
        let mut near: Vec<(f64, usize)> = Vec::new();
        near.extend(
            self.targets
                .iter()
                .filter(|target| target.length <= self.limit)
                .map(|target| (target.length, target.count)),
        );
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut count = 0;
        for (length, here) in near {
            count += here;
            if count >= self.wanted {
                self.limit = self.limit.min(length);
                return;
            }
        }
    }
}
