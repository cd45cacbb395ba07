//! What kinds of points are made from.

/// An endless, or long enough, sequence of points.
pub(crate) trait Source {
    fn next(&mut self) -> [f64; 2];
}
