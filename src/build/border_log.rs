//! The border log: triangles that become final above the leaves, spilled until the borders are put together.
//!
//! Tiles are taken in groups of neighbours in leaf order, and each group has a bucket, to which every late triangle with a
//! vertex in it is appended. Buckets fill buffers; full buffers go to the end of one file, which has no name. After the
//! root the log is read back bucket by bucket, so borders are made in leaf order and memory holds one bucket at a time.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::Path;

use super::node::SeamVertex;
use crate::geometry::Point;
use crate::store::{TileId, VertexId};

/// A triangle that was settled by a merge: crossing, or late. Corners counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub(super) struct LateTriangle(pub(super) [SeamVertex; 3]);

/// Bytes of a corner: tile, place, x, y.
const CORNER: usize = 24;
/// Bytes of a triangle in the log.
const TRIANGLE: usize = 3 * CORNER;
/// Bytes that all buffers may take together.
const BUFFERS: usize = 16 << 20;
/// Bytes of a buffer, at most.
const BUFFER: usize = 64 << 10;

impl LateTriangle {
    fn encode(&self, bytes: &mut Vec<u8>) {
        for corner in self.0 {
            bytes.extend_from_slice(&corner.id.tile.0.to_le_bytes());
            bytes.extend_from_slice(&corner.id.index.to_le_bytes());
            bytes.extend_from_slice(&corner.point.x.to_le_bytes());
            bytes.extend_from_slice(&corner.point.y.to_le_bytes());
        }
    }

    fn decode(bytes: &[u8]) -> Self {
        let word = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"));
        Self([0, CORNER, 2 * CORNER].map(|at| {
            let id = word(at);
            SeamVertex {
                id: VertexId {
                    tile: TileId(id as u32),
                    index: (id >> 32) as u32,
                },
                point: Point::new(f64::from_bits(word(at + 8)), f64::from_bits(word(at + 16))),
            }
        }))
    }
}

/// Each value once.
fn distinct([a, b, c]: [u32; 3]) -> impl Iterator<Item = u32> {
    let values = [Some(a), (b != a).then_some(b), (c != a && c != b).then_some(c)];
    values.into_iter().flatten()
}

/// The log while it is written.
#[derive(Debug)]
pub(super) struct BorderLog {
    file: File,
    length: u64,
    tiles: u32,
    tiles_per_bucket: u32,
    buckets: Vec<Bucket>,
    /// Triangles so far.
    triangles: u64,
    buffer_size: usize,
}

#[derive(Debug, Default)]
struct Bucket {
    buffer: Vec<u8>,
    /// What was written before, as places in the file.
    chunks: Vec<Range<u64>>,
}

impl BorderLog {
    /// Makes an empty log in a folder, for so many tiles of so many vertices.
    pub(super) fn create(folder: &Path, tiles: u32, tile_vertices: usize) -> io::Result<Self> {
        // The file has no name, so it goes away with its handle, however the process ends.
        let file = tempfile::tempfile_in(folder)?;
        // A tile has about 16 √m late triangles, so a bucket has some 65,000, which are a few megabytes.
        let tiles_per_bucket = (4096.0 / (tile_vertices as f64).sqrt()).ceil() as u32;
        let count = tiles.div_ceil(tiles_per_bucket) as usize;
        let mut buckets = Vec::new();
        buckets.resize_with(count, Bucket::default);
        Ok(Self {
            file,
            length: 0,
            tiles,
            tiles_per_bucket,
            buckets,
            triangles: 0,
            buffer_size: (BUFFERS / count.max(1)).clamp(TRIANGLE, BUFFER),
        })
    }

    /// Appends triangles.
    pub(super) fn append(&mut self, triangles: &[LateTriangle]) -> io::Result<()> {
        self.triangles += triangles.len() as u64;
        for triangle in triangles {
            let of = |v: SeamVertex| v.id.tile.0 / self.tiles_per_bucket;
            for number in distinct(triangle.0.map(of)) {
                let bucket = &mut self.buckets[number as usize];
                triangle.encode(&mut bucket.buffer);
                if bucket.buffer.len() >= self.buffer_size {
                    self.file.write_all_at(&bucket.buffer, self.length)?;
                    let end = self.length + bucket.buffer.len() as u64;
                    bucket.chunks.push(self.length..end);
                    self.length = end;
                    bucket.buffer.clear();
                }
            }
        }
        Ok(())
    }

    /// How many triangles were appended.
    pub(super) fn triangle_count(&self) -> u64 {
        self.triangles
    }

    /// Bytes that were spilled.
    pub(super) fn spilled_bytes(&self) -> u64 {
        self.length
    }

    /// How many buckets there are.
    pub(super) fn bucket_count(&self) -> usize {
        self.buckets.len()
    }

    /// Reads a bucket back, and forgets it.
    pub(super) fn take_bucket(&mut self, number: usize) -> io::Result<BucketBorders> {
        let bucket = std::mem::take(&mut self.buckets[number]);
        let spilled: u64 = bucket.chunks.iter().map(|chunk| chunk.end - chunk.start).sum();
        let mut bytes = vec![0; spilled as usize];
        let mut rest = &mut bytes[..];
        for chunk in bucket.chunks {
            let (part, after) = rest.split_at_mut((chunk.end - chunk.start) as usize);
            self.file.read_exact_at(part, chunk.start)?;
            rest = after;
        }
        bytes.extend_from_slice(&bucket.buffer);
        let first = number as u32 * self.tiles_per_bucket;
        let end = first.saturating_add(self.tiles_per_bucket).min(self.tiles);
        Ok(BucketBorders::new(bytes, first..end))
    }
}

/// The late triangles of a group of tiles.
#[derive(Debug)]
pub(super) struct BucketBorders {
    bytes: Vec<u8>,
    tiles: Range<u32>,
    /// Numbers of triangles, tile by tile.
    numbers: Vec<u32>,
    /// For each tile where its numbers start; and the end.
    starts: Vec<usize>,
}

impl BucketBorders {
    fn new(bytes: Vec<u8>, tiles: Range<u32>) -> Self {
        let mut of_tile: Vec<(u32, u32)> = Vec::with_capacity(bytes.len() / TRIANGLE);
        for (triangle, number) in bytes.chunks_exact(TRIANGLE).zip(0..) {
            let triangle = LateTriangle::decode(triangle);
            let inside = distinct(triangle.0.map(|v| v.id.tile.0)).filter(|tile| tiles.contains(tile));
            of_tile.extend(inside.map(|tile| (tile, number)));
        }
        of_tile.sort_unstable();
        let starts = tiles
            .clone()
            .chain([tiles.end])
            .map(|tile| of_tile.partition_point(|&(t, _)| t < tile))
            .collect();
        Self {
            numbers: of_tile.into_iter().map(|(_, number)| number).collect(),
            bytes,
            tiles,
            starts,
        }
    }

    /// The tiles of the group.
    pub(super) fn tiles(&self) -> Range<u32> {
        self.tiles.clone()
    }

    /// The late triangles with a vertex in a tile.
    pub(super) fn of_tile(&self, tile: TileId) -> impl Iterator<Item = LateTriangle> {
        let place = (tile.0 - self.tiles.start) as usize;
        let numbers = &self.numbers[self.starts[place]..self.starts[place + 1]];
        numbers.iter().map(|&number| {
            let at = number as usize * TRIANGLE;
            LateTriangle::decode(&self.bytes[at..at + TRIANGLE])
        })
    }
}
