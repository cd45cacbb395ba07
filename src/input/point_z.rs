//! The coordinates of a point, of an end of a segment or of a site, with the checks that every
//! format makes.

use crate::geometry::Point;
use crate::input::flaw::Flaw;

/// A valid and normalized point, with its elevation if it has one.
#[derive(Clone, Copy)]
pub struct PointZ {
    pub point: Point,
    /// The elevation, if there is one; finite.
    pub z: Option<f64>,
}

impl PointZ {
    /// Checks and normalizes coordinates.
    #[inline]
    pub fn new(x: f64, y: f64, z: Option<f64>) -> Result<Self, Flaw> {
        let point = Point::new(x, y);
        if !point.is_valid() || z.is_some_and(|z| !z.is_finite()) {
            return Err(flaw(x, y, z));
        }
        Ok(Self {
            point: point.normalized(),
            z: z.map(|z| z + 0.0),
        })
    }
}

/// Returns what is wrong with coordinates of which at least one is invalid.
#[cold]
fn flaw(x: f64, y: f64, z: Option<f64>) -> Flaw {
    let (axis, value) = if !Point::new(x, 0.0).is_valid() {
        ('x', x)
    } else if !Point::new(0.0, y).is_valid() {
        ('y', y)
    } else {
        ('z', z.unwrap_or(f64::NAN))
    };
    if !value.is_finite() {
        Flaw::NotFinite { axis, value }
    } else if value.abs() > 1.0 {
        Flaw::TooLarge { axis, value }
    } else {
        Flaw::TooSmall { axis, value }
    }
}
