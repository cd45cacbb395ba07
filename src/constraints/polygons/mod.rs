//! Each polygon by itself: where its rings run in the wrong direction.
//!
//! ```text
//!   segments as they arrive    ──▶ arrivals ──▶ check ──▶ polygons that are inside out: an error
//!   subsegments after a split  ──▶ repair ──▶ subsegments that cover what rings enclose
//!                                    └── both use sweep, with its status
//! ```

pub(crate) mod arrivals;
pub(crate) mod check;
pub(crate) mod repair;
mod status;
mod sweep;
