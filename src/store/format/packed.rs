//! Arrays of unsigned integers, each stored in as few bytes as the largest needs.
//!
//! Layout: `width` bytes per integer, little-endian, then 8 − `width` bytes of padding. Because of
//! the padding, reading an integer is a load of eight bytes and a mask.

use std::ops::RangeInclusive;

use bytes::Bytes;
use flatbuffers::FlatBufferBuilder;
use flatbuffers::WIPOffset;

use crate::store::format::damage::Damage;
use crate::store::format::generated::tile as schema;

/// A packed array that is read in place.
#[derive(Clone, Debug)]
pub(crate) struct Packed {
    data: Bytes,
    width: usize,
    mask: u64,
    len: usize,
}

impl Packed {
    /// Opens the array in a verified buffer. The error says what is wrong with it.
    pub(crate) fn open(buffer: &Bytes, table: schema::Packed<'_>) -> Result<Self, Damage> {
        let width = usize::from(table.width());
        if !(1..=8).contains(&width) {
            return Err(Damage::new(format!(
                "packed integers have {width} bytes each, not 1 to 8"
            )));
        }
        let data = table.data().map_or(&[][..], |data| data.bytes());
        let Some(length) = data.len().checked_sub(8 - width).filter(|l| l.is_multiple_of(width)) else {
            return Err(Damage::new(format!(
                "{} bytes do not hold integers of {width} bytes",
                data.len()
            )));
        };
        Ok(Self {
            data: buffer.slice_ref(data),
            width,
            mask: mask(width),
            len: length / width,
        })
    }

    /// Returns the number of integers.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Returns the largest value of this width. Marks are numbered from this value downwards.
    pub(crate) fn largest(&self) -> u64 {
        self.mask
    }

    /// Returns the size of the array in bytes.
    pub(crate) fn byte_size(&self) -> usize {
        self.data.len()
    }

    /// Returns the integer at `index`.
    ///
    /// # Panics
    ///
    /// Panics if `index` is out of range.
    #[inline]
    pub(crate) fn get(&self, index: usize) -> u64 {
        assert!(index < self.len);
        let at = index * self.width;
        let word: [u8; 8] = self.data[at..at + 8].try_into().expect("eight bytes");
        u64::from_le_bytes(word) & self.mask
    }

    /// Returns a value within `range`, if there is one. If there is none, the search takes no
    /// longer than reading the array.
    pub(crate) fn find_within(&self, range: RangeInclusive<u64>) -> Option<u64> {
        // No early exit, and one loop per width, so that the compiler can vectorise the
        // comparisons.
        let bytes = &self.data[..self.len * self.width];
        let found = match self.width {
            1 => any_within(bytes, &range, |[a]: [u8; 1]| a),
            2 => any_within(bytes, &range, u16::from_le_bytes),
            3 => any_triple_within(bytes, &range),
            4 => any_within(bytes, &range, u32::from_le_bytes),
            _ => true,
        };
        found.then(|| self.iter().find(|value| range.contains(value))).flatten()
    }

    /// Adds the integers to `all`, three at a time, as `of` makes them of the lowest 32 bits. Takes less
    /// time than [`get`](Self::get) for each.
    pub(crate) fn extend_triples<T>(&self, all: &mut Vec<[T; 3]>, of: impl Fn(u32) -> T) {
        let bytes = &self.data[..self.len * self.width];
        match self.width {
            1 => triples(bytes, all, |[a]: [u8; 1]| of(a.into())),
            2 => triples(bytes, all, |value| of(u16::from_le_bytes(value).into())),
            3 => triples(bytes, all, |[a, b, c]| of(u32::from_le_bytes([a, b, c, 0]))),
            4 => triples(bytes, all, |value| of(u32::from_le_bytes(value))),
            _ => all.extend((0..self.len / 3).map(|i| [0, 1, 2].map(|corner| of(self.get(3 * i + corner) as u32)))),
        }
    }

    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = u64> + Clone {
        (0..self.len).map(|i| self.get(i))
    }
}

/// Adds the values of `WIDTH` bytes to `all`, three at a time, as `read` makes them.
fn triples<const WIDTH: usize, T>(bytes: &[u8], all: &mut Vec<[T; 3]>, read: impl Fn([u8; WIDTH]) -> T) {
    let values: &[[u8; WIDTH]] = bytes.as_chunks().0;
    let values: &[[_; 3]] = values.as_chunks().0;
    all.extend(values.iter().map(|&three| three.map(&read)));
}

/// Returns whether any value of `WIDTH` bytes is within `range`.
fn any_within<const WIDTH: usize, T: Copy + PartialOrd + TryFrom<u64>>(
    bytes: &[u8],
    range: &RangeInclusive<u64>,
    read: impl Fn([u8; WIDTH]) -> T,
) -> bool {
    // A start beyond the largest value of the type: no value is in the range.
    let (Ok(first), false) = (T::try_from(*range.start()), range.is_empty()) else {
        return false;
    };
    let values = bytes.as_chunks().0.iter().map(|&value| read(value));
    match T::try_from(*range.end()) {
        Ok(last) => values.fold(false, |found, value| found | ((value >= first) & (value <= last))),
        Err(_) => values.fold(false, |found, value| found | (value >= first)),
    }
}

/// Returns whether any value of three bytes is within `range`.
///
/// Compilers do not vectorise loops over three bytes each, so four values are compared in the halves
/// of two words. This takes 0.37 of the time.
fn any_triple_within(bytes: &[u8], range: &RangeInclusive<u64>) -> bool {
    /// The highest bit of each half of a word.
    const HIGHEST: u64 = halves(1 << 31);
    const fn halves(value: u64) -> u64 {
        value | value << 32
    }
    const LARGEST: u64 = (1 << 24) - 1;

    let (first, last) = (*range.start(), LARGEST.min(*range.end()));
    if first > last {
        return false;
    }
    // Added to a value, these set the highest bit of a half if the value is at least `first`, and if
    // it is above `last`. No sum exceeds 32 bits.
    let (to_first, above_last) = (HIGHEST - halves(first), HIGHEST - halves(last + 1));
    let (fours, rest) = bytes.as_chunks();
    let found = fours.iter().fold(0, |found, four: &[u8; 12]| {
        let word = |bytes: Option<&[u8; 8]>| bytes.map_or(0, |&bytes| u64::from_le_bytes(bytes));
        let halves = |word: u64| word & LARGEST | (word & LARGEST << 24) << 8;
        let (two, more) = (halves(word(four.first_chunk())), halves(word(four.last_chunk()) >> 16));
        found | (two + to_first) & !(two + above_last) | (more + to_first) & !(more + above_last)
    });
    found & HIGHEST != 0 || any_within(rest, range, |[a, b, c]| u32::from_le_bytes([a, b, c, 0]))
}

/// Returns the number of indices below `count` for which `before` is true. These must precede all
/// others.
pub(crate) fn partition_point(count: usize, before: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, count);
    while low < high {
        let middle = (low + high) / 2;
        if before(middle) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

/// Returns the mark that stands for the `distance`-th largest value of any width. [`write`]
/// translates it.
pub(crate) const fn mark(distance: u64) -> u64 {
    u64::MAX - distance
}

const fn mask(width: usize) -> u64 {
    u64::MAX >> (64 - 8 * width)
}

/// Returns the bytes per integer needed for values up to `largest` and `marks` marks.
fn width_for(largest: u64, marks: u64) -> usize {
    (1..8).find(|&w| largest <= mask(w) - marks).unwrap_or(8)
}

/// Adds a packed array to a buffer. Each value is at most `largest`, or one of `marks` [`mark`]s.
pub(crate) fn write<'b>(
    builder: &mut FlatBufferBuilder<'b>,
    values: impl ExactSizeIterator<Item = u64>,
    largest: u64,
    marks: u64,
) -> WIPOffset<schema::Packed<'b>> {
    write_groups(builder, values.map(|value| [value]), largest, marks)
}

/// Adds a packed array of the values of all groups to a buffer, as [`write`] does.
pub(crate) fn write_groups<'b, const SIZE: usize>(
    builder: &mut FlatBufferBuilder<'b>,
    groups: impl ExactSizeIterator<Item = [u64; SIZE]>,
    largest: u64,
    marks: u64,
) -> WIPOffset<schema::Packed<'b>> {
    let width = width_for(largest, marks);
    let is_valid = |value: u64| value <= largest || value > u64::MAX - marks;
    let groups = groups.inspect(|group| debug_assert!(group.iter().all(|&value| is_valid(value))));
    let bytes = match width {
        1 => lowest_bytes(groups, |[a, ..]| [a]),
        2 => lowest_bytes(groups, |[a, b, ..]| [a, b]),
        3 => lowest_bytes(groups, |[a, b, c, ..]| [a, b, c]),
        4 => lowest_bytes(groups, |[a, b, c, d, ..]| [a, b, c, d]),
        5 => lowest_bytes(groups, |[a, b, c, d, e, ..]| [a, b, c, d, e]),
        6 => lowest_bytes(groups, |[a, b, c, d, e, f, ..]| [a, b, c, d, e, f]),
        7 => lowest_bytes(groups, |[a, b, c, d, e, f, g, _]| [a, b, c, d, e, f, g]),
        _ => lowest_bytes(groups, |all| all),
    };
    let data = Some(builder.create_vector(&bytes));
    let width = width as u8;
    schema::Packed::create(builder, &schema::PackedArgs { width, data })
}

/// Returns `WIDTH` bytes of each value, as `of` takes them from its eight, and the padding.
fn lowest_bytes<const WIDTH: usize, const SIZE: usize>(
    groups: impl ExactSizeIterator<Item = [u64; SIZE]>,
    of: impl Fn([u8; 8]) -> [u8; WIDTH],
) -> Vec<u8> {
    // With room for the padding.
    let mut all = Vec::with_capacity(groups.len() + 8usize.div_ceil(WIDTH));
    all.extend(groups.map(|group| group.map(|value| of(value.to_le_bytes()))));
    let mut bytes = all.into_flattened().into_flattened();
    bytes.resize(bytes.len() + 8 - WIDTH, 0);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_written_as_single_values() {
        for largest in [200, 60_000, 1 << 20, 1 << 30, 1 << 62] {
            let values = [0, largest / 3, largest, 1, mark(0), mark(1)];
            let (mut of_values, mut of_groups) = (FlatBufferBuilder::new(), FlatBufferBuilder::new());
            let root = write(&mut of_values, values.into_iter(), largest, 2);
            of_values.finish(root, None);
            let groups: &[[u64; 3]] = values.as_chunks().0;
            let root = write_groups(&mut of_groups, groups.iter().copied(), largest, 2);
            of_groups.finish(root, None);
            assert_eq!(of_values.finished_data(), of_groups.finished_data());
        }
    }

    #[test]
    fn triples_are_as_single_values() {
        for largest in [200, 60_000, 1 << 20, 1 << 30, 1 << 40_u64] {
            let mut builder = FlatBufferBuilder::new();
            let values: Vec<u64> = (0..31).map(|i| largest * i / 30).collect();
            let root = write(&mut builder, values.into_iter(), largest, 2);
            builder.finish(root, None);
            let bytes = Bytes::from(builder.finished_data().to_vec());
            let packed = Packed::open(&bytes, flatbuffers::root::<schema::Packed>(&bytes).unwrap()).unwrap();
            let mut triples = vec![[7; 3]];
            packed.extend_triples(&mut triples, |value| value);
            let singles: Vec<u32> = packed.iter().take(30).map(|value| value as u32).collect();
            assert_eq!(triples[1..].as_flattened(), singles);
        }
    }

    #[test]
    fn values_and_marks_are_read_as_they_were_written() {
        for largest in [
            0u64,
            1,
            253,
            254,
            255,
            256,
            65_533,
            65_534,
            65_535,
            1 << 24,
            1 << 40,
            u64::MAX - 2,
        ] {
            let mut builder = FlatBufferBuilder::new();
            let values = [largest, 0, mark(0), largest / 2, mark(1)];
            let root = write(&mut builder, values.iter().copied(), largest, 2);
            builder.finish(root, None);
            let bytes = Bytes::from(builder.finished_data().to_vec());
            let packed = Packed::open(&bytes, flatbuffers::root::<schema::Packed>(&bytes).unwrap()).unwrap();
            let marked = |v: u64| {
                if v > largest {
                    packed.largest() - (u64::MAX - v)
                } else {
                    v
                }
            };
            assert_eq!(packed.iter().collect::<Vec<_>>(), values.map(marked), "{largest}");
            assert!(packed.largest() - 1 > largest || largest > 1 << 56);
            let ends = [
                0,
                1,
                200,
                256,
                60_000,
                1 << 20,
                1 << 33,
                packed.largest() - 1,
                packed.largest(),
                u64::MAX,
            ];
            for range in ends.iter().flat_map(|&start| ends.map(|end| start..=end)) {
                let within = packed.iter().find(|value| range.contains(value));
                assert_eq!(packed.find_within(range.clone()), within, "{largest} {range:?}");
            }
        }
    }

    #[test]
    fn a_value_of_three_bytes_is_found_at_each_position() {
        let packed = |values: &[u64]| {
            let mut builder = FlatBufferBuilder::new();
            let root = write(&mut builder, values.iter().copied(), 1 << 20, 2);
            builder.finish(root, None);
            let bytes = Bytes::from(builder.finished_data().to_vec());
            Packed::open(&bytes, flatbuffers::root::<schema::Packed>(&bytes).unwrap()).unwrap()
        };
        let limit = 77_777;
        let largest = packed(&[0]).largest();
        for count in 0..30 {
            // Neighbours of what is searched for on both sides.
            let mut values: Vec<u64> = (0..count)
                .map(|i| if i % 2 == 0 { limit - 1 } else { mark(0) })
                .collect();
            assert_eq!(packed(&values).find_within(limit..=largest - 1), None, "{count}");
            for index in 0..values.len() {
                for (value, stored) in [(limit, limit), (mark(1), largest - 1)] {
                    let before = std::mem::replace(&mut values[index], value);
                    let found = packed(&values).find_within(limit..=largest - 1);
                    assert_eq!(found, Some(stored), "{index} of {count}");
                    values[index] = before;
                }
            }
        }
    }

    #[test]
    fn invalid_widths_and_lengths_are_rejected() {
        for (width, length) in [(0, 8), (9, 8), (3, 4), (3, 7), (8, 7), (1, 0)] {
            let mut builder = FlatBufferBuilder::new();
            let data = Some(builder.create_vector(&vec![0u8; length]));
            let root = schema::Packed::create(&mut builder, &schema::PackedArgs { width, data });
            builder.finish(root, None);
            let bytes = Bytes::from(builder.finished_data().to_vec());
            assert!(
                Packed::open(&bytes, flatbuffers::root::<schema::Packed>(&bytes).unwrap()).is_err(),
                "{width} {length}"
            );
        }
    }
}
