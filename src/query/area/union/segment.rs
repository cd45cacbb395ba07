//! Segments between grid points, with exact predicates.

/// A point of the grid, as multiples of its step. Differences of coordinates are below 2^38.
pub(super) type Pixel = [i64; 2];

/// A segment between grid points, and the change of the winding number from its right to its left.
#[derive(Clone, Copy)]
pub(super) struct Segment {
    pub(super) from: Pixel,
    /// Greater than `from`, in lexicographic order.
    pub(super) to: Pixel,
    pub(super) change: i32,
}

impl Segment {
    /// Returns the segment between two pixels, unless they are equal. `change` is that from right to
    /// left on the way from the first to the second pixel.
    pub(super) fn between(a: Pixel, b: Pixel, change: i32) -> Option<Self> {
        let (from, to, change) = if a < b { (a, b, change) } else { (b, a, -change) };
        (from != to).then_some(Self { from, to, change })
    }

    fn delta(&self) -> [i64; 2] {
        [self.to[0] - self.from[0], self.to[1] - self.from[1]]
    }

    /// Returns the ends of the range of the coordinates on an axis.
    pub(super) fn range(&self, axis: usize) -> [i64; 2] {
        let [a, b] = [self.from[axis], self.to[axis]];
        [a.min(b), a.max(b)]
    }

    /// Returns twice the signed area between the segment and a pixel's centre, positive on the left.
    fn off(&self, [x, y]: Pixel) -> i128 {
        let ([dx, dy], [px, py]) = (self.delta(), [x - self.from[0], y - self.from[1]]);
        i128::from(dx) * i128::from(py) - i128::from(dy) * i128::from(px)
    }

    /// Returns whether the segment passes a pixel's half-open square, and does not end in it.
    pub(super) fn passes(&self, pixel: Pixel) -> bool {
        let is_in_range = (0..2).all(|axis| {
            let [low, high] = self.range(axis);
            low <= pixel[axis] && pixel[axis] <= high
        });
        if !is_in_range || pixel == self.from || pixel == self.to {
            return false;
        }
        // The line separates the corners of the square, or meets the least one only, which it does on
        // its way down to the right. Another one, met alone, does not belong to the square.
        let [dx, dy] = self.delta();
        let (off, reach) = (2 * self.off(pixel), i128::from(dx.abs() + dy.abs()));
        off.abs() < reach || (off == reach && dy < 0)
    }
}

/// Returns the pixel in which two segments cross, unless an end of one is on the other.
pub(super) fn crossing(first: &Segment, second: &Segment) -> Option<Pixel> {
    let is_near = (0..2).all(|axis| {
        let ([a, b], [c, d]) = (first.range(axis), second.range(axis));
        a <= d && c <= b
    });
    if !is_near {
        return None;
    }
    let are_apart = |a: i128, b: i128| (a < 0 && b > 0) || (a > 0 && b < 0);
    if !are_apart(first.off(second.from), first.off(second.to)) {
        return None;
    }
    let [from, to] = [second.off(first.from), second.off(first.to)];
    are_apart(from, to).then(|| {
        // The crossing is `from / whole` of the way.
        let (from, whole) = if from < to {
            (-from, to - from)
        } else {
            (from, from - to)
        };
        let delta = first.delta();
        [0, 1].map(|axis| {
            let doubled = 2 * i128::from(delta[axis]) * from + whole;
            first.from[axis] + doubled.div_euclid(2 * whole) as i64
        })
    })
}
