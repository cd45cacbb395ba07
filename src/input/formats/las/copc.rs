//! The octree of a COPC file, and the choice of its nodes by level and rectangle.
//!
//! In: the COPC record of the header, the chunk table of the points, and [`InputOptions`]. Out: the
//! nodes to read, in the order of the file. Source: COPC specification 1.0.
//!
//! Each node of the octree with points has one chunk of the LAZ file. The cube of a node contains
//! its points, and the levels above it have a sample of the points around.
//!
//! ```text
//!   header | COPC record | ... | chunk | chunk | ... | chunk table | page | page | ...
//!   COPC record:  f64 centre x, y, z; half the root's side; spacing | u64 root page: offset, bytes | ...
//!   page:         entries of 32 bytes, one per node
//!   entry:        i32 level, x, y, z | u64 offset | i32 bytes | i32 points
//!   points:       0: none;  -1: offset and bytes are those of another page
//! ```
//!
//! All pages are read, although few may be needed: 32 bytes per node are little beside its points,
//! and only so it is known that no node is missing. The pages must not overlap, and each chunk must
//! be the one of exactly one node. This bounds time and memory by the size of the file, and a page
//! that refers to itself is an error.

use crate::geometry::{Point, Rect};
use crate::input::error::NOT_COPC;
use crate::input::formats::las::layout::Layout;
use crate::input::formats::las::problem::{FileReader, Problem, trimmed};
use crate::input::options::InputOptions;
use ::las::raw::Vlr;
use laz::laszip::ChunkTableEntry;
use std::collections::BTreeMap;
use std::io;
use std::io::{Read, Seek};

/// The name and the number of the COPC record.
const USER_ID: &[u8] = b"copc";
const RECORD_ID: u16 = 1;

/// The length of an entry of a page, in bytes.
const ENTRY: u64 = 32;

/// The deepest level at which an i32 can number the nodes along an axis.
const DEEPEST: i32 = 31;

/// The limit on the relative rounding error of a cube's borders: five operations of 2^-53 on numbers
/// of at most three times the magnitude, and as much again in the program that wrote the file.
const ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

const STALE: &str = "the file is damaged, or was changed by a program that does not know COPC";

/// A node to read.
pub struct Node {
    /// The offset and the length of its chunk, in bytes.
    pub offset: u64,
    pub bytes: u64,
    /// The number of its points, and of those between the node before it and this one.
    pub points: u64,
    pub skipped: u64,
    /// Contains its points. The whole plane if no node was left out because of its place.
    pub bounds: Rect,
}

/// The choice of nodes, before the pages are read.
pub struct Choice {
    /// The root page: offset and bytes.
    root: (u64, u64),
    /// The length of a point's record, in bytes.
    record: u64,
    centre: [f64; 2],
    half: f64,
    /// The distance up to which the points of a node may lie beyond its cube.
    slack: [f64; 2],
    deepest: i32,
    bounds: Option<Rect>,
}

/// Returns whether this is the record of the header that makes a LAZ file a COPC file.
pub fn is_info(record: &Vlr) -> bool {
    record.record_id == RECORD_ID && trimmed(&record.user_id) == USER_ID
}

impl Choice {
    /// Returns the choice that the options make; `None` if they exclude no node, or if the file is
    /// not COPC and they do not require that it is.
    pub fn new(
        records: &[Vlr],
        compressed: bool,
        layout: &Layout,
        options: &InputOptions,
    ) -> Result<Option<Self>, Problem> {
        let Some(record) = records.iter().find(|record| compressed && is_info(record)) else {
            return match options.selects_levels() {
                true => Err(no_copc()),
                false => Ok(None),
            };
        };
        if !options.selects_levels() && options.bounds.is_none() {
            return Ok(None);
        }
        let (numbers, _) = record.data.as_chunks::<8>();
        let &[x, y, _, half, spacing, offset, bytes, ..] = numbers else {
            let length = record.data.len();
            return Err(stale(format!("the COPC record has {length} of at least 56 bytes")));
        };
        let [x, y, half, spacing] = [x, y, half, spacing].map(f64::from_le_bytes);
        let is_sound = [x, y, half].iter().all(|number| number.abs() <= Point::MAX_MAGNITUDE);
        if !is_sound || half <= 0.0 {
            return Err(stale(format!(
                "the COPC record has an octree around {x}, {y} with half a side of {half}"
            )));
        }
        let slack = |axis: usize, centre: f64| layout.step(axis) + (centre.abs() + half) * ROUNDING;
        Ok(Some(Self {
            root: (u64::from_le_bytes(offset), u64::from_le_bytes(bytes)),
            record: layout.length as u64,
            centre: [x, y],
            half,
            slack: [slack(0, x), slack(1, y)],
            deepest: deepest(options, spacing)?,
            bounds: options.bounds,
        }))
    }

    /// Reads all pages, and returns the nodes to read in the order of the file; `None` if these are
    /// all. `start` is the offset of the first chunk, and `count` the number of points.
    pub fn nodes(
        &self,
        file: &mut FileReader,
        size: u64,
        start: u64,
        table: &[ChunkTableEntry],
        count: u64,
    ) -> Result<Option<Vec<Node>>, Problem> {
        let mut walk = Walk {
            size,
            chunks: self.chunks(start, table, size, count)?,
            pages: BTreeMap::new(),
            left: BTreeMap::new(),
        };
        let mut chosen = Vec::new();
        walk.add_page(self.root, "the COPC record")?;
        let mut position = file.stream_position().map_err(|error| unreadable(0, error))?;
        while let Some((offset, end)) = walk.next_page(position) {
            // Pages are often neighbours. This keeps what is in the buffer.
            file.seek_relative(offset.cast_signed() - position.cast_signed())
                .map_err(|error| unreadable(offset, error))?;
            position = end;
            for at in (offset..end).step_by(ENTRY as usize) {
                let entry = Entry::read(file).map_err(|error| unreadable(at, error))?;
                if let Some(chunk) = walk.take(&entry, at)?
                    && self.chooses(entry.key)
                {
                    chosen.push((chunk, entry.key));
                }
            }
        }
        if let Some(chunk) = walk.chunks.iter().find(|chunk| !chunk.is_known) {
            return Err(stale(format!(
                "no node of the octree has the chunk of points at byte {}",
                chunk.offset
            )));
        }
        if chosen.len() == walk.chunks.len() {
            return Ok(None);
        }
        chosen.sort_unstable_by_key(|(chunk, _)| *chunk);
        let mut end = 0;
        let nodes = chosen.into_iter().map(|(chunk, key)| {
            let chunk = &walk.chunks[chunk];
            let skipped = chunk.first - end;
            end = chunk.first + chunk.points;
            Node {
                offset: chunk.offset,
                bytes: chunk.bytes,
                points: chunk.points,
                skipped,
                bounds: self.node_bounds(key),
            }
        });
        Ok(Some(nodes.collect()))
    }

    /// Returns the chunks. They must be within the file, and have `count` points.
    fn chunks(&self, start: u64, table: &[ChunkTableEntry], size: u64, count: u64) -> Result<Vec<Chunk>, Problem> {
        let (mut offset, mut first) = (start, 0u64);
        let mut chunks = Vec::new();
        for entry in table {
            let (bytes, points) = (entry.byte_count, entry.point_count);
            // The first point is not compressed. This limits the number of chunks.
            let end = offset
                .checked_add(bytes)
                .filter(|end| *end <= size && bytes >= self.record);
            let Some(end) = end else {
                return Err(Problem::cut_short(format!(
                    "a chunk of points of {bytes} bytes at byte {offset}, in a file of {size} bytes"
                )));
            };
            chunks.push(Chunk {
                offset,
                bytes,
                first,
                points,
                is_known: false,
            });
            first = first.saturating_add(points);
            offset = end;
        }
        if first == count {
            Ok(chunks)
        } else {
            Err(stale(format!(
                "the chunk table has {first} points, and the header {count}"
            )))
        }
    }

    fn chooses(&self, key: [i32; 4]) -> bool {
        key[0] <= self.deepest && self.bounds.is_none_or(|bounds| self.cube(key).intersects(bounds))
    }

    fn node_bounds(&self, key: [i32; 4]) -> Rect {
        match self.bounds {
            Some(_) => self.cube(key),
            None => Rect::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY),
        }
    }

    /// Returns a rectangle that contains the points of a node. Its coordinates may be infinite, but
    /// not NaN.
    ///
    /// The cube alone might not: a program may choose the node of a point before it rounds the
    /// point to the steps of the file.
    fn cube(&self, [level, x, y, _]: [i32; 4]) -> Rect {
        // At most 2^DEEPEST, so that this is exact.
        let side = 2.0 * (self.half / (1u64 << level) as f64);
        let low = |axis: usize, n: i32| self.centre[axis] - self.half + f64::from(n) * side - self.slack[axis];
        let high = |axis: usize, n: i32| self.centre[axis] - self.half + (f64::from(n) + 1.0) * side + self.slack[axis];
        Rect::new(low(0, x), low(1, y), high(0, x), high(1, y))
    }
}

/// Returns the deepest level that the options select.
fn deepest(options: &InputOptions, spacing: f64) -> Result<i32, Problem> {
    let level = options.copc_level.map_or(DEEPEST, i32::from);
    let Some(resolution) = options.copc_resolution else {
        return Ok(level);
    };
    if !spacing.is_finite() || spacing <= 0.0 {
        return Err(stale(format!("the COPC record has a spacing of {spacing}")));
    }
    // Each level halves the spacing.
    let fine = (0..DEEPEST).find(|level| spacing / (1u64 << level) as f64 <= resolution);
    Ok(level.min(fine.unwrap_or(DEEPEST)))
}

/// A chunk of the points.
struct Chunk {
    offset: u64,
    bytes: u64,
    /// The number of its first point, and the number of its points.
    first: u64,
    points: u64,
    /// Whether a node has it.
    is_known: bool,
}

/// An entry of a page.
struct Entry {
    /// The level and the position of a node.
    key: [i32; 4],
    offset: u64,
    bytes: i32,
    points: i32,
}

impl Entry {
    fn read(file: &mut FileReader) -> io::Result<Self> {
        let mut entry = [0; ENTRY as usize];
        file.read_exact(&mut entry)?;
        let number = |n: usize| i32::from_le_bytes([0, 1, 2, 3].map(|byte| entry[4 * n + byte]));
        Ok(Self {
            key: [0, 1, 2, 3].map(number),
            offset: u64::from_le_bytes([0, 1, 2, 3, 4, 5, 6, 7].map(|byte| entry[16 + byte])),
            bytes: number(6),
            points: number(7),
        })
    }
}

/// The state of reading the pages.
struct Walk {
    size: u64,
    chunks: Vec<Chunk>,
    /// The end of each page by its offset: of all pages so far, and of those still to be read.
    pages: BTreeMap<u64, u64>,
    left: BTreeMap<u64, u64>,
}

impl Walk {
    /// Takes the entry at byte `at`. Returns the index of its chunk, if it has one.
    fn take(&mut self, entry: &Entry, at: u64) -> Result<Option<usize>, Problem> {
        let [level, place @ ..] = entry.key;
        let is_node = (0..=DEEPEST).contains(&level) && place.iter().all(|&n| n >= 0 && i64::from(n) >> level == 0);
        if !is_node {
            let [x, y, z] = place;
            return Err(stale(format!("byte {at}: the octree has no node {level}-{x}-{y}-{z}")));
        }
        match (entry.points, u64::try_from(entry.bytes)) {
            (0, _) => Ok(None),
            (-1, Ok(bytes)) => {
                self.add_page((entry.offset, bytes), &format!("byte {at}"))?;
                Ok(None)
            }
            (points @ 1.., Ok(bytes)) => self.take_chunk(entry, bytes, points.unsigned_abs(), at).map(Some),
            (points, _) => Err(stale(format!(
                "byte {at}: a node of {points} points in {} bytes",
                entry.bytes
            ))),
        }
    }

    fn take_chunk(&mut self, entry: &Entry, bytes: u64, points: u32, at: u64) -> Result<usize, Problem> {
        let found = self.chunks.binary_search_by_key(&entry.offset, |chunk| chunk.offset);
        let is_it = |chunk: &Chunk| chunk.bytes == bytes && chunk.points == u64::from(points) && !chunk.is_known;
        match found {
            Ok(index) if is_it(&self.chunks[index]) => {
                self.chunks[index].is_known = true;
                Ok(index)
            }
            _ => Err(stale(format!(
                "byte {at}: a node of {points} points in {bytes} bytes at byte {}, which is not a chunk, or one of \
                 another node",
                entry.offset
            ))),
        }
    }

    /// Takes the first page from `position` on, or else the first of all: its offset and its end.
    fn next_page(&mut self, position: u64) -> Option<(u64, u64)> {
        let next = self
            .left
            .range(position..)
            .next()
            .or_else(|| self.left.first_key_value());
        let (&offset, &end) = next?;
        self.left.remove(&offset);
        Some((offset, end))
    }

    /// Adds a page to those to read: offset and bytes.
    fn add_page(&mut self, (offset, bytes): (u64, u64), of: &str) -> Result<(), Problem> {
        let fail = |what: &str| Err(stale(format!("{of}: a page of {bytes} bytes at byte {offset}, {what}")));
        let end = match offset.checked_add(bytes) {
            Some(end) if end <= self.size => end,
            _ => return fail("which is not within the file"),
        };
        if bytes == 0 || bytes % ENTRY != 0 {
            return fail("which is no whole number of entries");
        }
        // The pages do not overlap, so that the last one that begins before `end` ends last.
        let before = self.pages.range(..end).next_back();
        if before.is_some_and(|(_, &before)| before > offset) {
            return fail("which overlaps another one");
        }
        self.pages.insert(offset, end);
        self.left.insert(offset, end);
        Ok(())
    }
}

fn unreadable(at: u64, error: io::Error) -> Problem {
    Problem::cut_short(format!("byte {at}: the hierarchy of nodes cannot be read")).caused_by(error)
}

/// Returns the error of an octree that does not belong to the points.
pub fn stale(problem: String) -> Problem {
    Problem {
        hint: STALE,
        ..Problem::damaged(problem)
    }
}

fn no_copc() -> Problem {
    Problem {
        hint: NOT_COPC.1,
        ..Problem::damaged(NOT_COPC.0)
    }
}
