//! The ids of features, from a property or from the member `id`.

use crate::input::error::InputError;
use crate::input::flaw::Flaw;
use crate::input::formats::geojson::json::{Json, ValueType};
use crate::input::formats::shapes::FoundId;
use crate::input::sites::SiteId;

/// Skips `properties`, except the wanted one. Returns the last value that it has there;
/// `Some(None)` if that is null.
pub fn read_property(json: &mut Json, wanted: Option<&str>) -> Result<Option<Option<FoundId>>, InputError> {
    if json.peek()? != ValueType::Object {
        return json.skip().map(|()| None);
    }
    let mut found = None;
    json.begin_object()?;
    while json.has_next()? {
        if Some(json.name()?) == wanted {
            found = Some(read_id(json)?);
        } else {
            json.skip()?;
        }
    }
    json.end_object()?;
    Ok(found)
}

/// Reads an id; `None` if it is null.
pub fn read_id(json: &mut Json) -> Result<Option<FoundId>, InputError> {
    match json.peek()? {
        ValueType::Null => json.skip().map(|()| None),
        ValueType::String => Ok(Some(SiteId::from_text(json.string()?))),
        ValueType::Number => Ok(Some(SiteId::from_field(json.number_text()?.as_bytes()))),
        _ => json.skip().map(|()| Some(Err(Flaw::IdOfWrongType))),
    }
}
