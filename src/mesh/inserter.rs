//! Constraints: segments become edges of a triangulation, which stays Delaunay beside them.
//!
//! In: a canonical triangulation, and segments between its points. Out: the constrained Delaunay triangulation, which is
//! a function of the points and of the segments as sets: the circle test's tie rule leaves one choice only, so neither the
//! order nor the direction of the segments matters.
//!
//! A segment is cut into **pieces** at the vertices that lie on it. Inserting a piece changes exactly the triangles that it
//! crosses (Wu, Lemma 3.3.6); these are taken out, and the [cavity](super::cavity) is triangulated on both sides:
//!
//! ```text
//!        u ───── v                u ───── v
//!      ╱  ╲     ╱ ╲             ╱      ╱   ╲
//!     a    ╲   ╱   b     →     a ═══════════ b
//!      ╲    ╲ ╱   ╱             ╲     │     ╱
//!        ──── l ──                ──── l ──
//! ```
//!
//! As many triangles come out as go in, so they keep their places in the arrays.

use super::cavity::Cavity;
use super::chain::{Chain, fill};
use super::constrained::{CROSSED, Constrained};
use super::leaving::{Leaving, Stars, leaving_towards};
use super::topology::Topology;
use crate::geometry::{HalfEdge, Orientation, Point, TriangleId, orient2d};

/// Two segments cross, away from the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the segment between points {} and {} crosses the constraint between {} and {}", segment[0], segment[1], edge[0], edge[1])]
pub struct Crossing {
    /// The ends of the segment that was to be inserted.
    pub segment: [u32; 2],
    /// The ends of the constraint edge that it crosses.
    pub edge: [u32; 2],
}

/// Inserts segments. It keeps its memory from one to the next.
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
    /// The triangles that a piece crosses.
    crossed: Vec<TriangleId>,
    left: Chain,
    right: Chain,
    cavity: Cavity,
}

/// Where the line from a vertex goes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Along the edge of this half-edge, to this vertex.
    Edge(HalfEdge, u32),
    /// Through triangles, to this vertex on the line.
    Triangles(u32),
    /// Through triangles, or none, to where there are no more.
    Out,
}

impl Inserter {
    /// Makes a segment between two points a chain of constraint edges. If they are the same, nothing happens.
    ///
    /// `points` are those of the triangulation.
    ///
    /// # Errors
    /// If it crosses a constraint. Some of its pieces may be constraints then.
    pub fn insert(&mut self, points: &[Point], mesh: &mut Constrained, segment: [u32; 2]) -> Result<(), Crossing> {
        if mesh.mesh.triangles.is_empty() {
            let [a, b] = segment.map(|point| mesh.places[point as usize] as usize);
            mesh.line[a.min(b)..a.max(b)].fill(true);
            return Ok(());
        }
        let mut ends = segment;
        while ends[0] != ends[1] {
            let (which, step) = self
                .step_between(points, mesh, ends)
                .map_err(|edge| Crossing { segment, edge })?;
            ends[which] = match step {
                Step::Edge(side, vertex) => {
                    mesh.fix(side, false);
                    vertex
                }
                Step::Triangles(vertex) => {
                    self.replace(points, mesh, false);
                    vertex
                }
                Step::Out => unreachable!("a triangulation has no gaps between its points"),
            };
        }
        Ok(())
    }

    /// The first step from one of two vertices to the other, and which it starts from: whichever has fewer edges, since
    /// thousands of segments may share one end. Or the constraint in its way.
    pub(crate) fn step_between(
        &mut self,
        points: &[Point],
        mesh: &Constrained,
        ends: [u32; 2],
    ) -> Result<(usize, Step), [u32; 2]> {
        let Some((which, start)) = leaving_towards(points, mesh, ends) else {
            self.crossed.clear();
            return Ok((0, Step::Out));
        };
        let to = points[ends[1 - which] as usize];
        Ok((which, self.follow(points, mesh, start, to)?))
    }

    /// The first step from a vertex towards another place. Or the constraint in its way. `stars` are of this mesh as it is.
    pub(crate) fn step(
        &mut self,
        points: &[Point],
        mesh: &Constrained,
        stars: &mut Stars,
        from: u32,
        to: Point,
    ) -> Result<Step, [u32; 2]> {
        match stars.start(points, mesh, from, to) {
            Some(start) => self.follow(points, mesh, start, to),
            None => {
                self.crossed.clear();
                Ok(Step::Out)
            }
        }
    }

    /// The first step of a line that comes in by a boundary edge. None: it does not. Or the constraint in its way.
    pub(crate) fn enter(
        &mut self,
        points: &[Point],
        mesh: &Constrained,
        line: [Point; 2],
    ) -> Result<Option<Step>, [u32; 2]> {
        let Some((from, to, side)) = mesh.boundary.entry(points, line) else {
            return Ok(None);
        };
        if mesh.is_constraint(side) {
            return Err([from, to]);
        }
        self.crossed.clear();
        // Nobody asks for these after a line that comes in; they must not grow with each.
        self.left.clear();
        self.right.clear();
        self.walk(points, mesh, side, line).map(Some)
    }

    /// The triangles that the last step crossed.
    pub(crate) fn crossed(&self) -> &[TriangleId] {
        &self.crossed
    }

    /// Follows a line from the origin of a half-edge.
    fn follow(&mut self, points: &[Point], mesh: &Constrained, start: Leaving, to: Point) -> Result<Step, [u32; 2]> {
        let side = match start {
            Leaving::Edge(side, vertex) => return Ok(Step::Edge(side, vertex)),
            Leaving::Triangle(side) => side,
        };
        let topology = &mesh.mesh;
        let from = topology.origin(side);
        self.crossed.clear();
        self.crossed.push(side.triangle());
        self.right.begin(from.0, topology.destination(side).0, side);
        self.left.begin(from.0, topology.apex(side).0, side.prev());
        match pass(mesh, side.next())? {
            None => Ok(Step::Out),
            Some(entered) => self.walk(points, mesh, entered, [points[from.index()], to]),
        }
    }

    /// Walks along a line from the half-edge by which it enters a triangle, and collects what is crossed up to the next vertex on
    /// the line.
    fn walk(
        &mut self,
        points: &[Point],
        mesh: &Constrained,
        mut entered: HalfEdge,
        [a, b]: [Point; 2],
    ) -> Result<Step, [u32; 2]> {
        loop {
            let apex = mesh.mesh.apex(entered).0;
            self.crossed.push(entered.triangle());
            let (left, right) = (entered.prev(), entered.next());
            let gate = match orient2d(a, b, points[apex as usize]) {
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
                    return Ok(Step::Triangles(apex));
                }
            };
            let Some(next) = pass(mesh, gate)? else {
                return Ok(Step::Out);
            };
            entered = next;
        }
    }

    /// Triangulates both sides of the piece of the last step, which went through triangles to a vertex, in place of the
    /// triangles that it crosses.
    pub(crate) fn replace(&mut self, points: &[Point], mesh: &mut Constrained, is_wall: bool) {
        for &triangle in &self.crossed {
            mesh.fixed[triangle.index()] |= CROSSED;
        }
        // Both chains have their polygon on the left.
        self.right.reverse();
        self.left.resolve(mesh);
        self.right.resolve(mesh);
        let (left, right) = self.crossed.split_at(self.left.vertices.len() - 2);
        let sides = [(&self.left, left), (&self.right, right)].map(|(chain, places)| {
            let chain_points = chain.vertices.iter().map(|&vertex| points[vertex as usize]);
            let is_polygon = self.cavity.triangulate(chain_points);
            assert!(is_polygon, "what a piece crosses is a polygon on each side");
            fill(mesh, chain, places, &self.cavity)
        });
        mesh.mesh.set_twin(sides[0], sides[1].into());
        mesh.mesh.set_twin(sides[1], sides[0].into());
        mesh.fix(sides[0], is_wall);
    }
}

/// The half-edge behind a gate, if there is one and it is no constraint.
fn pass(mesh: &Constrained, gate: HalfEdge) -> Result<Option<HalfEdge>, [u32; 2]> {
    if mesh.is_constraint(gate) {
        return Err([mesh.mesh.origin(gate), mesh.mesh.destination(gate)].map(|end| end.0));
    }
    Ok(mesh.mesh.twin(gate).half_edge())
}

#[cfg(test)]
mod tests;
