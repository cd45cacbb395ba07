//! Decompression of LAZ, with checks of everything that the crate `laz` trusts.
//!
//! In: a file at its point data, the LASzip record of its header, and the nodes to read if it is a
//! COPC file. Out: point records as in LAS, chunk by chunk.
//! Format: LASzip 2 and 3 (chunks of points; from point format 6 on, the fields of a chunk are in
//! layers).
//!
//! ```text
//!   point data:  [i64: offset of the table] chunk 0 | chunk 1 | ... | table
//!   layered chunk:  first point, raw | u32: points | u32 per layer: its bytes | layers
//!   table:  u32 version | u32: chunks | compressed entries (points), bytes
//! ```
//!
//! Chunks do not depend on each other. Where the table says where each of them is, they are decoded
//! ahead on several threads, otherwise as their points are read.
//!
//! `laz` 0.13 handles hostile numbers as follows. This module checks them first:
//!
//! - It allocates 16 bytes for each chunk that the table claims. Here the number of chunks is
//!   limited to one for each 20 bytes of the file.
//! - It allocates the bytes that each layer claims. Here the sum is compared with the rest of the
//!   file.
//! - It allocates about 10 KiB per extra byte. The limit on the record length bounds this.
//! - It accepts tables of any numbers of points. Here the table must have as many points as the
//!   header, and no chunk without points.
//!
//! Its arithmetic decoder can still divide by zero or index out of range on damaged data. Only
//! decoding itself could detect this, so such a panic is caught and becomes an error (where panics
//! unwind; `caught` tells the program's panic hook not to report it).
//!
//! | module | contents |
//! |---|---|
//! | `compression` | the record of the header, and the table of the chunks |
//! | `chunks` | the chunks to read |
//! | `decoder` | decompression of one chunk after another |
//! | `ahead` | decompression on several threads |

mod ahead;
mod chunks;
mod compression;
mod decoder;

use crate::geometry::Rect;
use crate::input::formats::las::copc::Node;
use crate::input::formats::las::problem::{FileReader, Problem};
use ahead::Ahead;
use chunks::{Chunks, not_found};
pub use compression::Compression;
use decoder::ChunkDecoder;
use std::io::{Seek, SeekFrom};

/// The points of the chunks that are read.
pub struct Laz {
    decoding: Decoding,
    length: usize,
    /// The number of points left in the chunk.
    left: u64,
    /// Contains the points of the chunk.
    bounds: Option<Rect>,
}

enum Decoding {
    /// As the points are read.
    Streaming(ChunkDecoder<FileReader>, Chunks),
    /// On other threads, ahead of the reading.
    Ahead(Ahead),
}

impl Laz {
    /// Starts the decompression of all chunks, or of those of some nodes, on `threads` threads.
    pub fn new(
        mut file: FileReader,
        size: u64,
        compression: Compression,
        nodes: Option<Vec<Node>>,
        threads: usize,
    ) -> Result<Self, Problem> {
        file.seek(SeekFrom::Start(compression.start)).map_err(not_found)?;
        let can_be_ahead = threads > 1 && ahead::is_possible(&compression, nodes.as_deref());
        let Compression {
            scheme, table, count, ..
        } = compression;
        let chunks = match (nodes, table) {
            (Some(nodes), _) => Chunks::Nodes(nodes.into_iter()),
            (None, Some(table)) => Chunks::Table(table, 0, count),
            (None, None) => Chunks::Fixed(compression.chunk_points),
        };
        Ok(Self {
            length: scheme.length,
            decoding: match can_be_ahead {
                true => Decoding::Ahead(Ahead::new(file, chunks, scheme, threads)),
                false => Decoding::Streaming(ChunkDecoder::new(file, size, "the file", &scheme), chunks),
            },
            left: 0,
            bounds: None,
        })
    }

    /// Returns the number of points left in the chunk.
    pub fn left(&self) -> u64 {
        self.left
    }

    /// Returns a rectangle that the octree of the file says contains the points of the chunk.
    pub fn bounds(&self) -> Option<Rect> {
        self.bounds
    }

    /// Fills the buffer with whole records of the chunk, at most as many as are left.
    pub fn read(&mut self, buffer: &mut [u8]) -> Result<(), Problem> {
        self.left -= (buffer.len() / self.length) as u64;
        match &mut self.decoding {
            Decoding::Streaming(decoder, _) => decoder.read(buffer),
            Decoding::Ahead(ahead) => ahead.read(buffer),
        }
    }

    /// Begins the next chunk to read, once no point of the last one is left. Returns the number of
    /// points between them; `None` if there is no chunk to read.
    pub fn next_chunk(&mut self) -> Result<Option<u64>, Problem> {
        let (next, chunks) = match &mut self.decoding {
            Decoding::Ahead(ahead) => (ahead.next_chunk()?, &ahead.chunks),
            Decoding::Streaming(decoder, chunks) => {
                let next = chunks.next();
                if let Some(chunk) = &next {
                    chunk.go_to(decoder.source())?;
                    decoder.begin()?;
                }
                (next, &*chunks)
            }
        };
        let Some(chunk) = next else {
            return match chunks {
                Chunks::Nodes(_) => Ok(None),
                _ => Err(Problem::damaged("the chunk table has fewer points than the header")),
            };
        };
        self.left = chunk.points;
        self.bounds = chunk.bounds;
        Ok(Some(chunk.skipped))
    }
}
