//! The chunks of a file to read, in their order.

use crate::geometry::Rect;
use crate::input::formats::las::copc::Node;
use crate::input::formats::las::problem::{FileReader, Problem};
use laz::laszip::ChunkTable;
use std::io;
use std::io::{Seek, SeekFrom};

/// A chunk to read.
pub struct Chunk {
    pub points: u64,
    /// The number of its bytes, if it is known.
    pub bytes: Option<u64>,
    /// Where it begins, if that is not where the chunk before it ends.
    offset: Option<u64>,
    /// The number of points between the chunk before it and this one.
    pub skipped: u64,
    pub bounds: Option<Rect>,
}

/// The remaining chunks.
pub enum Chunks {
    /// All have this number of points, and one follows another.
    Fixed(u64),
    /// As in the table, from this index on, with this number of points.
    Table(ChunkTable, usize, u64),
    /// Those of these nodes.
    Nodes(std::vec::IntoIter<Node>),
}

impl Iterator for Chunks {
    type Item = Chunk;

    fn next(&mut self) -> Option<Chunk> {
        let following = |points, bytes| Chunk {
            points,
            bytes,
            offset: None,
            skipped: 0,
            bounds: None,
        };
        match self {
            Self::Fixed(points) => Some(following(*points, None)),
            Self::Table(table, next, left) => {
                let entry = table.as_ref().get(*next)?;
                *next += 1;
                // The table says nothing of the points of the last chunk if all others have the same.
                let points = entry.point_count.min(*left);
                *left -= points;
                Some(following(points, Some(entry.byte_count)))
            }
            Self::Nodes(nodes) => nodes.next().map(|node| Chunk {
                points: node.points,
                bytes: Some(node.bytes),
                offset: Some(node.offset),
                skipped: node.skipped,
                bounds: Some(node.bounds),
            }),
        }
    }
}

impl Chunk {
    /// Goes to the beginning of the chunk, from the end of the one before it.
    pub fn go_to(&self, file: &mut FileReader) -> Result<(), Problem> {
        match self.offset {
            Some(offset) => file.seek(SeekFrom::Start(offset)).map(|_| ()).map_err(not_found),
            None => Ok(()),
        }
    }
}

/// Returns the error of points to which the file does not lead.
pub fn not_found(error: io::Error) -> Problem {
    Problem::cut_short("the points cannot be found").caused_by(error)
}
