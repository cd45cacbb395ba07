//! Bounds in few bytes, which are never too small.

use crate::geometry::Rect;

/// The number of steps into which a side is divided.
const STEPS: u16 = u16::MAX;

/// The bounding rectangle of a part of a file, in steps of 1/65535 of the whole file's bounds. It
/// is rounded outwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CoarseBounds {
    pub(super) min: [u16; 2],
    pub(super) max: [u16; 2],
}

/// Returns the coordinate of a step between `low` and `high`.
fn at(step: u16, [low, high]: [f64; 2]) -> f64 {
    match step {
        0 => low,
        STEPS => high,
        _ => {
            let part = f64::from(step) / f64::from(STEPS);
            low * (1.0 - part) + high * part
        }
    }
}

/// Returns the step before `value`, as near as computing it is.
fn near(value: f64, [low, high]: [f64; 2]) -> u16 {
    let part = (value / 2.0 - low / 2.0) / (high / 2.0 - low / 2.0);
    // Not a number if there is no width, and then any step will do.
    (part * f64::from(STEPS)) as u16
}

impl CoarseBounds {
    /// Bounds that contain nothing.
    pub(crate) const EMPTY: Self = Self {
        min: [STEPS; 2],
        max: [0; 2],
    };

    /// Returns the smallest bounds around `rect`, which must be within `whole`.
    pub(crate) fn around(rect: Rect, whole: Rect) -> Self {
        if rect.is_empty() {
            return Self::EMPTY;
        }
        let below = |value: f64, side: [f64; 2]| {
            let first = near(value, side).saturating_add(1);
            (0..=first).rev().find(|&step| at(step, side) <= value).unwrap_or(0)
        };
        let above = |value: f64, side: [f64; 2]| {
            let first = near(value, side).saturating_sub(1);
            (first..=STEPS).find(|&step| at(step, side) >= value).unwrap_or(STEPS)
        };
        let (x, y) = ([whole.min_x, whole.max_x], [whole.min_y, whole.max_y]);
        Self {
            min: [below(rect.min_x, x), below(rect.min_y, y)],
            max: [above(rect.max_x, x), above(rect.max_y, y)],
        }
    }

    /// Returns the bounds as a rectangle, given the bounds of the whole file.
    pub(crate) fn rect(self, whole: Rect) -> Rect {
        if self == Self::EMPTY {
            return Rect::EMPTY;
        }
        let (x, y) = ([whole.min_x, whole.max_x], [whole.min_y, whole.max_y]);
        Rect::new(
            at(self.min[0], x),
            at(self.min[1], y),
            at(self.max[0], x),
            at(self.max[1], y),
        )
    }

    /// Returns the smallest bounds around both.
    pub(crate) fn union(self, other: Self) -> Self {
        let with = |a: [u16; 2], b: [u16; 2], pick: fn(u16, u16) -> u16| [pick(a[0], b[0]), pick(a[1], b[1])];
        Self {
            min: with(self.min, other.min, u16::min),
            max: with(self.max, other.max, u16::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn coarse_bounds_contain_the_exact_ones_and_little_more(
            xs in proptest::array::uniform4(-1e200..1e200f64),
            ys in proptest::array::uniform4(0.0..1e-140f64),
        ) {
            let sorted = |mut four: [f64; 4]| {
                four.sort_by(f64::total_cmp);
                four
            };
            let ([x0, x1, x2, x3], [y0, y1, y2, y3]) = (sorted(xs), sorted(ys));
            let whole = Rect::new(x0, y0, x3, y3);
            for rect in [Rect::new(x1, y1, x2, y2), whole, Rect::new(x1, y0, x1, y0)] {
                let coarse = CoarseBounds::around(rect, whole).rect(whole);
                prop_assert_eq!(coarse.union(rect), coarse);
                let (step_x, step_y) = (1.01 * (x3 - x0) / 65535.0, 1.01 * (y3 - y0) / 65535.0);
                prop_assert!(rect.min_x - coarse.min_x <= step_x && coarse.max_x - rect.max_x <= step_x);
                prop_assert!(rect.min_y - coarse.min_y <= step_y && coarse.max_y - rect.max_y <= step_y);
                prop_assert_eq!(CoarseBounds::EMPTY.union(CoarseBounds::around(rect, whole)).rect(whole), coarse);
            }
        }
    }

    #[test]
    fn bounds_without_width_or_content_are_kept() {
        let point = Rect::new(3.0, -4.0, 3.0, -4.0);
        assert_eq!(CoarseBounds::around(point, point).rect(point), point);
        assert_eq!(CoarseBounds::around(Rect::EMPTY, point).rect(point), Rect::EMPTY);
        let line = Rect::new(0.1, -4.0, 0.7, -4.0);
        let part = Rect::new(0.2, -4.0, 0.6, -4.0);
        let coarse = CoarseBounds::around(part, line).rect(line);
        assert_eq!((coarse.union(part), coarse.min_y, coarse.max_y), (coarse, -4.0, -4.0));
    }
}
