//! GeoJSON (RFC 7946): its geometries as events.

mod document;
mod fields;
mod ids;
mod json;
mod kinds;

pub use document::GeoJson;
