//! A triangulation some of whose edges are constraints.

use super::boundary::Boundary;
use super::topology::{Topology, Twin};
use super::triangulation::Triangulation;
use crate::geometry::{HalfEdge, PackedHalfEdge, TriangleId};

/// In the byte of a triangle, the bits of its sides that are constraints stand at 0 to 2, those that are walls too at
/// [`WALLS`] to 5, and that of a triangle that a piece crosses here.
pub(super) const CROSSED: u8 = 1 << 6;
/// The place of the first side's wall bit.
pub(crate) const WALLS: u32 = 3;
/// The bits of a side that is a constraint, and of one that is a wall, both in the places of the first side.
const CONSTRAINT: u8 = 1;
pub(super) const WALL: u8 = CONSTRAINT | 1 << WALLS;

/// A triangulation with constraints.
#[derive(Clone, Debug, Default)]
pub struct Constrained {
    pub(super) mesh: Triangulation,
    /// For each triangle, the bits of its sides; and [`CROSSED`], while it is being replaced.
    pub(super) fixed: Vec<u8>,
    /// A half-edge that leaves each point.
    pub(super) leaving: Vec<PackedHalfEdge>,
    pub(super) boundary: Boundary,
    /// Without triangles: for each point of the hull, whether the edge to the next is a constraint, and its place there.
    pub(super) line: Vec<bool>,
    pub(super) places: Vec<u32>,
}

impl Constrained {
    /// Takes a triangulation of so many points, none of whose edges is a constraint.
    #[must_use]
    pub fn new(mesh: Triangulation, points: usize) -> Self {
        let fixed = vec![0; mesh.triangles.len()];
        Self::with_constraints(mesh, fixed, points)
    }

    /// Takes triangles of so many points, which may be parts of a triangulation, and the bits of each one's sides.
    pub(crate) fn with_constraints(mesh: Triangulation, fixed: Vec<u8>, points: usize) -> Self {
        let mut this = Self {
            fixed,
            leaving: vec![PackedHalfEdge::NONE; points],
            ..Self::default()
        };
        if mesh.triangles.is_empty() {
            this.line = vec![false; mesh.hull.len()];
            this.places = vec![0; points];
            for (&point, place) in mesh.hull.iter().zip(0..) {
                this.places[point as usize] = place;
            }
        } else {
            for half_edge in mesh.half_edges() {
                this.leaving[mesh.origin(half_edge).index()] = half_edge.into();
            }
            let edges = mesh.half_edges().filter(|&side| mesh.twin(side) == Twin::Hull);
            let edges = edges.map(|side| (mesh.origin(side).0, mesh.destination(side).0, side));
            this.boundary = Boundary::new(edges.collect(), points);
        }
        this.mesh = mesh;
        this
    }

    /// The triangles and their adjacency. Their corners and their places may differ from those without constraints; the hull
    /// does not.
    #[must_use]
    pub fn mesh(&self) -> &Triangulation {
        &self.mesh
    }

    /// Whether a half-edge is on a constraint.
    #[must_use]
    pub fn is_constraint(&self, side: HalfEdge) -> bool {
        self.fixed[side.triangle().index()] >> side.corner() & 1 == 1
    }

    /// All constraint edges, once each.
    pub fn constraints(&self) -> impl Iterator<Item = [u32; 2]> {
        let mesh = &self.mesh;
        let sides = mesh.half_edges().filter(|&side| self.is_constraint(side));
        let once = sides.filter(|&side| mesh.twin(side).half_edge().is_none_or(|twin| side < twin));
        let edges = once.map(|side| [mesh.origin(side).0, mesh.destination(side).0]);
        let pairs = mesh.hull.windows(2).zip(&self.line);
        edges.chain(pairs.filter(|(_, fixed)| **fixed).map(|(pair, _)| [pair[0], pair[1]]))
    }

    /// The bits of a triangle's sides: from 0 on those that are constraints, from [`WALLS`] on those that are walls.
    pub(crate) fn side_bits(&self, triangle: TriangleId) -> u8 {
        self.fixed[triangle.index()]
    }

    /// The triangles, and the bits of each one's sides.
    pub(crate) fn into_parts(self) -> (Triangulation, Vec<u8>) {
        (self.mesh, self.fixed)
    }

    /// Makes the edge of a half-edge a constraint, or even a wall.
    pub(crate) fn fix(&mut self, side: HalfEdge, is_wall: bool) {
        let bits = if is_wall { WALL } else { CONSTRAINT };
        for side in [Some(side), self.mesh.twin(side).half_edge()].into_iter().flatten() {
            self.fixed[side.triangle().index()] |= bits << side.corner();
        }
    }

    /// A boundary edge belongs to this half-edge now.
    pub(super) fn move_boundary(&mut self, side: HalfEdge) {
        let [from, to] = [self.mesh.origin(side), self.mesh.destination(side)];
        self.boundary.set(from.0, to.0, side);
    }
}
