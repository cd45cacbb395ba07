//! The boundary of the cavity on one side of a piece, and the triangles that fill it.

use super::cavity::Cavity;
use super::constrained::{CROSSED, Constrained, WALL};
use super::topology::Topology;
use crate::geometry::{HalfEdge, PackedHalfEdge, TriangleId};

/// The boundary of a cavity on one side of a piece.
#[derive(Debug, Default)]
pub(super) struct Chain {
    pub(super) vertices: Vec<u32>,
    /// Between each vertex and the next, the half-edge of the crossed triangle there.
    sides: Vec<HalfEdge>,
    /// What lies across each of these, and the bits of the half-edge, in the places of a first one.
    across: Vec<(Across, u8)>,
    /// Positions whose edges the chain passes once more.
    open: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
enum Across {
    /// A half-edge of a triangle that stays, or nothing.
    Stays(Option<HalfEdge>),
    /// The chain passes the edge once more, the other way, at this position.
    Chain(u32),
}

impl Chain {
    pub(super) fn clear(&mut self) {
        self.vertices.clear();
        self.sides.clear();
    }

    pub(super) fn begin(&mut self, from: u32, to: u32, side: HalfEdge) {
        self.clear();
        self.vertices.push(from);
        self.push(to, side);
    }

    pub(super) fn push(&mut self, vertex: u32, side: HalfEdge) {
        self.vertices.push(vertex);
        self.sides.push(side);
    }

    pub(super) fn reverse(&mut self) {
        self.vertices.reverse();
        self.sides.reverse();
    }

    /// Finds out what lies across, while the crossed triangles are still there.
    ///
    /// An edge between two crossed triangles that is not crossed itself is passed twice: a constraint that dangles into the
    /// cavity, or an edge from which triangles hang that the piece does not cross. Such edges lie within each other as
    /// brackets do.
    pub(super) fn resolve(&mut self, mesh: &Constrained) {
        self.across.clear();
        self.open.clear();
        for (position, &side) in (0..).zip(&self.sides) {
            let twin = mesh.mesh.twin(side).half_edge();
            let is_crossed = |twin: HalfEdge| mesh.fixed[twin.triangle().index()] & CROSSED != 0;
            let across = match self.open.last() {
                _ if !twin.is_some_and(is_crossed) => Across::Stays(twin),
                Some(&other) if Some(self.sides[other as usize]) == twin => {
                    self.open.pop();
                    self.across[other as usize].0 = Across::Chain(position);
                    Across::Chain(other)
                }
                _ => {
                    self.open.push(position);
                    // Until it comes again.
                    Across::Chain(position)
                }
            };
            let bits = mesh.fixed[side.triangle().index()] >> side.corner() & WALL;
            self.across.push((across, bits));
        }
        debug_assert!(self.open.is_empty());
    }
}

/// Puts the triangles of a cavity in these places. Returns the half-edge on the piece.
pub(super) fn fill(mesh: &mut Constrained, chain: &Chain, places: &[TriangleId], cavity: &Cavity) -> HalfEdge {
    let global = |side: HalfEdge| HalfEdge::new(places[side.triangle().index()], side.corner());
    for ((&place, corners), triangle) in places.iter().zip(&cavity.triangles).zip((0..).map(TriangleId)) {
        let corners = corners.map(|position| chain.vertices[position as usize]);
        let twins = HalfEdge::of_triangle(triangle).map(|side| cavity.twin(side).map(global));
        mesh.mesh.triangles[place.index()] = corners;
        mesh.mesh.neighbours[place.index()] = twins.map(PackedHalfEdge::from);
        mesh.fixed[place.index()] = 0;
        for (side, vertex) in HalfEdge::of_triangle(place).into_iter().zip(corners) {
            mesh.leaving[vertex as usize] = side.into();
        }
    }
    let mut sides = cavity.sides.iter().map(|&side| global(side));
    for (&(across, bits), side) in chain.across.iter().zip(sides.by_ref()) {
        let twin = match across {
            Across::Stays(twin) => {
                match twin {
                    Some(twin) => mesh.mesh.set_twin(twin, side.into()),
                    None => mesh.move_boundary(side),
                }
                twin
            }
            Across::Chain(position) => Some(global(cavity.sides[position as usize])),
        };
        mesh.mesh.set_twin(side, twin.into());
        mesh.fixed[side.triangle().index()] |= bits << side.corner();
    }
    sides.next().expect("one side more than edges of the chain")
}
