//! The encoding of chunks.
//!
//! ```text
//! numbers   0  the smallest number             u64
//!           8  bytes of each: 4 or 8           u32
//!          12  count                           u32
//!          16  each, minus the smallest        u32 or u64
//!
//! segments  0  length of the sources           u64
//!           8  sources                         numbers
//!              x, y of both ends of each       f64
//!              z of both, if there are any     f64
//! ```
//!
//! All values are little-endian. Lines are mostly consecutive, so sources take four bytes except in
//! unusual inputs.

use crate::constraints::segment::Segment;
use crate::geometry::Point;
use crate::store::LinePart;

/// Bytes before the numbers.
const HEADER: usize = 16;
/// Bytes of two points.
const ENDS: usize = 32;

/// Encodes numbers into `bytes`, whose contents it replaces.
pub(crate) fn encode_numbers(numbers: impl Iterator<Item = u64> + Clone, bytes: &mut Vec<u8>) {
    bytes.clear();
    append_numbers(numbers, bytes);
}

fn append_numbers(numbers: impl Iterator<Item = u64> + Clone, bytes: &mut Vec<u8>) {
    let bounds = numbers
        .clone()
        .fold((u64::MAX, 0, 0u32), |(least, most, count), number| {
            (least.min(number), most.max(number), count + 1)
        });
    let (least, most, count) = bounds;
    let is_wide = count > 0 && most - least > u64::from(u32::MAX);
    bytes.extend_from_slice(&least.to_le_bytes());
    bytes.extend_from_slice(&(if is_wide { 8u32 } else { 4 }).to_le_bytes());
    bytes.extend_from_slice(&count.to_le_bytes());
    for number in numbers {
        let more = number - least;
        if is_wide {
            bytes.extend_from_slice(&more.to_le_bytes());
        } else {
            bytes.extend_from_slice(&(more as u32).to_le_bytes());
        }
    }
}

/// Encoded numbers, read one by one.
#[derive(Clone, Debug)]
pub(crate) struct Numbers<'a> {
    least: u64,
    is_wide: bool,
    rest: &'a [u8],
}

impl<'a> Numbers<'a> {
    /// Reads the header of encoded numbers. Returns `None` if `bytes` is not an encoding of
    /// numbers.
    pub(crate) fn decode(bytes: &'a [u8]) -> Option<Self> {
        let (header, rest) = bytes.split_first_chunk::<HEADER>()?;
        let (words, _) = header.as_chunks::<4>();
        let width = u32::from_le_bytes(words[2]);
        let count = u32::from_le_bytes(words[3]);
        let fits = matches!(width, 4 | 8) && rest.len() as u64 == u64::from(width) * u64::from(count);
        fits.then(|| Self {
            least: word(header, 0),
            is_wide: width == 8,
            rest,
        })
    }
}

impl Iterator for Numbers<'_> {
    type Item = u64;

    #[inline]
    fn next(&mut self) -> Option<u64> {
        let more = if self.is_wide {
            let (first, rest) = self.rest.split_first_chunk()?;
            self.rest = rest;
            u64::from_le_bytes(*first)
        } else {
            let (first, rest) = self.rest.split_first_chunk()?;
            self.rest = rest;
            u64::from(u32::from_le_bytes(*first))
        };
        Some(self.least.wrapping_add(more))
    }
}

fn word(bytes: &[u8; HEADER], at: usize) -> u64 {
    let (words, _) = bytes.as_chunks::<8>();
    u64::from_le_bytes(words[at])
}

/// Encodes segments, and their z if there are any, into `bytes`, whose contents it replaces.
pub(crate) fn encode_segments(segments: &[Segment], z: &[[f64; 2]], bytes: &mut Vec<u8>) {
    bytes.clear();
    bytes.extend_from_slice(&[0; 8]);
    append_numbers(segments.iter().map(|segment| segment.source.to_bits()), bytes);
    let length = bytes.len() as u64 - 8;
    bytes[..8].copy_from_slice(&length.to_le_bytes());
    for Segment { ends: [a, b], .. } in segments {
        let coordinates = [a.x, a.y, b.x, b.y].map(f64::to_le_bytes);
        bytes.extend_from_slice(coordinates.as_flattened());
    }
    for z in z {
        bytes.extend_from_slice(z.map(f64::to_le_bytes).as_flattened());
    }
}

/// An encoded chunk of segments.
#[derive(Clone, Debug)]
pub(crate) struct SegmentChunk<'a> {
    sources: Numbers<'a>,
    ends: &'a [[u8; ENDS]],
    z: &'a [[u8; 8]],
}

impl<'a> SegmentChunk<'a> {
    /// Reads an encoded chunk. Returns `None` if `bytes` is not an encoding of segments.
    pub(crate) fn decode(bytes: &'a [u8]) -> Option<Self> {
        let (length, rest) = bytes.split_first_chunk()?;
        let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
        let (numbers, rest) = rest.split_at_checked(length)?;
        let count = u32::from_le_bytes(*numbers[..].get(12..)?.first_chunk()?) as usize;
        let sources = Numbers::decode(numbers)?;
        let (ends, z) = rest.split_at_checked(count.checked_mul(ENDS)?)?;
        let ((ends, _), (z, [])) = (ends.as_chunks(), z.as_chunks()) else {
            return None;
        };
        (z.is_empty() || z.len() == 2 * count).then_some(Self { sources, ends, z })
    }

    /// Returns the segments.
    pub(crate) fn segments(self) -> impl Iterator<Item = Segment> + 'a {
        let ends = self.ends.iter().map(|ends| {
            let (c, _) = ends.as_chunks();
            let [a, b, c, d] = [0, 1, 2, 3].map(|at| f64::from_le_bytes(c[at]));
            [Point::new(a, b), Point::new(c, d)]
        });
        ends.zip(self.sources).map(|(ends, source)| Segment {
            ends,
            source: LinePart::from_bits(source),
        })
    }

    /// Returns the z of each end, or nothing.
    pub(crate) fn z(&self) -> impl Iterator<Item = f64> + 'a {
        self.z.iter().map(|&z| f64::from_le_bytes(z))
    }
}
