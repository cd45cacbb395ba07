//! How the wave starts: in triangles, at a vertex, or outside the hull.

use std::collections::{BinaryHeap, HashMap, HashSet};

use super::cone::Cone;
use super::goal::Goal;
use super::queue::{Item, Kind, NOWHERE, Queue, Via};
use super::reached::Reached;
use super::roots::{NO_ROOT, Root, SeenVertices};
use super::waiting::Waiting;
use super::wave::{PAUSE, Wave};
use crate::geometry::{Orientation, Point, orient2d};
use crate::query::free_space::{Ground, Place, SINGLE, Spot, Wedge};
use crate::query::request::{Contradiction, next, side_towards};
use crate::store::VertexId;

impl Wave {
    /// Puts in the queue what the source sees first.
    pub(crate) fn start(&mut self, source: &Place) {
        self.roots.push(Root {
            point: source.point,
            vertex: source.vertex(),
            length: 0.0,
            parent: NO_ROOT,
            done: [0; 2],
        });
        let nowhere = VertexId {
            tile: NOWHERE,
            index: 0,
        };
        let mut push = |kind, tile, index, other| {
            let item = Item {
                kind,
                tile,
                index,
                other,
                root: 0,
                right: source.point,
                left: source.point,
                seam: 0,
            };
            self.queue.push(0.0, item);
        };
        match source.spot {
            Spot::Triangle(triangle) => push(Kind::Start, triangle.tile, 3 * triangle.triangle, nowhere),
            Spot::Edge { ends: [a, b] } => {
                for (a, b) in [(a, b), (b, a)] {
                    push(Kind::Start, b.id.tile, b.id.index, a.id);
                }
            }
            Spot::Vertex(vertex) => push(Kind::StartVertex, vertex.id.tile, vertex.id.index, nowhere),
            Spot::Outside([from, to]) => {
                push(Kind::Hull, from.tile, from.index, to);
                push(Kind::HullBack, from.tile, from.index, to);
            }
        }
        if let Goal::Places(places) = &self.goal {
            let here = |(point, _): &(&Point, u32)| **point == source.point;
            let here: Vec<u32> = places
                .points()
                .iter()
                .zip(0..)
                .filter(here)
                .map(|(_, goal)| goal)
                .collect();
            for goal in here {
                self.tell_place(goal, 0.0, 0);
            }
        }
    }

    /// The source lies in a closed triangle.
    pub(crate) fn start_in(&mut self, ground: Ground<'_>, item: &Item) -> Result<(), Contradiction> {
        let side = if item.other.tile == NOWHERE {
            item.index
        } else if let Some(side) = side_towards(ground.tile, item.index, item.other)? {
            side
        } else {
            return self.start_on_hull(ground, item);
        };
        if ground.is_free(side / 3) {
            self.spread_in(ground, 0, side / 3)?;
        }
        Ok(())
    }

    /// The source lies on a hull edge, and outside of it.
    pub(super) fn start_on_hull(&mut self, ground: Ground<'_>, item: &Item) -> Result<(), Contradiction> {
        if !self.outside_is_free {
            return Ok(());
        }
        let edge = ground.first(item.index)?;
        let ends = [edge, next(edge)].map(|side| ground.tile.origin(side));
        for end in ends {
            self.see(ground, 0, end, Via::Outside);
        }
        // The hull is on the left of the edge.
        self.see_half(ground.point(ends[1]), false);
        Ok(())
    }

    /// The source is a vertex.
    pub(crate) fn start_at(&mut self, ground: Ground<'_>, vertex: u32) -> Result<(), Contradiction> {
        if vertex >= ground.tile.vertex_count() {
            return Err(Contradiction::NoVertex(vertex));
        }
        self.seen.entry(ground.tile.vertex(vertex).id).or_default().limit = 0.0;
        if ground.marks().of_vertices[vertex as usize] & SINGLE != 0 {
            self.here.reach(vertex, 0.0);
        }
        self.tell_vertex(ground, vertex, 0.0, 0);
        for wedge in ground.free_wedges(vertex)? {
            match wedge {
                Wedge::Triangle(side) => self.spread_in(ground, 0, side / 3)?,
                Wedge::Outside => self.spread_outside(ground, 0, vertex, None)?,
            }
        }
        Ok(())
    }

    /// All that a root sees that lies in a closed triangle or at its corner.
    pub(super) fn spread_in(&mut self, ground: Ground<'_>, root: u32, triangle: u32) -> Result<(), Contradiction> {
        let at = self.roots[root as usize].point;
        self.see_places_in(ground, root, triangle);
        for side in [0, 1, 2].map(|s| 3 * triangle + s) {
            let [from, to] = [side, next(side)].map(|side| ground.tile.origin(side));
            self.see_by(ground, root, from, side);
            let [right, left] = [from, to].map(|corner| ground.point(corner));
            if orient2d(right, left, at) == Orientation::CounterClockwise {
                let cone = Cone { root: at, right, left };
                self.pass(ground, root, side, cone, [right, left])?;
            }
        }
        Ok(())
    }

    /// The source lies outside and sees a hull edge from without: that which leaves a vertex, or the one that comes in.
    pub(crate) fn start_along_hull(&mut self, ground: Ground<'_>, item: &Item) -> Result<(), Contradiction> {
        let (vertex, forward) = (item.index, item.kind == Kind::Hull);
        if vertex >= ground.tile.vertex_count() {
            return Err(Contradiction::NoVertex(vertex));
        }
        self.pause = self.pause.saturating_sub(1);
        let at = self.source;
        self.see(ground, 0, vertex, Via::Outside);
        let edge = ground.along_hull(vertex, forward)?;
        let ends = [edge, next(edge)].map(|side| ground.tile.origin(side));
        let [left, right] = ends.map(|end| ground.point(end));
        if !goes_on_convexly(item, left, right, forward) {
            return Err(Contradiction::ConcaveHull(vertex));
        }
        if orient2d(left, right, at) != Orientation::Clockwise {
            self.see_half(ground.point(vertex), !forward);
            return Ok(());
        }
        self.see_before_hull(right, left);
        if !ground.tile.is_wall(edge) && ground.is_free(edge / 3) {
            let cone = Cone { root: at, right, left };
            self.through(ground, 0, edge, cone)?;
        }
        let beyond = ground.tile.vertex(ends[usize::from(forward)]).id;
        let item = Item {
            kind: if forward { Kind::Hull } else { Kind::HullBack },
            tile: beyond.tile,
            index: beyond.index,
            other: beyond,
            root: 0,
            right,
            left,
            seam: 0,
        };
        self.queue.push(0.0, item);
        Ok(())
    }
}

/// Whether the hull edge from `left` to `right` continues the one that the item comes from, if there is one, without a turn to the
/// right. Those that a source outside sees then are no more than there are, also where damaged tiles contradict each other: no convex
/// chain that has a point on its right all the way turns by more than half a turn.
fn goes_on_convexly(item: &Item, left: Point, right: Point, forward: bool) -> bool {
    if item.left == item.right {
        return true;
    }
    let (joined, turn) = if forward {
        (item.right == left, orient2d(item.left, item.right, right))
    } else {
        (item.left == right, orient2d(left, right, item.right))
    };
    joined && turn != Orientation::Clockwise
}

impl Wave {
    /// A wave from a free place to all that is not farther away than `limit`.
    pub(super) fn new(source: &Place, goal: Goal, limit: f64, outside_is_free: bool) -> Box<Self> {
        let towards = match &goal {
            Goal::Places(places) => places.single(),
            Goal::Sites | Goal::Vertices => None,
        };
        // It is large, and moved with the futures that drive it.
        let mut this = Box::new(Self {
            source: source.point,
            outside_is_free,
            goal,
            towards,
            limit,
            queue: Queue::new(),
            waiting: Waiting::new(),
            joins: towards.is_none(),
            passed: 0,
            roots: Vec::with_capacity(8),
            seen: SeenVertices::default(),
            here: Reached::default(),
            here_is: NOWHERE,
            elsewhere: HashMap::default(),
            ready: BinaryHeap::new(),
            told: HashSet::default(),
            pause: PAUSE,
            parts: None,
            beside: None,
        });
        this.start(source);
        this
    }
}
