//! What queries note of a tile beside it, for those that come after them.

use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;

use crate::geometry::VertexIndex;

/// What queries note of a tile. It takes no memory before the first query asks.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    marks: OnceLock<VertexNotes>,
    sides: OnceLock<HalfEdgeNotes>,
}

/// What queries note of a tile's vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct VertexNotes {
    /// A byte for each.
    pub(crate) of_vertices: Vec<u8>,
    /// For each, the place in `ends` of what is noted there of it, or a number beyond.
    pub(crate) place: Vec<u32>,
    /// Two corners for some of them.
    pub(crate) ends: Vec<[VertexIndex; 2]>,
    /// Whether a side is a constraint that does not block.
    pub(crate) has_break_lines: bool,
}

/// What queries note of a tile's sides, each when the first one comes to it.
#[derive(Debug)]
pub(crate) struct HalfEdgeNotes {
    /// The corner that each starts at, and what lies beyond it.
    pub(crate) of_sides: Vec<HalfEdgeNote>,
    /// How many searches came to the tile.
    pub(crate) visits: AtomicU32,
    /// Whether it is noted where dead ends begin.
    pub(crate) knows_dead_ends: AtomicBool,
}

/// Two numbers for a side, or none. Searches in several threads may note the same at once.
#[derive(Debug)]
pub(crate) struct HalfEdgeNote(
    /// The complements of both, so that memory of zeros has none.
    AtomicU64,
);

/// Which number of a side.
#[derive(Clone, Copy, Debug)]
pub(crate) enum NoteKind {
    /// The corner that it starts at.
    Corner,
    /// What lies beyond it.
    Beyond,
}

impl Notes {
    /// Bytes that the notes take at most.
    pub(crate) fn byte_size(vertices: usize, sides: usize) -> usize {
        vertices * (size_of::<u8>() + size_of::<u32>() + size_of::<[VertexIndex; 2]>()) + sides * size_of::<HalfEdgeNote>()
    }

    /// What is noted of the vertices, made when it is first asked for.
    pub(crate) fn marks(&self, make: impl FnOnce() -> VertexNotes) -> &VertexNotes {
        self.marks.get_or_init(make)
    }

    /// What is noted of the sides, of which there are so many.
    #[inline]
    pub(crate) fn sides(&self, count: u32) -> &HalfEdgeNotes {
        self.sides.get_or_init(|| HalfEdgeNotes {
            // Zeros come from the system as they are needed, and the conversion costs nothing.
            of_sides: vec![0; count as usize]
                .into_iter()
                .map(|zero| HalfEdgeNote(AtomicU64::new(zero)))
                .collect(),
            visits: AtomicU32::new(0),
            knows_dead_ends: AtomicBool::new(false),
        })
    }
}

impl HalfEdgeNote {
    /// In place of a number: there is none.
    pub(crate) const NONE: u32 = u32::MAX;

    #[inline]
    pub(crate) fn get(&self, which: NoteKind) -> u32 {
        !((self.0.load(Ordering::Relaxed) >> which.shift()) as u32)
    }

    /// Notes a number where there is none, and tells which one there is then.
    pub(crate) fn note(&self, which: NoteKind, number: u32) -> u32 {
        let with = u64::from(!number) << which.shift();
        let is_new = |there: u64| ((there >> which.shift()) as u32 == 0).then_some(there | with);
        let noted = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, is_new);
        noted.map_or_else(|there| !((there >> which.shift()) as u32), |_| number)
    }

    /// Sets bits of a number that there is.
    pub(crate) fn set_bits(&self, which: NoteKind, bits: u32) {
        self.0.fetch_and(!(u64::from(bits) << which.shift()), Ordering::Relaxed);
    }
}

impl NoteKind {
    #[inline]
    fn shift(self) -> u32 {
        match self {
            Self::Corner => 0,
            Self::Beyond => 32,
        }
    }
}
