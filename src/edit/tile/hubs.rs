//! An index of the edges at vertices with many triangles, by their ends.
//!
//! Thousands of lines may share a vertex. Walking round it for each of them would take time
//! quadratic in their number.

use foldhash::{HashMap, HashSet};

use crate::edit::tile::room::{bytes_of, make_room, with_room};
use crate::geometry::{HalfEdge, TriangleId, VertexIndex};

/// A vertex with more triangles than this is a hub. Walking round other vertices is faster than
/// keeping an index of their edges.
pub(crate) const MOST_AROUND: u32 = 64;

/// The number of triangles of each vertex of a tile, and the half-edges at those that have many.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hubs {
    degrees: Vec<u32>,
    hubs: HashSet<VertexIndex>,
    /// The half-edge from one corner to another, one of which is a hub.
    half_edges: HashMap<[VertexIndex; 2], HalfEdge>,
}

impl Hubs {
    /// Makes the index of a tile with `vertices` vertices. Corners that are not a vertex of any
    /// tile are ignored.
    pub(crate) fn of(vertices: usize, triangles: &[[VertexIndex; 3]]) -> Self {
        let mut this = Self {
            degrees: with_room((0..vertices).map(|_| 0)),
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

    /// Makes room for more vertices, which no triangle has yet. Returns false if there are hubs: their
    /// edges may end at corners of other tiles, which get other numbers.
    pub(crate) fn add_vertices(&mut self, more: usize) -> bool {
        make_room(&mut self.degrees, more);
        self.degrees.resize(self.degrees.len() + more, 0);
        self.hubs.is_empty()
    }

    /// Returns about how many bytes of memory it takes.
    pub(crate) fn byte_size(&self) -> usize {
        bytes_of(&self.degrees) + 24 * self.half_edges.len()
    }

    /// Returns the number of triangles at a vertex of the tile.
    pub(crate) fn degree(&self, vertex: VertexIndex) -> u32 {
        self.degrees.get(vertex.index()).copied().unwrap_or(0)
    }

    /// Returns whether a corner is a hub, so that [`half_edge`](Self::half_edge) knows its edges.
    pub(crate) fn has(&self, corner: VertexIndex) -> bool {
        self.hubs.contains(&corner)
    }

    /// Returns whether a corner is a vertex of the tile that has enough triangles for a hub but is
    /// none yet.
    pub(crate) fn is_new(&self, corner: VertexIndex) -> bool {
        self.degree(corner) > MOST_AROUND && !self.has(corner)
    }

    /// Returns the half-edge from one corner to another, one of which is a hub.
    pub(crate) fn half_edge(&self, ends: [VertexIndex; 2]) -> Option<HalfEdge> {
        self.half_edges.get(&ends).copied()
    }

    /// Makes a vertex a hub. The caller must then enter all its triangles.
    pub(crate) fn make(&mut self, vertex: VertexIndex) {
        self.hubs.insert(vertex);
    }

    /// Adds a triangle by its corners and its position.
    pub(crate) fn add(&mut self, corners: [VertexIndex; 3], triangle: TriangleId) {
        for corner in corners {
            if let Some(degree) = self.degrees.get_mut(corner.index()) {
                *degree += 1;
            }
        }
        self.enter(corners, triangle);
    }

    /// Removes a triangle.
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

    /// Enters the half-edges of a triangle that start or end at a hub.
    pub(crate) fn enter(&mut self, corners: [VertexIndex; 3], triangle: TriangleId) {
        for (ends, corner) in self.of_hubs(corners) {
            self.half_edges.insert(ends, HalfEdge::new(triangle, corner));
        }
    }

    /// Returns the half-edges of a triangle that start or end at a hub: their ends, and the
    /// position of the corner that they start at.
    fn of_hubs(&self, corners: [VertexIndex; 3]) -> impl Iterator<Item = ([VertexIndex; 2], u32)> + use<> {
        let [a, b, c] = corners;
        let is_hub = corners.map(|corner| self.has(corner));
        let half_edges = [([a, b], 0), ([b, c], 1), ([c, a], 2)].into_iter();
        half_edges.filter(move |(_, s)| is_hub[*s as usize] || is_hub[(*s as usize + 1) % 3])
    }
}
