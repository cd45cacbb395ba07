//! The header of a TIFF file: directories of tags, before all data.
//!
//! In: the tags of the images and the lengths of their tiles. Out: the bytes before the first tile.
//! Format: TIFF 6.0, with tiles; BigTIFF where offsets need more than 32 bits.

/// The value of a tag.
pub(super) enum Value {
    Short(Vec<u16>),
    Long(Vec<u32>),
    Double(Vec<f64>),
    Ascii(String),
    /// The places of tiles: of 32 or 64 bits.
    Offsets(Vec<u64>),
}

impl Value {
    /// Returns the code of the type, the number of values and their bytes.
    fn encoded(&self, is_big: bool) -> (u16, u64, Vec<u8>) {
        match self {
            Self::Ascii(text) => {
                let bytes = [text.as_bytes(), b"\0"].concat();
                (2, bytes.len() as u64, bytes)
            }
            Self::Short(values) => (
                3,
                values.len() as u64,
                values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            ),
            Self::Long(values) => (
                4,
                values.len() as u64,
                values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            ),
            Self::Double(values) => (
                12,
                values.len() as u64,
                values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            ),
            Self::Offsets(values) if is_big => (
                16,
                values.len() as u64,
                values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            ),
            Self::Offsets(values) => {
                let bytes = values.iter().flat_map(|&v| (v as u32).to_le_bytes());
                (4, values.len() as u64, bytes.collect())
            }
        }
    }
}

/// An image: its tags in ascending order, without those of its tiles, and the lengths of its tiles.
pub(super) struct Image {
    pub(super) tags: Vec<(u16, Value)>,
    pub(super) tile_lengths: Vec<u32>,
}

const TILE_OFFSETS: u16 = 324;
const TILE_BYTE_COUNTS: u16 = 325;

/// Returns the header of a file with some images, each but the first an overview. The tiles of the
/// last image come first behind the header, those of the first image last.
pub(super) fn header(images: &[Image]) -> Vec<u8> {
    let data: u64 = images
        .iter()
        .flat_map(|image| &image.tile_lengths)
        .map(|&length| u64::from(length))
        .sum();
    // The header itself has the same length for all offsets.
    let is_big = lay_out(images, true, 0).len() as u64 + data > u64::from(u32::MAX);
    let start = lay_out(images, is_big, 0).len() as u64;
    lay_out(images, is_big, start)
}

/// Returns the header of a file whose tiles begin at `start`.
fn lay_out(images: &[Image], is_big: bool, start: u64) -> Vec<u8> {
    let mut out = match is_big {
        true => [b"II\x2b\0\x08\0\0\0".as_slice(), &16u64.to_le_bytes()].concat(),
        false => [b"II\x2a\0".as_slice(), &8u32.to_le_bytes()].concat(),
    };
    let mut offsets = offsets(images, start);
    for (number, image) in images.iter().enumerate() {
        let is_last = number + 1 == images.len();
        put_directory(image, std::mem::take(&mut offsets[number]), is_big, is_last, &mut out);
    }
    out
}

/// Returns the offset of each tile of each image.
fn offsets(images: &[Image], start: u64) -> Vec<Vec<u64>> {
    let mut next = start;
    let mut all: Vec<Vec<u64>> = Vec::new();
    for image in images.iter().rev() {
        let of_image = image.tile_lengths.iter().map(|&length| {
            let offset = next;
            next += u64::from(length);
            offset
        });
        all.push(of_image.collect());
    }
    all.reverse();
    all
}

/// Appends a directory, and behind it the values that do not fit into its entries.
fn put_directory(image: &Image, offsets: Vec<u64>, is_big: bool, is_last: bool, out: &mut Vec<u8>) {
    let (offsets, lengths) = (Value::Offsets(offsets), Value::Long(image.tile_lengths.clone()));
    let mut tags: Vec<(u16, &Value)> = image.tags.iter().map(|(tag, value)| (*tag, value)).collect();
    tags.extend([(TILE_OFFSETS, &offsets), (TILE_BYTE_COUNTS, &lengths)]);
    tags.sort_by_key(|(tag, _)| *tag);
    let (inline, entry, count) = if is_big { (8, 20, 8) } else { (4, 12, 2) };
    let end = out.len() + count + entry * tags.len() + inline;
    let mut behind = Vec::new();
    match is_big {
        true => out.extend_from_slice(&(tags.len() as u64).to_le_bytes()),
        false => out.extend_from_slice(&(tags.len() as u16).to_le_bytes()),
    }
    for (tag, value) in tags {
        let (kind, count, mut bytes) = value.encoded(is_big);
        out.extend_from_slice(&tag.to_le_bytes());
        out.extend_from_slice(&kind.to_le_bytes());
        put_offset(count, is_big, out);
        if bytes.len() > inline {
            put_offset((end + behind.len()) as u64, is_big, out);
            behind.append(&mut bytes);
            // Values begin at even offsets.
            behind.resize(behind.len().next_multiple_of(8), 0);
        } else {
            bytes.resize(inline, 0);
            out.append(&mut bytes);
        }
    }
    let next = if is_last {
        0
    } else {
        (end + behind.len()).next_multiple_of(2)
    };
    put_offset(next as u64, is_big, out);
    out.append(&mut behind);
    out.resize(out.len().next_multiple_of(2), 0);
}

fn put_offset(offset: u64, is_big: bool, out: &mut Vec<u8>) {
    match is_big {
        true => out.extend_from_slice(&offset.to_le_bytes()),
        false => out.extend_from_slice(&(offset as u32).to_le_bytes()),
    }
}
