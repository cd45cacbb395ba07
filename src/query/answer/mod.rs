//! The answers of queries.

pub(crate) mod distance;
mod path;
mod site;

pub use distance::Distance;
pub(crate) use distance::distance;
pub(crate) use path::WayPoint;
pub use path::{Bend, Path, PathOutcome};
pub use site::{SiteFound, VertexFound};
