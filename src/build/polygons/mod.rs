//! Each polygon by itself: where its rings go round the wrong way.
//!
//! ```text
//!   segments as they come ──▶ arrivals ──▶ check ──▶ polygons that are inside out: an error
//!   pieces after a split  ──▶ put_right ──▶ pieces of polygons that cover what their rings go round
//!                               └── both by sweep, with its status
//! ```

mod arrivals;
mod check;
mod put_right;
mod status;
mod sweep;

pub(super) use arrivals::{Arrivals, PolygonNumbers};
pub(super) use check::Runs;
pub use check::{Inverted, InvertedPolygons, PolygonCheck, PolygonFaults};
pub(super) use put_right::{PutRight, put_right};
