//! The border log: the data of borders, spilled until the borders are assembled.
//!
//! Tiles are grouped with their neighbours in leaf order. A group gets the boundary half-edges of
//! its tiles' cores and every late triangle with a vertex in it. With segments it also gets the
//! constraint edges that belong to its tiles and are not in their cores, and the anchors of its
//! tiles' components. The data fills buffers; full buffers are appended to one file, as checksummed
//! chunks. After the root the log is read back in batches of groups, so borders are made in leaf
//! order and memory holds one batch at a time, and the next one.
//!
//! The positions of a finished block's chunks go to the journal, so that a resumed build finds
//! them.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::sync::Arc;

use crate::geometry::Point;
use crate::geometry::{HalfEdge, VertexIndex};
use crate::mesh::WALLS;
use crate::pipeline::output::by_tile::ByTile;
use crate::pipeline::records::{
    Anchor, BoundaryEdge, DoneEdge, GroupChunks, KINDS, LateTriangle, LoggedEdge, SeamVertex,
};
use crate::store::{DigestSum, Extent, LinePart, TileId, VertexId};

/// Bytes of a corner: tile, index, x, y.
const CORNER: usize = 24;
/// Flags in the index of a corner or in the number of a half-edge: the half-edge is a constraint,
/// or a wall.
const CONSTRAINT: u32 = 1 << 31;
const WALL: u32 = 1 << 30;
/// Bytes of a triangle in the log: its corners and its number. With z, those of its corners follow.
const TRIANGLE: usize = 3 * CORNER + 4;
const TRIANGLE_WITH_Z: usize = TRIANGLE + 3 * 8;
/// Bytes of a boundary half-edge in the log: tile, from, to, half-edge, component.
const BOUNDARY_EDGE: usize = 20;
/// Bytes of a constraint edge in the log: tile and index of both ends, part of a line, x and y of
/// both ends. The edge belongs to the tile of its first end.
const EDGE: usize = 56;
/// Bytes of an anchor in the log: tile, component, relative depth, number of triangles, sum of
/// their hashes.
const ANCHOR: usize = 32;
/// Most bytes of a buffer.
const BUFFER: usize = 64 << 10;

impl LateTriangle {
    fn encode(&self, has_z: bool, bytes: &mut Vec<u8>) {
        for (corner, edge) in self.corners.iter().zip(0..) {
            let bit = |at: u32, mark: u32| if self.edge_bits >> at & 1 == 1 { mark } else { 0 };
            let mark = bit(edge, CONSTRAINT) | bit(edge + WALLS, WALL);
            bytes.extend_from_slice(&corner.id.tile.0.to_le_bytes());
            bytes.extend_from_slice(&(corner.id.index.0 | mark).to_le_bytes());
            bytes.extend_from_slice(&corner.point.x.to_le_bytes());
            bytes.extend_from_slice(&corner.point.y.to_le_bytes());
        }
        bytes.extend_from_slice(&self.number.to_le_bytes());
        if has_z {
            bytes.extend(self.corners.iter().flat_map(|corner| corner.z.to_le_bytes()));
        }
    }

    fn decode(bytes: &[u8]) -> Self {
        let word = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"));
        let mut edge_bits = 0;
        let z = bytes[TRIANGLE..].as_chunks().0;
        let corners = [0, 1, 2].map(|edge| {
            let id = word(edge * CORNER);
            let index = (id >> 32) as u32;
            edge_bits |= u8::from(index & CONSTRAINT != 0) << edge;
            edge_bits |= u8::from(index & WALL != 0) << (edge as u32 + WALLS);
            let coordinate = |axis: usize| f64::from_bits(word(edge * CORNER + 8 + 8 * axis));
            SeamVertex {
                id: VertexId {
                    tile: TileId(id as u32),
                    index: VertexIndex(index & !(CONSTRAINT | WALL)),
                },
                point: Point::new(coordinate(0), coordinate(1)),
                z: z.get(edge).map_or(0.0, |&z| f64::from_le_bytes(z)),
            }
        });
        Self {
            corners,
            edge_bits,
            number: words::<1>(&bytes[3 * CORNER..])[0],
        }
    }
}

/// Adds `more` to the numbers of the triangles of a chunk, if its content is of that kind.
pub(crate) fn renumber(chunk: &mut [u8], kind: usize, has_z: bool, more: u32) {
    if kind == TRIANGLES {
        for triangle in chunk.chunks_exact_mut(triangle_bytes(has_z)) {
            let number = words::<1>(&triangle[3 * CORNER..])[0] + more;
            triangle[3 * CORNER..][..4].copy_from_slice(&number.to_le_bytes());
        }
    }
}

/// Returns the bytes of a triangle in the log.
fn triangle_bytes(has_z: bool) -> usize {
    if has_z { TRIANGLE_WITH_Z } else { TRIANGLE }
}

/// Yields each value once.
fn distinct([a, b, c]: [u32; 3]) -> impl Iterator<Item = u32> {
    let values = [Some(a), (b != a).then_some(b), (c != a && c != b).then_some(c)];
    values.into_iter().flatten()
}

const BOUNDARY_EDGES: usize = 0;
const TRIANGLES: usize = 1;
const EDGES: usize = 2;
const ANCHORS: usize = 3;

/// A border log while it is written.
#[derive(Debug)]
pub(crate) struct BorderLog {
    file: Arc<File>,
    length: u64,
    tiles: u32,
    tiles_per_group: u32,
    /// Whether triangles have the z of their corners.
    has_z: bool,
    groups: Vec<TileGroup>,
    /// Number of triangles so far.
    triangles: u64,
    /// The number of the next triangle. It exceeds `triangles` if an earlier build numbered
    /// triangles of blocks that it did not finish.
    next_number: u64,
    /// Bytes in all buffers, and the limit of these bytes.
    buffered: usize,
    buffers: usize,
    written: u64,
    read: u64,
}

#[derive(Debug, Default)]
struct TileGroup {
    first_tile: u32,
    buffers: [Vec<u8>; KINDS],
    chunks: GroupChunks,
}

impl BorderLog {
    /// Creates a log in `file` after its first `length` bytes, with `buffers` bytes of buffers, for
    /// tiles of up to `tile_vertices` vertices, with z or without.
    pub(crate) fn new(file: Arc<File>, length: u64, buffers: usize, tile_vertices: usize, has_z: bool) -> Self {
        Self {
            file,
            length,
            tiles: 0,
            // A tile of m vertices has about 16 √m late triangles, so a group has some 65,000,
            // which are a few megabytes.
            tiles_per_group: (4096.0 / (tile_vertices as f64).sqrt()).ceil() as u32,
            has_z,
            groups: Vec::new(),
            triangles: 0,
            next_number: 0,
            buffered: 0,
            buffers,
            written: 0,
            read: 0,
        }
    }

    /// Makes `tile` the number of the first tile.
    pub(crate) fn starting_at(self, tile: u32) -> Self {
        Self { tiles: tile, ..self }
    }

    /// Adds groups for the `tiles` tiles of another block.
    pub(crate) fn add_tiles(&mut self, tiles: u32) {
        let end = self.tiles + tiles;
        let groups = (self.tiles..end).step_by(self.tiles_per_group as usize);
        self.groups.extend(groups.map(|first_tile| TileGroup {
            first_tile,
            ..TileGroup::default()
        }));
        self.tiles = end;
    }

    /// Returns the groups of the tiles of a block.
    fn groups_of(&self, tiles: Range<u32>) -> Range<usize> {
        let before = |tile: u32| self.groups.partition_point(|group| group.first_tile < tile);
        before(tiles.start)..before(tiles.end)
    }

    fn group_of(&self, tile: u32) -> usize {
        self.groups.partition_point(|group| group.first_tile <= tile) - 1
    }

    /// Appends the boundary half-edges of a tile's core.
    pub(crate) fn append_boundary_edges(&mut self, tile: TileId, boundary_edges: &[BoundaryEdge]) -> io::Result<()> {
        let group = self.group_of(tile.0);
        let buffer = &mut self.groups[group].buffers[BOUNDARY_EDGES];
        for edge in boundary_edges {
            let mark = if edge.is_constraint { CONSTRAINT } else { 0 };
            for word in [tile.0, edge.from, edge.to, edge.half_edge.0 | mark, edge.component] {
                buffer.extend_from_slice(&word.to_le_bytes());
            }
        }
        self.buffered += boundary_edges.len() * BOUNDARY_EDGE;
        self.relieve(group, BOUNDARY_EDGES)
    }

    /// Appends constraint edges that are not in a core.
    pub(crate) fn append_edges(&mut self, edges: &[DoneEdge]) -> io::Result<()> {
        for edge in edges {
            let [mut first, mut second] = edge.ends;
            let mut source = edge.source;
            if second.point.lex_cmp(first.point).is_lt() {
                (first, second, source) = (second, first, source.reversed());
            }
            let group = self.group_of(first.id.tile.0);
            let buffer = &mut self.groups[group].buffers[EDGES];
            for word in [first.id.tile.0, first.id.index.0, second.id.tile.0, second.id.index.0] {
                buffer.extend_from_slice(&word.to_le_bytes());
            }
            buffer.extend_from_slice(&source.to_bits().to_le_bytes());
            let points = [first.point, second.point];
            buffer.extend(points.iter().flat_map(|p| [p.x, p.y]).flat_map(f64::to_le_bytes));
            self.buffered += EDGE;
            self.relieve(group, EDGES)?;
        }
        Ok(())
    }

    /// Appends the anchors of a tile's components.
    pub(crate) fn append_anchors(&mut self, tile: TileId, anchors: &[Anchor]) -> io::Result<()> {
        let group = self.group_of(tile.0);
        let buffer = &mut self.groups[group].buffers[ANCHORS];
        for anchor in anchors {
            // A core has fewer than 2³² triangles.
            let triangles = anchor.triangles.count as u32;
            for word in [tile.0, anchor.component, anchor.deeper as u32, triangles] {
                buffer.extend_from_slice(&word.to_le_bytes());
            }
            buffer.extend_from_slice(&anchor.triangles.sum.to_le_bytes());
        }
        self.buffered += anchors.len() * ANCHOR;
        self.relieve(group, ANCHORS)
    }

    /// Appends triangles and numbers them.
    pub(crate) fn append_triangles(&mut self, triangles: &[LateTriangle]) -> io::Result<()> {
        for triangle in triangles {
            let number = u32::try_from(self.next_number).map_err(|_| io::ErrorKind::FileTooLarge)?;
            let triangle = LateTriangle { number, ..*triangle };
            self.triangles += 1;
            self.next_number += 1;
            for group in distinct(triangle.corners.map(|v| self.group_of(v.id.tile.0) as u32)) {
                triangle.encode(self.has_z, &mut self.groups[group as usize].buffers[TRIANGLES]);
                self.buffered += triangle_bytes(self.has_z);
                self.relieve(group as usize, TRIANGLES)?;
            }
        }
        Ok(())
    }

    /// Writes a buffer if it is full, and all buffers if their total exceeds the limit.
    fn relieve(&mut self, group: usize, kind: usize) -> io::Result<()> {
        if self.groups[group].buffers[kind].len() >= BUFFER {
            self.write(group, kind)?;
        }
        if self.buffered > self.buffers {
            for group in 0..self.groups.len() {
                self.write_all(group)?;
            }
        }
        Ok(())
    }

    fn write_all(&mut self, group: usize) -> io::Result<()> {
        (0..KINDS).try_for_each(|kind| self.write(group, kind))
    }

    fn write(&mut self, group: usize, kind: usize) -> io::Result<()> {
        let TileGroup { buffers, chunks, .. } = &mut self.groups[group];
        if buffers[kind].is_empty() {
            return Ok(());
        }
        // Frees the memory too: most groups get little or no more data.
        let buffer = std::mem::take(&mut buffers[kind]);
        self.file.write_all_at(&buffer, self.length)?;
        let length = buffer.len() as u32;
        chunks[kind].push(Extent::raw(self.length, length, crc32c::crc32c(&buffer)));
        self.length += buffer.len() as u64;
        self.written += buffer.len() as u64;
        self.buffered -= buffer.len();
        Ok(())
    }

    /// Writes all buffered data of the tiles of a block. Returns the chunks of its groups.
    pub(crate) fn finish_block(&mut self, tiles: Range<u32>) -> io::Result<Vec<GroupChunks>> {
        let groups = self.groups_of(tiles);
        for group in groups.clone() {
            self.write_all(group)?;
        }
        Ok(self.groups[groups].iter().map(|group| group.chunks.clone()).collect())
    }

    /// Adds the tiles of a block that an earlier build finished, and its number of triangles.
    pub(crate) fn restore(&mut self, tiles: u32, chunks: Vec<GroupChunks>, triangles: u64) {
        let first = self.groups.len();
        self.add_tiles(tiles);
        for (group, chunks) in self.groups[first..].iter_mut().zip(chunks) {
            group.chunks = chunks;
        }
        self.triangles += triangles;
    }

    /// Makes `number` the number of the next triangle. Those of all blocks that an earlier build
    /// finished are less: merges begin while further blocks are restored.
    pub(crate) fn number_from(&mut self, number: u64) {
        self.next_number = number;
    }

    /// Returns the number of triangles appended.
    pub(crate) fn triangle_count(&self) -> u64 {
        self.triangles
    }

    /// Returns the number of the next triangle. Those of all others are less.
    pub(crate) fn next_number(&self) -> u64 {
        self.next_number
    }

    /// Returns the bytes read back and the bytes written.
    pub(crate) fn traffic(&self) -> [u64; 2] {
        [self.read, self.written]
    }

    /// Returns the numbers of all groups, in batches of at least `tiles` tiles where one group has
    /// fewer.
    pub(crate) fn batches(&self, tiles: u32) -> Vec<Range<usize>> {
        let mut batches = Vec::new();
        let mut start = 0;
        for end in 1..=self.groups.len() {
            let count = self.end_of(end - 1) - self.groups[start].first_tile;
            if count >= tiles || end == self.groups.len() {
                batches.push(start..end);
                start = end;
            }
        }
        batches
    }

    /// Reads groups back.
    pub(crate) fn read_groups(&mut self, numbers: Range<usize>) -> io::Result<Vec<GroupBorders>> {
        numbers.map(|number| self.read_group(number)).collect()
    }

    /// Forgets groups.
    pub(crate) fn forget_groups(&mut self, numbers: Range<usize>) {
        for group in &mut self.groups[numbers] {
            let forgotten = std::mem::take(group);
            group.first_tile = forgotten.first_tile;
            self.buffered -= forgotten.buffers.iter().map(Vec::len).sum::<usize>();
        }
    }

    /// Returns the end of the tiles of a group.
    fn end_of(&self, group: usize) -> u32 {
        self.groups.get(group + 1).map_or(self.tiles, |next| next.first_tile)
    }

    fn read_group(&mut self, number: usize) -> io::Result<GroupBorders> {
        let TileGroup {
            first_tile,
            buffers,
            chunks,
        } = &self.groups[number];
        let tiles = *first_tile..self.end_of(number);
        let mut by_kind = [const { Vec::new() }; KINDS];
        for ((entries, buffer), chunks) in by_kind.iter_mut().zip(buffers).zip(chunks) {
            let spilled: usize = chunks.iter().map(|chunk| chunk.length as usize).sum();
            entries.reserve_exact(spilled + buffer.len());
            for chunk in chunks {
                let start = entries.len();
                entries.resize(start + chunk.length as usize, 0);
                self.file.read_exact_at(&mut entries[start..], chunk.offset)?;
                if crc32c::crc32c(&entries[start..]) != chunk.crc {
                    let message = format!("the checksum of the border log is wrong at {}", chunk.offset);
                    return Err(io::Error::new(io::ErrorKind::InvalidData, message));
                }
            }
            self.read += spilled as u64;
            entries.extend_from_slice(buffer);
        }
        Ok(GroupBorders::new(by_kind, tiles, self.has_z))
    }
}

/// The data of the borders of a group of tiles.
#[derive(Debug)]
pub(crate) struct GroupBorders {
    tiles: Range<u32>,
    boundary_edges: ByTile,
    triangles: ByTile,
    edges: ByTile,
    anchors: ByTile,
    /// Whether the vertices have z.
    pub(crate) has_z: bool,
}

impl GroupBorders {
    fn new([boundary_edges, triangles, edges, anchors]: [Vec<u8>; KINDS], tiles: Range<u32>, has_z: bool) -> Self {
        let of_one = |bytes: &[u8]| words::<1>(bytes);
        let of_triangle = |bytes: &[u8]| [0, CORNER, 2 * CORNER].map(|at| words::<1>(&bytes[at..])[0]);
        Self {
            boundary_edges: ByTile::new(boundary_edges, BOUNDARY_EDGE, &tiles, of_one),
            triangles: ByTile::new(triangles, triangle_bytes(has_z), &tiles, of_triangle),
            edges: ByTile::new(edges, EDGE, &tiles, of_one),
            anchors: ByTile::new(anchors, ANCHOR, &tiles, of_one),
            tiles,
            has_z,
        }
    }

    /// Returns the size in bytes.
    pub(crate) fn byte_size(&self) -> u64 {
        let by_kind = [&self.boundary_edges, &self.triangles, &self.edges, &self.anchors];
        by_kind.map(ByTile::byte_size).iter().sum::<usize>() as u64
    }

    /// Returns the tiles of the group.
    pub(crate) fn tiles(&self) -> Range<u32> {
        self.tiles.clone()
    }

    /// Returns the late triangles with a vertex in `tile`.
    pub(crate) fn triangles_of(&self, tile: TileId) -> impl Iterator<Item = LateTriangle> {
        self.triangles.of(tile.0 - self.tiles.start).map(LateTriangle::decode)
    }

    /// Returns the boundary half-edges of a tile's core.
    pub(crate) fn boundary_edges_of(&self, tile: TileId) -> Vec<BoundaryEdge> {
        let boundary_edges = self.boundary_edges.of(tile.0 - self.tiles.start).map(words);
        let open = boundary_edges.map(|[_, from, to, half_edge, component]| BoundaryEdge {
            from,
            to,
            half_edge: HalfEdge(half_edge & !CONSTRAINT),
            is_constraint: half_edge & CONSTRAINT != 0,
            component,
        });
        open.collect()
    }

    /// Returns the constraint edges that belong to `tile` and are not in its core, once for each of
    /// their sources.
    pub(crate) fn edges_of(&self, tile: TileId) -> impl Iterator<Item = LoggedEdge> {
        self.edges.of(tile.0 - self.tiles.start).map(|bytes| {
            let [tile, index, other_tile, other_index, low, high] = words(bytes);
            let id = |tile, index| VertexId {
                tile: TileId(tile),
                index: VertexIndex(index),
            };
            let source = LinePart::from_bits(u64::from(high) << 32 | u64::from(low));
            let [from_x, from_y, to_x, to_y] = floats(&bytes[24..]);
            LoggedEdge {
                ends: [id(tile, index), id(other_tile, other_index)],
                points: [Point::new(from_x, from_y), Point::new(to_x, to_y)],
                source,
            }
        })
    }

    /// Returns the anchors of a tile's components.
    pub(crate) fn anchors_of(&self, tile: TileId) -> impl Iterator<Item = Anchor> {
        self.anchors.of(tile.0 - self.tiles.start).map(|bytes| {
            let [_, component, deeper, triangles, sum @ ..]: [u32; 8] = words(bytes);
            let sum = sum.iter().rev().fold(0, |sum, &word| sum << 32 | u128::from(word));
            Anchor {
                component,
                deeper: deeper as i32,
                triangles: DigestSum {
                    count: triangles.into(),
                    sum,
                },
            }
        })
    }
}

fn floats<const N: usize>(bytes: &[u8]) -> [f64; N] {
    let (floats, _) = bytes.as_chunks::<8>();
    std::array::from_fn(|at| f64::from_le_bytes(floats[at]))
}

fn words<const N: usize>(bytes: &[u8]) -> [u32; N] {
    let (words, _) = bytes.as_chunks::<4>();
    std::array::from_fn(|at| u32::from_le_bytes(words[at]))
}
