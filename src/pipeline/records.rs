//! Values that the phases of a build pass to each other.

use std::collections::HashMap;
use std::ops::Range;

use crate::constraints::segment::Segment;
use crate::geometry::{HalfEdge, Point, Rect};
use crate::pipeline::summary::LevelSummary;
use crate::store::{Digest, DigestSum, Extent, KdTree, LinePart, LineSource, Source, TileId, VertexId};

/// The generation of the tiles of a new file.
pub(crate) const GENERATION: u32 = 1;

/// The caller's description of the input: metadata, and a memo that a resumed build returns.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Description {
    /// The files that the points come from.
    pub sources: Vec<Source>,
    /// The files that the lines come from, in the order of their numbers.
    pub lines: Vec<LineSource>,
    /// The coordinate reference system.
    pub crs: Option<String>,
    /// Any text for the caller that resumes the build. It is not written to the file.
    pub memo: String,
}

/// The results of a divided block so far; each leaf and merge adds to them. Those of a finished
/// block go to the journal, so all that later phases need of its leaves is here.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BlockState {
    pub(crate) first_tile: u32,
    pub(crate) tree: KdTree,
    pub(crate) tiles: Vec<TileState>,
    pub(crate) duplicates: u64,
    pub(crate) ends: u64,
    pub(crate) late_triangles: u64,
    pub(crate) held_triangles: u64,
    pub(crate) levels: Vec<LevelSummary>,
    /// The digest of the cores of its tiles.
    pub(crate) digest: Digest,
    /// Pairs of a tile and a component of its core that contains a seed.
    pub(crate) seeded: Vec<(u32, u32)>,
    /// The tiles with sites.
    pub(crate) with_sites: Vec<u32>,
    /// Number of vertices without z that got 0, when others have z.
    pub(crate) without_z: u64,
    pub(crate) draped: Draped,
}

/// The blocks that an earlier build finished.
#[derive(Debug, Default)]
pub(crate) struct FinishedBlocks {
    pub(crate) blocks: u32,
    pub(crate) points: u64,
    pub(crate) cores: Vec<Extent>,
    /// Where the cores of each block end in the tile file.
    pub(crate) ends: Vec<u64>,
    /// The cores that are not in the tile file but stay in files of their own.
    pub(crate) left: Vec<LeftCores>,
    pub(crate) journal_length: u64,
    /// Lengths, in bytes, of the valid parts of the tile file and the border log.
    pub(crate) file_length: u64,
    pub(crate) log_length: u64,
    /// More than the number of any triangle in the border log.
    pub(crate) next_number: u64,
}

/// The cores of a block that stay in a file of their own, where the tile file has a gap.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LeftCores {
    pub(crate) block: u32,
    /// Their bytes in the tile file.
    pub(crate) range: Range<u64>,
}

/// Numbers of the vertices that took their z from the surface of the points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Draped {
    /// Vertices that had no z.
    pub(crate) vertices: u64,
    /// Those of them that are outside the hull.
    pub(crate) outside: u64,
    /// Points of the input that took the z of a pond.
    pub(crate) flattened: u64,
}

impl BlockState {
    pub(crate) fn tile_range(&self) -> Range<u32> {
        self.first_tile..self.first_tile + self.tiles.len() as u32
    }
}

/// The results of a tile so far, except its extents.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TileState {
    pub(crate) vertices: u32,
    pub(crate) core_triangles: u32,
    pub(crate) border_triangles: u32,
    pub(crate) owned_triangles: u32,
    pub(crate) bounds: Rect,
    pub(crate) constraint_edges: u64,
    /// Numbers of components of the core, and of those that are open. Both are 0 if regions are not
    /// distinguished.
    pub(crate) components: u32,
    pub(crate) open_components: u32,
    /// The triangles of the core, if regions are not distinguished.
    pub(crate) core_sum: DigestSum,
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
            core_sum: DigestSum::default(),
            bounds: Rect::EMPTY,
        }
    }
}

/// The data that a node passes to its parent.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Seam {
    /// The vertices of the unsettled triangles and all hull vertices, or all vertices if there are
    /// no triangles. Sorted by tile and index.
    pub(crate) vertices: Vec<SeamVertex>,
    /// The unsettled triangles, as indices into `vertices`, each rotated so that its smallest
    /// corner comes first, sorted.
    pub(crate) unsettled: Vec<[u32; 3]>,
    /// Number of levels of nodes from the leaves up to and including this node.
    pub(crate) level: usize,
    /// Number of vertices of all tiles of the node.
    pub(crate) below: u64,
    /// The constraints that are not inserted yet.
    pub(crate) pending: Pending,
}

impl Seam {
    /// Returns the size in bytes.
    pub(crate) fn byte_size(&self) -> u64 {
        let own = self.vertices.len() * size_of::<SeamVertex>() + self.unsettled.len() * 12;
        own as u64 + self.pending.byte_size()
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SeamVertex {
    pub(crate) id: VertexId,
    pub(crate) point: Point,
    /// For the borders of other tiles; 0 if the points have no z.
    pub(crate) z: f64,
}

/// The data that a node passes up for its constraints.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Pending {
    /// The vertices of the following fields, sorted by id.
    pub(crate) vertices: Vec<SeamVertex>,
    /// Held triangles: final triangles that pending subsegments cross. Corners, and the bits of the
    /// half-edges.
    pub(crate) held: Vec<([u32; 3], u8)>,
    /// Subsegments that are not inserted yet.
    pub(crate) subsegments: Vec<Subsegment>,
    /// Segments that leave the cell.
    pub(crate) open: Vec<OpenSegment>,
    /// What the node and those below it deferred.
    pub(crate) deferred: Deferred,
}

/// Deferred segments: they would hold too many triangles, so an edit inserts them once the file is
/// complete. Each has the number of its copies. Sorted, without duplicates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Deferred(pub(crate) Vec<(Segment, u64)>);

/// A part of a segment between two vertices. Once it is inserted, it is a constraint edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Subsegment {
    /// Indices of the vertices, ascending.
    pub(crate) ends: [u32; 2],
    /// The part of the line, seen from the first end to the second.
    pub(crate) source: LinePart,
}

/// A constraint edge that is done: the triangles on both sides are final.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DoneEdge {
    pub(crate) ends: [SeamVertex; 2],
    /// Why the edge is a constraint, seen from the first end to the second.
    pub(crate) source: LinePart,
}

impl DoneEdge {
    /// If the ends are vertices of two tiles, returns the tile of the lexicographically smaller
    /// end, which owns the edge, and the larger end.
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

/// A segment that leaves a node's cell at one end at least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OpenSegment {
    pub(crate) segment: Segment,
    /// The first and the last vertex on the segment in the node, seen from the segment's first end.
    /// `None` if it passes between vertices.
    pub(crate) run: Option<[u32; 2]>,
}

impl Pending {
    /// Returns the size in bytes.
    pub(crate) fn byte_size(&self) -> u64 {
        let bytes = size_of_val(&*self.vertices)
            + size_of_val(&*self.held)
            + size_of_val(&*self.subsegments)
            + size_of_val(&*self.open)
            + size_of_val(&*self.deferred.0);
        bytes as u64
    }
}

impl Deferred {
    /// Returns whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns whether a segment is deferred.
    pub(crate) fn has(&self, segment: &Segment) -> bool {
        let key = segment.key();
        self.0.binary_search_by_key(&key, |(segment, _)| segment.key()).is_ok()
    }

    /// Adds segments with the numbers of their copies. Where one is there already, the larger
    /// number counts.
    pub(crate) fn extend(&mut self, segments: impl IntoIterator<Item = (Segment, u64)>) {
        self.0.extend(segments);
        self.0
            .sort_unstable_by_key(|(segment, copies)| (segment.key(), u64::MAX - copies));
        self.0.dedup_by_key(|(segment, _)| segment.key());
    }

    /// Returns all copies of all segments.
    pub(crate) fn into_segments(self) -> Vec<Segment> {
        let copies = |(segment, copies)| std::iter::repeat_n(segment, copies as usize);
        self.0.into_iter().flat_map(copies).collect()
    }
}

impl Subsegment {
    /// Creates the subsegment from one vertex to another.
    pub(crate) fn new(from: u32, to: u32, source: LinePart) -> Self {
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

    /// Returns the part of the subsegment from one vertex on it to another, in its direction.
    pub(crate) fn part(self, [from, to]: [u32; 2]) -> Self {
        Self::new(from, to, self.source.between([from, to], self.ends))
    }

    /// Returns the subsegment with its vertices renumbered.
    pub(crate) fn renumbered(self, number: impl Fn(u32) -> u32) -> Self {
        let [from, to] = self.ends.map(number);
        Self::new(from, to, self.source)
    }
}

impl OpenSegment {
    pub(crate) fn renumbered(self, number: impl Fn(u32) -> u32) -> Self {
        Self {
            run: self.run.map(|run| run.map(number)),
            ..self
        }
    }
}

/// A boundary half-edge of a core: its twin is not in a core triangle. The border may have one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundaryEdge {
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) half_edge: HalfEdge,
    pub(crate) is_constraint: bool,
    /// The component of its triangle.
    pub(crate) component: u32,
}

/// A component's depth relative to an open component, `component`: it is `deeper` deeper than that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Anchor {
    pub(crate) component: u32,
    pub(crate) deeper: i32,
    /// The number of its triangles, and the sum of their hashes.
    pub(crate) triangles: DigestSum,
}

/// A constraint edge in the border log, starting at its lexicographically smaller end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoggedEdge {
    pub(crate) ends: [VertexId; 2],
    pub(crate) points: [Point; 2],
    /// Why the edge is a constraint, seen from the first end to the second.
    pub(crate) source: LinePart,
}

/// A triangle that was settled by a merge: crossing, or late.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LateTriangle {
    /// In counter-clockwise order.
    pub(crate) corners: [SeamVertex; 3],
    /// The bits of the half-edges, in the layout of a triangulation with constraints.
    pub(crate) edge_bits: u8,
    /// The triangle's number, which the border log assigns.
    pub(crate) number: u32,
}

/// The chunks of a group, by kind of content.
pub(crate) type GroupChunks = [Vec<Extent>; KINDS];

/// Number of kinds of content of the border log: half-edges, triangles, edges, anchors.
pub(crate) const KINDS: usize = 4;

/// For collinear input: for a tile, the vertex of another tile to which an edge of the tile leads.
pub(crate) type Nexts = HashMap<TileId, SeamVertex>;
