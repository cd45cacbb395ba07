//! Encoding and decoding of the tile file format, which `schema/FORMAT.md` specifies.
//!
//! This module does no I/O.

pub(crate) mod cell_index;
mod cells_code;
pub(super) mod coarse_bounds;
pub(super) mod codec;
pub(crate) mod component_table;
pub(crate) mod damage;
pub(super) mod digest;
pub(super) mod directory;
pub(super) mod edge_source;
pub(super) mod encode;
pub(super) mod entry;
pub(super) mod extent;
pub(super) mod flat_buffer;
mod generated;
pub(super) mod ids;
pub(super) mod kd_tree;
pub(super) mod layout;
pub(super) mod limits;
pub(crate) mod line_part;
pub(super) mod line_source;
pub(super) mod lists;
pub(super) mod metadata;
pub(super) mod overview;
mod packed;
pub(super) mod page;
pub(super) mod page_list;
pub(super) mod polygon_lines;
mod preorder;
pub(super) mod root;
pub(super) mod superblock;
pub(crate) mod table_place;
pub(super) mod tile;
