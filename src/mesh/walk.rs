//! Point location: a walk through the triangles between a half-edge and a point.
//!
//! The walk crosses any edge of its triangle that has the point strictly on the other side
//! (Devillers, Pion and Teillaud, "Walking in a triangulation", 2002). It examines the edges in
//! random order. On a Delaunay triangulation it cannot go in circles, and on others it does not do
//! so for ever.

use super::topology::{Embedded, Twin};
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, orient2d};

/// A walk to a point. Where it leaves one part of a triangulation, it goes on in another part.
///
/// The path of the walk, and so its end, is a function of the arguments.
///
/// # Example
///
/// ```
/// use delaunay_tiles::geometry::{HalfEdge, Point, TriangleId};
/// use delaunay_tiles::mesh::{EngineKind, Mesh, Triangulation, Walk, WalkEnd};
///
/// let points = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]].map(|[x, y]| Point::new(x, y));
/// let mut triangulation = Triangulation::default();
/// EngineKind::Native.create().triangulate(&points, &mut triangulation);
/// let mesh = Mesh { triangulation: &triangulation, points: &points };
/// let mut walk = Walk::new(Point::new(0.5, 0.5), 1);
/// assert_eq!(walk.run(&mesh, HalfEdge(0))?, WalkEnd::Triangle(TriangleId(0)));
/// # Ok::<(), delaunay_tiles::mesh::EndlessWalk>(())
/// ```
#[derive(Clone, Debug)]
pub struct Walk {
    target: Point,
    /// The number of triangles that the walk may still enter. Beyond that, it must be going in
    /// circles.
    steps: u64,
}

/// Where a walk ends in one part of a triangulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WalkEnd {
    /// The point lies in the interior of this triangle.
    Triangle(TriangleId),
    /// The point lies in the interior of the edge of this half-edge.
    Edge(HalfEdge),
    /// The point is the origin of this half-edge.
    Vertex(HalfEdge),
    /// The point lies outside the hull, on the right of this half-edge.
    Hull(HalfEdge),
    /// The walk goes on in another part, on the other side of this half-edge.
    Elsewhere(HalfEdge),
}

/// The error of a walk that goes in circles: the triangulation contradicts itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a walk goes in circles")]
pub struct EndlessWalk;

impl Walk {
    /// Creates a walk to `target`, in a triangulation of `triangles` triangles in all its parts.
    #[must_use]
    pub fn new(target: Point, triangles: u64) -> Self {
        Self {
            target,
            steps: 4 * triangles.saturating_add(4),
        }
    }

    /// Returns the point that the walk goes to.
    #[must_use]
    pub fn target(&self) -> Point {
        self.target
    }

    /// Walks from the triangle of `start` as far as this part of the triangulation goes.
    ///
    /// # Errors
    /// If the triangulation contradicts itself, so that the walk goes in circles.
    pub fn run(&mut self, mesh: &impl Embedded, start: HalfEdge) -> Result<WalkEnd, EndlessWalk> {
        let target = self.target;
        let mut entered = start;
        let mut from = mesh.point(mesh.origin(entered));
        let mut to = mesh.point(mesh.destination(entered));
        // A walk enters a triangle only by an edge that has the point strictly on this side.
        let mut across = orient2d(from, to, target);
        loop {
            self.steps = self.steps.checked_sub(1).ok_or(EndlessWalk)?;
            let (next, prev) = (entered.next(), entered.prev());
            let apex = mesh.point(mesh.origin(prev));
            // Both, because a branch that is guessed wrong takes longer than a turn.
            let turns = [orient2d(to, apex, target), orient2d(apex, from, target)];
            let leaves = turns.map(|turn| turn == Orientation::Clockwise);
            // On a triangulation that is not Delaunay, as where constraints are, the walk might go
            // in circles if it always turned the same way.
            let turns_left = self.steps.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 63 == 1;
            let by_prev = leaves[1] & (turns_left | !leaves[0]);
            let exit = if by_prev {
                prev
            } else if leaves[0] {
                next
            } else if across == Orientation::Clockwise {
                entered
            } else {
                return Ok(inside([entered, next, prev], [across, turns[0], turns[1]]));
            };
            // The twin runs the other way.
            (from, to) = if by_prev {
                (from, apex)
            } else if leaves[0] {
                (apex, to)
            } else {
                (to, from)
            };
            across = Orientation::CounterClockwise;
            entered = match mesh.twin(exit) {
                Twin::HalfEdge(entered) => entered,
                Twin::Hull => return Ok(WalkEnd::Hull(exit)),
                Twin::Elsewhere => return Ok(WalkEnd::Elsewhere(exit)),
            };
        }
    }
}

/// Returns where a point lies in a triangle that it is not outside of.
fn inside(edges: [HalfEdge; 3], turns: [Orientation; 3]) -> WalkEnd {
    let mut on = edges
        .into_iter()
        .zip(turns)
        .filter(|(_, turn)| *turn == Orientation::Collinear)
        .map(|(edge, _)| edge);
    match [on.next(), on.next()] {
        [None, _] => WalkEnd::Triangle(edges[0].triangle()),
        [Some(edge), None] => WalkEnd::Edge(edge),
        // The point lies on two edges: it is the corner between them.
        [Some(a), Some(b)] => WalkEnd::Vertex(if a.next() == b { b } else { a }),
    }
}
