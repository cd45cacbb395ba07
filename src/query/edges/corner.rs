//! Triangles by their vertices, which are vertices of the file or inserted points.

use crate::geometry::{HalfEdge, Point, TriangleId, VertexIndex};
use crate::store::{Tile, TileId, VertexId};

/// A vertex of the file, or an inserted point. It has the size of a vertex id, because the queue
/// and the sets of a search have many of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct GraphVertex(VertexId);

impl GraphVertex {
    /// The tile id that marks inserted points.
    const INSERTED: TileId = TileId(u32::MAX);

    /// Returns the inserted point with this number.
    pub(crate) fn inserted(number: u32) -> Self {
        Self(VertexId {
            tile: Self::INSERTED,
            index: VertexIndex(number),
        })
    }

    /// Returns whether this is an inserted point.
    #[inline]
    pub(crate) fn is_inserted(self) -> bool {
        self.0.tile == Self::INSERTED
    }

    /// Returns the number of an inserted point; `None` for a vertex of the file.
    pub(crate) fn number(self) -> Option<u32> {
        self.is_inserted().then_some(self.0.index.0)
    }

    /// Returns the vertex of the file; `None` for an inserted point.
    #[inline]
    pub(crate) fn vertex(self) -> Option<VertexId> {
        (!self.is_inserted()).then_some(self.0)
    }
}

impl From<VertexId> for GraphVertex {
    fn from(vertex: VertexId) -> Self {
        Self(vertex)
    }
}

/// A position at a vertex: in a wedge of the file, which determines the sector, or in a sector of
/// an inserted point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Within {
    /// In the wedge of the file's triangle on the right of the edge to this vertex.
    RightOf(VertexId),
    /// In the outside.
    Outside,
    /// In the sector with this number of an inserted point.
    Sector(u32),
}

/// A vertex, in one of its wedges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    pub(crate) vertex: GraphVertex,
    pub(crate) point: Point,
    pub(crate) within: Within,
}

/// The kind of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EdgeKind {
    /// Not a constraint.
    Open,
    /// A constraint that does not block.
    Line,
    /// A constraint that blocks.
    Wall,
}

impl EdgeKind {
    pub(super) fn of(tile: &Tile, half_edge: HalfEdge) -> Self {
        match (tile.is_constraint(half_edge), tile.is_wall(half_edge)) {
            (false, _) => Self::Open,
            (true, false) => Self::Line,
            (true, true) => Self::Wall,
        }
    }
}

/// A directed edge; its corners are those of the triangle, or the outside, on its left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FaceEdge {
    pub(super) from: Corner,
    pub(super) to: Corner,
    pub(super) kind: EdgeKind,
}

impl FaceEdge {
    pub(super) fn ends(&self) -> [GraphVertex; 2] {
        [self.from.vertex, self.to.vertex]
    }
}

/// A triangle with counter-clockwise corners, and the kinds of its edges, starting with the edge
/// from its first to its second corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Face {
    pub(super) corners: [Corner; 3],
    pub(super) kinds: [EdgeKind; 3],
}

impl Face {
    /// Returns a triangle of the file.
    pub(super) fn of(tile: &Tile, triangle: TriangleId) -> Self {
        let vertices = tile.vertices(triangle);
        let corner = |i: usize| Corner {
            vertex: vertices[i].id.into(),
            point: vertices[i].point,
            within: Within::RightOf(vertices[(i + 2) % 3].id),
        };
        Self {
            corners: [corner(0), corner(1), corner(2)],
            kinds: HalfEdge::of_triangle(triangle).map(|half_edge| EdgeKind::of(tile, half_edge)),
        }
    }

    pub(super) fn edges(&self) -> [FaceEdge; 3] {
        [0, 1, 2].map(|i| FaceEdge {
            from: self.corners[i],
            to: self.corners[(i + 1) % 3],
            kind: self.kinds[i],
        })
    }

    pub(super) fn points(&self) -> [Point; 3] {
        self.corners.map(|corner| corner.point)
    }

    /// Returns the vertices, sorted.
    pub(super) fn key(&self) -> [GraphVertex; 3] {
        let mut key = self.corners.map(|corner| corner.vertex);
        key.sort_unstable();
        key
    }
}

/// Returns the two vertices of an edge, sorted.
pub(crate) fn sorted([a, b]: [GraphVertex; 2]) -> [GraphVertex; 2] {
    if a < b { [a, b] } else { [b, a] }
}
