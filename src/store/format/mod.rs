//! Encoding and decoding of the tile file format, which `schema/FORMAT.md` specifies.
//!
//! This module does no I/O.

pub(crate) mod cell_index;
pub(crate) mod components;
pub(crate) mod damage;
pub(super) mod directory;
pub(super) mod edge_source;
pub(super) mod encode;
pub(super) mod entry;
mod generated;
pub(super) mod ids;
pub(super) mod kd_tree;
pub(crate) mod line_part;
pub(super) mod metadata;
mod packed;
pub(super) mod superblock;
pub(super) mod tile;
