//! The tile file: superblocks, directory, tiles, and the code that writes, reads and checks them.
//!
//! This module does not triangulate. `schema/FORMAT.md` specifies the format.

mod borders_ahead;
mod cache;
mod cells;
mod compact;
mod digest;
mod directory_writer;
pub(crate) mod divide;
mod error;
pub(crate) mod format;
mod open_options;
mod opening;
mod overview;
mod pages;
mod pass;
mod reader;
#[cfg(test)]
pub(crate) mod relabelled;
mod tiles_of_points;
mod verify;
mod writer;

pub use cache::{Cache, CacheStatistics, PinnedTile};
pub(crate) use cache::{EditCache, EditLease, EditPin, Failure, Weight};
pub(crate) use cells::{Cell, CellContent};
pub use compact::CompactError;
pub(crate) use directory_writer::front_end_for;
pub use error::ReadError;
pub use format::codec::Codec;
pub(crate) use format::codec::{Part, StoredPart};
pub(crate) use format::component_table;
pub(crate) use format::component_table::{Component, ComponentId, ComponentRecord};
pub(crate) use format::digest::triangle_hash;
pub use format::digest::{Digest, DigestSum};
pub use format::directory::Directory;
pub use format::edge_source::{EdgeSource, LineKind};
pub(crate) use format::encode::{BorderDraft, CoreDraft};
pub use format::entry::TileEntry;
pub use format::extent::Extent;
pub(crate) use format::ids::MAX_TILE_VERTICES;
pub use format::ids::{TileId, VertexId};
pub use format::kd_tree::{KdNode, KdTree};
pub(crate) use format::limits::{BLOCK, MAX_OVERVIEWS, MAX_TILES};
pub use format::line_part::LinePart;
pub use format::line_source::LineSource;
pub use format::lists::{Lists, Source};
pub use format::metadata::Metadata;
pub(crate) use format::metadata::hull_edges;
pub use format::overview::Overview;
pub(crate) use format::overview::OverviewEntry;
pub(crate) use format::page::Page;
pub use format::polygon_lines::PolygonLine;
pub(crate) use format::polygon_lines::in_order as polygon_lines_in_order;
pub(crate) use format::polygon_lines::polygon_of;
pub use format::superblock::{FORMAT_VERSION, FileId};
pub(crate) use format::table_place::TablePlace;
pub(crate) use format::tile::{HalfEdgeNote, HalfEdgeNotes, VertexNotes};
pub use format::tile::{Site, Tile, TileEdge, Vertex};
pub use open_options::OpenOptions;
pub(crate) use pass::{Needs, PassPlan, PassReader, TileInPass, by_tile, list_for, spawn};
pub use reader::TileReader;
pub(crate) use tiles_of_points::{Piece, PointsOfTile};
pub use verify::{LineBatch, PointOrigin, VerifyError, VerifyReport};
pub(crate) use writer::TileWriter;
