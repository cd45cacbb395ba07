//! Shortest paths over the visibility graph (Dijkstra), which is made as they are found.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::edges::{LocalGraph, NONE};
use super::sweep::{Range, Seen, Side, Sweep};
use crate::geometry::{Orientation, orient2d};
use crate::query::answer::WayPoint;

/// Ways whose lengths differ by less than this part may be equally long but for rounding, so that neither rules out the other.
const TIE: f64 = 1.0 + 1e-12;

/// A target that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    pub(crate) node: u32,
    /// The way to it.
    pub(crate) length: f64,
    /// Where it turns last.
    turn: u32,
}

/// A turn at a node, to the left or to the right: number `2 · node + side`.
#[derive(Clone, Copy, Debug)]
struct Turn {
    length: f64,
    /// The turn before it, or none.
    before: u32,
    is_done: bool,
}

/// What is known of the sector in which paths turn at a node.
#[derive(Clone, Copy, Debug)]
struct Sector {
    /// Its ends, once they were asked for; none if no path turns at the node.
    bounds: Option<Option<[u32; 2]>>,
    /// The shortest way into it.
    length: f64,
}

/// A target, with how many of those that are looked for are at it.
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
pub(crate) struct Search<'g> {
    graph: &'g LocalGraph,
    source: u32,
    /// Nothing farther away is wanted; it comes down as targets are seen.
    limit: f64,
    wanted: usize,
    targets: Vec<Target>,
    /// The target at a node, or [`NONE`].
    target_at: Vec<u32>,
    turns: Vec<Turn>,
    sectors: Vec<Sector>,
    /// By the bits of the length: turns, and behind those the targets.
    queue: BinaryHeap<Reverse<(u64, u32)>>,
    sweep: Sweep,
    /// Nodes in the open that are looked for.
    points: Vec<u32>,
    /// How many there are of those that are wanted, at all targets.
    there: usize,
    /// The targets that were found, and how many are at them.
    found: Vec<Found>,
    count: usize,
    /// Nodes that were swept.
    pub(crate) swept: u64,
    /// Nodes that those saw: edges of the visibility graph.
    pub(crate) links: u64,
}

impl<'g> Search<'g> {
    /// A search for the nearest targets, until so many are found or none is within the limit. Each target is a node and how many of
    /// those that are wanted are at it.
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
            let place = &mut this.target_at[node as usize];
            if *place != NONE {
                this.targets[*place as usize].count += count;
                continue;
            }
            *place = this.targets.len() as u32;
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

    /// Goes on for so many sweeps, or to the end; returns whether that is reached.
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
                        self.found.push(Found {
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

    /// The targets that are nearest, in order; all of those that are as far away as the last one.
    pub(crate) fn found(&self) -> &[Found] {
        &self.found
    }

    /// The way to a target: the source, the nodes at which it turns, and the target.
    pub(crate) fn way(&self, found: &Found) -> Vec<WayPoint> {
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
        // Farther by more than what rounding takes away.
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
        let place = self.target_at[node as usize];
        if let Some(target) = self.targets.get_mut(place as usize)
            && length < target.length
        {
            (target.length, target.turn) = (length, turn);
            self.queue
                .push(Reverse((length.to_bits(), self.turns.len() as u32 + place)));
        }
    }

    /// A node is reached from another one: paths may turn there.
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
            // It faces the obstacle; in the same sector, nobody who comes by a longer way need turn.
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

    /// What is farther away than as many targets as are wanted need not be looked at.
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
