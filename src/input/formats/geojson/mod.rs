//! GeoJSON (RFC 7946): points, lines, the rings of polygons, and sites.

mod document;
mod event;
mod features;
mod ids;
mod json;
mod lines;
mod points;
mod rings;
mod sites;

pub use lines::Lines;
pub use points::Points;
pub use rings::Rings;
pub use sites::Sites;
