//! The queries of the surface: `z`, `profile` and `volume`.

pub mod profile;
mod surface;
pub mod volume;
pub mod z;
