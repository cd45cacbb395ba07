//! LAS, LAZ and COPC files of lidar points.
//!
//! Each of these modules uses only those above it:
//!
//! | module | contents |
//! |---|---|
//! | `problem` | what is wrong with a file |
//! | `layout` | the fields of a point's record, and the selection of points |
//! | `copc` | the octree of a COPC file, and the choice of its nodes |
//! | `header` | the header and its records |
//! | `about` | what the header says, and counts, for a description |
//! | `laz` | decompression, chunk by chunk |
//! | `reader` | the reader of all three |

mod about;
mod copc;
mod header;
mod layout;
mod laz;
mod problem;
mod reader;

pub use reader::{no_stream, open};
