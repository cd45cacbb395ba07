//! Inserts segments as constraints into a triangulation, which stays Delaunay beside them.
//!
//! Input: a canonical triangulation, and segments between its points. Output: the constrained
//! Delaunay triangulation. It is a function of the set of points and the set of segments: the tie
//! rule of the circle test leaves only one choice, so neither the order nor the direction of the
//! segments matters.
//!
//! The vertices on a segment cut it into **subsegments**. Inserting a subsegment changes exactly
//! the triangles that it crosses (Wu, Lemma 3.3.6). These are removed, and the
//! [cavity](super::cavity) is triangulated on both sides:
//!
//! ```text
//!        u ───── v                u ───── v
//!      ╱  ╲     ╱ ╲             ╱      ╱   ╲
//!     a    ╲   ╱   b     →     a ═══════════ b
//!      ╲    ╲ ╱   ╱             ╲     │     ╱
//!        ──── l ──                ──── l ──
//! ```
//!
//! The number of triangles stays the same, so the new triangles take the slots of the old ones in
//! the arrays.

use super::cavity::Cavity;
use super::chain::{Chain, fill};
use super::constrained::{CROSSED, Constrained};
use super::leaving::{Leaving, Stars, leaving_towards};
use super::topology::Topology;
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, orient2d};

/// The error of a segment that crosses a constraint at a point that is not a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the segment between points {} and {} crosses the constraint between {} and {}", segment[0], segment[1], edge[0], edge[1])]
pub struct Crossing {
    /// The ends of the segment to insert.
    pub segment: [u32; 2],
    /// The ends of the constraint edge that it crosses.
    pub edge: [u32; 2],
}

/// Inserts segments. It keeps its memory between calls.
///
/// ```
/// use delaunay_tiles::geometry::Point;
/// use delaunay_tiles::mesh::{Constrained, EngineKind, Inserter, Triangulation};
///
/// let points = [[0.0, 0.0], [8.0, 0.0], [4.0, 1.0], [4.0, -1.0]].map(|[x, y]| Point::new(x, y));
/// let mut mesh = Triangulation::default();
/// EngineKind::Native.create().triangulate(&points, &mut mesh);
/// let mut mesh = Constrained::new(mesh, points.len());
/// Inserter::default().insert(&points, &mut mesh, [0, 1])?;
/// assert_eq!(mesh.constraints().count(), 1);
/// assert!(mesh.mesh().triangles.iter().all(|t| t.contains(&0) && t.contains(&1)));
/// # Ok::<(), delaunay_tiles::mesh::Crossing>(())
/// ```
#[derive(Debug, Default)]
pub struct Inserter {
    /// The triangles that the last step crossed.
    crossed: Vec<TriangleId>,
    left: Chain,
    right: Chain,
    cavity: Cavity,
}

/// The first step of a line through a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LineStep {
    /// Along the edge of this half-edge, to this vertex.
    Edge(HalfEdge, u32),
    /// Through triangles, to this vertex on the line.
    Triangles(u32),
    /// Through any number of triangles, and out of the mesh.
    Out,
}

impl Inserter {
    /// Turns the segment between two points into a chain of constraint edges. Does nothing if the
    /// points are the same.
    ///
    /// `points` are those of the triangulation.
    ///
    /// # Errors
    /// If the segment crosses a constraint. Some of its subsegments may be constraints then.
    pub fn insert(&mut self, points: &[Point], mesh: &mut Constrained, segment: [u32; 2]) -> Result<(), Crossing> {
        if mesh.mesh.triangles.is_empty() {
            let [a, b] = segment.map(|point| mesh.positions[point as usize] as usize);
            mesh.line[a.min(b)..a.max(b)].fill(true);
            return Ok(());
        }
        let mut ends = segment;
        while ends[0] != ends[1] {
            let (which, step) = self
                .step_between(points, mesh, ends)
                .map_err(|edge| Crossing { segment, edge })?;
            ends[which] = match step {
                LineStep::Edge(edge, vertex) => {
                    mesh.fix(edge, false);
                    vertex
                }
                LineStep::Triangles(vertex) => {
                    self.replace(points, mesh, false);
                    vertex
                }
                LineStep::Out => unreachable!("a triangulation has no gaps between its points"),
            };
        }
        Ok(())
    }

    /// Returns the first step between two vertices, and the index in `ends` of the vertex that it
    /// starts from. That is the vertex with fewer edges, since thousands of segments may share one
    /// end. The error is the constraint in the way.
    pub(crate) fn step_between(
        &mut self,
        points: &[Point],
        mesh: &Constrained,
        ends: [u32; 2],
    ) -> Result<(usize, LineStep), [u32; 2]> {
        let Some((which, start)) = leaving_towards(points, mesh, ends) else {
            self.crossed.clear();
            return Ok((0, LineStep::Out));
        };
        let to = points[ends[1 - which] as usize];
        Ok((which, self.follow(points, mesh, start, to)?))
    }

    /// Returns the first step from the vertex `from` towards the point `to`. The error is the
    /// constraint in the way. `stars` must belong to `mesh` in its current state.
    pub(crate) fn step(
        &mut self,
        points: &[Point],
        mesh: &Constrained,
        stars: &mut Stars,
        from: u32,
        to: Point,
    ) -> Result<LineStep, [u32; 2]> {
        match stars.start(points, mesh, from, to) {
            Some(start) => self.follow(points, mesh, start, to),
            None => {
                self.crossed.clear();
                Ok(LineStep::Out)
            }
        }
    }

    /// Returns the first step of a line that enters by a boundary edge, or `None` if it does not
    /// enter. The error is the constraint in the way.
    pub(crate) fn enter(
        &mut self,
        points: &[Point],
        mesh: &Constrained,
        line: [Point; 2],
    ) -> Result<Option<LineStep>, [u32; 2]> {
        let Some((from, to, edge)) = mesh.boundary.entry(points, line) else {
            return Ok(None);
        };
        if mesh.is_constraint(edge) {
            return Err([from, to]);
        }
        self.crossed.clear();
        // After a line that enters, nothing reads the chains. They must not grow with each such
        // line.
        self.left.clear();
        self.right.clear();
        self.walk(points, mesh, edge, line).map(Some)
    }

    /// Returns the triangles that the last step crossed.
    pub(crate) fn crossed(&self) -> &[TriangleId] {
        &self.crossed
    }

    /// Follows a line from the vertex that `start` leaves, towards the point `to`.
    fn follow(
        &mut self,
        points: &[Point],
        mesh: &Constrained,
        start: Leaving,
        to: Point,
    ) -> Result<LineStep, [u32; 2]> {
        let edge = match start {
            Leaving::Edge(edge, vertex) => return Ok(LineStep::Edge(edge, vertex)),
            Leaving::Triangle(edge) => edge,
        };
        let topology = &mesh.mesh;
        let from = topology.origin(edge);
        self.crossed.clear();
        self.crossed.push(edge.triangle());
        self.right.begin(from.0, topology.destination(edge).0, edge);
        self.left.begin(from.0, topology.apex(edge).0, edge.prev());
        match pass(mesh, edge.next())? {
            None => Ok(LineStep::Out),
            Some(entered) => self.walk(points, mesh, entered, [points[from.index()], to]),
        }
    }

    /// Walks along the line from `a` to `b`, from the half-edge by which the line enters a
    /// triangle. Collects what the line crosses up to the next vertex on it.
    fn walk(
        &mut self,
        points: &[Point],
        mesh: &Constrained,
        mut entered: HalfEdge,
        [a, b]: [Point; 2],
    ) -> Result<LineStep, [u32; 2]> {
        loop {
            let apex = mesh.mesh.apex(entered).0;
            self.crossed.push(entered.triangle());
            let (left, right) = (entered.prev(), entered.next());
            let exit = match orient2d(a, b, points[apex as usize]) {
                Orientation::CounterClockwise => {
                    self.left.push(apex, left);
                    right
                }
                Orientation::Clockwise => {
                    self.right.push(apex, right);
                    left
                }
                Orientation::Collinear => {
                    self.left.push(apex, left);
                    self.right.push(apex, right);
                    return Ok(LineStep::Triangles(apex));
                }
            };
            let Some(next) = pass(mesh, exit)? else {
                return Ok(LineStep::Out);
            };
            entered = next;
        }
    }

    /// Replaces the triangles that the last step crossed by the triangulations of both sides of its
    /// subsegment. The last step must be [`LineStep::Triangles`].
    pub(crate) fn replace(&mut self, points: &[Point], mesh: &mut Constrained, is_wall: bool) {
        for &triangle in &self.crossed {
            mesh.fixed[triangle.index()] |= CROSSED;
        }
        // Each chain must have its polygon on its left.
        self.right.reverse();
        self.left.resolve(mesh);
        self.right.resolve(mesh);
        let (left, right) = self.crossed.split_at(self.left.vertices.len() - 2);
        let edges = [(&self.left, left), (&self.right, right)].map(|(chain, slots)| {
            let chain_points = chain.vertices.iter().map(|&vertex| points[vertex as usize]);
            let is_polygon = self.cavity.triangulate(chain_points);
            assert!(
                is_polygon,
                "the triangles that a subsegment crosses form a polygon on each side"
            );
            fill(mesh, chain, slots, &self.cavity)
        });
        mesh.mesh.set_twin(edges[0], edges[1].into());
        mesh.mesh.set_twin(edges[1], edges[0].into());
        mesh.fix(edges[0], is_wall);
    }
}

/// Returns the twin of `exit`, if it has one. The error is the ends of `exit`, if it is a
/// constraint.
fn pass(mesh: &Constrained, exit: HalfEdge) -> Result<Option<HalfEdge>, [u32; 2]> {
    if mesh.is_constraint(exit) {
        return Err([mesh.mesh.origin(exit), mesh.mesh.destination(exit)].map(|end| end.0));
    }
    Ok(mesh.mesh.twin(exit).half_edge())
}

#[cfg(test)]
mod tests;
