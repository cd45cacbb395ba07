//! Segments, found by their place.
//!
//! In: segments. Out: those near a rectangle. Horizontal strips of equal height have lists of the
//! segments that meet them.

use std::ops::RangeInclusive;

use crate::geometry::{Point, Rect};

/// Segments in horizontal strips.
#[derive(Clone, Debug)]
pub(crate) struct Strips {
    segments: Vec<[Point; 2]>,
    bounds: Rect,
    /// The numbers of the segments that meet each of some horizontal strips of equal height, one strip
    /// after the other.
    in_strips: Vec<u32>,
    /// Where each strip begins in `in_strips`, and the end of the last one.
    starts: Vec<u32>,
}

impl Strips {
    /// The largest number of segments, which together take about 300 MB.
    pub(crate) const MAX: usize = 1 << 22;
    /// The number of strips that a segment is in on average, at most.
    const PER_SEGMENT: f64 = 8.0;

    /// # Panics
    /// Panics if there are more than [`MAX`](Self::MAX).
    pub(crate) fn new(segments: Vec<[Point; 2]>) -> Self {
        assert!(segments.len() <= Self::MAX, "{} segments", segments.len());
        let bounds = Rect::around(segments.iter().copied().flatten());
        let height = bounds.max_y - bounds.min_y;
        let heights: f64 = segments.iter().map(|[a, b]| (a.y - b.y).abs()).sum();
        let count = segments.len() as f64;
        let strips = (Self::PER_SEGMENT * count * (height / heights)).min(count);
        // 1 also if the quotient is NaN.
        let strips = (strips as usize).max(1);
        let mut this = Self {
            segments,
            bounds,
            in_strips: Vec::new(),
            starts: vec![0; strips + 1],
        };
        let ranges: Vec<_> = this.segments.iter().map(|&[a, b]| this.strips(a.y, b.y)).collect();
        for range in &ranges {
            for strip in range.clone() {
                this.starts[strip + 1] += 1;
            }
        }
        for strip in 0..strips {
            this.starts[strip + 1] += this.starts[strip];
        }
        let mut next = this.starts.clone();
        this.in_strips = vec![0; this.starts[strips] as usize];
        for (range, segment) in ranges.into_iter().zip(0..) {
            for strip in range {
                this.in_strips[next[strip] as usize] = segment;
                next[strip] += 1;
            }
        }
        this
    }

    /// Returns the rectangle around all segments.
    pub(crate) fn bounds(&self) -> Rect {
        self.bounds
    }

    /// Returns the number of strips.
    pub(crate) fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the number of segments.
    pub(crate) fn segment_count(&self) -> u64 {
        self.segments.len() as u64
    }

    /// Returns the bytes of memory.
    pub(crate) fn bytes(&self) -> u64 {
        let numbers = self.in_strips.len() + self.starts.len();
        (size_of_val(&*self.segments) + size_of::<u32>() * numbers) as u64
    }

    /// Returns the strips from the one of `a` to that of `b`.
    fn strips(&self, a: f64, b: f64) -> RangeInclusive<usize> {
        let count = self.count();
        let height = self.bounds.max_y - self.bounds.min_y;
        // Monotone in y, so that a segment and a point at the same y are in the same strip.
        let strip = |y: f64| (((y - self.bounds.min_y) / height * count as f64) as usize).min(count - 1);
        strip(a.min(b))..=strip(a.max(b))
    }

    /// Returns the segments that may have a y from `a` to `b`, with their numbers; those that are in
    /// several strips, as often.
    pub(crate) fn between(&self, a: f64, b: f64) -> impl Iterator<Item = (u32, [Point; 2])> {
        let strips = self.strips(a, b);
        let range = self.starts[*strips.start()] as usize..self.starts[*strips.end() + 1] as usize;
        let numbers = self.in_strips[range].iter();
        numbers.map(|&number| (number, self.segments[number as usize]))
    }

    /// Returns the numbers of the segments whose bounding boxes meet a rectangle, in order.
    pub(crate) fn near(&self, rect: Rect) -> Vec<u32> {
        if !self.bounds.intersects(rect) {
            return Vec::new();
        }
        let near = self.between(rect.min_y, rect.max_y);
        let mut near: Vec<u32> = near
            .filter(|&(_, ends)| Rect::around(ends).intersects(rect))
            .map(|(number, _)| number)
            .collect();
        near.sort_unstable();
        near.dedup();
        near
    }

    /// Returns a segment.
    pub(crate) fn segment(&self, number: u32) -> [Point; 2] {
        self.segments[number as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_finds_the_segments_whose_boxes_meet_a_rectangle_once() {
        let segments: Vec<_> = (0..500u32)
            .map(|i| {
                let (x, y) = (f64::from(i * 37 % 101), f64::from(i * 53 % 97));
                [
                    Point::new(x, y),
                    Point::new(x + f64::from(i % 7), y - f64::from(i % 11)),
                ]
            })
            .collect();
        let strips = Strips::new(segments.clone());
        assert!(strips.count() > 100);
        let mut found = 0;
        for i in 0..300u32 {
            let (x, y) = (f64::from(i * 29 % 110), f64::from(i * 31 % 110) - 8.0);
            let rect = Rect::new(x, y, x + f64::from(i % 5), y + f64::from(i % 6));
            let meets = |&number: &u32| Rect::around(segments[number as usize]).intersects(rect);
            let expected: Vec<u32> = (0..500).filter(meets).collect();
            found += expected.len();
            assert_eq!(strips.near(rect), expected, "{rect:?}");
        }
        assert!(found > 300, "{found}");
        assert!(Strips::new(vec![]).near(Rect::PLANE).is_empty());
    }
}
