//! Segments, all or copies of some.

use crate::constraints::crossings::ends::Ends;
use crate::geometry::Point;

/// Segments, all or copies of some.
pub(crate) struct Lines<'a, S> {
    pub(crate) segments: &'a [S],
    /// Of copies: the numbers of the originals.
    pub(crate) numbers: Option<&'a [u32]>,
}

impl<S> Clone for Lines<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for Lines<'_, S> {}

impl<S: Ends> Lines<'_, S> {
    #[inline]
    pub(crate) fn ends(&self, member: u32) -> [Point; 2] {
        self.segments[member as usize].ends()
    }

    pub(crate) fn number(&self, member: u32) -> u32 {
        self.numbers.map_or(member, |numbers| numbers[member as usize])
    }
}
