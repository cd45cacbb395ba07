//! Notes that queries store beside a tile, for later queries.

use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;

use crate::geometry::VertexIndex;

/// The notes of a tile. They take no memory until the first query needs them.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    vertices: OnceLock<VertexNotes>,
    half_edges: OnceLock<HalfEdgeNotes>,
}

/// The notes on a tile's vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct VertexNotes {
    /// One byte per vertex.
    pub(crate) marks: Vec<u8>,
    /// For each vertex, the index of its corners in `ends`, or a number beyond the end of `ends` if
    /// it has none.
    pub(crate) ends_index: Vec<u32>,
    /// Two corners for each of some vertices.
    pub(crate) ends: Vec<[VertexIndex; 2]>,
    /// Whether any edge of the tile is a constraint but not a wall.
    pub(crate) has_break_lines: bool,
}

/// The notes on a tile's half-edges. Each is made when the first query needs it.
#[derive(Debug)]
pub(crate) struct HalfEdgeNotes {
    /// For each half-edge, its origin and the passage across it.
    pub(crate) half_edges: Vec<HalfEdgeNote>,
    /// The number of searches that visited the tile.
    pub(crate) visits: AtomicU32,
    /// Whether the notes say which half-edges lead into dead ends.
    pub(crate) knows_dead_ends: AtomicBool,
}

/// Two numbers for a half-edge, each of which may be absent. Several threads may store the same
/// number at once.
#[derive(Debug)]
pub(crate) struct HalfEdgeNote(
    /// The complements of both numbers, so that zeroed memory means that both are absent.
    AtomicU64,
);

/// Selects one of the two numbers of a half-edge.
#[derive(Clone, Copy, Debug)]
pub(crate) enum NoteKind {
    /// The corner at which the half-edge starts.
    Origin,
    /// The passage across the half-edge, as the query encodes it.
    Passage,
}

impl Notes {
    /// Returns the maximum size of the notes in bytes.
    pub(crate) fn byte_size(vertices: usize, half_edges: usize) -> usize {
        vertices * (size_of::<u8>() + size_of::<u32>() + size_of::<[VertexIndex; 2]>())
            + half_edges * size_of::<HalfEdgeNote>()
    }

    /// Returns the notes on the vertices. The first call creates them with `make`.
    pub(crate) fn vertices(&self, make: impl FnOnce() -> VertexNotes) -> &VertexNotes {
        self.vertices.get_or_init(make)
    }

    /// Returns the notes on the half-edges. The first call creates them for `count` half-edges.
    #[inline]
    pub(crate) fn half_edges(&self, count: u32) -> &HalfEdgeNotes {
        self.half_edges.get_or_init(|| HalfEdgeNotes {
            // The system provides zeroed pages on demand, and the conversion is free.
            half_edges: vec![0; count as usize]
                .into_iter()
                .map(|zero| HalfEdgeNote(AtomicU64::new(zero)))
                .collect(),
            visits: AtomicU32::new(0),
            knows_dead_ends: AtomicBool::new(false),
        })
    }
}

impl HalfEdgeNote {
    /// Stands for an absent number.
    pub(crate) const NONE: u32 = u32::MAX;

    #[inline]
    pub(crate) fn get(&self, which: NoteKind) -> u32 {
        !((self.0.load(Ordering::Relaxed) >> which.shift()) as u32)
    }

    /// Stores a number if it is absent. Returns the number that is stored then.
    pub(crate) fn note(&self, which: NoteKind, number: u32) -> u32 {
        let with = u64::from(!number) << which.shift();
        let is_new = |there: u64| ((there >> which.shift()) as u32 == 0).then_some(there | with);
        let noted = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, is_new);
        noted.map_or_else(|there| !((there >> which.shift()) as u32), |_| number)
    }

    /// Sets bits of a number that is present.
    pub(crate) fn set_bits(&self, which: NoteKind, bits: u32) {
        self.0.fetch_and(!(u64::from(bits) << which.shift()), Ordering::Relaxed);
    }
}

impl NoteKind {
    #[inline]
    fn shift(self) -> u32 {
        match self {
            Self::Origin => 0,
            Self::Passage => 32,
        }
    }
}
