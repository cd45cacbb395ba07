//! A file feature by feature, with the number of features and a look-ahead to the first position.

use crate::input::error::InputError;
use crate::input::formats::shapes::event::{Event, Kind};
use crate::input::formats::shapes::{FoundId, Shapes};

/// The events of a file, with the number of the feature that they belong to.
pub struct Features {
    shapes: Box<dyn Shapes>,
    /// The event that the look-ahead found.
    first: Option<Event>,
    has_z: bool,
    /// The number of features, and of geometries outside of any feature, that have ended.
    ended: u64,
}

impl Features {
    /// Skips events up to the first position, but stops at a geometry without positions whose kind
    /// `passes` rejects. Keeps ids if `id_field` is given.
    pub fn new(shapes: Box<dyn Shapes>, id_field: Option<&str>, passes: fn(Kind) -> bool) -> Result<Self, InputError> {
        let mut this = Self {
            shapes,
            first: None,
            has_z: false,
            ended: 0,
        };
        if let Some(field) = id_field {
            this.shapes.keep_ids(field);
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
        let event = self.shapes.next_event()?;
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

    /// Returns the type of the geometry whose positions come next, if it is already known.
    pub fn kind(&self) -> Option<Kind> {
        self.shapes.kind()
    }

    /// Returns the coordinate reference system, if the part of the file that was read has one.
    pub fn crs(&self) -> Option<&str> {
        self.shapes.crs()
    }

    /// Returns notes for the user about the file, at its end.
    pub fn notes(&self) -> Vec<String> {
        self.shapes.notes()
    }

    /// Takes the id of the feature that has just ended.
    pub fn take_id(&mut self) -> Option<FoundId> {
        self.shapes.take_id()
    }
}
