//! The pixels of which one sample does not tell all.

use crate::map_tiles::grid::PIXELS;
use crate::map_tiles::window::{PER_PIXEL, Unit};

/// How far from a line a pixel may be to be marked, in pixels: more than positions are rounded by.
const NEAR: f64 = 0.125;

/// Pixels of a tile that are marked.
pub(super) struct Marks(Vec<bool>);

impl Marks {
    pub(super) fn new() -> Self {
        Self(vec![false; (PIXELS * PIXELS) as usize])
    }

    /// Marks the pixels that a line passes.
    pub(super) fn line(&mut self, ends: [Unit; 2]) {
        let [a, b] = ends.map(|end| end.map(|v| f64::from(v) / f64::from(PER_PIXEL)));
        let ([_, top], [_, bottom]) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        for row in range(top, bottom) {
            let at = |y: f64| match b[1] - a[1] {
                0.0 => [0.0, 1.0],
                height => [(y - a[1]) / height; 2],
            };
            let shares = [at(f64::from(row) - NEAR)[0], at(f64::from(row) + 1.0 + NEAR)[1]];
            let [x, other] = shares.map(|share| a[0] + (b[0] - a[0]) * share.clamp(0.0, 1.0));
            for column in range(x.min(other), x.max(other)) {
                self.0[(row * PIXELS + column) as usize] = true;
            }
        }
    }

    /// Marks the pixels that differ from one of their neighbours. `values` has a margin of one
    /// pixel.
    pub(super) fn changes<T: PartialEq>(&mut self, values: &[T]) {
        let width = (PIXELS + 2) as usize;
        for (pixel, mark) in self.0.iter_mut().enumerate() {
            let at = (pixel / PIXELS as usize + 1) * width + pixel % PIXELS as usize + 1;
            let around = [at - width, at - 1, at + 1, at + width];
            *mark |= around.iter().any(|&other| values[other] != values[at]);
        }
    }

    /// Returns the numbers of the marked pixels.
    pub(super) fn pixels(&self) -> Vec<u32> {
        let marked = self.0.iter().zip(0..).filter(|(mark, _)| **mark);
        marked.map(|(_, pixel)| pixel).collect()
    }
}

/// Returns the rows or columns of pixels that an interval meets, or nearly so.
fn range(least: f64, most: f64) -> std::ops::Range<u32> {
    // Conversions saturate.
    (least - NEAR).floor() as u32..((most + NEAR).floor() + 1.0).clamp(0.0, f64::from(PIXELS)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_pixels_along_a_line_are_marked_and_few_others() {
        for (a, b) in [
            ([0, 0], [4096, 4096]),
            ([100, 200], [4000, 210]),
            ([64, 4090], [64, -50]),
            ([9, 9], [9, 9]),
        ] {
            let mut marks = Marks::new();
            marks.line([a, b]);
            let mut passed = 0;
            for i in 0..=10_000 {
                let at = |axis: usize| f64::from(a[axis]) + f64::from(b[axis] - a[axis]) * f64::from(i) / 10_000.0;
                let [x, y] = [at(0), at(1)].map(|v| (v / 16.0).floor() as i64);
                if (0..256).contains(&x) && (0..256).contains(&y) {
                    assert!(marks.0[(y * 256 + x) as usize], "{a:?} {b:?} {x} {y}");
                    passed += 1;
                }
            }
            assert!(passed > 0 && marks.pixels().len() <= 3 * 256 + 4);
        }
    }

    #[test]
    fn changes_are_marked_on_both_sides() {
        let values: Vec<bool> = (0..258 * 258).map(|i| i % 258 > 100).collect();
        let mut marks = Marks::new();
        marks.changes(&values);
        assert_eq!(marks.pixels().len(), 2 * 256);
    }
}
