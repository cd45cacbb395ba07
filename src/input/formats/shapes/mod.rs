//! Geometries as points, segments, the rings of polygons, and sites, for all formats that have
//! features.
//!
//! In: the events of a file ([`Shapes`]). Out: records of each kind. So a file in one format gives
//! the same records as the same features in another: lines are numbered by feature, polygons by
//! their outer rings, and the first position of a file tells whether it has z.

#[cfg(any(feature = "flatgeobuf", feature = "shapefile"))]
mod blocks;
#[cfg(any(feature = "flatgeobuf", feature = "shapefile", feature = "wkb"))]
mod decoded;
mod event;
mod features;
mod lines;
mod points;
mod rings;
mod sites;

use crate::input::about::Field;
use crate::input::error::InputError;
use crate::input::flaw::Flaw;
use crate::input::sites::SiteId;

#[cfg(any(feature = "flatgeobuf", feature = "shapefile"))]
pub use blocks::Blocks;
#[cfg(feature = "geopackage")]
pub use decoded::LONGEST;
#[cfg(any(feature = "flatgeobuf", feature = "shapefile", feature = "wkb"))]
pub use decoded::{Decoded, Decoder, Feature};
#[cfg(feature = "geojson")]
pub use event::Position;
pub use event::{Event, Kind};
pub use lines::Lines;
pub use points::Points;
pub use rings::Rings;
pub use sites::Sites;

/// An id, or what is wrong with it.
pub type FoundId = Result<SiteId, Flaw>;

/// The geometries of a file as a stream of events.
pub trait Shapes: Send {
    /// Returns the next event; `None` at the end of the file.
    fn next_event(&mut self) -> Result<Option<Event>, InputError>;

    /// Returns the type of the geometry whose positions come next, if it is already known.
    fn kind(&self) -> Option<Kind>;

    /// From now on, keeps the id of every feature, which is in the field `field`.
    fn keep_ids(&mut self, field: &str);

    /// Takes the id of the feature that has just ended; `None` if it has none.
    fn take_id(&mut self) -> Option<FoundId>;

    /// From now on, keeps the names and types of the fields, if the features have them.
    fn keep_fields(&mut self) {}

    /// Returns the fields of the features, at the end of the file.
    fn fields(&self) -> Vec<Field>;

    /// Returns the coordinate reference system, if the part of the file that was read has one.
    fn crs(&self) -> Option<&str>;

    /// Returns notes for the user, at the end of the file.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}
