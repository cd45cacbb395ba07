//! The stretch factor of paths along edges.

/// A proved upper bound of the stretch factor: 4π√3/9, rounded up (Bose and Keil, "On the stretch
/// factor of the constrained Delaunay triangulation", ISVD 2006).
pub(crate) const STRETCH: f64 = 2.42;
