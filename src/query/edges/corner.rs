//! Triangles by their vertices, whether these are the file's or were put in.

use crate::geometry::{HalfEdge, Point, TriangleId, VertexIndex};
use crate::store::{Tile, TileId, VertexId};

/// A vertex of the file, or a point that was put in. It is as small as the number of a vertex, since the queue and the sets of
/// a search are full of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct End(VertexId);

impl End {
    /// The tile that points which were put in have in place of one.
    const PUT_IN: TileId = TileId(u32::MAX);

    /// The point that was put in under this number.
    pub(crate) fn put_in(number: u32) -> Self {
        Self(VertexId {
            tile: Self::PUT_IN,
            index: VertexIndex(number),
        })
    }

    /// Whether it was put in.
    #[inline]
    pub(crate) fn is_put_in(self) -> bool {
        self.0.tile == Self::PUT_IN
    }

    /// The number under which it was put in, if it was.
    pub(crate) fn number(self) -> Option<u32> {
        self.is_put_in().then_some(self.0.index.0)
    }

    /// The vertex of the file, if it is one.
    #[inline]
    pub(crate) fn vertex(self) -> Option<VertexId> {
        (!self.is_put_in()).then_some(self.0)
    }
}

impl From<VertexId> for End {
    fn from(vertex: VertexId) -> Self {
        Self(vertex)
    }
}

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
    pub(crate) vertex: End,
    pub(crate) point: Point,
    pub(crate) within: Within,
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
        match (tile.is_constraint(side), tile.is_wall(side)) {
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
    pub(super) fn ends(&self) -> [End; 2] {
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
    pub(super) fn of(tile: &Tile, triangle: TriangleId) -> Self {
        let vertices = tile.vertices(triangle);
        let corner = |i: usize| Corner {
            vertex: vertices[i].id.into(),
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
    pub(super) fn key(&self) -> [End; 3] {
        let mut key = self.corners.map(|corner| corner.vertex);
        key.sort_unstable();
        key
    }
}

/// The two vertices of an edge, in order.
pub(crate) fn sorted([a, b]: [End; 2]) -> [End; 2] {
    if a < b { [a, b] } else { [b, a] }
}
