//! The manifest of a file in parts: text that says which bytes of which objects the file consists of.
//!
//! ```text
//! delaunay-tiles parts 1
//! OFFSET LENGTH FROM NAME      a part: LENGTH bytes of the object NAME, from FROM on, at OFFSET of the file
//! …                            in the order of the offsets; what lies between two parts is 0, and short
//! end CRC                      CRC-32C of all bytes before this line, as 8 hexadecimal digits
//! ```
//!
//! Names are relative to the manifest, by `/`, and lead down only.

use std::ffi::OsStr;
use std::fmt::Write;
use std::ops::Range;

const FIRST_LINE: &str = "delaunay-tiles parts 1";
/// The end of the name of every manifest.
const EXTENSION: &str = ".parts";
/// What is added to the name of a manifest in that of the folder of its parts.
pub(crate) const FOLDER: &str = ".d";
/// The maximum number of bytes of a manifest, and of its parts.
pub(crate) const MOST_BYTES: u64 = 64 << 20;
const MOST_PARTS: usize = 1 << 20;
/// The maximum number of bytes between two parts.
const LONGEST_GAP: u64 = 1 << 16;

/// Returns whether a name is that of a manifest.
pub(crate) fn is_manifest(name: impl AsRef<OsStr>) -> bool {
    name.as_ref().as_encoded_bytes().ends_with(EXTENSION.as_bytes())
}

/// Returns the name of the folder of the parts of the file `id`.
pub(crate) fn id_name(id: u64) -> String {
    format!("{id:016x}")
}

/// Returns whether a name is that of the folder of the parts of a file.
pub(crate) fn is_id_name(name: &str) -> bool {
    u64::from_str_radix(name, 16).is_ok_and(|id| id_name(id) == name)
}

/// The parts that a file consists of.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Manifest {
    /// In the order of their offsets.
    pub(crate) parts: Vec<Part>,
}

/// Bytes of a file that lie in an object.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    /// The bytes of the file.
    pub(crate) range: Range<u64>,
    /// The offset of the first of them in the object.
    pub(crate) from: u64,
    /// The name of the object, relative to the manifest.
    pub(crate) name: String,
}

impl Manifest {
    /// Returns the length of the file in bytes.
    pub(crate) fn length(&self) -> u64 {
        self.parts.last().map_or(0, |part| part.range.end)
    }

    /// Returns the text of the manifest.
    pub(crate) fn text(&self) -> String {
        let mut text = format!("{FIRST_LINE}\n");
        for Part { range, from, name } in &self.parts {
            let length = range.end - range.start;
            // Writing to a string does not fail.
            let _ = writeln!(text, "{} {length} {from} {name}", range.start);
        }
        let crc = crc32c::crc32c(text.as_bytes());
        let _ = writeln!(text, "end {crc:08x}");
        text
    }

    /// Reads the text of a manifest. The error says what is wrong with it.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, String> {
        let text = std::str::from_utf8(bytes).map_err(|_| "it is no text".to_owned())?;
        if !text.starts_with(FIRST_LINE) {
            return Err(format!("its first line is not `{FIRST_LINE}`"));
        }
        let body = text.strip_suffix('\n').and_then(|text| text.rfind('\n')).unwrap_or(0) + 1;
        let (body, end) = text.split_at(body);
        let crc = crc32c::crc32c(body.as_bytes());
        if end != format!("end {crc:08x}\n") {
            return Err("it is cut off or damaged: its checksum is another one".to_owned());
        }
        let mut parts: Vec<Part> = Vec::new();
        for (line, number) in body.lines().skip(1).zip(2..) {
            let before = parts.last().map_or(0, |part| part.range.end);
            let follows = |part: &Part| (before..=before.saturating_add(LONGEST_GAP)).contains(&part.range.start);
            let part = part(line).filter(follows);
            parts.push(part.ok_or_else(|| format!("line {number} is no part that follows the one before"))?);
            if parts.len() > MOST_PARTS {
                return Err(format!("it has more than {MOST_PARTS} parts"));
            }
        }
        Ok(Self { parts })
    }
}

/// Reads a line.
fn part(line: &str) -> Option<Part> {
    let mut words = line.splitn(4, ' ');
    let mut number = || words.next()?.parse::<u64>().ok();
    let [offset, length, from] = [number()?, number()?, number()?];
    let name = words.next().filter(|name| leads_down(name))?;
    let end = offset.checked_add(length).filter(|&end| i64::try_from(end).is_ok())?;
    from.checked_add(length)?;
    (length > 0).then(|| Part {
        range: offset..end,
        from,
        name: name.to_owned(),
    })
}

/// Returns whether a name stays below the folder that it is relative to.
fn leads_down(name: &str) -> bool {
    let is_step = |step: &str| !["", ".", ".."].contains(&step);
    !name.contains(|c: char| c.is_control() || c == '\\') && name.split('/').all(is_step)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manifest() -> Manifest {
        let part = |range, from, name: &str| Part {
            range,
            from,
            name: name.to_owned(),
        };
        Manifest {
            parts: vec![
                part(0..100, 0, "a.parts.d/1/main"),
                part(4096..5000, 0, "a.parts.d/1/block 0"),
                part(8192..8200, 8192, "a.parts.d/1/main"),
            ],
        }
    }

    /// Returns the text of a manifest with these lines, with the right checksum.
    fn sealed(lines: &str) -> String {
        let body = format!("{FIRST_LINE}\n{lines}");
        format!("{body}end {:08x}\n", crc32c::crc32c(body.as_bytes()))
    }

    #[test]
    fn a_manifest_is_read_as_it_was_written() {
        let manifest = manifest();
        assert_eq!(Manifest::parse(manifest.text().as_bytes()), Ok(manifest.clone()));
        assert_eq!(manifest.length(), 8200);
        assert_eq!(Manifest::parse(sealed("").as_bytes()), Ok(Manifest::default()));
    }

    #[test]
    fn a_manifest_that_is_cut_off_or_changed_is_refused() {
        let text = manifest().text();
        for length in 0..text.len() {
            assert!(Manifest::parse(&text.as_bytes()[..length]).is_err(), "{length} bytes");
            let mut changed = text.clone().into_bytes();
            changed[length] ^= 1;
            assert!(Manifest::parse(&changed).is_err(), "byte {length}");
        }
    }

    #[test]
    fn parts_that_overlap_or_lead_elsewhere_are_refused() {
        for lines in [
            "0 10 0 a\n5 10 0 b\n",
            "10 10 0 a\n0 10 0 b\n",
            "0 10 0 a\n65547 10 0 a\n",
            "0 0 0 a\n",
            "0 10 0\n",
            "0 10 a\n",
            "0 10 0 \n",
            "0 -1 0 a\n",
            "0 18446744073709551615 0 a\n",
            "1 18446744073709551615 0 a\n",
            "0 10 18446744073709551615 a\n",
            "0 10 0 /etc/passwd\n",
            "0 10 0 ../a\n",
            "0 10 0 a/../../b\n",
            "0 10 0 a//b\n",
            "0 10 0 a\\b\n",
            "0 10 0 a\u{7}\n",
        ] {
            let error = Manifest::parse(sealed(lines).as_bytes()).unwrap_err();
            assert!(error.contains("is no part"), "{lines}: {error}");
        }
    }
}
