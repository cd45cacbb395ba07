//! FlatBuffers read by hand, independently of generated code. It trusts its bytes, and panics if an
//! offset is out of range.

/// A table in a buffer.
#[derive(Clone, Copy)]
pub struct Table<'a> {
    pub bytes: &'a [u8],
    /// The offset of the table in the buffer.
    pub at: usize,
}

pub fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(bytes[at..at + 2].try_into().unwrap())
}

pub fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

pub fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
}

pub fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_bits(u64_at(bytes, at))
}

impl<'a> Table<'a> {
    /// Returns the root table of a buffer.
    pub fn root(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: u32_at(bytes, 0) as usize,
        }
    }

    /// Returns the offset of a field in the buffer, if the field is present.
    pub fn field(self, slot: usize) -> Option<usize> {
        let back = u32_at(self.bytes, self.at) as i32;
        let vtable = usize::try_from(self.at as i64 - i64::from(back)).unwrap();
        let size = usize::from(u16_at(self.bytes, vtable));
        let entry = 4 + 2 * slot;
        if entry + 2 > size {
            return None;
        }
        match u16_at(self.bytes, vtable + entry) {
            0 => None,
            offset => Some(self.at + usize::from(offset)),
        }
    }

    pub fn u8(self, slot: usize) -> u8 {
        self.field(slot).map_or(0, |at| self.bytes[at])
    }

    pub fn u32(self, slot: usize) -> u32 {
        self.field(slot).map_or(0, |at| u32_at(self.bytes, at))
    }

    pub fn u64(self, slot: usize) -> u64 {
        self.field(slot).map_or(0, |at| u64_at(self.bytes, at))
    }

    pub fn f64(self, slot: usize) -> f64 {
        self.field(slot).map_or(0.0, |at| f64_at(self.bytes, at))
    }

    fn follow(self, slot: usize) -> Option<usize> {
        self.field(slot).map(|at| at + u32_at(self.bytes, at) as usize)
    }

    /// Returns the table that a field refers to.
    pub fn table(self, slot: usize) -> Option<Table<'a>> {
        self.follow(slot).map(|at| Table { at, ..self })
    }

    /// Returns the offset of a vector's first element, and the number of elements.
    pub fn vector(self, slot: usize) -> Option<(usize, usize)> {
        self.follow(slot).map(|at| (at + 4, u32_at(self.bytes, at) as usize))
    }

    /// Returns the tables of a vector of tables.
    pub fn tables(self, slot: usize) -> Vec<Table<'a>> {
        let (first, count) = self.vector(slot).unwrap_or((0, 0));
        let offsets = (0..count).map(|i| first + 4 * i);
        offsets
            .map(|at| Table {
                at: at + u32_at(self.bytes, at) as usize,
                ..self
            })
            .collect()
    }

    pub fn string(self, slot: usize) -> Option<&'a str> {
        let (at, length) = self.vector(slot)?;
        Some(std::str::from_utf8(&self.bytes[at..at + length]).unwrap())
    }
}
