//! What the wave has still to do.

use std::hash::BuildHasher;

use crate::geometry::{HalfEdge, Point, TriangleId, VertexIndex};
use crate::store::{TileId, VertexId};

/// A thing to do, in a tile that the queue knows.
#[derive(Clone, Copy, Debug)]
pub(super) enum Task {
    /// The cone of `root` between `right` and `left` enters a triangle of `tile` by `side`. All its ways have at least `length`.
    Cone {
        tile: TileId,
        side: HalfEdge,
        root: u32,
        right: Point,
        left: Point,
        length: f64,
    },
    /// The same, from another tile: by the side that comes from vertex `from` to `vertex` of the tile.
    /// `seam` is [`seam_between`] its ends, as they are there.
    ConeOver {
        vertex: VertexIndex,
        from: VertexId,
        root: u32,
        right: Point,
        left: Point,
        seam: u64,
    },
    /// A vertex of the tile, at `point`, is reached from `root`, over `length` in all.
    Vertex {
        vertex: VertexIndex,
        point: Point,
        root: u32,
        length: f64,
        via: Via,
    },
    /// A goal is reached from `root`, over `length` in all. This needs no tile.
    Goal { goal: u32, root: u32, length: f64 },
    /// The source lies in a triangle.
    Start { triangle: TriangleId },
    /// The source lies on an edge, in the triangle of the side that comes from vertex `from` to `vertex` of the tile.
    StartOnEdge { vertex: VertexIndex, from: VertexId },
    /// The source is a vertex of the tile.
    StartVertex { vertex: VertexIndex },
    /// The source lies outside and sees the hull edge that leaves a vertex of the tile, forward along the hull, or else the one
    /// that comes in there. `before` is the edge before that, if one was seen, with the hull on its left.
    StartOnHull {
        vertex: VertexIndex,
        forward: bool,
        before: Option<[Point; 2]>,
    },
    /// Nothing: it was done, or became part of another one.
    Nothing,
}

/// The queue moves tasks about: they stay as large as a cache line.
const _: () = assert!(size_of::<Task>() <= 64);

/// What two tiles agree in that have the same ends of a side.
pub(super) fn seam_between(ends: [Point; 2]) -> u64 {
    let bits = ends.map(|end| [end.x.to_bits(), end.y.to_bits()]);
    foldhash::quality::FixedState::default().hash_one(bits)
}

/// In which wedge a vertex is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Via {
    /// That of the triangle of this side of the vertex's tile, which leaves the vertex.
    Side(HalfEdge),
    /// That of the triangle on the right of the edge to this vertex.
    RightOf(VertexId),
    /// Outside.
    Outside,
}
