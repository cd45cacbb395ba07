//! The command line of delaunay-tiles.
fn main() {}
