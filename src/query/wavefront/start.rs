//! How the wavefront starts: in triangles, at a vertex, or outside the hull.

use std::collections::{BinaryHeap, HashMap, HashSet};

use super::aims::Aims;
use super::goal::Goal;
use super::queue::Queue;
use super::reached::Reached;
use super::roots::{Root, SeenVertices};
use super::state::{PAUSE, Wavefront};
use super::task::{Task, Via};
use super::waiting::Waiting;
use super::window::Window;
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, VertexIndex, orient2d};
use crate::query::free_space::{FreeSpace, Position, QueryPoint, Wedge};
use crate::query::locating::TriangleRef;
use crate::query::request::{Contradiction, half_edge_towards};
use crate::store::VertexId;

impl Wavefront {
    /// Creates a wavefront from a free point to all targets that are at most `limit` away.
    pub(crate) fn new(source: &QueryPoint, goal: Goal, limit: f64, outside_is_free: bool) -> Box<Self> {
        let aims = match &goal {
            Goal::Points(points) => points.aims(),
            Goal::Sites | Goal::Vertices => Aims::default(),
        };
        // Boxed, because it is large and moves with the futures that drive it.
        let mut this = Box::new(Self {
            source: source.point,
            outside_is_free,
            goal,
            limit,
            queue: Queue::new(aims.is_one()),
            waiting: Waiting::new(),
            joins: aims.is_empty(),
            aims,
            passed: 0,
            roots: Vec::with_capacity(8),
            seen: SeenVertices::default(),
            here: Reached::default(),
            current_tile: None,
            elsewhere: HashMap::default(),
            ready: BinaryHeap::new(),
            reported: HashSet::default(),
            pause: PAUSE,
            regions: None,
            whole: None,
            seen_half_plane: None,
        });
        this.start(source);
        this
    }

    /// Puts the first tasks in the queue.
    pub(crate) fn start(&mut self, source: &QueryPoint) {
        self.roots.push(Root {
            point: source.point,
            vertex: source.vertex(),
            length: 0.0,
            parent: None,
            depth: 1,
            done: [0; 2],
        });
        let mut push = |tile, task| _ = self.queue.push(0.0, Some(tile), task);
        match source.position {
            Position::Triangle(TriangleRef { tile, triangle, .. }) => push(tile, Task::Start { triangle }),
            Position::Edge { ends: [a, b] } => {
                for (from, VertexId { tile, index }) in [(a.id, b.id), (b.id, a.id)] {
                    push(tile, Task::StartOnEdge { vertex: index, from });
                }
            }
            Position::Vertex(vertex) => push(
                vertex.id.tile,
                Task::StartVertex {
                    vertex: vertex.id.index,
                },
            ),
            Position::Outside([from, _]) => {
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
        if let Goal::Points(points) = &self.goal {
            let here = |(point, _): &(&Point, u32)| **point == source.point;
            let here: Vec<u32> = points
                .points()
                .iter()
                .zip(0..)
                .filter(here)
                .map(|(_, goal)| goal)
                .collect();
            for goal in here {
                self.report_point(goal, 0.0, 0);
            }
        }
    }

    /// Starts at a source in a closed triangle.
    pub(super) fn start_in(&mut self, space: FreeSpace<'_>, triangle: TriangleId) -> Result<(), Contradiction> {
        if space.is_free(triangle) {
            self.spread_in(space, 0, triangle)?;
        }
        Ok(())
    }

    /// Starts at a source on the edge from `from` to `to`, a vertex of the tile.
    pub(super) fn start_on_edge(
        &mut self,
        space: FreeSpace<'_>,
        to: VertexIndex,
        from: VertexId,
    ) -> Result<(), Contradiction> {
        if let Some(half_edge) = half_edge_towards(space.tile, to, from)? {
            return self.start_in(space, half_edge.triangle());
        }
        // The edge is a hull edge, and this is its outer side.
        if !self.outside_is_free {
            return Ok(());
        }
        let edge = space.first(to)?;
        let ends = [edge, edge.next()].map(|half_edge| space.tile.origin(half_edge));
        for end in ends {
            self.see(space, 0, end, Via::Outside);
        }
        // The hull is on the left of the edge.
        self.see_half(space.point(ends[1]), false);
        Ok(())
    }

    /// Starts at a source that is a vertex.
    pub(crate) fn start_at(&mut self, space: FreeSpace<'_>, vertex: VertexIndex) -> Result<(), Contradiction> {
        let mark = space.mark(vertex).ok_or(Contradiction::NoVertex(vertex))?;
        self.seen.entry(space.tile.vertex(vertex).id).or_default().limit = 0.0;
        if mark.is_single() {
            self.here.reach(vertex, 0.0);
        }
        self.report_vertex(space, vertex, 0.0, 0);
        for wedge in space.free_wedges(vertex)? {
            match wedge {
                Wedge::Triangle(half_edge) => self.spread_in(space, 0, half_edge.triangle())?,
                Wedge::Outside => self.spread_outside(space, 0, vertex, None)?,
            }
        }
        Ok(())
    }

    /// Spreads from a root that lies in a closed triangle or at its corner.
    pub(super) fn spread_in(
        &mut self,
        space: FreeSpace<'_>,
        root: u32,
        triangle: TriangleId,
    ) -> Result<(), Contradiction> {
        let at = self.roots[root as usize].point;
        self.see_points_in(space, root, triangle);
        for half_edge in HalfEdge::of_triangle(triangle) {
            let [from, to] = [half_edge, half_edge.next()].map(|half_edge| space.tile.origin(half_edge));
            self.see_by(space, root, from, half_edge);
            let [right, left] = [from, to].map(|corner| space.point(corner));
            if orient2d(right, left, at) == Orientation::CounterClockwise {
                let window = Window { root: at, right, left };
                self.pass(space, root, half_edge, window, [right, left])?;
            }
        }
        Ok(())
    }

    /// Starts at a source outside the hull, at the hull edge that leaves `vertex` (`forward`) or
    /// arrives there.
    pub(super) fn start_on_hull(
        &mut self,
        space: FreeSpace<'_>,
        vertex: VertexIndex,
        forward: bool,
        before: Option<[Point; 2]>,
    ) -> Result<(), Contradiction> {
        if !space.tile.has_vertex(vertex) {
            return Err(Contradiction::NoVertex(vertex));
        }
        self.pause = self.pause.saturating_sub(1);
        let at = self.source;
        self.see(space, 0, vertex, Via::Outside);
        let edge = space.along_hull(vertex, forward)?;
        let ends = [edge, edge.next()].map(|half_edge| space.tile.origin(half_edge));
        let [left, right] = ends.map(|end| space.point(end));
        if !before.is_none_or(|before| goes_on_convexly(before, [left, right], forward)) {
            return Err(Contradiction::ConcaveHull(vertex));
        }
        if orient2d(left, right, at) != Orientation::Clockwise {
            self.see_half(space.point(vertex), !forward);
            return Ok(());
        }
        self.see_before_hull(right, left);
        if !space.tile.is_wall(edge) && space.is_free(edge.triangle()) {
            let window = Window { root: at, right, left };
            self.through(space, 0, edge, window)?;
        }
        let beyond = space.tile.vertex(ends[usize::from(forward)]).id;
        let task = Task::StartOnHull {
            vertex: beyond.index,
            forward,
            before: Some([left, right]),
        };
        self.queue.push(0.0, Some(beyond.tile), task);
        Ok(())
    }
}

/// Returns whether the hull edge from `left` to `right` continues the edge `before` without a turn
/// to the right. This bounds the number of edges that a source outside sees by the number of hull
/// edges, even if damaged tiles contradict each other: a convex chain with a point on its right all
/// the way turns by at most a half-turn.
fn goes_on_convexly(before: [Point; 2], [left, right]: [Point; 2], forward: bool) -> bool {
    let (joined, turn) = if forward {
        (before[1] == left, orient2d(before[0], before[1], right))
    } else {
        (before[0] == right, orient2d(left, right, before[1]))
    };
    joined && turn != Orientation::Clockwise
}
