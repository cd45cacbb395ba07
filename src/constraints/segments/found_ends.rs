//! The ends of a part that were found, with their positions.
//!
//! ```text
//! chunk   0  the chunk before this one in the file: offset u64, length u32, CRC-32C u32; or zeros
//!        16  for each end: its number u32, x, y f64
//! ```
//!
//! All values are little-endian. Each part has only a small buffer, and each full buffer becomes a
//! chunk. So memory has the location of the last chunk only. It leads to the others, from the
//! newest to the oldest.

use std::io;

use crate::constraints::segments::chunk_store::{Chunk, ChunkStore, damaged};
use crate::geometry::Point;
use crate::store::Extent;

/// Bytes before the ends.
const HEADER: usize = 16;
/// Bytes of an end.
const END_BYTES: usize = 20;

/// The position of an end that was not found.
const UNKNOWN: Point = Point {
    x: f64::NAN,
    y: f64::NAN,
};

/// Ends that were found.
#[derive(Debug, Default)]
pub(crate) struct FoundEnds {
    /// The chunks that stay in memory. They are older than all others.
    chunks: Vec<Chunk>,
    /// The newest chunk in the file.
    last: Option<Extent>,
    /// The next chunk, which is not full yet.
    buffer: Vec<u8>,
}

impl FoundEnds {
    /// Returns the bytes in memory, except those of chunks that the store keeps there.
    pub(crate) fn byte_size(&self) -> usize {
        self.chunks.capacity() * size_of::<Chunk>() + self.buffer.capacity()
    }

    /// Adds an end and its position. If an end comes several times, the last position counts.
    #[inline]
    pub(crate) fn push(&mut self, end: u32, position: Point, capacity: usize, store: &ChunkStore) -> io::Result<()> {
        if self.buffer.is_empty() {
            self.buffer.extend_from_slice(&[0; HEADER]);
        }
        self.buffer.extend_from_slice(&end.to_le_bytes());
        let coordinates = [position.x, position.y].map(f64::to_le_bytes);
        self.buffer.extend_from_slice(coordinates.as_flattened());
        if self.buffer.len() + END_BYTES > capacity {
            self.spill(store)?;
        }
        Ok(())
    }

    fn spill(&mut self, store: &ChunkStore) -> io::Result<()> {
        if let Some(Extent {
            offset, length, crc, ..
        }) = self.last
        {
            self.buffer[..8].copy_from_slice(&offset.to_le_bytes());
            self.buffer[8..12].copy_from_slice(&length.to_le_bytes());
            self.buffer[12..HEADER].copy_from_slice(&crc.to_le_bytes());
        }
        match store.append(&self.buffer)? {
            Chunk::File(extent) => self.last = Some(extent),
            chunk => self.chunks.push(chunk),
        }
        self.buffer.clear();
        Ok(())
    }

    /// Writes the position of each of `ends` ends to `positions`. The inner error is the first end
    /// that was not found.
    ///
    /// Passes the location of each chunk in the file to `visit`; nothing else knows it.
    pub(crate) fn positions(
        &self,
        ends: u32,
        store: &ChunkStore,
        positions: &mut Vec<Point>,
        mut visit: impl FnMut(Extent),
    ) -> io::Result<Result<(), u32>> {
        positions.clear();
        positions.resize(ends as usize, UNKNOWN);
        fill_in(&self.buffer, positions)?;
        let mut bytes = Vec::new();
        let mut next = self.last;
        while let Some(extent) = next {
            let chunk = Chunk::File(extent);
            let chunk = store.read(&chunk, &mut bytes)?;
            fill_in(chunk, positions)?;
            next = before(chunk, extent)?;
            visit(extent);
        }
        for chunk in self.chunks.iter().rev() {
            fill_in(store.read(chunk, &mut bytes)?, positions)?;
        }
        Ok(match positions.iter().position(|point| point.x.is_nan()) {
            Some(end) => Err(end as u32),
            None => Ok(()),
        })
    }

    /// Frees the chunks in memory.
    pub(crate) fn free(self, store: &ChunkStore) {
        self.chunks.into_iter().for_each(|chunk| store.free(chunk));
    }
}

/// Writes the positions of the ends of a chunk, unless a newer one is there.
fn fill_in(chunk: &[u8], positions: &mut [Point]) -> io::Result<()> {
    let (ends, _) = chunk.get(HEADER..).unwrap_or_default().as_chunks::<END_BYTES>();
    for bytes in ends.iter().rev() {
        let [a, b, c, d, coordinates @ ..] = bytes;
        let (coordinates, _) = coordinates.as_chunks();
        let position = positions.get_mut(u32::from_le_bytes([*a, *b, *c, *d]) as usize);
        let position = position.ok_or_else(|| damaged("an end of a segment is beyond its part"))?;
        if position.x.is_nan() {
            *position = Point::new(f64::from_le_bytes(coordinates[0]), f64::from_le_bytes(coordinates[1]));
        }
    }
    Ok(())
}

/// Returns the location of the chunk before the chunk at `here`.
fn before(chunk: &[u8], here: Extent) -> io::Result<Option<Extent>> {
    let (words, _) = chunk.as_chunks::<4>();
    let &[a, b, length, crc, ..] = words else {
        return Err(damaged("a chunk of ends is too short"));
    };
    let offset = u64::from(u32::from_le_bytes(a)) | u64::from(u32::from_le_bytes(b)) << 32;
    let extent = Extent::raw(offset, u32::from_le_bytes(length), u32::from_le_bytes(crc));
    if extent.length == 0 {
        return Ok(None);
    }
    // Offsets must decrease, so that the walk terminates.
    if extent.range().end > here.offset {
        return Err(damaged("a chunk of ends leads to a later one"));
    }
    Ok(Some(extent))
}
