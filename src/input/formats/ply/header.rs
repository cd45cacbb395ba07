//! The header of a PLY file: its elements, and their properties.

use crate::input::error::InputError;
use crate::input::formats::text_lines::Lines;

/// The limits on the header, far above what programs write.
const MOST_ELEMENTS: usize = 256;
const MOST_PROPERTIES: usize = 4096;
const LONGEST_LINE: usize = 1024;

const HINT: &str = "is this a PLY file, and is its header whole?";

/// The way in which numbers are written.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// A property of an element.
pub struct Property {
    pub name: String,
    /// For a list, the type of the number of its items.
    pub count: Option<Scalar>,
    /// The type of the number, or of the items of a list.
    pub scalar: Scalar,
}

/// An element: rows of the same properties.
pub struct Element {
    pub name: String,
    /// The number of rows that the header claims.
    pub rows: u64,
    pub properties: Vec<Property>,
}

pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
}

impl Scalar {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Returns the name in the header.
    pub fn name(self) -> &'static str {
        match self {
            Self::I8 => "char",
            Self::U8 => "uchar",
            Self::I16 => "short",
            Self::U16 => "ushort",
            Self::I32 => "int",
            Self::U32 => "uint",
            Self::F32 => "float",
            Self::F64 => "double",
        }
    }

    /// Returns the number of bytes of a number.
    pub fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Returns the number that begins `bytes`, which are at least as many as [`Self::bytes`].
    #[inline]
    pub fn decode(self, bytes: &[u8], encoding: Encoding) -> f64 {
        fn first<const N: usize>(bytes: &[u8], encoding: Encoding) -> [u8; N] {
            let mut number = [0; N];
            number.copy_from_slice(&bytes[..N]);
            if encoding == Encoding::BigEndian {
                number.reverse();
            }
            number
        }
        match self {
            Self::I8 => f64::from(i8::from_le_bytes(first(bytes, encoding))),
            Self::U8 => f64::from(bytes[0]),
            Self::I16 => f64::from(i16::from_le_bytes(first(bytes, encoding))),
            Self::U16 => f64::from(u16::from_le_bytes(first(bytes, encoding))),
            Self::I32 => f64::from(i32::from_le_bytes(first(bytes, encoding))),
            Self::U32 => f64::from(u32::from_le_bytes(first(bytes, encoding))),
            Self::F32 => f64::from(f32::from_le_bytes(first(bytes, encoding))),
            Self::F64 => f64::from_le_bytes(first(bytes, encoding)),
        }
    }
}

impl Element {
    /// Returns the number of the property with one of these names, ignoring case.
    pub fn property(&self, names: &[&str], is_list: bool) -> Option<usize> {
        self.properties.iter().position(|property| {
            let is_it = |name: &&str| property.name.eq_ignore_ascii_case(name);
            property.count.is_some() == is_list && names.iter().any(is_it)
        })
    }

    /// Returns the bytes of a row in a binary file, if all rows have the same number of them.
    pub fn stride(&self) -> Option<usize> {
        let bytes = |property: &Property| property.count.is_none().then_some(property.scalar.bytes());
        self.properties
            .iter()
            .try_fold(0, |sum, property| Some(sum + bytes(property)?))
    }

    /// Returns the least number of bytes that the rows take in a binary file; `None` if that
    /// exceeds a u64.
    pub fn least_bytes(&self) -> Option<u64> {
        let bytes = |property: &Property| property.count.unwrap_or(property.scalar).bytes();
        let row: usize = self.properties.iter().map(bytes).sum();
        self.rows.checked_mul(row as u64)
    }
}

impl Header {
    /// Reads the lines up to `end_header`.
    pub fn read(lines: &mut Lines) -> Result<Self, InputError> {
        if !lines.next_row()? || lines.text().trim_ascii() != b"ply" {
            return Err(lines.malformed("the file does not begin with `ply`", HINT));
        }
        let (mut encoding, mut elements) = (None, Vec::<Element>::new());
        let mut properties = 0;
        while lines.next_row()? {
            let text = lines.text().trim_ascii();
            if text.starts_with(b"comment") || text.starts_with(b"obj_info") {
                continue;
            }
            let text = std::str::from_utf8(text).ok().filter(|text| text.len() <= LONGEST_LINE);
            let words: Vec<&str> = text.unwrap_or_default().split_ascii_whitespace().take(6).collect();
            match words[..] {
                ["format", name, "1.0"] if encoding.is_none() => {
                    encoding = Encoding::of(name);
                    if encoding.is_none() {
                        return Err(wrong(lines));
                    }
                }
                ["element", name, rows] if elements.len() < MOST_ELEMENTS => elements.push(Element {
                    name: name.to_owned(),
                    rows: rows.parse().map_err(|_| wrong(lines))?,
                    properties: Vec::new(),
                }),
                ["property", ..] if properties < MOST_PROPERTIES => {
                    let property = Property::of(&words);
                    let (Some(property), Some(element)) = (property, elements.last_mut()) else {
                        return Err(wrong(lines));
                    };
                    element.properties.push(property);
                    properties += 1;
                }
                ["end_header"] => {
                    let missing = || lines.malformed("the header has no line `format`", HINT);
                    let encoding = encoding.ok_or_else(missing)?;
                    return Ok(Self { encoding, elements });
                }
                _ => return Err(wrong(lines)),
            }
        }
        Err(lines.malformed("the file ends within the header", HINT))
    }
}

impl Encoding {
    fn of(name: &str) -> Option<Self> {
        match name {
            "ascii" => Some(Self::Text),
            "binary_little_endian" => Some(Self::LittleEndian),
            "binary_big_endian" => Some(Self::BigEndian),
            _ => None,
        }
    }
}

impl Property {
    fn of(words: &[&str]) -> Option<Self> {
        let (count, scalar, name) = match *words {
            [_, "list", count, scalar, name] => (Some(Scalar::of(count)?), scalar, name),
            [_, scalar, name] => (None, scalar, name),
            _ => return None,
        };
        Some(Self {
            name: name.to_owned(),
            count,
            scalar: Scalar::of(scalar)?,
        })
    }
}

/// Returns the error of the current line of the header.
fn wrong(lines: &Lines) -> InputError {
    let problem = format!("the header has the line `{}`", lines.excerpt());
    lines.malformed(
        problem,
        "that is no line of a header of PLY 1.0 (or one element, property or name too many)",
    )
}
