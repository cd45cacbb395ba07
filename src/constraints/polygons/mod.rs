//! Each polygon by itself: where its rings go round the wrong way.
//!
//! ```text
//!   segments as they come ──▶ arrivals ──▶ check ──▶ polygons that are inside out: an error
//!   pieces after a split  ──▶ put_right ──▶ pieces of polygons that cover what their rings go round
//!                               └── both by sweep, with its status
//! ```

pub(crate) mod arrivals;
pub(crate) mod check;
pub(crate) mod repair;
mod status;
mod sweep;
