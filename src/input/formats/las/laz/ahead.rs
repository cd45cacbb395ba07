//! Decompression of chunks on several threads, ahead of the reading.

use crate::input::decoders::Decoders;
use crate::input::formats::las::copc::Node;
use crate::input::formats::las::laz::chunks::{Chunk, Chunks};
use crate::input::formats::las::laz::compression::{Compression, Scheme};
use crate::input::formats::las::laz::decoder::{ChunkDecoder, undecodable};
use crate::input::formats::las::problem::{FileReader, Problem};
use std::io::{Cursor, Read};

/// The most bytes of a chunk, compressed or not. This bounds the memory: a few chunks are there at a
/// time, each of them in both forms. Most programs write 50,000 points in a chunk, of 20 to 67 bytes.
const LARGEST_CHUNK: u64 = 4 << 20;

/// The number of records decompressed at once. Where decompression fails, fewer of the records before
/// are lost.
const RECORDS: usize = 1024;

/// Chunks that are decoded ahead.
pub struct Ahead {
    file: FileReader,
    /// The chunks that were not read.
    pub chunks: Chunks,
    decoders: Decoders<Piece, Decoded>,
    /// The records of the chunk that is read, and how many of their bytes have been read.
    records: Vec<u8>,
    read: usize,
    /// Why the chunk has no more records.
    failure: Option<Problem>,
}

/// A chunk with its bytes, or the reason why there are none.
struct Piece {
    chunk: Chunk,
    bytes: Result<Vec<u8>, Problem>,
}

/// The records of a chunk up to a failure.
struct Decoded {
    chunk: Chunk,
    records: Vec<u8>,
    failure: Option<Problem>,
}

/// Returns whether it is known where each chunk is, and whether they are many, and none too large. The
/// chunks of the table must fill the file up to the table: a program that wrote wrong sizes has not
/// used them, and no reader needs them unless it reads ahead.
pub fn is_possible(compression: &Compression, nodes: Option<&[Node]>) -> bool {
    let Some(table) = compression.table() else {
        return false;
    };
    let length = compression.scheme.length as u64;
    let fits = |points: u64, bytes: u64| points.max(1) <= LARGEST_CHUNK / length && bytes <= LARGEST_CHUNK;
    match nodes {
        Some(nodes) => nodes.len() > 1 && nodes.iter().all(|node| fits(node.points, node.bytes)),
        None => {
            let end = table
                .iter()
                .try_fold(compression.start, |end, chunk| end.checked_add(chunk.byte_count));
            table.len() > 1
                && end == Some(compression.end)
                && table.iter().all(|chunk| fits(chunk.point_count, chunk.byte_count))
        }
    }
}

impl Ahead {
    pub fn new(file: FileReader, chunks: Chunks, scheme: Scheme, threads: usize) -> Self {
        Self {
            file,
            chunks,
            decoders: Decoders::new(threads, move |piece| decode(piece, &scheme)),
            records: Vec::new(),
            read: 0,
            failure: None,
        }
    }

    /// Begins the next chunk; returns `None` if there is none.
    pub fn next_chunk(&mut self) -> Result<Option<Chunk>, Problem> {
        while self.decoders.want_more()
            && let Some(chunk) = self.chunks.next()
        {
            let bytes = self.bytes_of(&chunk);
            self.decoders.put(Piece { chunk, bytes });
        }
        let Some(decoded) = self.decoders.take() else {
            return Ok(None);
        };
        (self.records, self.read, self.failure) = (decoded.records, 0, decoded.failure);
        match self.failure.take_if(|_| self.records.is_empty()) {
            Some(failure) => Err(failure),
            None => Ok(Some(decoded.chunk)),
        }
    }

    fn bytes_of(&mut self, chunk: &Chunk) -> Result<Vec<u8>, Problem> {
        chunk.go_to(&mut self.file)?;
        let mut bytes = vec![0; chunk.bytes.unwrap_or_default() as usize];
        self.file.read_exact(&mut bytes).map_err(|error| {
            Problem::cut_short("a chunk of points ends beyond the end of the file").caused_by(error)
        })?;
        Ok(bytes)
    }

    /// Fills the buffer with whole records of the chunk.
    pub fn read(&mut self, buffer: &mut [u8]) -> Result<(), Problem> {
        let Some(records) = self.records.get(self.read..self.read + buffer.len()) else {
            return Err(self.failure.take().unwrap_or_else(undecodable));
        };
        buffer.copy_from_slice(records);
        self.read += buffer.len();
        Ok(())
    }
}

fn decode(piece: Piece, scheme: &Scheme) -> Decoded {
    let Piece { chunk, bytes } = piece;
    let mut records = Vec::new();
    let failure = bytes
        .and_then(|bytes| fill(&mut records, bytes, chunk.points, scheme))
        .err();
    Decoded {
        chunk,
        records,
        failure,
    }
}

/// Fills `records` with all points of a chunk, or with those before a failure.
fn fill(records: &mut Vec<u8>, bytes: Vec<u8>, points: u64, scheme: &Scheme) -> Result<(), Problem> {
    let size = bytes.len() as u64;
    let mut decoder = ChunkDecoder::new(Cursor::new(bytes), size, "its place in the file", scheme);
    decoder.begin()?;
    let whole = points as usize * scheme.length;
    records.reserve_exact(whole);
    while records.len() < whole {
        let (before, after) = (records.len(), whole.min(records.len() + RECORDS * scheme.length));
        records.resize(after, 0);
        decoder
            .read(&mut records[before..])
            .inspect_err(|_| records.truncate(before))?;
    }
    Ok(())
}
