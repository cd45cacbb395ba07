//! What a file says of itself beside its records: the names and types of fields, the header of LAS.
//! Readers fill these in for [`describe`](crate::input::describe); nothing else depends on them.

/// The limit on the number of fields that are described.
pub const MOST_FIELDS: usize = 4096;

/// A field of the records or features of a file, as [`describe`](crate::input::describe) finds it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Field {
    /// The name; empty for a column of text without a header. In PLY, the name of the element comes
    /// before it: `vertex.x`.
    pub name: String,
    /// The type, in the words of the format: `double`, `TEXT`, `i32, scaled`. For text without a header, `number` or
    /// `text` by the first row, and empty with one; for GeoJSON, the types of the values, such as `string or null`.
    pub kind: String,
}

impl Field {
    pub(super) fn new(name: impl Into<String>, kind: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            kind: kind.into(),
        }
    }
}

/// The header of a LAS file, and counts over all of its points, withheld ones included.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LasInfo {
    /// The version of the format, such as `1.4`.
    pub version: String,
    /// The point format, from 0 to 10.
    pub point_format: u8,
    /// The bytes of a point, uncompressed.
    pub record_length: u16,
    /// Whether the points are compressed, as in LAZ and COPC.
    pub is_compressed: bool,
    /// The identifier of the system that made the points, and the program that wrote the file.
    pub system: String,
    /// The program that wrote the file.
    pub software: String,
    /// The year and the day of that year, counted from 1, at which the file was made, if the header
    /// tells it.
    pub created: Option<(u16, u16)>,
    /// The scale of x, y and z.
    pub scale: [f64; 3],
    /// The offset of x, y and z.
    pub offset: [f64; 3],
    /// The classes that occur, ascending, each with its number of points.
    pub classes: Vec<(u8, u64)>,
    /// The numbers of returns that occur, ascending, each with its number of points.
    pub returns: Vec<(u8, u64)>,
    /// The octree of a COPC file.
    pub copc: Option<CopcInfo>,
}

/// The octree of a COPC file, as its header describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CopcInfo {
    /// The number of levels; `None` if the list of nodes cannot be read.
    pub levels: Option<u32>,
    /// The distance of points at the root, in units of the coordinates.
    pub spacing: f64,
}

/// What the reader of a file knows beside the records.
#[derive(Clone, Debug, Default)]
pub struct About {
    /// The variety of the format, such as `LAZ`.
    pub variety: Option<String>,
    pub fields: Vec<Field>,
    pub las: Option<LasInfo>,
}
