//! LAS, LAZ and COPC: lidar.

mod header;
mod layout;
mod laz;
mod problem;
mod reader;

pub use reader::{no_stream, open};
