//! The ids of features: a property, or the member `id`.

use super::{FoundId, Frame, GeoJson};
use crate::input::json::ValueType;
use crate::input::{InputError, SiteId};

impl GeoJson {
    /// Keeps from now on the id of every feature: its property of this name, or its member `id` if that is the name and it
    /// has no such property.
    pub fn keep_ids(&mut self, field: &str) {
        self.id_field = Some(field.into());
    }

    /// The id of the feature that has just come to its end.
    pub fn take_id(&mut self) -> Option<FoundId> {
        self.id.take()
    }

    /// Passes over `properties`, but for the wanted one.
    pub(super) fn read_properties(&mut self) -> Result<(), InputError> {
        if self.json.peek()? != ValueType::Object {
            return self.json.skip();
        }
        self.json.begin_object()?;
        while self.json.has_next()? {
            if Some(self.json.name()?) != self.id_field.as_deref() {
                self.json.skip()?;
                continue;
            }
            let id = self.read_id()?;
            if let Some(Frame::Object(object)) = self.open.last_mut() {
                object.property = id;
            }
        }
        self.json.end_object()
    }

    /// An id; `None` if it is null.
    pub(super) fn read_id(&mut self) -> Result<Option<FoundId>, InputError> {
        match self.json.peek()? {
            ValueType::Null => self.json.skip().map(|()| None),
            ValueType::String => Ok(Some(SiteId::from_text(self.json.string()?))),
            ValueType::Number => Ok(Some(SiteId::from_field(self.json.number_text()?.as_bytes()))),
            _ => {
                self.json.skip()?;
                Ok(Some(Err("the id is neither text nor a number".to_owned())))
            }
        }
    }
}
