//! What the edges of a tile are: constraints and walls, bit by bit, and the lines that made them so.

use bytes::Bytes;
use flatbuffers::Vector;

use crate::store::format::damage::Damage;
use crate::store::format::edge_source::EdgeSource;
use crate::store::format::generated::tile as schema;
use crate::store::format::packed::{Packed, partition_point};

/// Bits of the sides of a core or a border: which are on constraints, and which of them on walls.
#[derive(Clone)]
pub(crate) struct SideBits {
    /// Empty if there is none.
    constraints: Bytes,
    walls: Bytes,
}

impl SideBits {
    /// Takes the bits of so many sides from a verified buffer.
    pub(crate) fn open(
        buffer: &Bytes,
        constraints: Option<Vector<'_, u8>>,
        walls: Option<Vector<'_, u8>>,
        sides: usize,
    ) -> Result<Self, Damage> {
        let open = |bits: Option<Vector<'_, u8>>| bits.map_or_else(Bytes::new, |bits| buffer.slice_ref(bits.bytes()));
        let this = Self {
            constraints: open(constraints),
            walls: open(walls),
        };
        let expected = sides.div_ceil(8);
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

    pub(crate) fn is_constraint(&self, side: usize) -> bool {
        is_set(&self.constraints, side)
    }

    pub(crate) fn is_wall(&self, side: usize) -> bool {
        is_set(&self.walls, side)
    }

    /// Whether any side may be on a constraint.
    pub(crate) fn any(&self) -> bool {
        !self.constraints.is_empty()
    }

    pub(crate) fn byte_size(&self) -> usize {
        self.constraints.len() + self.walls.len()
    }
}

/// Whether a bit is set; those beyond the end are not.
pub(crate) fn is_set(bits: &[u8], place: usize) -> bool {
    bits.get(place / 8).is_some_and(|byte| byte >> (place % 8) & 1 == 1)
}

/// The sources of edges, by one side of each.
#[derive(Clone)]
pub(crate) struct Sources {
    sides: Packed,
    sources: Packed,
}

impl Sources {
    /// Takes them from a verified buffer; sides are below `limit`.
    pub(crate) fn open(
        buffer: &Bytes,
        sides: Option<schema::Packed<'_>>,
        sources: Option<schema::Packed<'_>>,
        limit: usize,
    ) -> Result<Option<Self>, Damage> {
        let (sides, sources) = match (sides, sources) {
            (None, None) => return Ok(None),
            (Some(sides), Some(sources)) => (Packed::open(buffer, sides)?, Packed::open(buffer, sources)?),
            _ => return Err(Damage::new("edges lack their sources, or sources their edges")),
        };
        if sides.len() != sources.len() {
            return Err(Damage::new(format!(
                "{} edges have {} sources",
                sides.len(),
                sources.len()
            )));
        }
        if !sides.iter().zip(sources.iter()).is_sorted() || sides.iter().any(|side| side >= limit as u64) {
            return Err(Damage::new("an edge with a source is out of range or out of order"));
        }
        Ok(Some(Self { sides, sources }))
    }

    /// The sources of the edge that is entered under this side.
    pub(crate) fn of(&self, side: u32) -> impl Iterator<Item = EdgeSource> {
        let side = u64::from(side);
        let first = partition_point(self.sides.len(), |place| self.sides.get(place) < side);
        (first..self.sides.len())
            .take_while(move |&place| self.sides.get(place) == side)
            .map(|place| EdgeSource::from_bits(self.sources.get(place)))
    }

    /// How many edges have sources.
    pub(crate) fn edge_count(&self) -> usize {
        let starts = (0..self.sides.len()).filter(|&i| i == 0 || self.sides.get(i - 1) != self.sides.get(i));
        starts.count()
    }

    pub(crate) fn byte_size(&self) -> usize {
        self.sides.byte_size() + self.sources.byte_size()
    }
}
