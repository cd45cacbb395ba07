//! A factor that the method of the thesis prunes by.

use crate::query::edges::STRETCH;

/// What the CDT distance is of the walking distance at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch(pub(super) f64);

impl Stretch {
    /// A factor that is proved: 4π√3/9, rounded up (Bose and Keil, "On the stretch factor of the constrained Delaunay
    /// triangulation", ISVD 2006).
    pub const PROVED: Self = Self(STRETCH);
    /// No factor can be less: there are points whose Delaunay triangulation stretches a distance by so much (Xia and Zhang,
    /// "Toward the tight bound of the stretch factor of Delaunay triangulations", CCCG 2011).
    pub const LEAST: Self = Self(1.5932);

    /// A factor that is not known to lose answers.
    ///
    /// # Errors
    /// If it is no number, or less than [`LEAST`](Self::LEAST).
    pub fn new(factor: f64) -> Result<Self, LosesAnswers> {
        if (Self::LEAST.0..f64::INFINITY).contains(&factor) {
            Ok(Self(factor))
        } else {
            Err(LosesAnswers { factor })
        }
    }

    /// The factor.
    #[must_use]
    pub const fn get(self) -> f64 {
        self.0
    }
}

/// A stretch factor is no number, or is known not to hold.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a stretch factor of {factor} would lose answers: there are points whose Delaunay triangulation stretches a distance by {least} (Xia and Zhang 2011); {proved} is proved to do (Bose and Keil 2006)", least = Stretch::LEAST.0, proved = Stretch::PROVED.0)]
pub struct LosesAnswers {
    /// The factor.
    pub factor: f64,
}
