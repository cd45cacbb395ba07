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
mod answer;
mod area;
#[cfg(feature = "baselines")]
pub mod baselines;
mod edges;
mod euclidean;
mod free_space;
mod funnel;
mod locating;
mod matrix;
mod request;
mod route;
mod walking;
mod wavefront;

pub use along::{AlongInterval, SiteAlong};
pub use answer::{Bend, Distance, Path, PathOutcome, SiteFound, VertexFound};
pub use area::AreaPiece;
pub use edges::{CdtPath, CdtVertex};
pub use euclidean::Near;
pub use free_space::Footing;
pub use locating::{Location, TriangleRef};
pub use matrix::{DistanceOutcome, PairDistance};
pub use request::{Explored, Mode, QueryError, QueryOptions, UnknownMode};
pub use walking::{Cost, Progress};
