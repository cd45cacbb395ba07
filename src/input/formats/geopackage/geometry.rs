//! The geometries of a feature table: a header of GeoPackage, then WKB.

use crate::input::formats::shapes::Feature;
use crate::input::formats::wkb;

/// The bytes of the header before the bounds.
const HEADER: usize = 8;

/// Adds a geometry. Returns what is wrong with it.
pub fn add_blob(blob: &[u8], into: &mut Feature) -> Result<(), String> {
    wkb::add(after_header(blob)?, into)
}

/// Returns the bytes after the header.
fn after_header(blob: &[u8]) -> Result<&[u8], String> {
    let flags = match blob.first_chunk::<HEADER>() {
        Some([b'G', b'P', 0, flags, ..]) => *flags,
        _ => return Err("it does not begin as geometries of a GeoPackage do".to_owned()),
    };
    if flags & 0x20 != 0 {
        return Err("it is of a type that an extension defines".to_owned());
    }
    let numbers = match (flags >> 1) & 7 {
        0 => 0,
        1 => 4,
        2 | 3 => 6,
        4 => 8,
        other => return Err(format!("there are no bounds of type {other}")),
    };
    blob.get(HEADER + 8 * numbers..)
        .ok_or_else(|| "it is cut short".to_owned())
}
