//! Which half-edges of a tile are on constraints and walls, and the sources of these edges.

use bytes::Bytes;
use flatbuffers::Vector;

use crate::store::format::damage::Damage;
use crate::store::format::edge_source::EdgeSource;
use crate::store::format::generated::tile as schema;
use crate::store::format::line_part::LinePart;
use crate::store::format::packed::{Packed, partition_point};

/// Bits of the half-edges of a core or a border: which are on constraints, and which of those are
/// on walls.
#[derive(Clone)]
pub(crate) struct HalfEdgeBits {
    /// Empty if no bit is set, like `walls`.
    constraints: Bytes,
    walls: Bytes,
}

impl HalfEdgeBits {
    /// Opens the bits of `half_edges` half-edges in a verified buffer.
    pub(crate) fn open(
        buffer: &Bytes,
        constraints: Option<Vector<'_, u8>>,
        walls: Option<Vector<'_, u8>>,
        half_edges: usize,
    ) -> Result<Self, Damage> {
        let open = |bits: Option<Vector<'_, u8>>| bits.map_or_else(Bytes::new, |bits| buffer.slice_ref(bits.bytes()));
        let this = Self {
            constraints: open(constraints),
            walls: open(walls),
        };
        let expected = half_edges.div_ceil(8);
        for (what, bits) in [("constraints", &this.constraints), ("walls", &this.walls)] {
            if !bits.is_empty() && bits.len() != expected {
                return Err(Damage::new(format!(
                    "there are {} bytes of {what}, not {expected}",
                    bits.len()
                )));
            }
        }
        let constraints = this.constraints.iter().chain(std::iter::repeat(&0));
        if this.walls.iter().zip(constraints).any(|(wall, one)| wall & !one != 0) {
            return Err(Damage::new("a wall is no constraint"));
        }
        Ok(this)
    }

    pub(crate) fn is_constraint(&self, half_edge: usize) -> bool {
        is_set(&self.constraints, half_edge)
    }

    pub(crate) fn is_wall(&self, half_edge: usize) -> bool {
        is_set(&self.walls, half_edge)
    }

    /// Returns the bits of each of `count` triangles: three for constraints, and three for walls from bit
    /// `walls` on.
    pub(crate) fn of_triangles(&self, count: usize, walls: u32) -> impl Iterator<Item = u8> {
        let three = |bits: &[u8], triangle: usize| {
            (0..3).fold(0, |all, corner| {
                all | u8::from(is_set(bits, 3 * triangle + corner)) << corner
            })
        };
        let any = self.any();
        (0..count).map(move |triangle| match any {
            true => three(&self.constraints, triangle) | three(&self.walls, triangle) << walls,
            false => 0,
        })
    }

    /// Returns whether any half-edge may be on a constraint.
    pub(crate) fn any(&self) -> bool {
        !self.constraints.is_empty()
    }

    pub(crate) fn byte_size(&self) -> usize {
        self.constraints.len() + self.walls.len()
    }
}

/// Returns whether a bit is set. Bits beyond the end are not set.
pub(crate) fn is_set(bits: &[u8], index: usize) -> bool {
    bits.get(index / 8).is_some_and(|byte| byte >> (index % 8) & 1 == 1)
}

/// The sources of edges. The key of an edge is the number of one of its half-edges; in a file
/// without triangles, it is the index of the edge.
#[derive(Clone)]
pub(crate) struct EdgeSources {
    keys: Packed,
    sources: Packed,
    /// Two bits for each source: whether a segment of the line begins, and ends, with the edge.
    /// `None` if all bits are set.
    segment_ends: Option<Bytes>,
}

impl EdgeSources {
    /// Opens the sources in a verified buffer. Keys must be below `limit`.
    pub(crate) fn open(
        buffer: &Bytes,
        keys: Option<schema::Packed<'_>>,
        sources: Option<schema::Packed<'_>>,
        segment_ends: Option<Vector<'_, u8>>,
        limit: usize,
    ) -> Result<Option<Self>, Damage> {
        let (keys, sources) = match (keys, sources) {
            (None, None) if segment_ends.is_some() => {
                return Err(Damage::new("there are ends of segments, but no sources"));
            }
            (None, None) => return Ok(None),
            (Some(keys), Some(sources)) => (Packed::open(buffer, keys)?, Packed::open(buffer, sources)?),
            _ => return Err(Damage::new("edges lack their sources, or sources their edges")),
        };
        if keys.len() != sources.len() {
            return Err(Damage::new(format!(
                "{} edges have {} sources",
                keys.len(),
                sources.len()
            )));
        }
        if !keys.iter().zip(sources.iter()).is_sorted() || keys.iter().any(|key| key >= limit as u64) {
            return Err(Damage::new("an edge with a source is out of range or out of order"));
        }
        let is_too_large = |source: u64| source > EdgeSource::MAX_BITS;
        if is_too_large(sources.largest()) && sources.iter().any(is_too_large) {
            return Err(Damage::new("the number of a line is too large"));
        }
        let segment_ends = segment_ends.map(|bits| buffer.slice_ref(bits.bytes()));
        let expected = sources.len().div_ceil(4);
        let found = segment_ends.as_ref().map_or(expected, Bytes::len);
        if found != expected {
            return Err(Damage::new(format!(
                "there are {found} bytes of ends of segments, not {expected}"
            )));
        }
        Ok(Some(Self {
            keys,
            sources,
            segment_ends,
        }))
    }

    /// Returns the sources of the edge with this key, as parts of their lines.
    pub(crate) fn of(&self, key: u32) -> impl Iterator<Item = LinePart> {
        let key = u64::from(key);
        let first = partition_point(self.keys.len(), |index| self.keys.get(index) < key);
        (first..self.keys.len())
            .take_while(move |&index| self.keys.get(index) == key)
            .map(|index| self.part(index))
    }

    fn part(&self, index: usize) -> LinePart {
        let source = EdgeSource::from_bits(self.sources.get(index));
        let Some(bits) = &self.segment_ends else {
            return LinePart::whole(source);
        };
        let [begins, ends] = [2 * index, 2 * index + 1].map(|bit| is_set(bits, bit));
        LinePart::of(source, begins, ends)
    }

    /// Returns the number of edges that have sources.
    pub(crate) fn edge_count(&self) -> usize {
        let starts = (0..self.keys.len()).filter(|&i| i == 0 || self.keys.get(i - 1) != self.keys.get(i));
        starts.count()
    }

    pub(crate) fn byte_size(&self) -> usize {
        self.keys.byte_size() + self.sources.byte_size() + self.segment_ends.as_ref().map_or(0, Bytes::len)
    }
}
