//! A view of segments: all of them, or copies of some.

use crate::constraints::crossings::ends::Ends;
use crate::geometry::Point;

/// A view of segments: all of them, or copies of some.
pub(crate) struct SegmentView<'a, S> {
    pub(crate) segments: &'a [S],
    /// Of copies: the indices of the originals.
    pub(crate) originals: Option<&'a [u32]>,
}

impl<S> Clone for SegmentView<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for SegmentView<'_, S> {}

impl<S: Ends> SegmentView<'_, S> {
    #[inline]
    pub(crate) fn ends(&self, member: u32) -> [Point; 2] {
        self.segments[member as usize].ends()
    }

    pub(crate) fn number(&self, member: u32) -> u32 {
        self.originals.map_or(member, |originals| originals[member as usize])
    }
}
