//! The triangles that an inserted point removes.

use foldhash::HashMap;

use super::corner::{Face, FaceEdge, GraphVertex};

/// A cavity, or a part of one, with the edges of its triangles.
#[derive(Default)]
pub(super) struct Cavity {
    pub(super) half_edges: HashMap<[GraphVertex; 2], FaceEdge>,
    /// The edges in the order of insertion, so that results do not depend on hashing.
    pub(super) order: Vec<[GraphVertex; 2]>,
    pub(super) open: Vec<FaceEdge>,
    pub(super) faces: Vec<Face>,
}

impl Cavity {
    /// Adds a triangle and its edges.
    pub(super) fn take(&mut self, face: Face) {
        self.faces.push(face);
        face.edges().into_iter().for_each(|face_edge| self.take_edge(face_edge));
    }

    /// Adds an edge of a triangle, which is then one to look beyond.
    pub(super) fn take_edge(&mut self, face_edge: FaceEdge) {
        if self.half_edges.insert(face_edge.ends(), face_edge).is_none() {
            self.order.push(face_edge.ends());
            self.open.push(face_edge);
        }
    }

    /// Returns whether the triangle beyond an edge is in the cavity too.
    pub(super) fn has_twin(&self, [from, to]: [GraphVertex; 2]) -> bool {
        self.half_edges.contains_key(&[to, from])
    }
}
