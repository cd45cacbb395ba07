//! The trait of all distributions.

/// A sequence of points, endless or long enough.
pub(crate) trait Source {
    fn next(&mut self) -> [f64; 2];
}
