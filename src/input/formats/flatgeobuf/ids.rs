//! The ids of features, from one of their fields.

use crate::input::flaw::Flaw;
use crate::input::formats::shapes::FoundId;
use crate::input::sites::SiteId;
use ::flatgeobuf::{Column, ColumnType, Feature};

/// The field of the ids.
pub struct Field {
    name: Box<str>,
    /// The types of all columns of the header, and the number of the field's.
    columns: Columns,
}

/// The types of columns, and which of them is the field.
struct Columns {
    types: Vec<ColumnType>,
    wanted: Option<usize>,
}

/// Returns the field with this name.
pub fn find_field<'a>(columns: Option<impl IntoIterator<Item = Column<'a>>>, name: &str) -> Field {
    Field {
        name: name.into(),
        columns: Columns::new(columns, name),
    }
}

impl Columns {
    fn new<'a>(columns: Option<impl IntoIterator<Item = Column<'a>>>, name: &str) -> Self {
        let columns: Vec<Column> = columns.into_iter().flatten().collect();
        Self {
            types: columns.iter().map(Column::type_).collect(),
            wanted: columns.iter().position(|column| column.name() == name),
        }
    }
}

/// Returns the id of a feature; `None` if it has none. Fails if its fields are broken.
pub fn id(feature: &Feature, field: &Field) -> Result<Option<FoundId>, String> {
    let own = feature
        .columns()
        .map(|columns| Columns::new(Some(columns), &field.name));
    let columns = own.as_ref().unwrap_or(&field.columns);
    let Some(properties) = feature.properties() else {
        return Ok(None);
    };
    let mut rest = properties.bytes();
    while let Some((number, after)) = rest.split_first_chunk::<2>() {
        let number = usize::from(u16::from_le_bytes(*number));
        let Some(&kind) = columns.types.get(number) else {
            return Err(format!("there is no column {number}"));
        };
        let Some((value, after)) = split_value(kind, after) else {
            return Err(format!("the value of column {number} is cut short"));
        };
        if columns.wanted == Some(number) {
            return Ok(Some(id_of(kind, value)));
        }
        rest = after;
    }
    Ok(None)
}

/// Splits the first value off.
fn split_value(kind: ColumnType, bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let length = match kind {
        ColumnType::Byte | ColumnType::UByte | ColumnType::Bool => 1,
        ColumnType::Short | ColumnType::UShort => 2,
        ColumnType::Int | ColumnType::UInt | ColumnType::Float => 4,
        ColumnType::Long | ColumnType::ULong | ColumnType::Double => 8,
        ColumnType::String | ColumnType::Json | ColumnType::DateTime | ColumnType::Binary => {
            let (length, text) = bytes.split_first_chunk::<4>()?;
            return text.split_at_checked(u32::from_le_bytes(*length) as usize);
        }
        _ => return None,
    };
    bytes.split_at_checked(length)
}

/// Returns the id that a value is, as GeoJSON with the same value would give it.
fn id_of(kind: ColumnType, value: &[u8]) -> FoundId {
    fn array<const N: usize>(value: &[u8]) -> [u8; N] {
        value.try_into().unwrap_or([0; N])
    }
    let number = match kind {
        ColumnType::Byte => i8::from_le_bytes(array(value)).to_string(),
        ColumnType::UByte => u8::from_le_bytes(array(value)).to_string(),
        ColumnType::Short => i16::from_le_bytes(array(value)).to_string(),
        ColumnType::UShort => u16::from_le_bytes(array(value)).to_string(),
        ColumnType::Int => i32::from_le_bytes(array(value)).to_string(),
        ColumnType::UInt => u32::from_le_bytes(array(value)).to_string(),
        ColumnType::Long => i64::from_le_bytes(array(value)).to_string(),
        ColumnType::ULong => u64::from_le_bytes(array(value)).to_string(),
        ColumnType::Float => format!("{:?}", f32::from_le_bytes(array(value))),
        ColumnType::Double => format!("{:?}", f64::from_le_bytes(array(value))),
        ColumnType::String | ColumnType::DateTime => {
            let text = std::str::from_utf8(value).map_err(|_| Flaw::IdNotUtf8)?;
            return SiteId::from_text(text);
        }
        _ => return Err(Flaw::IdOfWrongType),
    };
    SiteId::from_field(number.as_bytes())
}
