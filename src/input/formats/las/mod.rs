//! LAS, LAZ and COPC files of lidar points.

mod about;
mod header;
mod layout;
mod laz;
mod problem;
mod reader;

pub use reader::{no_stream, open};
