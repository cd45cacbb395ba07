//! What the phases of a build hand to each other.

use std::collections::HashMap;
use std::ops::Range;

use crate::constraints::segment::Segment;
use crate::geometry::{HalfEdge, Point, Rect};
use crate::pipeline::summary::LevelSummary;
use crate::store::{EdgeSource, Extent, KdTree, LineSource, Source, TileId, VertexId};

/// The generation that a new file starts with.
pub(crate) const GENERATION: u32 = 1;

/// What the caller knows of the points: metadata, and a note that a build that is resumed gives back.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Description {
    /// The files that the points come from.
    pub sources: Vec<Source>,
    /// The files that lines come from, in the order of their numbers.
    pub lines: Vec<LineSource>,
    /// The coordinate reference system.
    pub crs: Option<String>,
    /// Anything that whoever resumes the build wants to know; it does not go to the file.
    pub memo: String,
}

/// What is known of a block that was divided, more with each leaf and merge; of a finished one it goes to the journal.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BlockFound {
    pub(crate) first_tile: u32,
    pub(crate) tree: KdTree,
    pub(crate) tiles: Vec<TileState>,
    pub(crate) duplicates: u64,
    pub(crate) ends: u64,
    pub(crate) late_triangles: u64,
    pub(crate) held_triangles: u64,
    pub(crate) levels: Vec<LevelSummary>,
}

impl BlockFound {
    pub(crate) fn tile_range(&self) -> Range<u32> {
        self.first_tile..self.first_tile + self.tiles.len() as u32
    }
}

/// What is known of a tile, but for its extents.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TileState {
    pub(crate) vertices: u32,
    pub(crate) core_triangles: u32,
    pub(crate) border_triangles: u32,
    pub(crate) owned_triangles: u32,
    pub(crate) bounds: Rect,
    pub(crate) constraint_edges: u64,
    /// The components of its core, and those of them that are open; none where there are no regions to be told apart.
    pub(crate) components: u32,
    pub(crate) open_components: u32,
}

impl Default for TileState {
    fn default() -> Self {
        Self {
            vertices: 0,
            core_triangles: 0,
            border_triangles: 0,
            owned_triangles: 0,
            constraint_edges: 0,
            components: 0,
            open_components: 0,
            bounds: Rect::EMPTY,
        }
    }
}

/// What a node hands to its parent.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Seam {
    /// The vertices of the unsettled triangles and all hull vertices; without triangles, all vertices. By tile and place.
    pub(crate) vertices: Vec<SeamVertex>,
    /// The unsettled triangles, by place in `vertices`, each from its smallest corner on, in order.
    pub(crate) unsettled: Vec<[u32; 3]>,
    /// How many levels of nodes there are below the node, and it.
    pub(crate) level: usize,
    /// The vertices of all tiles of the node.
    pub(crate) below: u64,
    /// What is to become of constraints.
    pub(crate) pending: Pending,
}

impl Seam {
    /// Bytes that it takes in memory.
    pub(crate) fn byte_size(&self) -> u64 {
        let own = self.vertices.len() * size_of::<SeamVertex>() + self.unsettled.len() * 12;
        own as u64 + self.pending.byte_size()
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SeamVertex {
    pub(crate) id: VertexId,
    pub(crate) point: Point,
}

/// What goes up from a node for its constraints.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Pending {
    /// The vertices of what follows, in order.
    pub(crate) vertices: Vec<SeamVertex>,
    /// Final triangles that pieces cross which are not in yet: corners, and the bits of the sides.
    pub(crate) held: Vec<([u32; 3], u8)>,
    /// Pieces that are not in yet.
    pub(crate) pieces: Vec<Piece>,
    /// Segments that leave the cell.
    pub(crate) open: Vec<Open>,
}

/// A part of a segment between two vertices; once it is in, a constraint edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Piece {
    /// The vertices, by place, in order.
    pub(crate) ends: [u32; 2],
    /// What it is a part of, seen from the first to the second.
    pub(crate) source: EdgeSource,
}

/// A constraint edge that is done: its triangles are final on both sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DoneEdge {
    pub(crate) ends: [SeamVertex; 2],
    /// Why it is a constraint, seen from the first end to the second.
    pub(crate) source: EdgeSource,
}

impl DoneEdge {
    /// If its ends are vertices of two tiles: that of the smaller one, which the edge belongs to, and the larger end.
    pub(crate) fn end_elsewhere(&self) -> Option<(TileId, SeamVertex)> {
        let [a, b] = self.ends;
        let (from, to) = if a.point.lex_cmp(b.point).is_lt() {
            (a, b)
        } else {
            (b, a)
        };
        (from.id.tile != to.id.tile).then_some((from.id.tile, to))
    }
}

/// A segment that leaves a node's cell on one side at least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Open {
    pub(crate) segment: Segment,
    /// The first and the last vertex on it in the node, from its first end on. None: it passes between vertices.
    pub(crate) run: Option<[u32; 2]>,
}

impl Pending {
    /// Bytes that it takes in memory.
    pub(crate) fn byte_size(&self) -> u64 {
        let bytes = size_of_val(&*self.vertices)
            + size_of_val(&*self.held)
            + size_of_val(&*self.pieces)
            + size_of_val(&*self.open);
        bytes as u64
    }
}

impl Piece {
    /// From one vertex to another.
    pub(crate) fn new(from: u32, to: u32, source: EdgeSource) -> Self {
        if from <= to {
            Self {
                ends: [from, to],
                source,
            }
        } else {
            Self {
                ends: [to, from],
                source: source.reversed(),
            }
        }
    }

    /// With other numbers of its vertices.
    pub(crate) fn renumbered(self, place: impl Fn(u32) -> u32) -> Self {
        let [from, to] = self.ends.map(place);
        Self::new(from, to, self.source)
    }
}

impl Open {
    pub(crate) fn renumbered(self, place: impl Fn(u32) -> u32) -> Self {
        Self {
            run: self.run.map(|run| run.map(place)),
            ..self
        }
    }
}

/// A side of a core triangle without another core triangle across: the border may have one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OpenSide {
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) side: HalfEdge,
    pub(crate) is_constraint: bool,
    /// The component of its triangle.
    pub(crate) component: u32,
}

/// An open component of a core, and by how much deeper than that another one lies, which has so many triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Anchor {
    pub(crate) component: u32,
    pub(crate) deeper: i32,
    pub(crate) triangles: u32,
}

/// A triangle that was settled by a merge: crossing, or late.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LateTriangle {
    /// Counter-clockwise.
    pub(crate) corners: [SeamVertex; 3],
    /// The bits of the sides, as in a triangulation with constraints.
    pub(crate) side_bits: u8,
    /// Its number in the log, which gives it.
    pub(crate) number: u32,
}

/// The chunks of a group, by the kind of what is in them.
pub(crate) type GroupChunks = [Vec<Extent>; KINDS];

/// Kinds of what the border log holds: sides, triangles, edges, anchors.
pub(crate) const KINDS: usize = 4;

/// Without triangles: of tiles, the vertex of another one that an edge leads to.
pub(crate) type Nexts = HashMap<TileId, SeamVertex>;
