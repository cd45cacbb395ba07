//! What queries note of a tile beside it, for those that come after them.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// What queries note of a tile. It takes no memory before the first query asks.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    marks: OnceLock<Marks>,
    sides: OnceLock<NotedSides>,
}

/// What queries note of a tile's vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct Marks {
    /// A byte for each.
    pub(crate) of_vertices: Vec<u8>,
    /// For each, the place in `ends` of what is noted there of it, or a number beyond.
    pub(crate) place: Vec<u32>,
    /// Two corners for some of them.
    pub(crate) ends: Vec<[u32; 2]>,
    /// Whether a side is a constraint that does not block.
    pub(crate) has_break_lines: bool,
}

/// What queries note of a tile's sides, each when the first one comes to it.
#[derive(Debug)]
pub(crate) struct NotedSides {
    /// The corner that each starts at.
    pub(crate) corners: Noted,
    /// What lies beyond each.
    pub(crate) beyond: Noted,
    /// How many searches came to the tile.
    pub(crate) visits: AtomicU32,
    /// Whether it is noted where dead ends begin.
    pub(crate) knows_dead_ends: AtomicBool,
}

/// A number for each side, or none. Searches in several threads may note the same at once.
#[derive(Debug)]
pub(crate) struct Noted(
    /// The complement of each, so that memory of zeros has none.
    Vec<AtomicU32>,
);

impl Notes {
    /// Bytes that the notes take at most.
    pub(crate) fn byte_size(vertices: usize, sides: usize) -> usize {
        vertices * (size_of::<u8>() + size_of::<u32>() + size_of::<[u32; 2]>()) + sides * 2 * size_of::<u32>()
    }

    /// What is noted of the vertices, made when it is first asked for.
    pub(crate) fn marks(&self, make: impl FnOnce() -> Marks) -> &Marks {
        self.marks.get_or_init(make)
    }

    /// What is noted of the sides, of which there are so many.
    #[inline]
    pub(crate) fn sides(&self, count: u32) -> &NotedSides {
        self.sides.get_or_init(|| NotedSides {
            corners: Noted::none(count),
            beyond: Noted::none(count),
            visits: AtomicU32::new(0),
            knows_dead_ends: AtomicBool::new(false),
        })
    }
}

impl Noted {
    /// In place of a number: there is none.
    pub(crate) const NONE: u32 = u32::MAX;

    fn none(count: u32) -> Self {
        // Zeros come from the system as they are needed, and the conversion costs nothing.
        Self(vec![0; count as usize].into_iter().map(AtomicU32::new).collect())
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    #[inline]
    pub(crate) fn get(&self, side: u32) -> u32 {
        !self.0[side as usize].load(Ordering::Relaxed)
    }

    /// Notes a number where there is none, and tells which one there is then.
    pub(crate) fn note(&self, side: u32, number: u32) -> u32 {
        let noted = self.0[side as usize].compare_exchange(0, !number, Ordering::Relaxed, Ordering::Relaxed);
        noted.map_or_else(|there| !there, |_| number)
    }

    /// Sets bits of a number that there is.
    pub(crate) fn set_bits(&self, side: u32, bits: u32) {
        self.0[side as usize].fetch_and(!bits, Ordering::Relaxed);
    }
}
