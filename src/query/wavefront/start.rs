//! How the wave starts: in triangles, at a vertex, or outside the hull.

use std::collections::{BinaryHeap, HashMap, HashSet};

use super::cone::Cone;
use super::goal::Goal;
use super::queue::Queue;
use super::reached::Reached;
use super::roots::{Root, SeenVertices};
use super::task::{Task, Via};
use super::waiting::Waiting;
use super::wave::{PAUSE, Wave};
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, VertexIndex, orient2d};
use crate::query::free_space::{Ground, Place, Spot, Wedge};
use crate::query::locating::TriangleRef;
use crate::query::request::{Contradiction, side_towards};
use crate::store::VertexId;

impl Wave {
    /// A wave from a free place to all that is not farther away than `limit`.
    pub(crate) fn new(source: &Place, goal: Goal, limit: f64, outside_is_free: bool) -> Box<Self> {
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
            here_is: None,
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

    /// Puts in the queue what the source sees first.
    pub(crate) fn start(&mut self, source: &Place) {
        self.roots.push(Root {
            point: source.point,
            vertex: source.vertex(),
            length: 0.0,
            parent: None,
            done: [0; 2],
        });
        let mut push = |tile, task| _ = self.queue.push(0.0, Some(tile), task);
        match source.spot {
            Spot::Triangle(TriangleRef { tile, triangle, .. }) => push(tile, Task::Start { triangle }),
            Spot::Edge { ends: [a, b] } => {
                for (from, VertexId { tile, index }) in [(a.id, b.id), (b.id, a.id)] {
                    push(tile, Task::StartOnEdge { vertex: index, from });
                }
            }
            Spot::Vertex(vertex) => push(
                vertex.id.tile,
                Task::StartVertex {
                    vertex: vertex.id.index,
                },
            ),
            Spot::Outside([from, _]) => {
                for forward in [true, false] {
                    let (vertex, before) = (from.index, None);
                    push(
                        from.tile,
                        Task::StartOnHull {
                            vertex,
                            forward,
                            before,
                        },
                    );
                }
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
    pub(super) fn start_in(&mut self, ground: Ground<'_>, triangle: TriangleId) -> Result<(), Contradiction> {
        if ground.is_free(triangle) {
            self.spread_in(ground, 0, triangle)?;
        }
        Ok(())
    }

    /// The source lies on an edge from one vertex to another one, of the tile.
    pub(super) fn start_on_edge(
        &mut self,
        ground: Ground<'_>,
        to: VertexIndex,
        from: VertexId,
    ) -> Result<(), Contradiction> {
        if let Some(side) = side_towards(ground.tile, to, from)? {
            return self.start_in(ground, side.triangle());
        }
        // On a hull edge, and outside of it.
        if !self.outside_is_free {
            return Ok(());
        }
        let edge = ground.first(to)?;
        let ends = [edge, edge.next()].map(|side| ground.tile.origin(side));
        for end in ends {
            self.see(ground, 0, end, Via::Outside);
        }
        // The hull is on the left of the edge.
        self.see_half(ground.point(ends[1]), false);
        Ok(())
    }

    /// The source is a vertex.
    pub(crate) fn start_at(&mut self, ground: Ground<'_>, vertex: VertexIndex) -> Result<(), Contradiction> {
        let mark = ground.mark(vertex).ok_or(Contradiction::NoVertex(vertex))?;
        self.seen.entry(ground.tile.vertex(vertex).id).or_default().limit = 0.0;
        if mark.is_single() {
            self.here.reach(vertex, 0.0);
        }
        self.tell_vertex(ground, vertex, 0.0, 0);
        for wedge in ground.free_wedges(vertex)? {
            match wedge {
                Wedge::Triangle(side) => self.spread_in(ground, 0, side.triangle())?,
                Wedge::Outside => self.spread_outside(ground, 0, vertex, None)?,
            }
        }
        Ok(())
    }

    /// All that a root sees that lies in a closed triangle or at its corner.
    pub(super) fn spread_in(
        &mut self,
        ground: Ground<'_>,
        root: u32,
        triangle: TriangleId,
    ) -> Result<(), Contradiction> {
        let at = self.roots[root as usize].point;
        self.see_places_in(ground, root, triangle);
        for side in HalfEdge::of_triangle(triangle) {
            let [from, to] = [side, side.next()].map(|side| ground.tile.origin(side));
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
    pub(super) fn start_on_hull(
        &mut self,
        ground: Ground<'_>,
        vertex: VertexIndex,
        forward: bool,
        before: Option<[Point; 2]>,
    ) -> Result<(), Contradiction> {
        if !ground.tile.has_vertex(vertex) {
            return Err(Contradiction::NoVertex(vertex));
        }
        self.pause = self.pause.saturating_sub(1);
        let at = self.source;
        self.see(ground, 0, vertex, Via::Outside);
        let edge = ground.along_hull(vertex, forward)?;
        let ends = [edge, edge.next()].map(|side| ground.tile.origin(side));
        let [left, right] = ends.map(|end| ground.point(end));
        if !before.is_none_or(|before| goes_on_convexly(before, [left, right], forward)) {
            return Err(Contradiction::ConcaveHull(vertex));
        }
        if orient2d(left, right, at) != Orientation::Clockwise {
            self.see_half(ground.point(vertex), !forward);
            return Ok(());
        }
        self.see_before_hull(right, left);
        if !ground.tile.is_wall(edge) && ground.is_free(edge.triangle()) {
            let cone = Cone { root: at, right, left };
            self.through(ground, 0, edge, cone)?;
        }
        let beyond = ground.tile.vertex(ends[usize::from(forward)]).id;
        let task = Task::StartOnHull {
            vertex: beyond.index,
            forward,
            before: Some([left, right]),
        };
        self.queue.push(0.0, Some(beyond.tile), task);
        Ok(())
    }
}

/// Whether the hull edge from `left` to `right` continues the one before without a turn to the right. Those that a source
/// outside sees then are no more than there are, also where damaged tiles contradict each other: no convex chain that has a point
/// on its right all the way turns by more than half a turn.
fn goes_on_convexly(before: [Point; 2], [left, right]: [Point; 2], forward: bool) -> bool {
    let (joined, turn) = if forward {
        (before[1] == left, orient2d(before[0], before[1], right))
    } else {
        (before[0] == right, orient2d(left, right, before[1]))
    };
    joined && turn != Orientation::Clockwise
}
