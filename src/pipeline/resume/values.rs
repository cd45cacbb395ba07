//! How the values of a build are stored in its work files.

use crate::constraints::polygons::check::{Inverted, InvertedPolygons, Overlapping};
use crate::constraints::polygons::repair::PolygonRepair;
use crate::constraints::segment::Segment;
use crate::geometry::{Point, Rect, VertexIndex};
use crate::input::SiteId;
use crate::pipeline::context::Given;
use crate::pipeline::ingest::drape::Draping;
use crate::pipeline::plan::{Block, BlockPlan, HeldLimits, NodeLimits, Run};
use crate::pipeline::records::{
    BlockState, Deferred, Description, Draped, OpenSegment, Pending, Seam, SeamVertex, Subsegment, TileState,
};
use crate::pipeline::resume::codec::{Stored, stored};
use crate::pipeline::summary::LevelSummary;
use crate::store::{
    Codec, Digest, DigestSum, Extent, KdNode, KdTree, LineKind, LinePart, LineSource, PolygonLine, Source, TileId,
    VertexId,
};
use crate::terrain::{Corner, Outline, Ponds};

stored! {
    Point { x, y }
    Rect { min_x, min_y, max_x, max_y }
    Corner { point, z }
    TileId { 0 }
    VertexIndex { 0 }
    VertexId { tile, index }
    Source { name, records, first }
    LineSource { name, kind, first, lines, edit }
    PolygonLine { line, polygon }
    Inverted { obstacle, point }
    InvertedPolygons { first, polygons }
    Overlapping { obstacle, point }
    PolygonRepair { inverted, parts, changes }
    Segment { ends, source }
    Description { sources, lines, crs, memo }
    Given {
        points, has_z, next_record, description, has_obstacles, seeds, first_crossing, first_site, site_ids,
        site_count, crossings, borders, split_points, inverted_if_uncrossed, overlapping_if_uncrossed,
        polygon_lines, repair,
    }
    Draping { first_lacking, first_end, outline, ponds }
    Run { number, points, length }
    Block { points, runs }
    HeldLimits { in_leaf, in_node }
    NodeLimits { merge_vertices, held }
    LevelSummary { nodes, vertices, settled, seam_vertices }
    Draped { vertices, outside, flattened }
    TileState {
        vertices, core_triangles, border_triangles, owned_triangles, bounds, constraint_edges, components,
        open_components, core_sum,
    }
    BlockState {
        first_tile, tree, tiles, duplicates, ends, late_triangles, held_triangles, levels, digest, seeded,
        with_sites, without_z, draped,
    }
    SeamVertex { id, point, z }
    Subsegment { ends, source }
    OpenSegment { segment, run }
    Deferred { 0 }
    Pending { vertices, held, subsegments, open, deferred }
    Seam { vertices, unsettled, level, below, pending }
}

/// Stores values as the numbers that stand for them.
macro_rules! stored_as {
    ($($value:ty: $to:ident, $from:ident;)*) => {$(
        impl Stored for $value {
            fn put(&self, out: &mut Vec<u8>) {
                self.$to().put(out);
            }

            fn take(from: &mut &[u8]) -> Option<Self> {
                Stored::take(from).map(Self::$from)
            }
        }
    )*};
}

stored_as! {
    DigestSum: to_words, from_words;
    Digest: to_words, from_words;
    LinePart: to_bits, from_bits;
}

impl Stored for LineKind {
    fn put(&self, out: &mut Vec<u8>) {
        self.to_code().put(out);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        Self::from_code(u8::take(from)?)
    }
}

impl Stored for SiteId {
    fn put(&self, out: &mut Vec<u8>) {
        match self {
            Self::Number(number) => (0u8, *number).put(out),
            Self::Text(text) => {
                1u8.put(out);
                text.put(out);
            }
        }
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        match u8::take(from)? {
            0 => Stored::take(from).map(Self::Number),
            1 => Stored::take(from).map(Self::Text),
            _ => None,
        }
    }
}

impl Stored for Extent {
    fn put(&self, out: &mut Vec<u8>) {
        (self.offset, (self.length, self.crc)).put(out);
        (self.codec.number(), self.decoded).put(out);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let (offset, (length, crc)) = Stored::take(from)?;
        let (codec, decoded) = Stored::take(from)?;
        Some(Self {
            offset,
            length,
            crc,
            codec: Codec::of_number(codec)?,
            decoded,
        })
    }
}

impl Stored for KdNode {
    fn put(&self, out: &mut Vec<u8>) {
        match *self {
            Self::X { cut, right } => (0u8, (cut, right)).put(out),
            Self::Y { cut, right } => (1u8, (cut, right)).put(out),
            Self::Leaf(tile) => (2u8, tile).put(out),
        }
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let kind = u8::take(from)?;
        if kind == 2 {
            return Stored::take(from).map(Self::Leaf);
        }
        let (cut, right) = Stored::take(from)?;
        match kind {
            0 => Some(Self::X { cut, right }),
            1 => Some(Self::Y { cut, right }),
            _ => None,
        }
    }
}

impl Stored for KdTree {
    fn put(&self, out: &mut Vec<u8>) {
        self.nodes().to_vec().put(out);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        Self::new(Stored::take(from)?).ok()
    }
}

/// Without the bytes that the interrupted build moved.
impl Stored for BlockPlan {
    fn put(&self, out: &mut Vec<u8>) {
        self.tree.put(out);
        self.blocks.put(out);
        (self.points, (self.merged, self.has_z)).put(out);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let (tree, blocks) = Stored::take(from)?;
        let (points, (merged, has_z)) = Stored::take(from)?;
        Some(Self {
            tree,
            blocks,
            points,
            merged,
            has_z,
            ..Self::default()
        })
    }
}

impl Stored for Outline {
    fn put(&self, out: &mut Vec<u8>) {
        let edges = self.edges().iter().map(|&[from, to]| (from, to));
        edges.collect::<Vec<_>>().put(out);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let edges: Vec<(Corner, Corner)> = Stored::take(from)?;
        Some(Self::of_edges(edges.into_iter().map(|(from, to)| [from, to]).collect()))
    }
}

impl Stored for Ponds {
    fn put(&self, out: &mut Vec<u8>) {
        self.shores().put(out);
        self.pond_of_edges().to_vec().put(out);
        self.levels().to_vec().put(out);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let (edges, pond_of) = Stored::take(from)?;
        Self::of_parts(edges, pond_of, Stored::take(from)?)
    }
}
