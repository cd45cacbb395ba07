//! The tasks of the wavefront.

use std::hash::BuildHasher;

use crate::geometry::{HalfEdge, Point, TriangleId, VertexIndex};
use crate::store::{TileId, VertexId};

/// A task. The queue knows its tile.
#[derive(Clone, Copy, Debug)]
pub(super) enum Task {
    /// The window of `root` between `right` and `left` enters a triangle of `tile` by `half_edge`.
    /// All its paths have at least `length`.
    Window {
        tile: TileId,
        half_edge: HalfEdge,
        root: u32,
        right: Point,
        left: Point,
        length: f64,
    },
    /// The same window from another tile enters by the half-edge from vertex `from` to `vertex` of
    /// the tile. `seam` is [`seam_between`] the ends of the edge, as the other tile has them.
    IncomingWindow {
        vertex: VertexIndex,
        from: VertexId,
        root: u32,
        right: Point,
        left: Point,
        seam: u64,
    },
    /// The path from `root` reaches a vertex of the tile at `point`, with `length` in total.
    Vertex {
        vertex: VertexIndex,
        point: Point,
        root: u32,
        length: f64,
        via: Via,
    },
    /// The path from `root` reaches a goal, with `length` in total. This needs no tile.
    Goal { goal: u32, root: u32, length: f64 },
    /// The source is inside a triangle.
    Start { triangle: TriangleId },
    /// The source is on an edge, and the triangle is that of the half-edge from vertex `from` to
    /// `vertex` of the tile.
    StartOnEdge { vertex: VertexIndex, from: VertexId },
    /// The source is a vertex of the tile.
    StartVertex { vertex: VertexIndex },
    /// The source is outside and sees the hull edge that leaves a vertex of the tile, if `forward`,
    /// or the hull edge that arrives there. `before` is the edge before that one, if one was seen,
    /// with the hull on its left.
    StartOnHull {
        vertex: VertexIndex,
        forward: bool,
        before: Option<[Point; 2]>,
    },
    /// Nothing: the task was run, or joined with another one.
    Nothing,
}

impl Task {
    /// Returns the root from which the task continues; 0 if it is a source.
    pub(super) fn root(&self) -> u32 {
        match *self {
            Self::Window { root, .. }
            | Self::IncomingWindow { root, .. }
            | Self::Vertex { root, .. }
            | Self::Goal { root, .. } => root,
            Self::Start { .. }
            | Self::StartOnEdge { .. }
            | Self::StartVertex { .. }
            | Self::StartOnHull { .. }
            | Self::Nothing => 0,
        }
    }
}

/// The queue copies tasks, so a task fits in a cache line.
const _: () = assert!(size_of::<Task>() <= 64);

/// Returns a hash of the ends of a half-edge, by which two tiles can check that they agree.
pub(super) fn seam_between(ends: [Point; 2]) -> u64 {
    let bits = ends.map(|end| [end.x.to_bits(), end.y.to_bits()]);
    foldhash::quality::FixedState::default().hash_one(bits)
}

/// The wedge in which a path reaches a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Via {
    /// The wedge of the triangle of this half-edge in the vertex's tile; its origin is the vertex.
    HalfEdge(HalfEdge),
    /// The wedge of the triangle on the right of the edge to this vertex.
    RightOf(VertexId),
    /// The outside.
    Outside,
}
