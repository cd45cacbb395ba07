//! The trait of values with two ends, which can cross.

use crate::constraints::segment::Segment;
use crate::geometry::Point;

/// A value with two ends.
pub(crate) trait Ends {
    /// Returns both ends.
    fn ends(&self) -> [Point; 2];
}

impl Ends for [Point; 2] {
    #[inline]
    fn ends(&self) -> [Point; 2] {
        *self
    }
}

impl Ends for Segment {
    #[inline]
    fn ends(&self) -> [Point; 2] {
        self.ends
    }
}
