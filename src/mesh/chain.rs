//! The boundary of the cavity on one side of a subsegment, and the triangles that fill the cavity
//! there.

use super::cavity::Cavity;
use super::constrained::{CROSSED, Constrained, WALL};
use super::topology::Topology;
use crate::geometry::{HalfEdge, PackedHalfEdge, TriangleId};

/// The boundary of a cavity on one side of a subsegment.
#[derive(Debug, Default)]
pub(super) struct Chain {
    pub(super) vertices: Vec<u32>,
    /// For each vertex but the last, the half-edge of the crossed triangle between it and the next.
    edges: Vec<HalfEdge>,
    /// For each half-edge in `edges`, its twin and its bits, at the bit positions of half-edge 0.
    twins: Vec<(ChainTwin, u8)>,
    /// The positions of edges that the chain passes once more.
    open: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
enum ChainTwin {
    /// A half-edge of a triangle that stays, or `None` on the boundary of the mesh.
    Stays(Option<HalfEdge>),
    /// The chain passes the edge once more, in the other direction, at this position.
    Chain(u32),
}

impl Chain {
    pub(super) fn clear(&mut self) {
        self.vertices.clear();
        self.edges.clear();
    }

    pub(super) fn begin(&mut self, from: u32, to: u32, edge: HalfEdge) {
        self.clear();
        self.vertices.push(from);
        self.push(to, edge);
    }

    pub(super) fn push(&mut self, vertex: u32, edge: HalfEdge) {
        self.vertices.push(vertex);
        self.edges.push(edge);
    }

    pub(super) fn reverse(&mut self) {
        self.vertices.reverse();
        self.edges.reverse();
    }

    /// Finds the twins of the chain's half-edges, while the crossed triangles still exist.
    ///
    /// The chain passes an edge twice if it lies between two crossed triangles but is not crossed
    /// itself. Such an edge is a constraint that dangles into the cavity, or an edge from which
    /// triangles hang that the subsegment does not cross. These edges are nested like brackets.
    pub(super) fn resolve(&mut self, mesh: &Constrained) {
        self.twins.clear();
        self.open.clear();
        for (position, &edge) in (0..).zip(&self.edges) {
            let twin = mesh.mesh.twin(edge).half_edge();
            let is_crossed = |twin: HalfEdge| mesh.fixed[twin.triangle().index()] & CROSSED != 0;
            let chain_twin = match self.open.last() {
                _ if !twin.is_some_and(is_crossed) => ChainTwin::Stays(twin),
                Some(&other) if Some(self.edges[other as usize]) == twin => {
                    self.open.pop();
                    self.twins[other as usize].0 = ChainTwin::Chain(position);
                    ChainTwin::Chain(other)
                }
                _ => {
                    self.open.push(position);
                    // A placeholder until the chain passes the edge again.
                    ChainTwin::Chain(position)
                }
            };
            let bits = mesh.fixed[edge.triangle().index()] >> edge.corner() & WALL;
            self.twins.push((chain_twin, bits));
        }
        debug_assert!(self.open.is_empty());
    }
}

/// Writes the triangles of a cavity to `slots`. Returns the half-edge on the subsegment.
pub(super) fn fill(mesh: &mut Constrained, chain: &Chain, slots: &[TriangleId], cavity: &Cavity) -> HalfEdge {
    let global = |edge: HalfEdge| HalfEdge::new(slots[edge.triangle().index()], edge.corner());
    for ((&slot, corners), triangle) in slots.iter().zip(&cavity.triangles).zip((0..).map(TriangleId)) {
        let corners = corners.map(|position| chain.vertices[position as usize]);
        let twins = HalfEdge::of_triangle(triangle).map(|edge| cavity.twin(edge).map(global));
        mesh.mesh.triangles[slot.index()] = corners;
        mesh.mesh.neighbours[slot.index()] = twins.map(PackedHalfEdge::from);
        mesh.fixed[slot.index()] = 0;
        for (edge, vertex) in HalfEdge::of_triangle(slot).into_iter().zip(corners) {
            mesh.leaving[vertex as usize] = edge.into();
        }
    }
    let mut edges = cavity.edges.iter().map(|&edge| global(edge));
    for (&(chain_twin, bits), edge) in chain.twins.iter().zip(edges.by_ref()) {
        let twin = match chain_twin {
            ChainTwin::Stays(twin) => {
                match twin {
                    Some(twin) => mesh.mesh.set_twin(twin, edge.into()),
                    None => mesh.move_boundary(edge),
                }
                twin
            }
            ChainTwin::Chain(position) => Some(global(cavity.edges[position as usize])),
        };
        mesh.mesh.set_twin(edge, twin.into());
        mesh.fixed[edge.triangle().index()] |= bits << edge.corner();
    }
    edges
        .next()
        .expect("a cavity has one edge more than the chain: the one on the subsegment")
}
