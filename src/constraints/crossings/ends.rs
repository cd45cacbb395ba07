//! What can cross: anything with two ends.

use crate::constraints::segment::Segment;
use crate::geometry::Point;

/// What has two ends.
pub(crate) trait Ends {
    /// Both ends.
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
