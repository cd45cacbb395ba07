//! Triangles by their vertices, whether these are the file's or were put in.

use crate::geometry::{HalfEdge, Point};
use crate::store::{Tile, TileId, VertexId};

/// The tile that points which were put in have in place of one.
pub(crate) const PUT_IN: TileId = TileId(u32::MAX);

/// Where one is, at a vertex: in a wedge of the file, which tells the sector, or in a sector of a point that was put in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Within {
    /// That of the file's triangle on the right of the edge to this vertex.
    RightOf(VertexId),
    /// The outside.
    Outside,
    /// The sector of this number of a point that was put in.
    Sector(u32),
}

/// A vertex, in one of its wedges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    pub(crate) vertex: VertexId,
    pub(crate) point: Point,
    pub(crate) within: Within,
}

impl Corner {
    /// Whether the vertex was put in.
    pub(super) fn is_put_in(&self) -> bool {
        self.vertex.tile == PUT_IN
    }
}

/// What a side is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bar {
    /// No constraint.
    Open,
    /// A constraint that one may pass.
    Line,
    /// A constraint that blocks.
    Wall,
}

impl Bar {
    pub(super) fn of(tile: &Tile, side: HalfEdge) -> Self {
        match (tile.is_constraint(side.0), tile.is_wall(side.0)) {
            (false, _) => Self::Open,
            (true, false) => Self::Line,
            (true, true) => Self::Wall,
        }
    }
}

/// A side, with what its triangle or the outside has on its left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rim {
    pub(super) from: Corner,
    pub(super) to: Corner,
    pub(super) bar: Bar,
}

impl Rim {
    pub(super) fn ends(&self) -> [VertexId; 2] {
        [self.from.vertex, self.to.vertex]
    }
}

/// A triangle, counter-clockwise, and what its sides are, that from its first to its second corner first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Face {
    pub(super) corners: [Corner; 3],
    pub(super) bars: [Bar; 3],
}

impl Face {
    /// A triangle of the file.
    pub(super) fn of(tile: &Tile, triangle: u32) -> Self {
        let vertices = tile.vertices(triangle);
        let corner = |i: usize| Corner {
            vertex: vertices[i].id,
            point: vertices[i].point,
            within: Within::RightOf(vertices[(i + 2) % 3].id),
        };
        Self {
            corners: [corner(0), corner(1), corner(2)],
            bars: HalfEdge::of_triangle(triangle).map(|side| Bar::of(tile, side)),
        }
    }

    pub(super) fn rims(&self) -> [Rim; 3] {
        [0, 1, 2].map(|i| Rim {
            from: self.corners[i],
            to: self.corners[(i + 1) % 3],
            bar: self.bars[i],
        })
    }

    pub(super) fn points(&self) -> [Point; 3] {
        self.corners.map(|corner| corner.point)
    }

    /// The numbers of its vertices, in order.
    pub(super) fn key(&self) -> [VertexId; 3] {
        let mut key = self.corners.map(|corner| corner.vertex);
        key.sort_unstable();
        key
    }
}

/// The two vertices of an edge, in order.
pub(crate) fn sorted([a, b]: [VertexId; 2]) -> [VertexId; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// Whether a vertex is a point that was put in.
pub(crate) fn is_put_in(vertex: VertexId) -> bool {
    vertex.tile == PUT_IN
}
