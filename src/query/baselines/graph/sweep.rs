//! The sweep: the nodes that a node sees.
//!
//! ```text
//!              ╲ b     A path that turns right round the node p leaves it between the edge to a,
//!      obstacle ● p    at the right end of the sector, and the line of the edge to b: the obstacle
//!              ╱ a     is on its right there, and was on its right before. A path that turns left
//!                      is the mirror image.
//! ```

use std::cmp::Ordering;

use super::edges::{LocalGraph, Ray, is_ahead, same_direction};
use super::status::{Crossed, Status};
use crate::geometry::Orientation::{Clockwise, Collinear, CounterClockwise};
use crate::geometry::{Point, orient2d};

/// A side of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
}

/// The directions of a node that are swept.
#[derive(Clone, Copy, Debug)]
pub(super) enum Range {
    /// All its free sectors.
    All,
    /// The directions into which a path leaves that turns to the side `to` round the node. The
    /// node's turning sector is between two nodes: `bounds` has the one at its right end and the
    /// one at its left end.
    Turn { to: Side, bounds: [u32; 2] },
}

/// A node that is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    pub(super) node: u32,
    /// Whether a path that arrives so can turn left there, and whether it can turn right.
    pub(super) turns: [bool; 2],
    /// Whether the path arrives along an edge.
    pub(super) is_along_edge: bool,
}

/// The sweep, with buffers that are reused.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    round: u32,
    /// The last round that a node was in, and whether it was in the range.
    nodes: Vec<(u32, bool)>,
    /// The last round that an edge was in.
    edges: Vec<u32>,
    events: Vec<u32>,
    status: Status,
    pub(super) seen: Vec<Seen>,
}

/// The center and the range of a sweep.
#[derive(Clone, Copy)]
struct Middle<'g> {
    graph: &'g LocalGraph,
    node: u32,
    at: Point,
    range: Range,
}

impl Middle<'_> {
    fn is_in_range(&self, to: Point) -> bool {
        let Range::Turn { to: side, bounds } = self.range else {
            return to != self.at;
        };
        let excluded = match side {
            Side::Right => Clockwise,
            Side::Left => CounterClockwise,
        };
        let is_out = |bound: u32| orient2d(self.at, self.graph.point(bound), to) == excluded;
        to != self.at && !bounds.into_iter().any(is_out)
    }

    /// Returns whether a point is in the second half of a full turn.
    fn is_late(&self, p: Point) -> bool {
        (p.y, p.x) < (self.at.y, self.at.x)
    }

    /// Returns the order of two events: counter-clockwise, and nearest first on the same ray.
    fn compare(&self, a: u32, b: u32) -> Ordering {
        let [a, b] = [a, b].map(|node| self.graph.point(node));
        if let Range::All = self.range
            && self.is_late(a) != self.is_late(b)
        {
            return self.is_late(a).cmp(&self.is_late(b));
        }
        match orient2d(self.at, a, b) {
            CounterClockwise => Ordering::Less,
            Clockwise => Ordering::Greater,
            Collinear if same_direction(self.at, a, b) => {
                let away = a.lex_cmp(b);
                if self.at.lex_cmp(a).is_lt() {
                    away
                } else {
                    away.reverse()
                }
            }
            // These are the two ends of a half-turn round the end of a wall, which starts or ends
            // at the wall.
            Collinear => match self.range {
                Range::Turn { to, bounds } => {
                    let is_on_wall = same_direction(self.at, self.graph.point(bounds[0]), a);
                    if is_on_wall == (to == Side::Right) {
                        Ordering::Less
                    } else {
                        Ordering::Greater
                    }
                }
                Range::All => Ordering::Equal,
            },
        }
    }

    fn is_same_ray(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|node| self.graph.point(node));
        orient2d(self.at, a, b) == Collinear && same_direction(self.at, a, b)
    }

    /// Returns whether an edge without ends in the range of a turn hides the whole range.
    fn hides_all(&self, crossed: &Crossed) -> bool {
        let Range::Turn { to, bounds } = self.range else {
            return false;
        };
        let bound = self.graph.point(match to {
            Side::Right => bounds[0],
            Side::Left => bounds[1],
        });
        orient2d(self.at, crossed.start, bound) == CounterClockwise
            && orient2d(self.at, bound, crossed.end) == CounterClockwise
    }
}

impl Sweep {
    /// Finds the nodes that a node sees within a distance. `points` are nodes without edges that
    /// may be seen. The result is in `seen`.
    pub(super) fn run(&mut self, graph: &LocalGraph, node: u32, range: Range, reach: f64, points: &[u32]) {
        let at = graph.point(node);
        let middle = Middle { graph, node, at, range };
        self.begin(graph);
        for &point in points {
            let p = graph.point(point);
            if (p.x - at.x).abs() <= reach && (p.y - at.y).abs() <= reach {
                self.meet(&middle, point);
            }
        }
        for (edge, number) in graph.edges.iter().zip(0..) {
            let [a, b] = edge.points;
            let is_far = a.x.min(b.x) > at.x + reach
                || a.x.max(b.x) < at.x - reach
                || a.y.min(b.y) > at.y + reach
                || a.y.max(b.y) < at.y - reach;
            if !is_far {
                self.take(&middle, number, edge.nodes);
            }
        }
        let mut events = std::mem::take(&mut self.events);
        events.sort_unstable_by(|&a, &b| middle.compare(a, b));
        self.turn(&middle, &events);
        self.events = events;
    }

    fn begin(&mut self, graph: &LocalGraph) {
        self.round = self.round.wrapping_add(1);
        if self.round == 0 {
            self.nodes.clear();
            self.edges.clear();
            self.round = 1;
        }
        self.nodes.resize(graph.nodes.len(), (0, false));
        self.edges.resize(graph.edges.len(), 0);
        self.events.clear();
        self.status.clear();
        self.seen.clear();
    }

    /// Makes a node an event if it is in the range. Returns whether it is.
    fn meet(&mut self, middle: &Middle<'_>, node: u32) -> bool {
        let known = &mut self.nodes[node as usize];
        if known.0 != self.round {
            *known = (self.round, middle.is_in_range(middle.graph.point(node)));
            if known.1 {
                self.events.push(node);
            }
        }
        known.1
    }

    /// Takes an edge into account. The ray crosses it from the start if the edge extends over the
    /// start of the range.
    fn take(&mut self, middle: &Middle<'_>, number: u32, nodes: [u32; 2]) {
        self.edges[number as usize] = self.round;
        let [a, b] = nodes.map(|node| (self.meet(middle, node), middle.graph.point(node)));
        let (start, end) = match orient2d(middle.at, a.1, b.1) {
            CounterClockwise => (a, b),
            Clockwise => (b, a),
            // The edge is on a ray, and its nodes determine what is along it.
            Collinear => return,
        };
        let crossed = Crossed {
            start: start.1,
            end: end.1,
            edge: number,
        };
        let is_first = match (middle.range, start.0, end.0) {
            (Range::All, ..) => middle.is_late(start.1) && !middle.is_late(end.1),
            (_, true, _) => false,
            (_, false, true) => true,
            (_, false, false) => middle.hides_all(&crossed),
        };
        if is_first {
            self.status.insert(crossed);
        }
    }

    /// Turns the ray over all events.
    fn turn(&mut self, middle: &Middle<'_>, events: &[u32]) {
        // For a source at an obstacle, `is_free` tells whether the ray's sector is free.
        let mut own: Vec<Ray> = middle.graph.rays(middle.node).collect();
        own.sort_unstable_by(|a, b| middle.compare(a.to, b.to));
        let mut is_free = own.last().is_none_or(|&ray| middle.graph.is_left_free(ray));
        for ray in events.chunk_by(|&a, &b| middle.is_same_ray(a, b)) {
            for &node in ray {
                self.pass(middle, node, false);
            }
            let along = own.iter().find(|own| own.to == ray[0]);
            let sides = match (middle.range, along) {
                (Range::All, None) => [is_free; 2],
                (Range::All, Some(&along)) => {
                    let on_right = std::mem::replace(&mut is_free, middle.graph.is_left_free(along));
                    [is_free, on_right]
                }
                (Range::Turn { .. }, None) => [true; 2],
                (Range::Turn { to, .. }, Some(_)) => [to == Side::Right, to == Side::Left],
            };
            self.look(middle, ray, sides);
            for &node in ray {
                self.pass(middle, node, true);
            }
        }
    }

    /// Moves the ray over a node: removes the edges that end there (`starts` is `false`), or adds
    /// those that start there.
    fn pass(&mut self, middle: &Middle<'_>, node: u32, starts: bool) {
        let at = middle.graph.point(node);
        for Ray { edge, to, .. } in middle.graph.rays(node) {
            if self.edges[edge as usize] != self.round {
                continue;
            }
            let to = middle.graph.point(to);
            let turn = orient2d(middle.at, at, to);
            if starts && turn == CounterClockwise {
                self.status.insert(Crossed {
                    start: at,
                    end: to,
                    edge,
                });
            } else if !starts && turn == Clockwise {
                self.status.remove(&Crossed {
                    start: to,
                    end: at,
                    edge,
                });
            }
        }
    }

    /// Examines the nodes on a ray. `sides` tells whether a path may start on the left and on the
    /// right of the ray.
    fn look(&mut self, middle: &Middle<'_>, ray: &[u32], sides: [bool; 2]) {
        let graph = middle.graph;
        let nearest = self.status.first().copied();
        let mut sides = sides;
        for &node in ray {
            let point = graph.point(node);
            let is_hidden = |edge: Crossed| orient2d(edge.start, edge.end, point) == Clockwise;
            if sides == [false; 2] || nearest.is_some_and(is_hidden) {
                return;
            }
            let (mut behind, mut ahead) = (false, false);
            // Whether a path can continue straight with all edges of the node on its right, and on
            // its left.
            let mut passes = [true; 2];
            let mut has_rays = false;
            for ray in graph.rays(node) {
                has_rays = true;
                let to = graph.point(ray.to);
                match orient2d(middle.at, point, to) {
                    CounterClockwise => passes[0] = false,
                    Clockwise => passes[1] = false,
                    Collinear if is_ahead(middle.at, point, to) => ahead = true,
                    Collinear => behind = true,
                }
            }
            sides = [sides[0] && passes[0], sides[1] && passes[1]];
            let turns = has_rays && !ahead;
            self.seen.push(Seen {
                node,
                turns: [turns && sides[1], turns && sides[0]],
                is_along_edge: behind,
            });
            if !ahead && sides != [false; 2] {
                sides = [true; 2];
            }
        }
    }
}
