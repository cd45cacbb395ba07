//! What all distributions are.

/// An endless, or long enough, sequence of points.
pub(crate) trait Source {
    fn next(&mut self) -> [f64; 2];
}
