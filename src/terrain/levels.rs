//! The levels of contours: heights at equal steps.

use std::ops::Range;

/// Heights at equal steps: `base + k · step` for all whole numbers `k`.
///
/// ```
/// use delaunay_tiles::terrain::Levels;
///
/// let levels = Levels::new(5.0, 2.5)?;
/// assert_eq!(levels.height(-1), -2.5);
/// assert!(Levels::new(0.0, 0.0).is_err());
/// # Ok::<(), delaunay_tiles::terrain::LevelsError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    step: f64,
    base: f64,
}

/// The error of levels that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LevelsError {
    /// The step is not a positive number.
    #[error("a step between levels is a number above 0, and not {0}")]
    Step(f64),
    /// The base is not a finite number.
    #[error("the base of levels is a number, and not {0}")]
    Base(f64),
    /// The heights of a surface have too many levels.
    #[error("the surface has more than {most} levels at steps of {step}; choose a larger step", most = Levels::MAX)]
    TooMany {
        /// The step.
        step: f64,
    },
    /// The heights of a surface, or the base, are too large for levels at this step.
    #[error("levels at steps of {step} cannot be told apart at a height of {height}; choose a larger step")]
    TooFine {
        /// The step.
        step: f64,
        /// The largest magnitude of a height, or of the base.
        height: f64,
    },
}

impl Levels {
    /// The largest number of levels between the least and the greatest height of a surface.
    pub const MAX: u64 = 100_000;

    /// Creates the levels at this distance from each other; one of them is `base`.
    ///
    /// # Errors
    /// Fails if `step` is not a positive number, or `base` is not a finite one.
    pub fn new(step: f64, base: f64) -> Result<Self, LevelsError> {
        match (step > 0.0 && step.is_finite(), base.is_finite()) {
            (true, true) => Ok(Self { step, base }),
            (false, _) => Err(LevelsError::Step(step)),
            (true, false) => Err(LevelsError::Base(base)),
        }
    }

    /// Returns the height of a level.
    #[must_use]
    pub fn height(&self, level: i64) -> f64 {
        // Zero has no sign.
        self.base + level as f64 * self.step + 0.0
    }

    /// Fails unless all levels between two heights differ, so that [`between`](Self::between) finds
    /// them.
    pub(crate) fn check(&self, least: f64, greatest: f64) -> Result<(), LevelsError> {
        let height = least.abs().max(greatest.abs()).max(self.base.abs());
        // A level that is not larger than `height` is rounded by at most 2 · ε · height, and the quotients
        // in `first_above` are below 2⁵⁰.
        match self.step > 8.0 * f64::EPSILON * height && height < f64::MAX / 4.0 {
            true => Ok(()),
            false => Err(LevelsError::TooFine {
                step: self.step,
                height,
            }),
        }
    }

    /// Fails if there are too many levels in a range.
    pub(crate) fn check_count(&self, levels: &Range<i64>) -> Result<(), LevelsError> {
        match levels.end.saturating_sub(levels.start) > Self::MAX as i64 {
            true => Err(LevelsError::TooMany { step: self.step }),
            false => Ok(()),
        }
    }

    /// Returns the levels above `low`, up to and including `high`, both of which passed
    /// [`check`](Self::check).
    pub(crate) fn between(&self, low: f64, high: f64) -> Range<i64> {
        self.first_above(low)..self.first_above(high)
    }

    fn first_above(&self, z: f64) -> i64 {
        let mut level = (z / self.step - self.base / self.step).floor() as i64;
        while self.height(level) > z {
            level -= 1;
        }
        while self.height(level) <= z {
            level += 1;
        }
        level
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_above_the_low_and_not_above_the_high() {
        let levels = Levels::new(0.1, 0.05).unwrap();
        for (low, high) in [(0.0, 1.0), (0.05, 0.15), (-7.25, -7.05), (3.0, 3.0), (1e6, 1e6 + 0.3)] {
            levels.check(low, high).unwrap();
            let found = levels.between(low, high);
            assert!(levels.height(found.start) > low && levels.height(found.start - 1) <= low);
            assert!(levels.height(found.end) > high && levels.height(found.end - 1) <= high);
        }
        assert_eq!(Levels::new(1.0, 0.0).unwrap().between(2.0, 5.0), 3..6);
        assert!(Levels::new(1.0, 0.0).unwrap().height(0).is_sign_positive());
    }

    #[test]
    fn bad_levels_are_errors() {
        for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(Levels::new(step, 0.0), Err(LevelsError::Step(_))));
        }
        assert!(matches!(Levels::new(1.0, f64::NAN), Err(LevelsError::Base(_))));
        for (step, base, high) in [(1e-9, 0.0, 1e9), (1.0, 1e20, 5.0), (1e300, 0.0, f64::MAX)] {
            let levels = Levels::new(step, base).unwrap();
            assert!(matches!(levels.check(0.0, high), Err(LevelsError::TooFine { .. })));
        }
        let levels = Levels::new(1e-3, 0.0).unwrap();
        levels.check(0.0, 1e9).unwrap();
        assert!(levels.check_count(&levels.between(0.0, 1e9)).is_err());
        levels.check_count(&levels.between(0.0, 99.9)).unwrap();
    }

    /// Close to the limit of [`Levels::check`], levels still differ, and are found.
    #[test]
    fn the_finest_levels_differ() {
        for base in [0.0, 1.0, -0.7] {
            let levels = Levels::new(9.0 * f64::EPSILON, base).unwrap();
            levels.check(-1.0, 1.0).unwrap();
            for z in [-1.0, -0.3, 1e-9, 0.5, 1.0] {
                let first = levels.first_above(z);
                for level in first - 20..first + 20 {
                    assert!(levels.height(level) < levels.height(level + 1));
                }
            }
        }
    }
}
