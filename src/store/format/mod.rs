//! The format: what stands in a tile file, to bytes and from bytes. It is written down in `schema/FORMAT.md`.
//!
//! Knows no files.

pub(crate) mod cell_index;
pub(crate) mod components;
pub(crate) mod damage;
pub(super) mod directory;
pub(super) mod edge_source;
pub(super) mod encode;
mod generated;
pub(super) mod ids;
pub(super) mod kd_tree;
pub(super) mod metadata;
mod packed;
pub(super) mod superblock;
pub(super) mod tile;
