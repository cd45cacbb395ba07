//! The flaws of records that readers report.

/// The reason why a record of a file gives no point, segment, site or hole.
#[derive(Debug, thiserror::Error)]
pub enum Flaw {
    #[error("{axis} is {value}, not a finite number")]
    NotFinite { axis: char, value: f64 },
    #[error("{axis} is {value:e}, of greater magnitude than 2^200, the most that exact arithmetic takes")]
    TooLarge { axis: char, value: f64 },
    #[error("{axis} is {value:e}, nearer to zero than 2^-142, the least that exact arithmetic takes")]
    TooSmall { axis: char, value: f64 },
    #[error("`{row}` is not an index and {dims} numbers")]
    NodeRow { row: String, dims: usize },
    #[error("`{row}` does not have the numbers that the header announces for its element")]
    PlyRow { row: String },
    #[error("a face of {corners} corners; the limit is {most}")]
    TooManyCorners { corners: u64, most: usize },
    #[error("{value} is not the index of a point")]
    NoIndex { value: f64 },
    #[error("`{row}` is not `v` and three numbers")]
    ObjVertex { row: String },
    #[error("`{row}` does not have the indices of at least two vertices")]
    ObjFace { row: String },
    #[error("`{row}` is not a number and the indices of three points")]
    EleRow { row: String },
    #[error("expected a number and the indices of two points, found the row `{row}`")]
    PolySegment { row: String },
    #[error("there is no point {index}, since there are no points")]
    NoPoints { index: u64 },
    #[error("there is no point {index}; they are {first} to {last}")]
    NoSuchPoint { index: u64, first: u64, last: u64 },
    #[error("expected a number, x and y, found the row `{row}`")]
    PolyHole { row: String },
    #[error("the row has {count} of {needed} fields: `{row}`")]
    TooFewFields { count: usize, needed: usize, row: String },
    #[error("{axis} is `{field}`, not a number{}", comma_advice(*has_comma))]
    NoNumber { axis: char, field: String, has_comma: bool },
    #[error("expected four numbers x1,y1,x2,y2, found the row `{row}`")]
    SegmentRow { row: String },
    #[error("the row has no column {column} for the id: `{row}`")]
    NoIdColumn { column: usize, row: String },
    #[error("{axis} is null")]
    Null { axis: char },
    #[error("this is a {kind}; points come from Points and MultiPoints")]
    NoPoint { kind: String },
    #[error("the geometry, of {bytes} bytes, is not WKB")]
    Wkb { bytes: usize },
    #[error("an element of the position is not a number")]
    NotNumeric,
    #[error("the position has {length} of at least 2 elements")]
    ShortPosition { length: usize },
    #[error("this is a {kind}; obstacles are Polygons and MultiPolygons")]
    NoPolygon { kind: String },
    #[error("there is no property `{field}` for the id")]
    NoIdProperty { field: String },
    #[error("the id is neither text nor a number")]
    IdOfWrongType,
    #[error("the id is not in UTF-8")]
    IdNotUtf8,
    #[error("the id is empty")]
    EmptyId,
    #[error("the id has {length} bytes; the limit is {most}")]
    LongId { length: usize, most: usize },
}

fn comma_advice(has_comma: bool) -> &'static str {
    match has_comma {
        true => " (a decimal comma? write decimal points)",
        false => "",
    }
}
