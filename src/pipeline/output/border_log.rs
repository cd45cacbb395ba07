//! The border log: what borders are made of, spilled until they are put together.
//!
//! Tiles are taken in groups of neighbours in leaf order. A group gets the open sides of its tiles' cores, and every late
//! triangle with a vertex in it; where there are segments, also the constraint edges that belong to its tiles and are not in
//! their cores, and the anchors of its tiles' components. What it gets fills a buffer; full buffers go to the end of one file, as checksummed chunks.
//! After the root the log is read back group by group, so borders are made in leaf order and memory holds one group at a time.
//!
//! Where the chunks of a finished block lie goes to the journal, so that a build that goes on finds them again.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::sync::Arc;

use crate::geometry::Point;
use crate::geometry::{HalfEdge, VertexIndex};
use crate::mesh::WALLS;
use crate::pipeline::records::{Anchor, DoneEdge, GroupChunks, KINDS, LateTriangle, OpenSide, SeamVertex};
use crate::store::{EdgeSource, Extent, TileId, VertexId};

/// Bytes of a corner: tile, place, x, y.
const CORNER: usize = 24;
/// In the place of a corner, or the number of a side: the side is a constraint, and a wall.
const CONSTRAINT: u32 = 1 << 31;
const WALL: u32 = 1 << 30;
/// Bytes of a triangle in the log: its corners and its number.
const TRIANGLE: usize = 3 * CORNER + 4;
/// Bytes of an open side in the log: tile, from, to, side, component.
const SIDE: usize = 20;
/// Bytes of a constraint edge in the log: tile and place of both ends, source. It belongs to the first one's tile.
const EDGE: usize = 24;
/// Bytes of an anchor in the log: tile, component, how much deeper, triangles.
const ANCHOR: usize = 16;
/// Bytes of a buffer, at most.
const BUFFER: usize = 64 << 10;

impl LateTriangle {
    fn encode(&self, bytes: &mut Vec<u8>) {
        for (corner, side) in self.corners.iter().zip(0..) {
            let bit = |at: u32, mark: u32| if self.side_bits >> at & 1 == 1 { mark } else { 0 };
            let mark = bit(side, CONSTRAINT) | bit(side + WALLS, WALL);
            bytes.extend_from_slice(&corner.id.tile.0.to_le_bytes());
            bytes.extend_from_slice(&(corner.id.index.0 | mark).to_le_bytes());
            bytes.extend_from_slice(&corner.point.x.to_le_bytes());
            bytes.extend_from_slice(&corner.point.y.to_le_bytes());
        }
        bytes.extend_from_slice(&self.number.to_le_bytes());
    }

    fn decode(bytes: &[u8]) -> Self {
        let word = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"));
        let mut side_bits = 0;
        let corners = [0, 1, 2].map(|side| {
            let id = word(side * CORNER);
            let place = (id >> 32) as u32;
            side_bits |= u8::from(place & CONSTRAINT != 0) << side;
            side_bits |= u8::from(place & WALL != 0) << (side as u32 + WALLS);
            let coordinate = |axis: usize| f64::from_bits(word(side * CORNER + 8 + 8 * axis));
            SeamVertex {
                id: VertexId {
                    tile: TileId(id as u32),
                    index: VertexIndex(place & !(CONSTRAINT | WALL)),
                },
                point: Point::new(coordinate(0), coordinate(1)),
            }
        });
        Self {
            corners,
            side_bits,
            number: words::<1>(&bytes[3 * CORNER..])[0],
        }
    }
}

/// Each value once.
fn distinct([a, b, c]: [u32; 3]) -> impl Iterator<Item = u32> {
    let values = [Some(a), (b != a).then_some(b), (c != a && c != b).then_some(c)];
    values.into_iter().flatten()
}

const SIDES: usize = 0;
const TRIANGLES: usize = 1;
const EDGES: usize = 2;
const ANCHORS: usize = 3;

/// The log while it is written.
#[derive(Debug)]
pub(crate) struct BorderLog {
    file: Arc<File>,
    length: u64,
    tiles: u32,
    tiles_per_group: u32,
    groups: Vec<Group>,
    /// Triangles so far.
    triangles: u64,
    /// Bytes in all buffers, and how many there may be.
    buffered: usize,
    buffers: usize,
    written: u64,
    read: u64,
}

#[derive(Debug, Default)]
struct Group {
    first_tile: u32,
    buffers: [Vec<u8>; KINDS],
    chunks: GroupChunks,
}

impl BorderLog {
    /// Starts a log in a file, behind its first `length` bytes, with buffers of so many bytes, for tiles of so many
    /// vertices.
    pub(crate) fn new(file: Arc<File>, length: u64, buffers: usize, tile_vertices: usize) -> Self {
        Self {
            file,
            length,
            tiles: 0,
            // A tile has about 16 √m late triangles, so a group has some 65,000, which are a few megabytes.
            tiles_per_group: (4096.0 / (tile_vertices as f64).sqrt()).ceil() as u32,
            groups: Vec::new(),
            triangles: 0,
            buffered: 0,
            buffers,
            written: 0,
            read: 0,
        }
    }

    /// Makes room for the tiles of another block.
    pub(crate) fn add_tiles(&mut self, tiles: u32) {
        let end = self.tiles + tiles;
        let groups = (self.tiles..end).step_by(self.tiles_per_group as usize);
        self.groups.extend(groups.map(|first_tile| Group {
            first_tile,
            ..Group::default()
        }));
        self.tiles = end;
    }

    /// The groups of the tiles of a block.
    fn groups_of(&self, tiles: Range<u32>) -> Range<usize> {
        let before = |tile: u32| self.groups.partition_point(|group| group.first_tile < tile);
        before(tiles.start)..before(tiles.end)
    }

    fn group_of(&self, tile: u32) -> usize {
        self.groups.partition_point(|group| group.first_tile <= tile) - 1
    }

    /// Appends the open sides of a tile.
    pub(crate) fn append_sides(&mut self, tile: TileId, sides: &[OpenSide]) -> io::Result<()> {
        let group = self.group_of(tile.0);
        let buffer = &mut self.groups[group].buffers[SIDES];
        for side in sides {
            let mark = if side.is_constraint { CONSTRAINT } else { 0 };
            for word in [tile.0, side.from, side.to, side.side.0 | mark, side.component] {
                buffer.extend_from_slice(&word.to_le_bytes());
            }
        }
        self.buffered += sides.len() * SIDE;
        self.relieve(group, SIDES)
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
            for word in [tile.0, anchor.component, anchor.deeper as u32, anchor.triangles] {
                buffer.extend_from_slice(&word.to_le_bytes());
            }
        }
        self.buffered += anchors.len() * ANCHOR;
        self.relieve(group, ANCHORS)
    }

    /// Appends triangles, and numbers them.
    pub(crate) fn append_triangles(&mut self, triangles: &[LateTriangle]) -> io::Result<()> {
        for triangle in triangles {
            let number = u32::try_from(self.triangles).map_err(|_| io::ErrorKind::FileTooLarge)?;
            let triangle = LateTriangle { number, ..*triangle };
            self.triangles += 1;
            for group in distinct(triangle.corners.map(|v| self.group_of(v.id.tile.0) as u32)) {
                triangle.encode(&mut self.groups[group as usize].buffers[TRIANGLES]);
                self.buffered += TRIANGLE;
                self.relieve(group as usize, TRIANGLES)?;
            }
        }
        Ok(())
    }

    /// Writes a buffer that is full, and all of them if together they are too large.
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
        let Group { buffers, chunks, .. } = &mut self.groups[group];
        if buffers[kind].is_empty() {
            return Ok(());
        }
        // The memory goes too: most groups get nothing more, or little.
        let buffer = std::mem::take(&mut buffers[kind]);
        self.file.write_all_at(&buffer, self.length)?;
        chunks[kind].push(Extent {
            offset: self.length,
            length: buffer.len() as u32,
            crc: crc32c::crc32c(&buffer),
        });
        self.length += buffer.len() as u64;
        self.written += buffer.len() as u64;
        self.buffered -= buffer.len();
        Ok(())
    }

    /// Writes all that there is of the tiles of a block, and tells where it lies, and how many triangles it has.
    pub(crate) fn finish_block(&mut self, tiles: Range<u32>) -> io::Result<Vec<GroupChunks>> {
        let groups = self.groups_of(tiles);
        for group in groups.clone() {
            self.write_all(group)?;
        }
        Ok(self.groups[groups].iter().map(|group| group.chunks.clone()).collect())
    }

    /// Takes up the tiles of a block that a build before has finished.
    pub(crate) fn restore(&mut self, tiles: u32, chunks: Vec<GroupChunks>, triangles: u64) {
        let first = self.groups.len();
        self.add_tiles(tiles);
        for (group, chunks) in self.groups[first..].iter_mut().zip(chunks) {
            group.chunks = chunks;
        }
        self.triangles += triangles;
    }

    /// How many triangles were appended.
    pub(crate) fn triangle_count(&self) -> u64 {
        self.triangles
    }

    /// Bytes that were read back and written.
    pub(crate) fn traffic(&self) -> [u64; 2] {
        [self.read, self.written]
    }

    /// How many groups there are.
    pub(crate) fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// Reads a group back, and forgets it.
    pub(crate) fn take_group(&mut self, number: usize) -> io::Result<GroupBorders> {
        let borders = self.read_group(number);
        self.forget_group(number);
        borders
    }

    /// Forgets a group.
    pub(crate) fn forget_group(&mut self, number: usize) {
        let Group {
            first_tile, buffers, ..
        } = std::mem::take(&mut self.groups[number]);
        self.groups[number].first_tile = first_tile;
        self.buffered -= buffers.iter().map(Vec::len).sum::<usize>();
    }

    /// Reads a group back.
    pub(crate) fn read_group(&mut self, number: usize) -> io::Result<GroupBorders> {
        let Group {
            first_tile,
            buffers,
            chunks,
        } = &self.groups[number];
        let end = self.groups.get(number + 1).map_or(self.tiles, |next| next.first_tile);
        let tiles = *first_tile..end;
        let mut parts = [const { Vec::new() }; KINDS];
        for ((part, buffer), chunks) in parts.iter_mut().zip(buffers).zip(chunks) {
            let spilled: usize = chunks.iter().map(|chunk| chunk.length as usize).sum();
            part.reserve_exact(spilled + buffer.len());
            for chunk in chunks {
                let start = part.len();
                part.resize(start + chunk.length as usize, 0);
                self.file.read_exact_at(&mut part[start..], chunk.offset)?;
                if crc32c::crc32c(&part[start..]) != chunk.crc {
                    let message = format!("the checksum of the border log is wrong at {}", chunk.offset);
                    return Err(io::Error::new(io::ErrorKind::InvalidData, message));
                }
            }
            self.read += spilled as u64;
            part.extend_from_slice(buffer);
        }
        Ok(GroupBorders::new(parts, tiles))
    }
}

/// What the borders of a group of tiles are made of.
#[derive(Debug)]
pub(crate) struct GroupBorders {
    tiles: Range<u32>,
    sides: ByTile,
    triangles: ByTile,
    edges: ByTile,
    anchors: ByTile,
}

/// Entries of one length, and which belong to each tile.
#[derive(Debug)]
struct ByTile {
    bytes: Vec<u8>,
    entry: usize,
    /// Numbers of entries, tile by tile.
    numbers: Vec<u32>,
    /// For each tile where its numbers start; and the end.
    starts: Vec<usize>,
}

impl ByTile {
    /// Entries of which `tiles_of` reads up to so many tiles, some of them perhaps of other groups.
    fn new<const N: usize>(
        bytes: Vec<u8>,
        entry: usize,
        tiles: &Range<u32>,
        tiles_of: impl Fn(&[u8]) -> [u32; N],
    ) -> Self {
        let mut starts = vec![0; tiles.len() + 1];
        let in_group = |bytes: &[u8]| {
            let its = tiles_of(bytes);
            // Each tile once.
            let places = its
                .into_iter()
                .enumerate()
                .filter(move |&(at, tile)| !its[..at].contains(&tile));
            let in_group = places.filter(|(_, tile)| tiles.contains(tile));
            in_group.map(|(_, tile)| (tile - tiles.start) as usize)
        };
        for bytes in bytes.chunks_exact(entry) {
            in_group(bytes).for_each(|place| starts[place + 1] += 1);
        }
        for place in 1..starts.len() {
            starts[place] += starts[place - 1];
        }
        let mut numbers = vec![0; starts[tiles.len()]];
        let mut next = starts.clone();
        for (bytes, number) in bytes.chunks_exact(entry).zip(0..) {
            for place in in_group(bytes) {
                numbers[next[place]] = number;
                next[place] += 1;
            }
        }
        Self {
            bytes,
            entry,
            numbers,
            starts,
        }
    }

    fn of(&self, place: u32) -> impl Iterator<Item = &[u8]> {
        let numbers = &self.numbers[self.starts[place as usize]..self.starts[place as usize + 1]];
        numbers.iter().map(|&number| {
            let at = number as usize * self.entry;
            &self.bytes[at..at + self.entry]
        })
    }
}

impl GroupBorders {
    fn new([sides, triangles, edges, anchors]: [Vec<u8>; KINDS], tiles: Range<u32>) -> Self {
        let of_one = |bytes: &[u8]| words::<1>(bytes);
        let of_triangle = |bytes: &[u8]| [0, CORNER, 2 * CORNER].map(|at| words::<1>(&bytes[at..])[0]);
        Self {
            sides: ByTile::new(sides, SIDE, &tiles, of_one),
            triangles: ByTile::new(triangles, TRIANGLE, &tiles, of_triangle),
            edges: ByTile::new(edges, EDGE, &tiles, of_one),
            anchors: ByTile::new(anchors, ANCHOR, &tiles, of_one),
            tiles,
        }
    }

    /// Bytes that it takes.
    pub(crate) fn byte_size(&self) -> u64 {
        let parts = [&self.sides, &self.triangles, &self.edges, &self.anchors];
        let bytes = parts.map(|part| part.bytes.len() + 4 * part.numbers.len() + 8 * part.starts.len());
        bytes.iter().sum::<usize>() as u64
    }

    /// The tiles of the group.
    pub(crate) fn tiles(&self) -> Range<u32> {
        self.tiles.clone()
    }

    /// The late triangles with a vertex in a tile.
    pub(crate) fn triangles_of(&self, tile: TileId) -> impl Iterator<Item = LateTriangle> {
        self.triangles.of(tile.0 - self.tiles.start).map(LateTriangle::decode)
    }

    /// The open sides of a tile's core.
    pub(crate) fn sides_of(&self, tile: TileId) -> Vec<OpenSide> {
        let sides = self.sides.of(tile.0 - self.tiles.start).map(words);
        let open = sides.map(|[_, from, to, side, component]| OpenSide {
            from,
            to,
            side: HalfEdge(side & !CONSTRAINT),
            is_constraint: side & CONSTRAINT != 0,
            component,
        });
        open.collect()
    }

    /// The constraint edges that belong to a tile and are not in its core, each from the end in the tile on.
    pub(crate) fn edges_of(&self, tile: TileId) -> impl Iterator<Item = ([VertexId; 2], EdgeSource)> {
        self.edges.of(tile.0 - self.tiles.start).map(|bytes| {
            let [tile, index, other_tile, other_index, low, high] = words(bytes);
            let id = |tile, index| VertexId {
                tile: TileId(tile),
                index: VertexIndex(index),
            };
            let source = EdgeSource::from_bits(u64::from(high) << 32 | u64::from(low));
            ([id(tile, index), id(other_tile, other_index)], source)
        })
    }

    /// The anchors of a tile's components.
    pub(crate) fn anchors_of(&self, tile: TileId) -> impl Iterator<Item = Anchor> {
        self.anchors.of(tile.0 - self.tiles.start).map(|bytes| {
            let [_, component, deeper, triangles] = words(bytes);
            Anchor {
                component,
                deeper: deeper as i32,
                triangles,
            }
        })
    }
}

fn words<const N: usize>(bytes: &[u8]) -> [u32; N] {
    let (words, _) = bytes.as_chunks::<4>();
    std::array::from_fn(|at| u32::from_le_bytes(words[at]))
}
