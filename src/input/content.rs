//! What a file is by its first bytes, where its name does not tell, or tells something else.

use crate::input::bytes::{ByteInput, is_gzip};
use crate::input::error::{InputError, Location};
use crate::input::format::Format;
use crate::input::watch::{Reading, Watched};
use std::path::Path;

/// The ids of applications in SQLite's header that GeoPackages have, at this offset.
const GEOPACKAGE: [&[u8]; 3] = [b"GPKG", b"GP10", b"GP11"];
const APPLICATION: usize = 68;

/// Returns the format that the first bytes of a file have; `None` if it is not known, as for text.
pub fn recognise(head: &[u8]) -> Option<Format> {
    let has = |at: usize, bytes: &[u8]| head.get(at..).is_some_and(|rest| rest.starts_with(bytes));
    if has(0, b"LASF") {
        return Some(Format::Las);
    }
    if has(0, b"ply\n") || has(0, b"ply\r\n") {
        return Some(Format::Ply);
    }
    if has(0, b"PAR1") {
        return Some(Format::Parquet);
    }
    if has(0, b"fgb") && has(4, b"fgb") {
        return Some(Format::FlatGeobuf);
    }
    if has(0, &9994u32.to_be_bytes()) && has(28, &1000u32.to_le_bytes()) {
        return Some(Format::Shapefile);
    }
    if has(0, b"SQLite format 3\0") && GEOPACKAGE.iter().any(|id| has(APPLICATION, id)) {
        return Some(Format::GeoPackage);
    }
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let first = text.iter().find(|byte| !byte.is_ascii_whitespace() && **byte != 0x1e);
    matches!(first, Some(b'{' | b'[')).then_some(Format::GeoJson)
}

/// Returns whether files of this format begin with bytes that no other has.
fn has_magic(format: Format) -> bool {
    matches!(
        format,
        Format::Las | Format::FlatGeobuf | Format::Shapefile | Format::GeoPackage | Format::Ply | Format::Parquet
    )
}

/// Returns the format that the name of a file indicates, or else the content of a regular file,
/// which may be gzip.
pub fn format_of(path: &Path) -> Option<Format> {
    Format::from_path(path).or_else(|| {
        let file = Watched::open(path, &Reading::default(), None).ok()?;
        // A pipe could not be read again.
        file.watch.size()?;
        recognise(&ByteInput::new(file, true).ok()?.head)
    })
}

/// Returns whether files of this format are read from any position, and so not from gzip.
fn needs_file(format: Format) -> bool {
    matches!(format, Format::Las | Format::GeoPackage | Format::Parquet)
}

/// Fails if a file that begins with `head` is not of the format `expected`, but of another, or if it
/// is gzip and must not be.
pub fn check(path: &Path, expected: Format, head: &[u8]) -> Result<(), InputError> {
    if is_gzip(head) && needs_file(expected) {
        let problem = format!("by its content this is gzip, and {expected} is not read from gzip");
        return Err(InputError::malformed(
            path,
            Location::File,
            problem,
            "decompress it first",
        ));
    }
    check_content(path, expected, head, "by its content")
}

/// Fails if the decompressed bytes of a gzip file are not of the format `expected`, but of another.
pub fn check_unzipped(input: &ByteInput, expected: Format) -> Result<(), InputError> {
    let is_it = recognise(&input.head) == Some(expected);
    if !is_it && matches!(expected, Format::FlatGeobuf | Format::Shapefile) {
        let problem = format!("by its content this is gzip, and what is in it is not {expected}");
        let hint = "decompress it, and give it the suffix of what it is";
        return Err(InputError::malformed(&input.path, Location::File, problem, hint));
    }
    check_content(&input.path, expected, &input.head, "by its content, which is gzip,")
}

fn check_content(path: &Path, expected: Format, head: &[u8], by: &str) -> Result<(), InputError> {
    match recognise(head) {
        Some(found) if found != expected && (has_magic(found) || has_magic(expected)) => Err(InputError::malformed(
            path,
            Location::File,
            format!("{by} this is {found}, and not {expected}"),
            "give it the suffix, or the option `format`, of what it is",
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_recognised_by_their_first_bytes() {
        let mut shapefile = vec![0; 100];
        shapefile[..4].copy_from_slice(&[0, 0, 0x27, 0x0a]);
        shapefile[28..30].copy_from_slice(&[0xe8, 3]);
        let mut geopackage = b"SQLite format 3\0".to_vec();
        geopackage.resize(100, 0);
        assert_eq!(recognise(&geopackage), None, "any SQLite");
        geopackage[68..72].copy_from_slice(b"GPKG");
        let known: [(&[u8], Format); 9] = [
            (b"ply\r\nformat", Format::Ply),
            (b"PAR1\x15", Format::Parquet),
            (b"LASF\0\0", Format::Las),
            (b"fgb\x03fgb\x01", Format::FlatGeobuf),
            (&shapefile, Format::Shapefile),
            (&geopackage, Format::GeoPackage),
            (b"\n {\"type\":", Format::GeoJson),
            (b"\x1e{\"type\":", Format::GeoJson),
            (b"\xef\xbb\xbf[", Format::GeoJson),
        ];
        for (head, format) in known {
            assert_eq!(recognise(head), Some(format), "{head:?}");
        }
        for unknown in [&b""[..], b"1,2\n", b"x y\n", b"\x1f\x8b\x08", b"\0\0\x27\x0a"] {
            assert_eq!(recognise(unknown), None, "{unknown:?}");
        }
    }
}
