//! The stretch factor with which the method of the thesis prunes.

use crate::query::edges::STRETCH;

/// An upper bound of the ratio of CDT distance to walking distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch(pub(super) f64);

impl Stretch {
    /// A proved factor: 4π√3/9, rounded up (Bose and Keil, "On the stretch factor of the
    /// constrained Delaunay triangulation", ISVD 2006).
    pub const PROVED: Self = Self(STRETCH);
    /// A lower bound of all valid factors: there are points whose Delaunay triangulation has this
    /// stretch factor (Xia and Zhang, "Toward the tight bound of the stretch factor of Delaunay
    /// triangulations", CCCG 2011).
    pub const LEAST: Self = Self(1.5932);

    /// Creates a factor that is not known to lose answers.
    ///
    /// # Errors
    /// If the factor is not finite, or less than [`LEAST`](Self::LEAST).
    pub fn new(factor: f64) -> Result<Self, LosesAnswers> {
        if (Self::LEAST.0..f64::INFINITY).contains(&factor) {
            Ok(Self(factor))
        } else {
            Err(LosesAnswers { factor })
        }
    }

    /// Returns the factor.
    #[must_use]
    pub const fn get(self) -> f64 {
        self.0
    }
}

/// The error for a stretch factor that is not finite, or is known to be too small.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a stretch factor of {factor} would lose answers: there are points whose Delaunay triangulation has a stretch factor of {least} (Xia and Zhang 2011); {proved} is proved to suffice (Bose and Keil 2006)", least = Stretch::LEAST.0, proved = Stretch::PROVED.0)]
pub struct LosesAnswers {
    /// The factor.
    pub factor: f64,
}
