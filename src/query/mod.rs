//! Questions to a triangulation on disk.
//!
//! A query is a state machine without I/O that asks for tiles; a thin async driver feeds it through the cache.
//!
//! ```text
//!   walking · matrix · along · area        sites and paths; many to many; along a line; all within reach
//!       │
//!       ├──▶ funnel ──▶ edges              an answer with bounds: the way along edges, and the same pulled taut
//!       ├──▶ wavefront ──▶ route           what can be reached, nearest first; the path as it bends, and its proof
//!       │
//!       └──▶ free_space ──▶ locating       where a query begins and ends, and where one may walk
//!                │
//!                └──▶ request, answer      what a query may use: options, and tiles within them; what it answers with
//!
//!   euclidean                              as the crow flies
//!   baselines                              the same by others' methods, to be measured (feature `baselines`)
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
