//! The mesh around a tile's core: its late triangles and the boundary half-edges of its core,
//! matched by their edges.

use crate::collections::bucket_sort::bucket_sort;
use crate::geometry::Rect;
use crate::geometry::{HalfEdge, TriangleId};
use crate::mesh::WALLS;
use crate::pipeline::output::border_log::GroupBorders;
use crate::pipeline::records::{BoundaryEdge, LateTriangle, SeamVertex, TileState};
use crate::store::{DigestSum, TileId, VertexId, triangle_hash};

/// The late triangles of a tile and the boundary half-edges of its core. Does not depend on the
/// order in which they arrived.
#[derive(Debug)]
pub(crate) struct BorderMesh {
    tile: TileId,
    /// Number of vertices of the tile. Corners from this number on are foreign.
    pub(crate) vertices: u32,
    /// Number of triangles of the core. Triangles from this number on are late ones, in order.
    pub(crate) core_triangles: u32,
    pub(crate) boundary_edges: Vec<BoundaryEdge>,
    /// The vertices of other tiles, sorted by id.
    pub(crate) foreign: Vec<SeamVertex>,
    /// The late triangles, sorted.
    pub(crate) late: Vec<BorderTriangle>,
    /// All half-edges, sorted by the ends of their edge.
    pub(crate) half_edges: Vec<KeyedHalfEdge>,
    /// Bounding box of the corners of the late triangles that belong to the tile, and their number
    /// and the sum of their hashes.
    pub(crate) bounds: Rect,
    pub(crate) owned: DigestSum,
}

/// A late triangle, rotated so that its smallest corner comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct BorderTriangle {
    pub(crate) corners: [u32; 3],
    /// Three bits each, one per half-edge: whether it is a constraint, whether it is a wall, and
    /// whether its edge belongs to the tile.
    bits: u16,
    /// Number of the triangle in the border log.
    pub(crate) number: u32,
    /// Whether the triangle belongs to the tile.
    pub(crate) is_own: bool,
}

/// Position of the first bit that tells whether an edge belongs to the tile.
const OWN: u32 = 2 * WALLS;

/// A half-edge with the ends of its edge as a key.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KeyedHalfEdge {
    /// Corners, the smaller first.
    pub(crate) ends: [u32; 2],
    /// The half-edge, numbered through the core's triangles, then the late ones.
    pub(crate) half_edge: HalfEdge,
    /// Index into `boundary_edges` for a boundary half-edge; else meaningless.
    boundary_index: u32,
}

impl BorderTriangle {
    /// Returns the constraint and wall bits, in the layout of a constrained triangulation.
    pub(crate) fn edge_bits(&self) -> u8 {
        (self.bits & ((1 << OWN) - 1)) as u8
    }

    /// Returns the triangle rotated so that its smallest corner comes first.
    fn smallest_first(mut self) -> Self {
        while self.corners[0] > self.corners[1] || self.corners[0] > self.corners[2] {
            self.corners.rotate_left(1);
            // Rotates the three bits of each kind along with the corners.
            let turned = |first: u32| {
                let three = self.bits >> first & 0b111;
                (three >> 1 | three << 2 & 0b100) << first
            };
            self.bits = turned(0) | turned(WALLS) | turned(OWN);
        }
        self
    }
}

impl BorderMesh {
    /// Creates the mesh of `tile` from its group's part of the border log.
    ///
    /// `next` is for collinear input, which has no triangles: the vertex of another tile to which
    /// an edge of this tile leads, which is the next one on the line.
    pub(crate) fn of(tile: TileId, state: &TileState, group: &GroupBorders, next: Option<SeamVertex>) -> Self {
        let vertices = state.vertices;
        let triangles: Vec<LateTriangle> = group.triangles_of(tile).collect();
        let corners = triangles.iter().flat_map(|t| t.corners);
        let mut foreign: Vec<SeamVertex> = corners.filter(|v| v.id.tile != tile).chain(next).collect();
        foreign.sort_unstable_by_key(|v| v.id);
        foreign.dedup_by_key(|v| v.id);
        let mut this = Self {
            tile,
            vertices,
            core_triangles: state.core_triangles,
            boundary_edges: group.boundary_edges_of(tile),
            foreign,
            late: Vec::with_capacity(triangles.len()),
            half_edges: Vec::new(),
            bounds: Rect::EMPTY,
            owned: DigestSum::default(),
        };
        for triangle in &triangles {
            let corners = triangle.corners;
            let is_mine = |a: &SeamVertex, b: &SeamVertex| {
                let first = if a.point.lex_cmp(b.point).is_lt() { a } else { b };
                first.id.tile == tile
            };
            let own = [0, 1, 2].map(|s| u16::from(is_mine(&corners[s], &corners[(s + 1) % 3])) << s);
            let smallest = corners.iter().min_by(|a, b| a.point.lex_cmp(b.point));
            let is_own = smallest.is_some_and(|v| v.id.tile == tile);
            if is_own {
                let points = corners.map(|v| v.point);
                this.bounds = this.bounds.union(Rect::around(points));
                this.owned.add_hash(triangle_hash(points));
            }
            let late = BorderTriangle {
                corners: corners.map(|v| this.corner(v.id)),
                bits: u16::from(triangle.edge_bits) | (own[0] | own[1] | own[2]) << OWN,
                number: triangle.number,
                is_own,
            };
            this.late.push(late.smallest_first());
        }
        let corners = (vertices as usize) + this.foreign.len();
        this.late = bucket_sort(&this.late, corners, |late| late.corners[0], |late| *late);
        this.half_edges = this.half_edges_by_edge();
        this
    }

    /// Returns the size in bytes.
    pub(crate) fn byte_size(&self) -> u64 {
        let bytes = size_of_val(&*self.boundary_edges)
            + size_of_val(&*self.foreign)
            + size_of_val(&*self.late)
            + size_of_val(&*self.half_edges);
        bytes as u64
    }

    fn half_edges_by_edge(&self) -> Vec<KeyedHalfEdge> {
        let on = |from: u32, to: u32, half_edge, boundary_index| KeyedHalfEdge {
            ends: [from.min(to), from.max(to)],
            half_edge,
            boundary_index,
        };
        let mut half_edges = Vec::with_capacity(self.boundary_edges.len() + 3 * self.late.len());
        let numbered = self.boundary_edges.iter().zip(0..);
        half_edges.extend(numbered.map(|(edge, index)| on(edge.from, edge.to, edge.half_edge, index)));
        for (late, triangle) in self.late.iter().zip((self.core_triangles..).map(TriangleId)) {
            let [a, b, c] = late.corners;
            let [ab, bc, ca] = HalfEdge::of_triangle(triangle);
            half_edges
                .extend([(a, b, ab), (b, c, bc), (c, a, ca)].map(|(from, to, half_edge)| on(from, to, half_edge, 0)));
        }
        let corners = (self.vertices as usize) + self.foreign.len();
        bucket_sort(
            &half_edges,
            corners,
            |keyed| keyed.ends[0],
            |keyed| (keyed.ends[1], keyed.half_edge),
        )
    }

    /// Returns the corner number of a vertex of the tile or of one of its late triangles.
    pub(crate) fn corner(&self, id: VertexId) -> u32 {
        if id.tile == self.tile {
            return id.index.0;
        }
        self.vertices + self.foreign.partition_point(|f| f.id < id) as u32
    }

    /// Returns a half-edge's late triangle and its index there, or `None` for a core's half-edge.
    fn late_of(&self, half_edge: HalfEdge) -> Option<(&BorderTriangle, usize)> {
        let late = half_edge.triangle().0.checked_sub(self.core_triangles)?;
        Some((&self.late[late as usize], half_edge.corner() as usize))
    }

    /// Returns the corner from which a half-edge starts.
    pub(crate) fn from(&self, keyed: &KeyedHalfEdge) -> u32 {
        match self.late_of(keyed.half_edge) {
            Some((late, s)) => late.corners[s],
            None => self.boundary_edges[keyed.boundary_index as usize].from,
        }
    }

    /// Returns the number of a half-edge's late triangle, or as `Err` the component of the core's
    /// triangle that it bounds.
    pub(crate) fn within(&self, keyed: &KeyedHalfEdge) -> Result<u32, u32> {
        match self.late_of(keyed.half_edge) {
            Some((late, _)) => Ok(late.number),
            None => Err(self.boundary_edges[keyed.boundary_index as usize].component),
        }
    }

    /// Returns whether a half-edge is a constraint.
    pub(crate) fn is_constraint(&self, keyed: &KeyedHalfEdge) -> bool {
        match self.late_of(keyed.half_edge) {
            Some((late, s)) => late.bits >> s & 1 == 1,
            None => self.boundary_edges[keyed.boundary_index as usize].is_constraint,
        }
    }

    /// Returns whether a half-edge's edge belongs to the tile.
    pub(crate) fn is_own_edge(&self, keyed: &KeyedHalfEdge) -> bool {
        self.late_of(keyed.half_edge)
            .is_none_or(|(late, s)| late.bits >> (s as u32 + OWN) & 1 == 1)
    }

    /// Returns the half-edges grouped by edge, in order.
    pub(crate) fn edges(&self) -> impl Iterator<Item = &[KeyedHalfEdge]> {
        self.half_edges.chunk_by(|a, b| a.ends == b.ends)
    }
}
