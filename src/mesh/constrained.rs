//! A triangulation in which some edges are constraints.

use super::boundary::Boundary;
use super::topology::{Topology, Twin};
use super::triangulation::Triangulation;
use crate::geometry::{HalfEdge, PackedHalfEdge, TriangleId};

/// The bit of a triangle that the current subsegment crosses, in the triangle's byte. Bits 0 to 2
/// of that byte mark the half-edges that are constraints, and bits [`WALLS`] to 5 those that are
/// also walls.
pub(super) const CROSSED: u8 = 1 << 6;
/// The position of half-edge 0's wall bit.
pub(crate) const WALLS: u32 = 3;
/// The bit of a constraint, at the position of half-edge 0. [`WALL`] has the bits of a wall, also
/// at the positions of half-edge 0.
const CONSTRAINT: u8 = 1;
pub(super) const WALL: u8 = CONSTRAINT | 1 << WALLS;

/// A triangulation with constraints.
#[derive(Clone, Debug, Default)]
pub struct Constrained {
    pub(super) mesh: Triangulation,
    /// For each triangle, the bits of its half-edges, and [`CROSSED`] while the triangle is being
    /// replaced.
    pub(super) fixed: Vec<u8>,
    /// For each point, a half-edge that leaves it.
    pub(super) leaving: Vec<PackedHalfEdge>,
    pub(super) boundary: Boundary,
    /// If there are no triangles: for each point of the hull, whether the edge to the next point is
    /// a constraint. `positions` has the position of each point in the hull.
    pub(super) line: Vec<bool>,
    pub(super) positions: Vec<u32>,
}

impl Constrained {
    /// Creates a mesh without constraints from a triangulation of `points` points.
    #[must_use]
    pub fn new(mesh: Triangulation, points: usize) -> Self {
        let fixed = vec![0; mesh.triangles.len()];
        Self::with_constraints(mesh, fixed, points)
    }

    /// Creates a mesh from triangles of `points` points and the bits of each triangle's half-edges.
    /// The triangles may be parts of a triangulation.
    pub(crate) fn with_constraints(mesh: Triangulation, fixed: Vec<u8>, points: usize) -> Self {
        let mut this = Self {
            fixed,
            leaving: vec![PackedHalfEdge::NONE; points],
            ..Self::default()
        };
        if mesh.triangles.is_empty() {
            this.line = vec![false; mesh.hull.len()];
            this.positions = vec![0; points];
            for (&point, position) in mesh.hull.iter().zip(0..) {
                this.positions[point as usize] = position;
            }
        } else {
            for edge in mesh.half_edges() {
                this.leaving[mesh.origin(edge).index()] = edge.into();
            }
            let edges = mesh.half_edges().filter(|&edge| mesh.twin(edge) == Twin::Hull);
            let edges = edges.map(|edge| (mesh.origin(edge).0, mesh.destination(edge).0, edge));
            this.boundary = Boundary::new(edges.collect(), points);
        }
        this.mesh = mesh;
        this
    }

    /// Returns the triangles and their adjacency. The corners of triangles and their indices may
    /// differ from those without constraints. The hull does not.
    #[must_use]
    pub fn mesh(&self) -> &Triangulation {
        &self.mesh
    }

    /// Returns whether a half-edge is on a constraint.
    #[must_use]
    pub fn is_constraint(&self, edge: HalfEdge) -> bool {
        self.fixed[edge.triangle().index()] >> edge.corner() & 1 == 1
    }

    /// Returns all constraint edges, each once.
    pub fn constraints(&self) -> impl Iterator<Item = [u32; 2]> {
        let mesh = &self.mesh;
        let marked = mesh.half_edges().filter(|&edge| self.is_constraint(edge));
        let once = marked.filter(|&edge| mesh.twin(edge).half_edge().is_none_or(|twin| edge < twin));
        let edges = once.map(|edge| [mesh.origin(edge).0, mesh.destination(edge).0]);
        let pairs = mesh.hull.windows(2).zip(&self.line);
        edges.chain(pairs.filter(|(_, fixed)| **fixed).map(|(pair, _)| [pair[0], pair[1]]))
    }

    /// Returns the bits of a triangle's half-edges. Bits 0 to 2 mark constraints, and bits
    /// [`WALLS`] to 5 mark walls.
    pub(crate) fn edge_bits(&self, triangle: TriangleId) -> u8 {
        self.fixed[triangle.index()]
    }

    /// Returns the triangles, and the bits of each triangle's half-edges.
    pub(crate) fn into_parts(self) -> (Triangulation, Vec<u8>) {
        (self.mesh, self.fixed)
    }

    /// Makes the edge of a half-edge a constraint, and a wall if `is_wall`.
    pub(crate) fn fix(&mut self, edge: HalfEdge, is_wall: bool) {
        let bits = if is_wall { WALL } else { CONSTRAINT };
        for edge in [Some(edge), self.mesh.twin(edge).half_edge()].into_iter().flatten() {
            self.fixed[edge.triangle().index()] |= bits << edge.corner();
        }
    }

    /// Assigns a boundary edge to the half-edge that now runs along it.
    pub(super) fn move_boundary(&mut self, edge: HalfEdge) {
        let [from, to] = [self.mesh.origin(edge), self.mesh.destination(edge)];
        self.boundary.set(from.0, to.0, edge);
    }
}
