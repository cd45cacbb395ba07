//! The expected work of a wavefront to a group of targets.

use std::f64::consts::PI;

use crate::geometry::Point;
use crate::query::answer::distance;

/// The work of starting a wavefront, in triangles passed.
const START: f64 = 200.0;
/// How often a directed wavefront passes a triangle, on average. Measured in a city, as all of
/// these constants.
const DIRECTED: f64 = 2.3;
/// The additional time for each target towards which a wavefront is directed, as a part of the time
/// of passing a triangle.
const AIM: f64 = 0.02;
/// The detour that is expected at first: distance divided by Euclidean distance.
const DETOUR: f64 = 1.1;

/// What is known of the ground: how dense triangles are, and how long detours are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expectation {
    /// Triangles per unit of area.
    density: f64,
    detour: f64,
}

impl Expectation {
    /// Creates the expectation for ground with this number of free triangles per unit of area.
    pub(crate) fn new(density: f64) -> Self {
        Self {
            density: if density.is_finite() { density } else { 0.0 },
            detour: DETOUR,
        }
    }

    /// Keeps the detour, but expects triangles as dense as `other` does.
    pub(crate) fn with_density_of(self, other: Self) -> Self {
        Self {
            density: other.density,
            ..self
        }
    }

    /// Learns from a distance and the Euclidean distance of the same points.
    pub(super) fn learn(&mut self, length: f64, straight: f64) {
        let detour = length / straight;
        if detour.is_finite() {
            self.detour += (detour.clamp(1.001, 100.0) - self.detour) / 32.0;
        }
    }

    /// Returns the expected work of a wavefront from a point until it has found `count` targets in
    /// a disc.
    ///
    /// A directed wavefront passes the triangles near a path to each target that is not longer than
    /// the one to the farthest target. So it passes an ellipse, and what is between the ellipses of
    /// different targets.
    pub(super) fn of(&self, from: Point, disc: Disc, count: usize) -> Work {
        let straight = distance(from, disc.centre);
        let farthest = straight + disc.radius;
        let width = (self.detour * self.detour - 1.0).sqrt();
        let ellipse = PI / 4.0 * self.detour * width * farthest * farthest;
        let reach = self.detour * farthest;
        let disc_area = PI * reach * reach;
        let along = 2.0 * farthest * self.density.sqrt();
        let directed = (ellipse + disc.radius * farthest).min(disc_area) * self.density + along;
        let directed = DIRECTED * directed * (1.0 + AIM * count as f64);
        let undirected = passes(disc_area * self.density) + along;
        Work {
            triangles: START + directed.min(undirected),
            is_directed: directed < undirected,
        }
    }
}

/// Returns how many triangles an undirected wavefront is expected to pass if it comes to this many
/// different ones.
pub(crate) fn passes(triangles: f64) -> f64 {
    triangles * (1.6 * (triangles / 200.0).powf(0.3)).clamp(1.0, 5.5)
}

/// The expected work of a wavefront.
#[derive(Clone, Copy, Debug)]
pub(super) struct Work {
    /// In triangles passed without a direction.
    pub(super) triangles: f64,
    /// Whether it is better to direct the wavefront towards its targets.
    pub(super) is_directed: bool,
}

/// A disc that contains targets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disc {
    pub(super) centre: Point,
    pub(super) radius: f64,
}
