//! What a raster shows of a surface: its height, its slope, or how it is lit.

use super::facet::{Facet, Place};
use crate::geometry::Point;

/// What the cells of a raster hold.
///
/// Slopes, aspects and shades are those of the triangle at the centre of a cell. A centre on an edge
/// or on a vertex belongs to one of the triangles there: the one in which it remains if it moves by an
/// infinitesimal distance to the right, and by an infinitesimal share of it upwards; or, if that one
/// does not count, the one whose sorted corners come first in lexicographic order.
///
/// ```
/// use delaunay_tiles::terrain::{Light, Measure};
///
/// let shaded: Measure = "hillshade".parse().unwrap();
/// assert_eq!(shaded, Measure::Hillshade(Light::default()));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Measure {
    /// The height, in units of z.
    #[default]
    Z,
    /// The angle between the triangle and the horizontal, in degrees.
    Slope,
    /// The direction in which the triangle descends, in degrees clockwise from north. Horizontal
    /// triangles have none.
    Aspect,
    /// The light that the triangle reflects, from 1 (none) to 255, as GDAL computes it.
    Hillshade(Light),
}

/// The light of a hillshade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// The direction from which it comes, in degrees clockwise from north.
    pub azimuth: f64,
    /// Its height above the horizon, in degrees.
    pub altitude: f64,
}

impl Default for Light {
    /// From the north-west, halfway up.
    fn default() -> Self {
        Self {
            azimuth: 315.0,
            altitude: 45.0,
        }
    }
}

/// The error of a name that no measure has.
#[derive(Clone, Debug, thiserror::Error)]
#[error("a raster shows z, slope, aspect or hillshade, and not '{0}'")]
pub struct UnknownMeasure(String);

impl std::str::FromStr for Measure {
    type Err = UnknownMeasure;

    fn from_str(name: &str) -> Result<Self, UnknownMeasure> {
        match name {
            "z" => Ok(Self::Z),
            "slope" => Ok(Self::Slope),
            "aspect" => Ok(Self::Aspect),
            "hillshade" => Ok(Self::Hillshade(Light::default())),
            _ => Err(UnknownMeasure(name.to_owned())),
        }
    }
}

impl std::fmt::Display for Measure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Z => "z",
            Self::Slope => "slope",
            Self::Aspect => "aspect",
            Self::Hillshade(_) => "hillshade",
        })
    }
}

/// A measure, prepared for many triangles. Heights are multiplied by a factor first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measuring {
    measure: Measure,
    z_factor: f64,
    /// The unit vector towards the light.
    light: [f64; 3],
}

impl Measuring {
    pub(crate) fn new(measure: Measure, z_factor: f64) -> Self {
        let light = match measure {
            Measure::Hillshade(Light { azimuth, altitude }) => {
                let (azimuth, altitude) = (azimuth.to_radians(), altitude.to_radians());
                [
                    azimuth.sin() * altitude.cos(),
                    azimuth.cos() * altitude.cos(),
                    altitude.sin(),
                ]
            }
            _ => [0.0; 3],
        };
        Self {
            measure,
            z_factor,
            light,
        }
    }

    /// Returns whether the value at a point is the same for all triangles that contain it.
    pub(crate) fn is_continuous(&self) -> bool {
        self.measure == Measure::Z
    }

    /// Returns a function from points at their places in a facet to their values; NaN is no value.
    #[inline]
    pub(crate) fn of<'a>(&'a self, facet: &'a Facet) -> impl Fn(Point, Place) -> f64 + 'a {
        let whole = match self.measure {
            Measure::Z => 0.0,
            measure => self.of_plane(measure, facet),
        };
        move |p, place| match self.measure {
            Measure::Z => facet.z_at(p, place) * self.z_factor,
            _ => whole,
        }
    }

    fn of_plane(&self, measure: Measure, facet: &Facet) -> f64 {
        let [east, north] = facet.gradient().map(|change| change * self.z_factor);
        let steepness = east.hypot(north);
        match measure {
            Measure::Z => f64::NAN,
            Measure::Slope => steepness.atan().to_degrees(),
            Measure::Aspect if steepness == 0.0 => f64::NAN,
            Measure::Aspect => {
                let degrees = (-east).atan2(-north).to_degrees();
                let positive = if degrees < 0.0 { degrees + 360.0 } else { degrees };
                // The sum can round to 360; and -0 is 0.
                if positive >= 360.0 { 0.0 } else { positive + 0.0 }
            }
            Measure::Hillshade(_) => {
                let [x, y, z] = self.light;
                let lit = (z - x * east - y * north) / steepness.hypot(1.0);
                if lit.is_nan() {
                    f64::NAN
                } else {
                    1.0 + 254.0 * lit.max(0.0)
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::facet::Corner;

    fn values(east: f64, north: f64) -> [f64; 3] {
        let corners = [(0.0, 0.0), (2.0, 0.0), (0.0, 2.0)].map(|(x, y)| Corner {
            point: Point::new(x, y),
            z: 7.0 + east * x + north * y,
        });
        let facet = Facet::new(corners);
        let measures = [Measure::Slope, Measure::Aspect, Measure::Hillshade(Light::default())];
        measures.map(|measure| Measuring::new(measure, 1.0).of(&facet)(Point::new(0.5, 0.5), Place::Inside))
    }

    #[test]
    fn slopes_descend_in_their_aspect_and_are_brightest_towards_the_light() {
        let diagonal = 0.5f64.sqrt();
        for (east, north, slope, aspect, shade) in [
            // Descends to the east, west, north, south.
            (-1.0, 0.0, 45.0, 90.0, 1.0 + 254.0 * (diagonal - 0.5) * diagonal),
            (1.0, 0.0, 45.0, 270.0, 1.0 + 254.0 * (diagonal + 0.5) * diagonal),
            (0.0, -1.0, 45.0, 0.0, 1.0 + 254.0 * (diagonal + 0.5) * diagonal),
            (0.0, 1.0, 45.0, 180.0, 1.0 + 254.0 * (diagonal - 0.5) * diagonal),
            // Towards the light, and away from it.
            (diagonal, -diagonal, 45.0, 315.0, 255.0),
            (-2.0 * diagonal, 2.0 * diagonal, 2f64.atan().to_degrees(), 135.0, 1.0),
        ] {
            for (found, expected) in values(east, north).into_iter().zip([slope, aspect, shade]) {
                assert!(
                    (found - expected).abs() < 1e-9,
                    "{east} {north}: {found}, not {expected}"
                );
            }
        }
        let [slope, aspect, shade] = values(0.0, 0.0);
        assert!(slope == 0.0 && aspect.is_nan() && (shade - (1.0 + 254.0 * diagonal)).abs() < 1e-9);
    }
}
