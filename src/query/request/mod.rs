//! The options of a query, the tiles within its limits, and its errors.

mod contradiction;
mod error;
mod explored;
mod options;
mod star;
mod stream;
mod tiles;
mod tiles_used;

pub(crate) use contradiction::Contradiction;
pub use error::QueryError;
pub use explored::Explored;
pub(crate) use explored::key;
pub use options::{Mode, QueryOptions, Search, UnknownMode, UnknownSearch};
pub(crate) use star::half_edge_towards;
pub(crate) use stream::unfold;
pub(crate) use tiles::Tiles;
pub use tiles_used::TilesUsed;
