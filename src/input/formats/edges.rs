//! The edges of faces: triangles, and rings of any number of corners.
//!
//! In: the corners of one face after another. Out: pairs of record numbers. An edge between two
//! faces comes from both of them; the second time it is left out. The edges seen last are
//! remembered in a table of fixed size, so an edge whose faces are far apart in the file may come
//! twice. A build counts it as two lines on one edge, with the same triangles.

use crate::collections::mix::Mix;
use crate::input::error::{InputError, Location, RecordKind};
use crate::input::flaw::Flaw;
use crate::input::lines::{LineTally, SegmentBatch};
use crate::input::reader::Sink;
use std::hash::Hasher;
use std::ops::RangeInclusive;

/// The number of edges that are remembered, a power of 2. They take 1 MiB.
const REMEMBERED: usize = 1 << 16;

/// No edge: an edge has its smaller end first, and never two equal ends.
const NONE: [u64; 2] = [0, 0];

/// The faces of a file, one at a time.
pub struct Faces {
    /// The numbers that points have in the file.
    points: RangeInclusive<u64>,
    has_points: bool,
    /// The corners of the current face, as record numbers, and the number of its edges to come.
    corners: Vec<u64>,
    left: usize,
    /// Whether the last corner is joined to the first.
    is_closed: bool,
    /// The number of faces so far.
    faces: u64,
    seen: Box<[[u64; 2]]>,
}

impl Faces {
    /// Takes faces whose corners are among `count` points, which are numbered from `base` on.
    pub fn new(base: u64, count: u64) -> Self {
        Self {
            points: base..=base.saturating_add(count.saturating_sub(1)),
            has_points: count > 0,
            corners: Vec::new(),
            left: 0,
            is_closed: true,
            faces: 0,
            seen: vec![NONE; REMEMBERED].into_boxed_slice(),
        }
    }

    /// Takes a face by the numbers of its corners.
    pub fn face(&mut self, corners: impl IntoIterator<Item = u64>) -> Result<(), Flaw> {
        self.take(corners, true)
    }

    /// Takes a line by the numbers of its vertices.
    pub fn line(&mut self, corners: impl IntoIterator<Item = u64>) -> Result<(), Flaw> {
        self.take(corners, false)
    }

    fn take(&mut self, corners: impl IntoIterator<Item = u64>, is_closed: bool) -> Result<(), Flaw> {
        self.corners.clear();
        self.is_closed = is_closed;
        for index in corners {
            if !self.has_points {
                return Err(Flaw::NoPoints { index });
            }
            let (&first, &last) = (self.points.start(), self.points.end());
            if !self.points.contains(&index) {
                return Err(Flaw::NoSuchPoint { index, first, last });
            }
            self.corners.push(index - first);
        }
        // Two corners have one edge, there and back.
        self.left = match self.corners.len() {
            n @ 3.. if is_closed => n,
            n => n.saturating_sub(1),
        };
        self.faces += 1;
        Ok(())
    }

    /// Passes edges of the current face on. Returns false if the batch is full before the last one.
    pub fn drain(&mut self, sink: &mut Sink<'_, SegmentBatch>) -> bool {
        while self.left > 0 {
            if sink.is_full() {
                return false;
            }
            self.left -= 1;
            let next = (self.left + 1) % self.corners.len();
            let edge = [self.corners[self.left], self.corners[next]];
            if self.is_new(edge) {
                sink.pair(edge, self.faces - 1);
            }
        }
        true
    }

    /// Returns whether an edge is none of those seen last, and remembers it.
    fn is_new(&mut self, [a, b]: [u64; 2]) -> bool {
        let edge = [a.min(b), a.max(b)];
        if a == b {
            return false;
        }
        let mut hash = Mix::default();
        edge.iter().for_each(|&end| hash.write_u64(end));
        let place = &mut self.seen[(hash.finish() >> 32) as usize % REMEMBERED];
        match *place == edge {
            // A third face would be no part of a triangulation, and its edge may come again.
            true => *place = NONE,
            false => *place = edge,
        }
        *place == edge
    }

    pub fn tally(&self) -> LineTally {
        LineTally {
            lines: self.faces,
            polygons: 0,
        }
    }

    /// Returns the error of the face that comes next.
    pub fn wrong(&self, sink: &Sink<'_, SegmentBatch>, location: Location, flaw: &Flaw) -> InputError {
        sink.wrong(RecordKind::Face, self.faces, location, flaw)
    }
}
