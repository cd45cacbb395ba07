//! A cloud of points in an octree, and its COPC file.

use crate::input::hostile::Random;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Cursor, Write};

/// The step of the coordinates. It is coarse beside the cubes, so that points which are rounded to
/// steps after their node was chosen lie outside of its cube.
const STEP: f64 = 0.5;

/// The root: its centre, half its side, and the distance of its points.
pub const CENTRE: [f64; 3] = [1000.25, -500.5, 60.0];
pub const HALF: f64 = 128.0;
pub const SPACING: f64 = 16.0;

/// The level and the position of a node.
pub type Key = [i32; 4];

/// A point of the file.
pub struct Placed {
    pub key: Key,
    pub point: (f64, f64),
    pub z: f64,
}

/// A COPC file.
pub struct Cloud {
    /// In the order of the file.
    pub points: Vec<Placed>,
    pub bytes: Vec<u8>,
    /// The offsets of the entries of all pages, and that of the root page.
    pub entries: Vec<usize>,
    pub root: usize,
}

/// The chunk of a node: where it begins and ends, and its number of points.
type Chunk = (u64, u64, i32);

/// The number of levels of a page.
const PAGE_LEVELS: i32 = 2;

impl Cloud {
    /// Makes a file of random points, at most `most` in each node down to `levels` levels.
    pub fn new(random: &mut Random, count: usize, most: usize, levels: i32) -> Self {
        let mut nodes: BTreeMap<Key, Vec<[i32; 3]>> = BTreeMap::new();
        for n in 0..count {
            // Every other point lies in one corner, so that the tree is deep there.
            let share = if n % 2 == 0 { 1.0 } else { 0.125 };
            let at = [0, 1, 2].map(|_| (random.next() >> 11) as f64 / (1u64 << 53) as f64 * share * 2.0 * HALF);
            let key = |level: i32| {
                let side = 2.0 * HALF / f64::from(1 << level);
                let [x, y, z] = at.map(|at| (at / side).floor() as i32);
                [level, x, y, z]
            };
            let is_open = |level: &i32| nodes.get(&key(*level)).is_none_or(|points| points.len() < most);
            let level = (0..levels).find(is_open).unwrap_or(levels);
            let steps = [0, 1, 2].map(|axis| ((CENTRE[axis] - HALF + at[axis]) / STEP).round() as i32);
            nodes.entry(key(level)).or_default().push(steps);
        }
        // Writers choose the order of the nodes.
        let mut order: Vec<(Key, Vec<[i32; 3]>)> = nodes.into_iter().collect();
        for n in (1..order.len()).rev() {
            order.swap(n, random.below(n + 1));
        }
        write(&order)
    }

    pub fn records(&self, mut is_in: impl FnMut(&Placed) -> bool) -> Vec<u64> {
        let numbered = self.points.iter().enumerate();
        numbered
            .filter(|(_, point)| is_in(point))
            .map(|(n, _)| n as u64)
            .collect()
    }

    /// Returns the file with other bytes at an offset.
    pub fn with(&self, at: usize, bytes: &[u8]) -> Vec<u8> {
        let mut changed = self.bytes.clone();
        changed[at..at + bytes.len()].copy_from_slice(bytes);
        changed
    }
}

/// Returns whether a node meets a box, with room for the points that were rounded.
pub fn meets([level, x, y, _]: Key, bounds: [f64; 4]) -> bool {
    let side = 2.0 * HALF / f64::from(1 << level);
    let [low_x, low_y] = [(0, x), (1, y)].map(|(axis, n)| CENTRE[axis] - HALF + f64::from(n) * side);
    low_x - STEP <= bounds[2]
        && bounds[0] <= low_x + side + STEP
        && low_y - STEP <= bounds[3]
        && bounds[1] <= low_y + side + STEP
}

fn write(nodes: &[(Key, Vec<[i32; 3]>)]) -> Cloud {
    let vlr = laz::LazVlrBuilder::default()
        .with_point_format(6, 0)
        .unwrap()
        .with_variable_chunk_size()
        .build();
    let mut laszip = Vec::new();
    vlr.write_to(&mut laszip).unwrap();
    let count: usize = nodes.iter().map(|(_, points)| points.len()).sum();
    let start = 375 + 54 + 160 + 54 + laszip.len();
    let mut file = Cursor::new(header(start as u32, count as u64));
    file.set_position(375);
    file.write_all(&record(b"copc", 1, 160)).unwrap();
    let info = file.position() as usize;
    file.write_all(&[0; 160]).unwrap();
    file.write_all(&record(b"laszip encoded", 22204, laszip.len() as u16))
        .unwrap();
    file.write_all(&laszip).unwrap();

    let mut points = Vec::new();
    let mut chunks = BTreeMap::new();
    let mut compressor = laz::LasZipCompressor::new(file, vlr).unwrap();
    compressor.reserve_offset_to_chunk_table().unwrap();
    for (n, (key, steps)) in nodes.iter().enumerate() {
        // What is left after the last node is finished by `done`.
        if n > 0 {
            compressor.finish_current_chunk().unwrap();
        }
        chunks.insert(*key, (compressor.get().position(), steps.len() as i32));
        for steps in steps {
            compressor.compress_one(&raw(*steps)).unwrap();
            let [x, y, z] = steps.map(|n| f64::from(n) * STEP);
            points.push(Placed {
                key: *key,
                point: (x, y),
                z,
            });
        }
    }
    compressor.done().unwrap();
    let mut bytes = compressor.into_inner().into_inner();
    let starts: Vec<u64> = chunks.values().map(|(start, _)| *start).collect();
    let table = u64::from_le_bytes(bytes[start..start + 8].try_into().unwrap());
    let end = |start: u64| {
        starts
            .iter()
            .copied()
            .filter(|other| *other > start)
            .min()
            .unwrap_or(table)
    };
    let chunks: BTreeMap<Key, Chunk> = chunks
        .into_iter()
        .map(|(key, (start, points))| (key, (start, end(start), points)))
        .collect();

    let evlr = bytes.len();
    bytes[235..243].copy_from_slice(&(evlr as u64).to_le_bytes());
    bytes.extend(
        [
            [0; 2].as_slice(),
            &padded::<16>(b"copc"),
            &1000u16.to_le_bytes(),
            &[0; 40],
        ]
        .concat(),
    );
    let mut entries = Vec::new();
    let (root, length) = write_page(&mut bytes, &mut entries, &chunks, [0; 4]);
    let pages = (bytes.len() - evlr - 60) as u64;
    bytes[evlr + 20..evlr + 28].copy_from_slice(&pages.to_le_bytes());
    let floats = [CENTRE[0], CENTRE[1], CENTRE[2], HALF, SPACING].map(f64::to_le_bytes);
    bytes[info..info + 40].copy_from_slice(floats.as_flattened());
    let page = [root as u64, length as u64].map(u64::to_le_bytes);
    bytes[info + 40..info + 56].copy_from_slice(page.as_flattened());
    Cloud {
        points,
        bytes,
        entries,
        root,
    }
}

/// Writes the page of a node after those below it. Returns its offset and its length, and adds the
/// offsets of entries to `entries`.
fn write_page(bytes: &mut Vec<u8>, entries: &mut Vec<usize>, chunks: &BTreeMap<Key, Chunk>, of: Key) -> (usize, usize) {
    let below = of[0] + PAGE_LEVELS;
    let (mut page, mut deeper) = (Vec::new(), BTreeSet::new());
    for (&key, &(start, end, points)) in chunks {
        if key[0] < of[0] || ancestor(key, of[0]) != of {
            continue;
        }
        if key[0] < below {
            page.push(entry(key, start, (end - start) as i32, points));
        } else {
            deeper.insert(ancestor(key, below));
        }
    }
    // A node without points, as the format allows.
    page.push(entry([of[0] + 9, 0, 0, 0], 0, 0, 0));
    for key in deeper {
        let (offset, length) = write_page(bytes, entries, chunks, key);
        page.push(entry(key, offset as u64, length as i32, -1));
    }
    let offset = bytes.len();
    entries.extend((0..page.len()).map(|n| offset + 32 * n));
    bytes.extend(page.as_flattened());
    (offset, 32 * page.len())
}

fn ancestor([of, x, y, z]: Key, level: i32) -> Key {
    [level, x >> (of - level), y >> (of - level), z >> (of - level)]
}

pub fn entry(key: Key, offset: u64, bytes: i32, points: i32) -> [u8; 32] {
    let key = key.map(i32::to_le_bytes);
    let rest = [bytes, points].map(i32::to_le_bytes);
    let parts = [key.as_flattened(), &offset.to_le_bytes(), rest.as_flattened()];
    parts.concat().try_into().unwrap()
}

/// Returns a point of format 6: the only return, of class 2.
fn raw(steps: [i32; 3]) -> [u8; 30] {
    let mut raw = [0; 30];
    raw[..12].copy_from_slice(steps.map(i32::to_le_bytes).as_flattened());
    (raw[14], raw[16]) = (0x11, 2);
    raw
}

fn padded<const N: usize>(text: &[u8]) -> [u8; N] {
    std::array::from_fn(|n| text.get(n).copied().unwrap_or(0))
}

/// Returns the head of a variable length record.
fn record(user: &[u8], id: u16, length: u16) -> Vec<u8> {
    let numbers = [id, length].map(u16::to_le_bytes);
    [&[0; 2], &padded::<16>(user)[..], numbers.as_flattened(), &[0; 32]].concat()
}

/// Returns the header of a LAZ file of version 1.4 with two records and an extended one.
fn header(start: u32, count: u64) -> Vec<u8> {
    let mut header = vec![0; 375];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, b"LASF");
    put(24, &[1, 4]);
    put(94, &375u16.to_le_bytes());
    put(96, &start.to_le_bytes());
    put(100, &2u32.to_le_bytes());
    put(104, &[0x80 | 6, 30]);
    put(131, [STEP; 3].map(f64::to_le_bytes).as_flattened());
    put(243, &1u32.to_le_bytes());
    put(247, &count.to_le_bytes());
    header
}
