//! Notes that queries store beside a tile, for later queries.
//!
//! A note is made when the first query needs it, so a query that touches a few hundred triangles of
//! a tile pays for these only. All notes of a tile together take at most about a sixth of its bytes.

use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::AtomicU8;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;

use crate::geometry::{HalfEdge, VertexIndex};

/// The notes of a tile. They take no memory until the first query needs them.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    vertices: OnceLock<VertexNotes>,
    half_edges: OnceLock<HalfEdgeNotes>,
    has_break_lines: OnceLock<bool>,
}

/// The notes on a tile's vertices: a mark for each, and two corners for some. Several threads may
/// note the same at once.
#[derive(Debug)]
pub(crate) struct VertexNotes {
    /// The marks, as the query encodes them; 0 if absent.
    marks: Box<[AtomicU8]>,
    /// Two corners for each vertex. There are none until the first vertex needs them.
    ends: OnceLock<Box<[AtomicU64]>>,
}

/// The notes on a tile's half-edges. Several threads may note the same at once.
#[derive(Debug)]
pub(crate) struct HalfEdgeNotes {
    /// Two bits for each half-edge.
    bits: Box<[AtomicU8]>,
    /// The number of triangles that searches passed in the tile, with repetitions.
    passed: AtomicU64,
    /// Whether a search computes the dead ends of the tile, or has computed them.
    finds_dead_ends: AtomicBool,
    /// Whether the notes say which half-edges lead into dead ends.
    pub(crate) knows_dead_ends: AtomicBool,
}

/// A note on a half-edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum HalfEdgeNote {
    /// Nothing is noted.
    None = 0,
    /// The half-edge agrees with its twin in the tile, and nothing blocks.
    Open = 1,
    /// The edge blocks, or what is beyond it is not free.
    Blocked = 2,
    /// As [`Open`](Self::Open), and the twin belongs to a dead end.
    DeadEnd = 3,
}

/// The number of notes in a byte.
const PER_BYTE: usize = 4;

impl Notes {
    /// Returns the maximum size of the notes in bytes. Only vertices with constraints have `ends`.
    pub(crate) fn byte_size(vertices: usize, half_edges: usize, has_constraints: bool) -> usize {
        let ends = if has_constraints { size_of::<AtomicU64>() } else { 0 };
        vertices * (size_of::<AtomicU8>() + ends) + half_edges.div_ceil(PER_BYTE)
    }

    /// Returns the notes on the vertices. The first call creates them for `count` vertices.
    #[inline]
    pub(crate) fn vertices(&self, count: u32) -> &VertexNotes {
        self.vertices.get_or_init(|| VertexNotes {
            // The conversion of the zeroed memory is free.
            marks: vec![0; count as usize].into_iter().map(AtomicU8::new).collect(),
            ends: OnceLock::new(),
        })
    }

    /// Returns the notes on the half-edges. The first call creates them for `count` half-edges.
    #[inline]
    pub(crate) fn half_edges(&self, count: u32) -> &HalfEdgeNotes {
        self.half_edges.get_or_init(|| HalfEdgeNotes {
            bits: vec![0; (count as usize).div_ceil(PER_BYTE)]
                .into_iter()
                .map(AtomicU8::new)
                .collect(),
            passed: AtomicU64::new(0),
            finds_dead_ends: AtomicBool::new(false),
            knows_dead_ends: AtomicBool::new(false),
        })
    }

    /// Returns whether the tile has break lines. The first call finds it with `find`.
    pub(crate) fn has_break_lines(&self, find: impl FnOnce() -> bool) -> bool {
        *self.has_break_lines.get_or_init(find)
    }
}

impl VertexNotes {
    /// Returns the mark of a vertex, 0 if it is absent, or `None` if the tile has no such vertex.
    #[inline]
    pub(crate) fn mark(&self, vertex: VertexIndex) -> Option<u8> {
        let mark = self.marks.get(vertex.index())?;
        // With the mark, the ends become visible.
        Some(mark.load(Ordering::Acquire))
    }

    /// Notes the mark of a vertex, and the corners if it has any.
    pub(crate) fn note(&self, vertex: VertexIndex, mark: u8, ends: Option<[VertexIndex; 2]>) {
        if let Some([first, second]) = ends {
            let all = self.ends.get_or_init(|| {
                let zeros = vec![0; self.marks.len()];
                zeros.into_iter().map(AtomicU64::new).collect()
            });
            // The complement, so that zeroed memory means that there are none.
            let ends = !(u64::from(first.0) << 32 | u64::from(second.0));
            all[vertex.index()].store(ends, Ordering::Relaxed);
        }
        self.marks[vertex.index()].store(mark, Ordering::Release);
    }

    /// Returns the corners of a vertex whose mark is present, if it has any.
    #[inline]
    pub(crate) fn ends(&self, vertex: VertexIndex) -> Option<[VertexIndex; 2]> {
        let ends = self.ends.get()?[vertex.index()].load(Ordering::Relaxed);
        (ends != 0).then(|| [(!ends >> 32) as u32, !ends as u32].map(VertexIndex))
    }
}

impl HalfEdgeNotes {
    #[inline]
    pub(crate) fn get(&self, half_edge: HalfEdge) -> HalfEdgeNote {
        let (byte, shift) = place(half_edge);
        match self.bits[byte].load(Ordering::Relaxed) >> shift & 3 {
            0 => HalfEdgeNote::None,
            1 => HalfEdgeNote::Open,
            2 => HalfEdgeNote::Blocked,
            _ => HalfEdgeNote::DeadEnd,
        }
    }

    /// Stores a note. An open half-edge may become one that leads into a dead end, and else all
    /// notes on a half-edge are the same.
    pub(crate) fn note(&self, half_edge: HalfEdge, note: HalfEdgeNote) {
        let (byte, shift) = place(half_edge);
        self.bits[byte].fetch_or((note as u8) << shift, Ordering::Relaxed);
    }

    /// Counts triangles that a search passed.
    pub(crate) fn count_passed(&self, triangles: u32) {
        self.passed.fetch_add(triangles.into(), Ordering::Relaxed);
    }

    /// Returns whether the caller has to compute the dead ends, because searches passed at least so
    /// many triangles. This is true only once.
    pub(crate) fn is_time_for_dead_ends(&self, least: u64) -> bool {
        self.passed.load(Ordering::Relaxed) >= least && !self.finds_dead_ends.swap(true, Ordering::Relaxed)
    }
}

/// Returns the byte with the note on a half-edge, and the position of the note in the byte.
#[inline]
fn place(half_edge: HalfEdge) -> (usize, usize) {
    let index = half_edge.index();
    (index / PER_BYTE, index % PER_BYTE * 2)
}
