//! Where an end of a segment or a site lies.

use super::sink::describe;
use crate::geometry::Point;

/// A place: valid and normalized.
#[derive(Clone, Copy)]
pub(super) struct Spot {
    pub point: Point,
    /// Its elevation, if it has one: finite.
    pub z: Option<f64>,
}

impl Spot {
    /// A place, or what is wrong with it.
    pub fn new(x: f64, y: f64, z: Option<f64>) -> Result<Self, String> {
        let point = Point::new(x, y);
        if !point.is_valid() || z.is_some_and(|z| !z.is_finite()) {
            return Err(describe(x, y, z));
        }
        Ok(Self {
            point: point.normalized(),
            z: z.map(|z| z + 0.0),
        })
    }
}
