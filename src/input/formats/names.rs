//! The names of columns that have coordinates.

/// Names of a column with x, best first.
pub const X: &[&str] = &["x", "lon", "longitude", "lng", "long", "easting", "east", "e"];
/// Names of a column with y, best first.
pub const Y: &[&str] = &["y", "lat", "latitude", "northing", "north", "n"];
/// Names of a column with z, best first.
pub const Z: &[&str] = &["z", "elevation", "elev", "height", "altitude", "alt"];
