//! GeoJSON feature by feature: counted, and looked at up to the first position.

use crate::input::bytes::ByteInput;
use crate::input::error::InputError;
use crate::input::formats::geojson::document::GeoJson;
use crate::input::formats::geojson::event::{Event, Kind};
use crate::input::formats::geojson::ids::FoundId;

/// The events of a file, with the number of the feature that they are of.
pub struct Features {
    json: GeoJson,
    /// What the look has found.
    first: Option<Event>,
    has_z: bool,
    /// Features, and geometries outside of all, that are at their end.
    ended: u64,
}

impl Features {
    /// Passes over what is before the first position, but stops at a geometry that has none and is not of these kinds.
    /// Ids are kept if there is a field for them.
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

    /// What comes next; `None` at the end of the file. [`Event::Record`] counts as it comes.
    pub fn next_event(&mut self) -> Result<Option<Event>, InputError> {
        if let Some(first) = self.first.take() {
            return Ok(Some(first));
        }
        let event = self.json.next_event()?;
        self.ended += u64::from(matches!(event, Some(Event::Record(_))));
        Ok(event)
    }

    /// The features before the one at hand; at the end all.
    pub fn ended(&self) -> u64 {
        self.ended
    }

    /// Whether the first position has a third element.
    pub fn has_z(&self) -> bool {
        self.has_z
    }

    /// What is known by now of the feature at hand.
    pub fn json(&self) -> &GeoJson {
        &self.json
    }

    /// The id of the feature that has just come to its end.
    pub fn take_id(&mut self) -> Option<FoundId> {
        self.json.take_id()
    }
}
