//! Buckets of a square grid, with the segments that pass near them.

use super::segment::{Pixel, Segment};

/// Squares of pixels, each with the indices of all segments that pass one of its pixels.
pub(super) struct Buckets {
    origin: Pixel,
    /// The number of buckets in a row.
    columns: usize,
    /// A bucket has 2^`shift` pixels in each direction.
    shift: u32,
    /// The range of each bucket in `list`.
    starts: Vec<u32>,
    list: Vec<u32>,
}

impl Buckets {
    /// Makes at most eight times as many buckets as segments: those of an area lie along its rim.
    pub(super) fn new(segments: &[Segment]) -> Self {
        let ends = segments.iter().flat_map(|segment| [segment.from, segment.to]);
        let bound = |of: fn(i64, i64) -> i64| ends.clone().reduce(|a, b| [of(a[0], b[0]), of(a[1], b[1])]);
        let origin = bound(i64::min).unwrap_or_default();
        let corner = bound(i64::max).unwrap_or_default();
        let count = |shift: u32| [0, 1].map(|axis| ((corner[axis] - origin[axis]) as usize >> shift) + 1);
        let product = |shift| {
            count(shift)
                .iter()
                .try_fold(1usize, |product, &size| product.checked_mul(size))
        };
        let most = (8 * segments.len()).max(1);
        let shift = (0..).find(|&shift| product(shift).is_some_and(|product| product <= most));
        let shift = shift.unwrap_or(0);
        let [columns, rows] = count(shift);
        let mut this = Self {
            origin,
            columns,
            shift,
            starts: vec![0; columns * rows + 1],
            list: Vec::new(),
        };
        this.fill(segments);
        this
    }

    /// Sorts the segments into the buckets, by counting.
    fn fill(&mut self, segments: &[Segment]) {
        let mut ends = vec![0u32; self.starts.len()];
        for segment in segments {
            self.visit(segment, |bucket| ends[bucket + 1] += 1);
        }
        for bucket in 1..ends.len() {
            ends[bucket] += ends[bucket - 1];
        }
        self.starts.copy_from_slice(&ends);
        let mut list = vec![0; ends.last().map_or(0, |&end| end as usize)];
        for (segment, index) in segments.iter().zip(0..) {
            self.visit(segment, |bucket| {
                list[ends[bucket] as usize] = index;
                ends[bucket] += 1;
            });
        }
        self.list = list;
    }

    /// Calls a function for each bucket that a segment may pass.
    fn visit(&self, segment: &Segment, mut then: impl FnMut(usize)) {
        let [[ax, ay], [bx, by]] = [segment.from, segment.to].map(|p| [p[0] - self.origin[0], p[1] - self.origin[1]]);
        let slope = (by - ay) as f64 / (bx - ax) as f64;
        let (low, high) = (ay.min(by), ay.max(by));
        for column in ax >> self.shift..=bx >> self.shift {
            // Pixels extend by a half to all sides, and rounding is far less than that.
            let left = ((column << self.shift) - 1).max(ax);
            let right = ((column + 1) << self.shift).min(bx);
            let (mut from, mut to) = (low, high);
            if left > ax || right < bx {
                let [a, b] = [left, right].map(|x| ay + (slope * (x - ax) as f64) as i64);
                (from, to) = ((a.min(b) - 2).max(low), (a.max(b) + 2).min(high));
            }
            for row in from >> self.shift..=to >> self.shift {
                then(row as usize * self.columns + column as usize);
            }
        }
    }

    /// Returns the segments of each bucket.
    pub(super) fn segments(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.starts.len() - 1).map(|bucket| self.of(bucket))
    }

    fn of(&self, bucket: usize) -> &[u32] {
        &self.list[self.starts[bucket] as usize..self.starts[bucket + 1] as usize]
    }

    /// Returns the segments of the bucket of a pixel, which is within the bounds of the segments.
    pub(super) fn at(&self, pixel: Pixel) -> &[u32] {
        let [column, row] = [0, 1].map(|axis| ((pixel[axis] - self.origin[axis]) >> self.shift) as usize);
        self.of(row * self.columns + column)
    }
}
