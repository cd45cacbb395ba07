//! The edges of vertices that have many, by their ends.
//!
//! Thousands of lines may share a vertex. To go round it for each of them would take time with the square of their number.

use foldhash::{HashMap, HashSet};

use crate::geometry::{HalfEdge, TriangleId, VertexIndex};

/// A vertex with more triangles than this is a hub. To go round others is faster than to keep an index of their edges.
pub(crate) const MOST_AROUND: u32 = 64;

/// How many triangles each vertex of a tile has, and the sides at those that have many.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hubs {
    degrees: Vec<u32>,
    hubs: HashSet<VertexIndex>,
    /// The side from one corner to another, one of which is a hub.
    half_edges: HashMap<[VertexIndex; 2], HalfEdge>,
}

impl Hubs {
    /// Of a tile with this number of vertices. Corners that are greater than those of any tile are none.
    pub(crate) fn of(vertices: usize, triangles: &[[VertexIndex; 3]]) -> Self {
        let mut this = Self {
            degrees: vec![0; vertices],
            ..Self::default()
        };
        for &corner in triangles.as_flattened() {
            if let Some(degree) = this.degrees.get_mut(corner.index()) {
                *degree += 1;
            }
        }
        let hubs = (0..)
            .map(VertexIndex)
            .zip(&this.degrees)
            .filter(|(_, degree)| **degree > MOST_AROUND);
        this.hubs = hubs.map(|(vertex, _)| vertex).collect();
        if !this.hubs.is_empty() {
            for (&corners, triangle) in triangles.iter().zip((0..).map(TriangleId)) {
                this.enter(corners, triangle);
            }
        }
        this
    }

    /// Bytes that it takes in memory, about.
    pub(crate) fn byte_size(&self) -> usize {
        4 * self.degrees.len() + 24 * self.half_edges.len()
    }

    /// The number of triangles at a vertex of the tile.
    pub(crate) fn degree(&self, vertex: VertexIndex) -> u32 {
        self.degrees.get(vertex.index()).copied().unwrap_or(0)
    }

    /// Whether a corner is a hub, so that [`side`](Self::side) knows its edges.
    pub(crate) fn has(&self, corner: VertexIndex) -> bool {
        self.hubs.contains(&corner)
    }

    /// Whether a corner is a vertex of the tile with as many triangles as a hub, but is none yet.
    pub(crate) fn is_new(&self, corner: VertexIndex) -> bool {
        self.degree(corner) > MOST_AROUND && !self.has(corner)
    }

    /// The side from one corner to another, one of which is a hub.
    pub(crate) fn half_edge(&self, ends: [VertexIndex; 2]) -> Option<HalfEdge> {
        self.half_edges.get(&ends).copied()
    }

    /// Makes a vertex a hub. All its triangles must be entered then.
    pub(crate) fn make(&mut self, vertex: VertexIndex) {
        self.hubs.insert(vertex);
    }

    /// Takes a new triangle, by its corners and its place.
    pub(crate) fn add(&mut self, corners: [VertexIndex; 3], triangle: TriangleId) {
        for corner in corners {
            if let Some(degree) = self.degrees.get_mut(corner.index()) {
                *degree += 1;
            }
        }
        self.enter(corners, triangle);
    }

    /// Forgets a triangle.
    pub(crate) fn remove(&mut self, corners: [VertexIndex; 3]) {
        for corner in corners {
            if let Some(degree) = self.degrees.get_mut(corner.index()) {
                *degree -= 1;
            }
        }
        for (ends, _) in self.of_hubs(corners) {
            self.half_edges.remove(&ends);
        }
    }

    /// Notes the sides of a triangle that start or end at a hub.
    pub(crate) fn enter(&mut self, corners: [VertexIndex; 3], triangle: TriangleId) {
        for (ends, corner) in self.of_hubs(corners) {
            self.half_edges.insert(ends, HalfEdge::new(triangle, corner));
        }
    }

    /// The sides of a triangle that start or end at a hub: their ends, and the corners that they start at.
    fn of_hubs(&self, corners: [VertexIndex; 3]) -> impl Iterator<Item = ([VertexIndex; 2], u32)> + use<> {
        let [a, b, c] = corners;
        let is_hub = corners.map(|corner| self.has(corner));
        let half_edges = [([a, b], 0), ([b, c], 1), ([c, a], 2)].into_iter();
        half_edges.filter(move |(_, s)| is_hub[*s as usize] || is_hub[(*s as usize + 1) % 3])
    }
}
