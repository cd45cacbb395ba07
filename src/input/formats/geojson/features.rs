//! GeoJSON feature by feature, with the number of features and a look-ahead to the first position.

use crate::input::bytes::ByteInput;
use crate::input::error::InputError;
use crate::input::formats::geojson::document::GeoJson;
use crate::input::formats::geojson::event::{Event, Kind};
use crate::input::formats::geojson::ids::FoundId;

/// The events of a file, with the number of the feature that they belong to.
pub struct Features {
    json: GeoJson,
    /// The event that the look-ahead found.
    first: Option<Event>,
    has_z: bool,
    /// The number of features, and of geometries outside of any feature, that have ended.
    ended: u64,
}

impl Features {
    /// Skips events up to the first position, but stops at a geometry without positions whose kind
    /// `passes` rejects. Keeps ids if `id_field` is given.
    pub fn new(input: ByteInput, id_field: Option<&str>, passes: fn(Kind) -> bool) -> Result<Self, InputError> {
        let mut this = Self {
            json: GeoJson::new(input)?,
            first: None,
            has_z: false,
            ended: 0,
        };
        if let Some(field) = id_field {
            this.json.keep_ids(field);
        }
        while let Some(event) = this.next_event()? {
            match event {
                Event::Record(_) | Event::LineEnd(_) => continue,
                Event::Geometry(kind, _) if passes(kind) => continue,
                Event::Geometry(..) => {}
                Event::Position(position) => this.has_z = position.length > 2,
            }
            this.first = Some(event);
            break;
        }
        Ok(this)
    }

    /// Returns the next event; `None` at the end of the file. [`Event::Record`] counts when it is
    /// returned.
    pub fn next_event(&mut self) -> Result<Option<Event>, InputError> {
        if let Some(first) = self.first.take() {
            return Ok(Some(first));
        }
        let event = self.json.next_event()?;
        self.ended += u64::from(matches!(event, Some(Event::Record(_))));
        Ok(event)
    }

    /// Returns the number of features before the current one; at the end, the number of all
    /// features.
    pub fn ended(&self) -> u64 {
        self.ended
    }

    /// Returns whether the first position has a third element.
    pub fn has_z(&self) -> bool {
        self.has_z
    }

    /// Returns the document, which has what is known so far of the current feature.
    pub fn json(&self) -> &GeoJson {
        &self.json
    }

    /// Takes the id of the feature that has just ended.
    pub fn take_id(&mut self) -> Option<FoundId> {
        self.json.take_id()
    }
}
