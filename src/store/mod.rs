//! The tile file: superblocks, directory, tiles, and those who write, read and check them.
//!
//! Knows no triangulating. The format is written down in `schema/FORMAT.md`.

mod borders_ahead;
mod cache;
pub(crate) mod cell_index;
mod compact;
pub(crate) mod components;
mod digest;
mod directory;
mod edge_source;
mod encode;
mod generated;
mod ids;
mod kd_tree;
mod metadata;
mod packed;
mod pass;
mod reader;
#[cfg(test)]
pub(crate) mod relabelled;
mod superblock;
mod tile;
mod verify;
mod writer;

pub use cache::{Cache, CacheStatistics, PinnedTile};
pub(crate) use cache::{EditCache, EditLease, EditPin, Failure, Weight};
pub use compact::CompactError;
pub use digest::{Digest, DigestSum};
pub(crate) use directory::MAX_TILES;
pub use directory::{Directory, Extent, TileEntry};
pub use edge_source::{EdgeSource, LineKind};
pub(crate) use encode::{BorderDraft, CoreDraft, ELSEWHERE, HULL};
pub(crate) use ids::MAX_TILE_VERTICES;
pub use ids::{TileId, VertexId};
pub use kd_tree::{KdNode, KdTree};
pub(crate) use metadata::hull_edges;
pub use metadata::{LineSource, Metadata, Source};
pub(crate) use pass::{Needs, Plan, TileInPass, Workspaces, by_tile, for_tiles, joined, list_for, spawn};
pub use reader::{OpenOptions, ReadError, TileReader};
pub(crate) use superblock::BLOCK;
pub use superblock::{FORMAT_VERSION, FileId};
pub use tile::{Across, Site, Tile, Vertex};
pub(crate) use tile::{Component, Marks, Noted, NotedSide, NotedSides};
pub use verify::{LineBatch, VerifyError, VerifyReport};
pub(crate) use writer::TileWriter;
