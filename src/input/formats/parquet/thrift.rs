//! A scan of Thrift's compact protocol, for checks before the crate decodes the same bytes.
//!
//! In: the bytes of a page's header, or of the file's metadata. Out: the numbers that the crate
//! would allocate by. The crate takes fields by their ids alone, and the lower bits of numbers that
//! are too large; here, a field of another type and a number that is too large make no sense.

/// The limit on nested structures. Parquet's own have far fewer.
const DEEPEST: usize = 32;

/// The types of fields that are looked at.
const I32: u8 = 5;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const STRUCT: u8 = 12;

/// A reader of bytes; `None` where they end or make no sense.
struct Scan<'a>(&'a [u8]);

impl<'a> Scan<'a> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    fn take(&mut self, count: u64) -> Option<&'a [u8]> {
        let (bytes, rest) = self.0.split_at_checked(usize::try_from(count).ok()?)?;
        self.0 = rest;
        Some(bytes)
    }

    fn number(&mut self) -> Option<u64> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Some(number);
            }
        }
        None
    }

    fn signed(&mut self) -> Option<i64> {
        let number = self.number()?;
        Some((number >> 1) as i64 ^ -((number & 1) as i64))
    }

    fn signed_32(&mut self) -> Option<i64> {
        self.signed().filter(|number| i32::try_from(*number).is_ok())
    }

    /// Returns the id and the type of the next field; `Some(None)` at the end of the structure.
    fn field(&mut self, last: &mut i64) -> Option<Option<(i64, u8)>> {
        let head = self.byte()?;
        if head & 15 == 0 {
            return Some(None);
        }
        *last = match head >> 4 {
            0 => self.signed()?,
            delta => last.checked_add(i64::from(delta))?,
        };
        i16::try_from(*last).ok()?;
        Some(Some((*last, head & 15)))
    }

    /// Returns the type and the number of the items of a list.
    fn list(&mut self) -> Option<(u8, u64)> {
        let head = self.byte()?;
        let count = match head >> 4 {
            15 => self.number()?,
            count => u64::from(count),
        };
        Some((head & 15, count))
    }

    fn skip(&mut self, kind: u8, depth: usize) -> Option<()> {
        let depth = depth.checked_sub(1)?;
        match kind {
            1 | 2 => {}
            3 => drop(self.byte()?),
            4..=6 => drop(self.number()?),
            7 => drop(self.take(8)?),
            BINARY => {
                let length = self.number()?;
                self.take(length)?;
            }
            LIST | 10 => {
                let (kind, count) = self.list()?;
                for _ in 0..count {
                    self.skip(item(kind), depth)?;
                }
            }
            11 => {
                let count = self.number()?;
                let kinds = if count > 0 { self.byte()? } else { 0 };
                for _ in 0..count {
                    self.skip(item(kinds >> 4), depth)?;
                    self.skip(item(kinds & 15), depth)?;
                }
            }
            STRUCT => {
                let mut last = 0;
                while let Some((_, kind)) = self.field(&mut last)? {
                    self.skip(kind, depth)?;
                }
            }
            13 => drop(self.take(16)?),
            _ => return None,
        }
        Some(())
    }
}

/// Returns the type by which to skip an item of a list or map: there, truth values are bytes. So
/// each item takes a byte at least, and a count that is too large soon comes to the end.
fn item(kind: u8) -> u8 {
    if kind == 1 || kind == 2 { 3 } else { kind }
}

/// What a page's header says.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct PageHeader {
    /// The bytes of the page, uncompressed and compressed.
    pub sizes: [i64; 2],
    /// The bytes of the levels at its beginning that are never compressed.
    pub levels: i64,
}

/// Returns what a page's header says, from the bytes that begin with it; `None` if these are no
/// whole header. If a field comes twice, the larger value counts.
pub fn page_header(bytes: &[u8]) -> Option<PageHeader> {
    let (mut scan, mut last, mut header) = (Scan(bytes), 0, PageHeader::default());
    while let Some((id, kind)) = scan.field(&mut last)? {
        match (id, kind) {
            (2 | 3, I32) => {
                let size = &mut header.sizes[id as usize - 2];
                *size = scan.signed_32()?.max(*size);
            }
            // The part for pages of version 2.
            (8, STRUCT) => header.levels = levels(&mut scan)?.max(header.levels),
            (2 | 3 | 8, _) => return None,
            _ => scan.skip(kind, DEEPEST)?,
        }
    }
    Some(header)
}

/// Returns the sum of the lengths of definition and repetition levels.
fn levels(scan: &mut Scan<'_>) -> Option<i64> {
    let (mut last, mut lengths) = (0, [0; 2]);
    while let Some((id, kind)) = scan.field(&mut last)? {
        match (id, kind) {
            (5 | 6, I32) => {
                let length = &mut lengths[id as usize - 5];
                *length = scan.signed_32()?.max(*length);
            }
            (5 | 6, _) => return None,
            _ => scan.skip(kind, DEEPEST)?,
        }
    }
    lengths[0].checked_add(lengths[1])
}

/// The nesting of a schema.
#[derive(Default)]
pub struct Schema {
    /// The number of groups and leaves.
    pub elements: u64,
    /// The largest number of groups around a leaf.
    pub depth: usize,
    /// The bytes of the names in the paths of all leaves.
    pub path_bytes: u64,
}

/// Returns the nesting of the schema in a file's metadata; `None` if that makes no sense.
pub fn schema(metadata: &[u8]) -> Option<Schema> {
    let (mut scan, mut last) = (Scan(metadata), 0);
    let mut schema = Schema::default();
    while let Some((id, kind)) = scan.field(&mut last)? {
        match (id, kind) {
            (2, LIST) => {
                let (kind, count) = scan.list()?;
                if kind != STRUCT {
                    return None;
                }
                schema.elements = schema.elements.saturating_add(count);
                measure(&mut scan, count, &mut schema)?;
            }
            (2, _) => return None,
            _ => scan.skip(kind, DEEPEST)?,
        }
    }
    Some(schema)
}

/// Measures the nesting of `count` elements, which come depth first.
fn measure(scan: &mut Scan<'_>, count: u64, schema: &mut Schema) -> Option<()> {
    // For each open group, the number of children to come, and the bytes of the names down to it.
    let mut open: Vec<(u64, u64)> = Vec::new();
    for _ in 0..count {
        let (mut last, mut children, mut name) = (0, 0, 0);
        while let Some((id, kind)) = scan.field(&mut last)? {
            match (id, kind) {
                (4, BINARY) => {
                    let length = scan.number()?;
                    name = scan.take(length)?.len() as u64;
                }
                (5, I32) => children = u64::try_from(scan.signed_32()?).ok()?,
                (4 | 5, _) => return None,
                _ => scan.skip(kind, DEEPEST)?,
            }
        }
        while open.last().is_some_and(|(left, _)| *left == 0) {
            open.pop();
        }
        let mut path = name;
        if let Some((left, names)) = open.last_mut() {
            *left -= 1;
            path = names.saturating_add(name);
        }
        match children {
            0 => schema.path_bytes = schema.path_bytes.saturating_add(path),
            _ => open.push((children, path)),
        }
        schema.depth = schema.depth.max(open.len());
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sizes_of_a_page_are_found() {
        // Type 0, 300 and 200 bytes, then a structure with a number.
        let header = [0x15, 0, 0x15, 0xd8, 4, 0x15, 0x90, 3, 0x2c, 0x15, 8, 0, 0, 77];
        let found = |sizes, levels| Some(PageHeader { sizes, levels });
        assert_eq!(page_header(&header), found([300, 200], 0));
        for length in 0..header.len() - 1 {
            assert_eq!(page_header(&header[..length]), None, "{length}");
        }
        // Type 3, 300 and 200 bytes, then field 8 with levels of 5 and 7 bytes (fields 5 and 6).
        let header = [0x15, 6, 0x15, 0xd8, 4, 0x15, 0x90, 3, 0x5c, 0x55, 10, 0x15, 14, 0, 0];
        assert_eq!(page_header(&header), found([300, 200], 12));
    }

    /// The crate would take the lower 32 bits of a size, and a field of any type for the size.
    #[test]
    fn sizes_that_the_crate_takes_for_others_are_refused() {
        // 2^32 + 300; field 2 as a number of 64 bits; field 65538, whose lower 16 bits are 2.
        let too_large = [0x15, 0, 0x15, 0xd8, 0x84, 0x80, 0x80, 0x20, 0x15, 2, 0];
        let other_type = [0x15, 0, 0x16, 0xd8, 4, 0x15, 2, 0];
        let other_field = [0x15, 0, 0x05, 0x84, 0x80, 8, 0xd8, 4, 0];
        let negative = [0x15, 0, 0x15, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f, 0x15, 2, 0];
        for header in [&too_large[..], &other_type, &other_field, &negative] {
            assert_eq!(page_header(header), None, "{header:?}");
        }
    }

    /// Items without a byte would be skipped as often as the count says.
    #[test]
    fn a_map_of_more_truth_values_than_bytes_is_refused() {
        let mut header = vec![0x1b];
        header.extend([0xff; 9]);
        header.extend([1, 0x11, 1, 2, 1, 2, 0]);
        assert_eq!(page_header(&header), None);
    }

    #[test]
    fn the_depth_of_a_schema_is_found() {
        // The elements have a name of one byte (field 4) and a number of children (field 5).
        let element = |children: u8| [0x48, 1, b'a', 0x15, 2 * children, 0];
        let mut metadata = vec![0x29, 0x5c];
        for children in [2, 0, 1, 1, 0] {
            metadata.extend(element(children));
        }
        metadata.push(0);
        let schema = schema(&metadata).unwrap();
        assert_eq!((schema.elements, schema.depth, schema.path_bytes), (5, 3, 2 + 4));
    }
}
