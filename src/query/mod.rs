//! Questions to a triangulation on disk.
//!
//! A query is a state machine without I/O that asks for tiles; a thin async driver feeds it through the cache.
//!
//! ```text
//!   matrix, along, area                   many to many; along a line; all within reach
//!       │
//!   proximity ──▶ place ──▶ locate        where a query begins and ends
//!       │
//!       ├───────▶ wave ───▶ ground        what can be reached from there, nearest first; where one may walk
//!       │
//!       ├───────▶ fast ───▶ edges, taut   an answer with bounds: the way along edges, and the same pulled taut
//!       ├───────▶ baselines ──▶ edges    the same by others' methods, to be measured (feature `baselines`)
//!       │
//!       └───────▶ route                   the path as it bends, and its proof
//! ```

mod along;
mod area;
#[cfg(feature = "baselines")]
pub mod baselines;
mod certify;
mod edges;
mod explored;
mod fast;
mod ground;
mod locate;
mod matrix;
mod options;
mod passages;
mod place;
mod progressive;
mod proximity;
mod route;
mod sight;
mod star;
mod straight;
mod taut;
mod tiles;
mod triangles_in;
mod wave;

pub use along::{AlongInterval, SiteAlong};
pub use area::AreaPiece;
pub use edges::{CdtPath, CdtVertex};
pub use explored::Explored;
pub use locate::{Location, TriangleRef};
pub use matrix::{DistanceOutcome, PairDistance};
pub use options::{Mode, QueryError, QueryOptions, UnknownMode};
pub use progressive::{Cost, Progress};
pub use proximity::{Distance, Footing, PathOutcome, SiteFound, VertexFound};
pub use route::{Bend, Path};
pub use straight::Near;

use crate::geometry::Point;

/// A coordinate that someone asks for, as the exact predicates can take it: what is closer to 0 than any coordinate of a
/// triangulation can be counts as 0. What is too large is outside anyway.
fn representable(v: f64) -> f64 {
    if v.abs() < Point::MIN_MAGNITUDE { 0.0 } else { v }
}
