//! The boundary of a polygon of old triangles, and the new triangles that fill it.

use foldhash::HashMap;

use crate::edit::patch::{NewTriangle, Patch, PatchTwin};
use crate::geometry::{HalfEdge, TriangleId};
use crate::mesh::{Cavity, WALLS};

/// A chain of vertices of a patch around a polygon of its old triangles, which is on the right. If
/// there are as many half-edges as vertices, the chain is closed; otherwise an edge that is no
/// old one, the *base*, closes the polygon.
#[derive(Default)]
pub(crate) struct Chain {
    pub(crate) vertices: Vec<u32>,
    /// The half-edge of the old triangle between each vertex and the next.
    pub(crate) half_edges: Vec<HalfEdge>,
}

impl Chain {
    pub(crate) fn clear(&mut self) {
        self.vertices.clear();
        self.half_edges.clear();
    }

    pub(crate) fn push(&mut self, vertex: u32, half_edge: HalfEdge) {
        self.vertices.push(vertex);
        self.half_edges.push(half_edge);
    }

    /// Adds the triangles of a cavity, which fills the polygon, to the patch. Returns the half-edge
    /// on the base. `is_passed_twice` says whether the chain may pass an edge in both directions.
    pub(crate) fn fill(&self, patch: &mut Patch, cavity: &Cavity, is_passed_twice: bool) -> HalfEdge {
        let first = patch.new.len() as u32;
        let of_patch = |half_edge: HalfEdge| HalfEdge(3 * first + half_edge.0);
        for (corners, number) in cavity.triangles.iter().zip((0..).map(TriangleId)) {
            // A half-edge without a twin is on the chain or on the base. Its twin is set later.
            let twin_of = |half_edge| {
                let twin = cavity.twin(half_edge);
                twin.map_or(PatchTwin::Hull, |twin| PatchTwin::New(of_patch(twin)))
            };
            patch.new.push(NewTriangle {
                corners: corners.map(|position| self.vertices[position as usize]),
                bits: 0,
                twins: HalfEdge::of_triangle(number).map(twin_of),
            });
        }
        // An edge between two triangles of the polygon that stays is passed twice. It is a
        // constraint that dangles into the polygon, or an edge from which triangles hang that are
        // not in it.
        let mut positions: HashMap<[u32; 2], usize> = HashMap::default();
        if is_passed_twice {
            positions.extend(self.edges().zip(0..));
        }
        for (position, ([from, to], &old)) in self.edges().zip(&self.half_edges).enumerate() {
            let half_edge = of_patch(cavity.edges[position]);
            let twin = positions.get(&[to, from]).map(|&other| of_patch(cavity.edges[other]));
            let bits = patch.old[old.triangle().index()].bits >> old.corner() & constraint_bits(true);
            let twin = twin.map_or(PatchTwin::Old(old), PatchTwin::New);
            patch.new[half_edge.triangle().index()].set(half_edge, twin, bits);
        }
        of_patch(cavity.edges[self.vertices.len() - 1])
    }

    /// Returns the ends of each edge that has a half-edge.
    fn edges(&self) -> impl Iterator<Item = [u32; 2]> {
        let next = self.vertices.iter().cycle().skip(1);
        let edges = self.vertices.iter().zip(next).map(|(&from, &to)| [from, to]);
        edges.take(self.half_edges.len())
    }
}

/// Returns the bits of a constraint that is the first half-edge of a triangle.
pub(crate) fn constraint_bits(is_wall: bool) -> u8 {
    1 | u8::from(is_wall) << WALLS
}
