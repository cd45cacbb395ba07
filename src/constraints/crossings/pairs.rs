//! All pairs of a few segments whose bounding boxes meet and that share no end.
//!
//! Branch-free: most pairs fail one of the two tests, and which one is unpredictable. So both tests
//! run over rows of pairs without a branch on their outcome.

use std::ops::ControlFlow;

use crate::constraints::crossings::boxes::{bounds, boxes_meet, share_an_end};
use crate::geometry::{Point, Rect};

/// Buffers of the comparison of all pairs.
#[derive(Debug, Default)]
pub(crate) struct Pairs {
    segments: Vec<[Point; 2]>,
    boxes: Vec<Rect>,
    /// The segments that may still meet the current one.
    partners: Vec<u32>,
}

impl Pairs {
    /// Visits the pairs of segments that may meet, with their indices.
    pub(crate) fn visit(
        &mut self,
        segments: impl Iterator<Item = [Point; 2]>,
        mut visit: impl FnMut(([Point; 2], u32), ([Point; 2], u32)) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.segments.clear();
        self.segments.extend(segments);
        self.boxes.clear();
        self.boxes.extend(self.segments.iter().map(|&ends| bounds(ends)));
        self.partners.resize(self.segments.len(), 0);
        let partners = &mut self.partners;
        for (index, (ends, bounds)) in (0..).zip(self.segments.iter().zip(&self.boxes)) {
            let mut kept = 0;
            for (other, other_bounds) in (0..index).zip(&self.boxes) {
                partners[kept] = other;
                kept += usize::from(boxes_meet(bounds, other_bounds));
            }
            let near = kept;
            kept = 0;
            for number in 0..near {
                let other = partners[number];
                partners[kept] = other;
                kept += usize::from(!share_an_end(*ends, self.segments[other as usize]));
            }
            for &other in &partners[..kept] {
                visit((*ends, index), (self.segments[other as usize], other))?;
            }
        }
        ControlFlow::Continue(())
    }
}
