//! A small sample of the points of all inputs, taken before any input is read.
//!
//! In: files whose records have a fixed length, so that each record can be read without those
//! before it. Out: points in input order. The records of all files form one sequence, which is cut
//! into equal parts. Each part gives a few neighbouring records, whose offset in the part is a hash
//! of the part's number: evenly spaced offsets would interfere with the rows of a grid or the lines
//! of a scanner. There are no random numbers: the same inputs give the same sample.

use crate::geometry::Point;
use crate::input::error::InputError;
use crate::input::watch::open_file;
use std::fs::File;
use std::io;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;
use xxhash_rust::xxh3::xxh3_64;

/// The limit on the bytes read, apart from one record per part.
const MOST_BYTES: usize = 4 << 20;

/// The limit on the number of parts; each part costs a read.
const MOST_PARTS: usize = 4096;

/// The number of points that a part gives, unless there are too many parts. It is small because
/// neighbours in a file are often neighbours in the plane, and tell less than points from
/// elsewhere.
const NEIGHBOURS: usize = 16;

/// Decodes the point of a record; `None` if the record is not one to keep. The point may be
/// invalid.
type Decode = dyn Fn(&[u8]) -> Option<Point> + Send + Sync;

/// Reading of the records of a file in any order. All records are within the file's size at open.
pub struct RandomAccess {
    /// The offset of the first record, in bytes.
    pub start: u64,
    /// The number of records.
    pub count: u64,
    /// The length of a record in bytes; not 0.
    pub length: usize,
    pub decode: Box<Decode>,
}

/// Returns about `count` valid points of the files, in order; fewer if the files have fewer.
pub fn sample<'a>(
    files: impl Iterator<Item = (&'a Path, &'a RandomAccess)> + Clone,
    count: usize,
) -> Result<Vec<Point>, InputError> {
    let total = files
        .clone()
        .fold(0u64, |sum, (_, file)| sum.saturating_add(file.count));
    let longest = files.clone().map(|(_, file)| file.length).max().unwrap_or(1);
    let parts = parts(total, count.min(MOST_BYTES / longest));
    let mut points = Vec::new();
    let mut before = 0u64;
    for (path, records) in files {
        let end = before.saturating_add(records.count);
        let first = parts.partition_point(|part| part.end <= before);
        let here = parts[first..].iter().take_while(|part| part.start < end);
        let mut here = here.map(|part| part.start.max(before) - before..part.end.min(end) - before);
        if let Some(part) = here.next() {
            let (mut file, _) = open_file(path)?;
            for part in std::iter::once(part).chain(here) {
                let offset = records.start + part.start * records.length as u64;
                let bytes = read(&mut file, offset, (part.end - part.start) as usize * records.length);
                let bytes = bytes.map_err(|source| InputError::read(path, offset, source))?;
                let found = bytes.chunks_exact(records.length).filter_map(&records.decode);
                points.extend(found.filter(|point| point.is_valid()).map(Point::normalized));
            }
        }
        before = end;
    }
    Ok(points)
}

/// Returns disjoint ranges, ascending, of about `count` of the numbers below `total`.
fn parts(total: u64, count: usize) -> Vec<Range<u64>> {
    let parts = count.div_ceil(NEIGHBOURS).min(MOST_PARTS) as u64;
    if parts == 0 {
        return Vec::new();
    }
    let wanted = (count as u64).div_ceil(parts);
    let cut = |part: u64| (u128::from(total) * u128::from(part) / u128::from(parts)) as u64;
    let part = |n: u64| {
        let (start, end) = (cut(n), cut(n + 1));
        let length = wanted.min(end - start);
        let start = start + xxh3_64(&n.to_le_bytes()) % (end - start - length + 1);
        start..start + length
    };
    (0..parts).map(part).filter(|part| !part.is_empty()).collect()
}

/// Reads bytes of the file from `offset` on: fewer than `length` if the file became shorter, which
/// the actual reading reports.
fn read(file: &mut File, offset: u64, length: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(length);
    file.seek(SeekFrom::Start(offset))?;
    file.take(length as u64).read_to_end(&mut bytes)?;
    Ok(bytes)
}
