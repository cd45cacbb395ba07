//! A run: the points of one cell, in a file of checksummed chunks.
//!
//! ```text
//! chunk   0  CRC-32C of the rest of the chunk     u32
//!         4  bytes after the header               u32
//!         8  points                               u32
//!        12  1 if the points have z               u32
//!        16  x, y of each                         f64
//!            z of each, if there are any          f64
//!            record of each, less the previous one (the first: less 0): zigzag, 7 bits to the byte
//! ```
//!
//! All numbers are little-endian. The records of a cell come almost in order, so most take a byte
//! or two.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use crate::constraints::without_z::NO_Z;
use crate::geometry::Point;
use crate::pipeline::ingest::point_store::Record;
use crate::pipeline::plan::{Run, path_of_run};

/// Bytes of a chunk's header.
pub(crate) const HEADER: usize = 16;
/// Most bytes of a point in a chunk.
const MAX_POINT: usize = 16 + 8 + 10;

/// A run while it is written. Whole chunks are appended to its file.
#[derive(Debug)]
pub(crate) struct RunWriter {
    run: Run,
    path: PathBuf,
    /// Created with the first chunk.
    file: Option<File>,
    /// Whether the file stays open between chunks.
    stays_open: bool,
    coordinates: Vec<u8>,
    z: Vec<u8>,
    records: Vec<u8>,
    last_record: u64,
    /// Bytes of coordinates and z at which a chunk is full.
    capacity: usize,
}

impl RunWriter {
    /// Starts a run with a buffer of `buffer` bytes.
    pub(crate) fn new(folder: &Path, number: u32, buffer: usize, stays_open: bool) -> Self {
        Self {
            run: Run {
                number,
                ..Run::default()
            },
            path: path_of_run(folder, number),
            file: None,
            stays_open,
            coordinates: Vec::new(),
            z: Vec::new(),
            records: Vec::new(),
            last_record: 0,
            capacity: (buffer / 20).max(1) * 16,
        }
    }

    /// Lets the name of the file, which is not created yet, end with `suffix`.
    pub(crate) fn name(&mut self, suffix: &str) {
        self.path.as_mut_os_string().push(suffix);
    }

    /// Adds a point. Either all or none of the points of a chunk must have z.
    #[inline]
    pub(crate) fn push(&mut self, point: Point, z: Option<f64>, record: u64) -> io::Result<()> {
        if self.coordinates.is_empty() {
            self.reserve(z.is_some());
        }
        let coordinates = [point.x.to_le_bytes(), point.y.to_le_bytes()];
        self.coordinates.extend_from_slice(coordinates.as_flattened());
        if let Some(z) = z {
            self.z.extend_from_slice(&z.to_le_bytes());
        }
        put_varint(&mut self.records, zigzag(record.wrapping_sub(self.last_record) as i64));
        self.last_record = record;
        if self.coordinates.len() + self.z.len() >= self.capacity {
            self.flush()?;
        }
        Ok(())
    }

    /// Makes room for a chunk. Buffers that grow would leave freed memory of their former sizes
    /// behind, which the allocator keeps.
    fn reserve(&mut self, has_z: bool) {
        let points = 1 + self.capacity / if has_z { 24 } else { 16 };
        self.coordinates.reserve_exact(16 * points);
        self.z.reserve_exact(if has_z { 8 * points } else { 0 });
        self.records.reserve_exact(2 * points);
    }

    /// Ends the chunk and writes it.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        if self.coordinates.is_empty() {
            return Ok(());
        }
        let points = self.coordinates.len() / 16;
        let length = self.coordinates.len() + self.z.len() + self.records.len();
        let mut chunk = Vec::with_capacity(HEADER + length);
        chunk.extend_from_slice(&[0; 4]);
        for word in [length as u32, points as u32, u32::from(!self.z.is_empty())] {
            chunk.extend_from_slice(&word.to_le_bytes());
        }
        for part in [&mut self.coordinates, &mut self.z, &mut self.records] {
            chunk.extend_from_slice(part);
            part.clear();
        }
        let crc = crc32c::crc32c(&chunk[4..]);
        chunk[..4].copy_from_slice(&crc.to_le_bytes());
        let file = match &mut self.file {
            Some(file) => file,
            none if self.run.length == 0 => none.insert(File::create(&self.path)?),
            none => none.insert(File::options().write(true).open(&self.path)?),
        };
        file.write_all_at(&chunk, self.run.length)?;
        if !self.stays_open {
            self.file = None;
        }
        self.run.length += chunk.len() as u64;
        self.run.points += points as u64;
        self.last_record = 0;
        Ok(())
    }

    /// Ends the chunk and writes it. Returns the run so far.
    pub(crate) fn flushed(&mut self) -> io::Result<Run> {
        self.flush()?;
        Ok(self.run.clone())
    }

    /// Writes the last chunk and returns the run.
    pub(crate) fn finish(mut self) -> io::Result<Run> {
        self.flush()?;
        Ok(self.run)
    }
}

/// Returns the length of the chunk with this header, including the header. `left` is the number of
/// bytes from the chunk's start to the end of the run. The error says what is wrong.
pub(crate) fn chunk_length(header: &[u8; HEADER], left: u64) -> Result<usize, &'static str> {
    let word = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
    let (length, points) = (word(4) as usize, word(8) as usize);
    if length < points.saturating_mul(17) || length > points.saturating_mul(MAX_POINT) {
        return Err("the length of a chunk does not fit its points");
    }
    if (HEADER + length) as u64 > left {
        return Err("a chunk reaches beyond the end");
    }
    Ok(HEADER + length)
}

/// Passes the points of a whole chunk to `take`. The error says what is wrong.
pub(crate) fn decode_chunk(chunk: &[u8], mut take: impl FnMut(Record)) -> Result<(), &'static str> {
    let word = |at: usize| u32::from_le_bytes([chunk[at], chunk[at + 1], chunk[at + 2], chunk[at + 3]]);
    if word(0) != crc32c::crc32c(&chunk[4..]) {
        return Err("the checksum of a chunk is wrong");
    }
    let (points, has_z) = (word(8) as usize, word(12) == 1);
    let body = &chunk[HEADER..];
    let z_at = points * 16;
    let records_at = z_at + if has_z { points * 8 } else { 0 };
    let (Some(coordinates), Some(z), Some(mut records)) =
        (body.get(..z_at), body.get(z_at..records_at), body.get(records_at..))
    else {
        return Err("a chunk is shorter than its points");
    };
    let (coordinates, _) = coordinates.as_chunks::<16>();
    let (z, _) = z.as_chunks::<8>();
    let mut record = 0u64;
    for (index, point) in coordinates.iter().enumerate() {
        let (numbers, _) = point.as_chunks::<8>();
        let step = take_varint(&mut records).ok_or("the records of a chunk end early")?;
        record = record.wrapping_add(unzigzag(step) as u64);
        take(Record {
            point: Point::new(f64::from_le_bytes(numbers[0]), f64::from_le_bytes(numbers[1])),
            z: z.get(index).map_or(NO_Z, |&z| f64::from_le_bytes(z)),
            record,
        });
    }
    Ok(())
}

fn zigzag(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}

fn unzigzag(value: u64) -> i64 {
    (value >> 1) as i64 ^ -((value & 1) as i64)
}

#[inline]
fn put_varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

#[inline]
fn take_varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let (&byte, rest) = bytes.split_first()?;
        *bytes = rest;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Some(value);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn the_buffers_of_a_run_keep_to_their_bytes() {
        let folder = tempfile::tempdir().unwrap();
        for z in [None, Some(0.5)] {
            let mut writer = RunWriter::new(folder.path(), 0, 8000, true);
            for record in 0..5000 {
                writer.push(Point::new(0.0, 1.0), z, record * 7).unwrap();
                let buffers = [&writer.coordinates, &writer.z, &writer.records];
                assert!(buffers.map(Vec::capacity).iter().sum::<usize>() <= 8000);
            }
            assert!(writer.run.points > 0);
        }
    }

    #[test]
    fn a_file_that_is_opened_for_each_chunk_has_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let points = (0..1000u32).map(|i| {
            (
                Point::new(f64::from(i), 0.5),
                Some(f64::from(i) / 3.0),
                u64::from(i * 7 % 50),
            )
        });
        let points: Vec<_> = points.collect();
        let [stays, opened] = [(0, true), (1, false)].map(|(number, stays_open)| {
            let mut writer = RunWriter::new(folder.path(), number, 400, stays_open);
            points
                .iter()
                .for_each(|&(point, z, record)| writer.push(point, z, record).unwrap());
            let run = writer.finish().unwrap();
            assert_eq!(run.points, 1000);
            let bytes = fs::read(run.path(folder.path())).unwrap();
            assert_eq!(run.length, bytes.len() as u64);
            bytes
        });
        assert_eq!(stays, opened);
        let (mut left, mut read) = (&opened[..], Vec::new());
        while let Some(header) = left.first_chunk() {
            let (chunk, rest) = left.split_at(chunk_length(header, left.len() as u64).unwrap());
            decode_chunk(chunk, |record| read.push((record.point, Some(record.z), record.record))).unwrap();
            left = rest;
        }
        assert!(read == points && opened.len() > 1000 * 17 + 20 * HEADER);
    }
}
