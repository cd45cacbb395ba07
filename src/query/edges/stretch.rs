//! What ways along edges can be longer than others.

/// A factor that is proved: 4π√3/9, rounded up (Bose and Keil, "On the stretch factor of the constrained Delaunay triangulation",
/// ISVD 2006).
pub(crate) const STRETCH: f64 = 2.42;
