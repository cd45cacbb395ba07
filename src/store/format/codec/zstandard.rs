//! Plans and Zstandard.
//!
//! Stored are the length of the plan, as four bytes, and Zstandard frames with the plan.

use zstd::bulk::{Compressor, decompress_to_buffer};

use crate::store::format::codec::part::Part;
use crate::store::format::codec::planes::Cursor;
use crate::store::format::codec::{encode_plan, fields, plan};
use crate::store::format::damage::Damage;

/// The level of compression. Higher ones gain 1 % and take twice as long or more.
const LEVEL: i32 = 1;
/// The least bytes of a frame, except the last.
const MIN_FRAME: usize = 2048;
/// The most bytes by which a plan may be longer than the buffer: a plan without sections.
const PLAN_HEADER: usize = 4;

/// Encodes a FlatBuffer. Returns `None` if it is no part of a tile, or if memory was refused.
pub(super) fn encode(buffer: &[u8], part: Part) -> Option<Vec<u8>> {
    let fields = match part {
        Part::Core => fields::of_core(buffer),
        Part::Border => fields::of_border(buffer),
    };
    let mut plan = encode_plan::encode(buffer, &fields?);
    if plan.bytes.len() > buffer.len() + PLAN_HEADER {
        plan = encode_plan::encode(buffer, &[]);
    }
    let mut stored = (plan.bytes.len() as u32).to_le_bytes().to_vec();
    let mut compressor = Compressor::new(LEVEL).ok()?;
    let mut start = 0;
    for end in plan.ends {
        // Parts have statistics of their own, and so are frames of their own.
        if end - start >= MIN_FRAME || end == plan.bytes.len() && end > start {
            stored.extend(compressor.compress(&plan.bytes[start..end]).ok()?);
            start = end;
        }
    }
    Some(stored)
}

/// Decodes stored bytes to a FlatBuffer of `decoded` bytes.
pub(super) fn decode(stored: &[u8], decoded: usize) -> Result<Vec<u8>, Damage> {
    let mut cursor = Cursor::new(stored);
    let length = u32::from_le_bytes(cursor.array()?) as usize;
    if length > decoded + PLAN_HEADER {
        return Err(Damage::new(format!(
            "its plan of {length} bytes is longer than the {decoded} bytes that it describes"
        )));
    }
    let mut plan = vec![0; length];
    let found = decompress_to_buffer(cursor.rest(), &mut plan[..])
        .map_err(|error| Damage::new(format!("its bytes cannot be decompressed: {error}")))?;
    if found != length {
        return Err(Damage::new(format!("its plan has {found} bytes, not {length}")));
    }
    let mut buffer = vec![0; decoded];
    plan::decode(&plan, &mut buffer)?;
    Ok(buffer)
}
