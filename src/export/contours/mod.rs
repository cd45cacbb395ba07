//! Export of contours: lines of equal height, as features.
//!
//! In: an open tile file with z and the levels. Out: one file, to anything that takes bytes. Tiles are
//! read once, and threads trace and format what is complete within a tile. The points of chains that
//! continue in other tiles go to a temporary file; when the last chain of a contour is there, all of it
//! is read again. So do contours that leave polygons, which are cut when they are complete, so that what
//! is left of them does not depend on the tiles.
//!
//! ```text
//! tile ──▶ trace ──┬─ complete ─────────────────────────────▶ features ──▶ Output
//!                  └─ chains ──▶ scratch file ──▶ contours ─────┘
//!                          └───▶ terrain::Strands ──┘
//! ```

mod clipped;
mod features;
mod job;
mod write;

pub use write::{ContourOutput, ExportedContours, export_contours};
