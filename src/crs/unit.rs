//! The units of coordinates.

use std::f64::consts::PI;

/// The unit of the coordinates of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unit {
    /// Metres.
    Metre,
    /// Kilometres.
    Kilometre,
    /// International feet of 0.3048 m.
    Foot,
    /// Feet of 1200/3937 m.
    UsSurveyFoot,
    /// Degrees: the coordinates are a longitude and a latitude.
    Degree,
    /// Another unit, or an unknown one.
    Unknown,
}

impl Unit {
    /// Returns the name of the unit, in the plural.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::Kilometre => "km",
            Self::Foot => "ft",
            Self::UsSurveyFoot => "US survey ft",
            Self::Degree => "degrees",
            Self::Unknown => "coordinate units",
        }
    }

    /// Returns the length of the unit in metres; `None` if it is an angle or unknown.
    ///
    /// ```
    /// # use delaunay_tiles::crs::Unit;
    /// assert_eq!(Unit::Foot.metres(), Some(0.3048));
    /// assert_eq!(Unit::Degree.metres(), None);
    /// ```
    #[must_use]
    pub const fn metres(self) -> Option<f64> {
        match self {
            Self::Metre => Some(1.0),
            Self::Kilometre => Some(1000.0),
            Self::Foot => Some(0.3048),
            Self::UsSurveyFoot => Some(1200.0 / 3937.0),
            Self::Degree | Self::Unknown => None,
        }
    }

    /// Returns the unit with this number of metres.
    pub(super) fn of_length(factor: f64) -> Self {
        // Both kinds of foot differ by two millionths.
        let is_it = |unit: &Self| {
            unit.metres()
                .is_some_and(|metres| (factor - metres).abs() <= 1e-7 * metres)
        };
        let units = [Self::Metre, Self::Kilometre, Self::Foot, Self::UsSurveyFoot];
        units.into_iter().find(is_it).unwrap_or(Self::Unknown)
    }

    /// Returns the unit with this number of radians.
    pub(super) fn of_angle(factor: f64) -> Self {
        match (factor - PI / 180.0).abs() <= 1e-8 {
            true => Self::Degree,
            false => Self::Unknown,
        }
    }
}
