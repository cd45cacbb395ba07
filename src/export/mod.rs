//! The triangulation in formats that other programs read.
//!
//! In: an open tile file. Out: its vertices and triangles, tile by tile, to anything that takes bytes. Memory is bounded by
//! what the reader [may use](crate::store::OpenOptions::memory): a few tiles, a few parts of them as bytes, and eight bytes for
//! each tile of the file.
//!
//! ```text
//! reader ──▶ numbering ──▶ part ──▶ ply, node, obj, geojson ──▶ output ──▶ io::Write
//!            one number     of a     a part's bytes at a time,   order, buffer,
//!            per vertex     tile     on blocking threads          blocking thread
//! ```
//!
//! Vertices are numbered through the file: in the order of the tiles, and within each as they stand. All formats have them
//! in this order, and every vertex once. Triangles stand once each, counter-clockwise, in the order of the tiles that they
//! belong to; those in holes only if they are [asked for](ExportOptions::holes). Whatever a file holds, an export ends with a whole output or an error; what was written until an error must
//! be thrown away.

mod error;
mod format;
mod geojson;
mod node;
mod numbering;
mod obj;
mod options;
mod output;
mod part;
mod ply;
mod text;
mod write;

#[cfg(test)]
mod edge_tests;
#[cfg(test)]
mod hole_tests;
#[cfg(test)]
mod tests;

pub use error::ExportError;
pub use format::{Format, UnknownFormat};
pub use options::ExportOptions;
pub use write::{Exported, export};
