//! Point location: a walk through the triangles between a half-edge and a point.
//!
//! The walk crosses any side that has the point strictly on its other side (Devillers, Pion and Teillaud, "Walking in a
//! triangulation", 2002), in random order: on a Delaunay triangulation it cannot go in circles, and on others it does not
//! for ever.

use super::topology::{Embedded, Twin};
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, orient2d};

/// A walk to a point, which goes on in another part of the triangulation where it leaves one.
///
/// The way, and so what it ends at, is a function of the arguments.
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
    /// Triangles that may still be entered, before the walk must be going in circles.
    steps: u64,
}

/// Where a walk ends, in one part of a triangulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WalkEnd {
    /// The point lies within this triangle.
    Triangle(TriangleId),
    /// It lies within the edge of this half-edge.
    Edge(HalfEdge),
    /// It is the origin of this half-edge.
    Vertex(HalfEdge),
    /// It lies outside the hull, on the right of this half-edge.
    Hull(HalfEdge),
    /// The walk goes on in another part, on the other side of this half-edge.
    Elsewhere(HalfEdge),
}

/// A walk goes in circles: the triangulation contradicts itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a walk goes in circles")]
pub struct EndlessWalk;

impl Walk {
    /// A walk to `target`, in a triangulation of `triangles` triangles, all parts together.
    #[must_use]
    pub fn new(target: Point, triangles: u64) -> Self {
        Self {
            target,
            steps: 4 * triangles.saturating_add(4),
        }
    }

    /// Where it goes.
    #[must_use]
    pub fn target(&self) -> Point {
        self.target
    }

    /// Goes as far as this part of the triangulation goes, from the triangle of a half-edge on.
    ///
    /// # Errors
    /// If the triangulation contradicts itself, so that the walk goes in circles.
    pub fn run(&mut self, mesh: &impl Embedded, start: HalfEdge) -> Result<WalkEnd, EndlessWalk> {
        let mut entered = start;
        loop {
            self.steps = self.steps.checked_sub(1).ok_or(EndlessWalk)?;
            // Off Delaunay's triangulation, where constraints are, the walk might go in circles if it always turned the same way.
            let turns_left = self.steps.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 63 == 1;
            let [one, other] = if turns_left {
                [entered.prev(), entered.next()]
            } else {
                [entered.next(), entered.prev()]
            };
            let sides = [one, other, entered];
            let turn = |side: HalfEdge| {
                // Not by `map` over both: the points would go through memory, in other pieces than they are read in.
                let from = mesh.point(mesh.origin(side));
                let to = mesh.point(mesh.destination(side));
                orient2d(from, to, self.target)
            };
            let Some(exit) = sides.into_iter().find(|&side| turn(side) == Orientation::Clockwise) else {
                return Ok(inside(sides, sides.map(turn)));
            };
            entered = match mesh.twin(exit) {
                Twin::HalfEdge(entered) => entered,
                Twin::Hull => return Ok(WalkEnd::Hull(exit)),
                Twin::Elsewhere => return Ok(WalkEnd::Elsewhere(exit)),
            };
        }
    }
}

/// Where a point lies in a triangle that it is not outside of.
fn inside(sides: [HalfEdge; 3], turns: [Orientation; 3]) -> WalkEnd {
    let mut on = sides
        .into_iter()
        .zip(turns)
        .filter(|(_, turn)| *turn == Orientation::Collinear)
        .map(|(side, _)| side);
    match [on.next(), on.next()] {
        [None, _] => WalkEnd::Triangle(sides[0].triangle()),
        [Some(side), None] => WalkEnd::Edge(side),
        // On two sides: at the corner between them.
        [Some(a), Some(b)] => WalkEnd::Vertex(if a.next() == b { b } else { a }),
    }
}
