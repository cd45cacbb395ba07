//! Independent points: the thesis's distributions, clusters, duplicates.

use crate::random::{Purpose, Stream, cos_sin, mix, point_of};
use crate::source::Source;

/// [`Kind::Uniform`](crate::Kind::Uniform).
#[derive(Clone, Debug)]
pub(crate) struct Uniform(Stream);

impl Uniform {
    pub(crate) fn new(seed: u64) -> Self {
        Uniform(Stream::new(seed, Purpose::Points))
    }
}

impl Source for Uniform {
    #[inline]
    fn next(&mut self) -> [f64; 2] {
        let x = self.0.unit();
        [x, self.0.unit()]
    }
}

/// [`Kind::Kuzmin`](crate::Kind::Kuzmin).
#[derive(Clone, Debug)]
pub(crate) struct Kuzmin(Stream);

impl Kuzmin {
    pub(crate) fn new(seed: u64) -> Self {
        Kuzmin(Stream::new(seed, Purpose::Points))
    }
}

impl Source for Kuzmin {
    #[inline]
    fn next(&mut self) -> [f64; 2] {
        let mass = self.0.unit();
        kuzmin(mass, self.0.unit())
    }
}

/// Returns the point at the radius that encloses the part `mass` of the mass, at an angle in turns.
#[inline]
pub(crate) fn kuzmin(mass: f64, turns: f64) -> [f64; 2] {
    let r = kuzmin_radius(mass);
    let [cos, sin] = cos_sin(turns);
    [r * cos, r * sin]
}

/// Returns the radius r with M(r) = 1 - 1/√(1 + r²) = `mass` < 1, that is √(1/(1 - mass)² - 1),
/// without cancellation.
#[inline]
pub(crate) fn kuzmin_radius(mass: f64) -> f64 {
    (mass * (2.0 - mass)).sqrt() / (1.0 - mass)
}

/// [`Kind::LineSingularity`](crate::Kind::LineSingularity).
#[derive(Clone, Debug)]
pub(crate) struct LineSingularity(Uniform);

impl LineSingularity {
    pub(crate) fn new(seed: u64) -> Self {
        LineSingularity(Uniform::new(seed))
    }
}

impl Source for LineSingularity {
    #[inline]
    fn next(&mut self) -> [f64; 2] {
        line_singularity(self.0.next())
    }
}

/// Maps the unit square to itself as in the thesis, b = 0.01. x decreases strictly with u: from 1
/// at u = 0 to b at u = 1.
#[inline]
pub(crate) fn line_singularity([u, v]: [f64; 2]) -> [f64; 2] {
    const B: f64 = 0.01;
    [B / (u - B * u + B), v]
}

/// [`Kind::Clusters`](crate::Kind::Clusters): a walk down a tree of clusters, to a random depth.
#[derive(Clone, Debug)]
pub(crate) struct Clusters {
    stream: Stream,
    root: u64,
}

impl Clusters {
    pub(crate) fn new(seed: u64) -> Self {
        Clusters {
            stream: Stream::new(seed, Purpose::Points),
            root: mix(seed),
        }
    }
}

impl Source for Clusters {
    fn next(&mut self) -> [f64; 2] {
        const LEVELS: u64 = 5;
        let (mut cluster, mut centre, mut size) = (self.root, [0.0; 2], 1.0);
        for _ in 0..1 + self.stream.below(LEVELS) {
            // Squared, so that the first of eight children gets a third of the points and the last
            // a sixteenth.
            let choice = self.stream.unit();
            let child = (choice * choice * 8.0) as u64;
            cluster = mix(cluster.wrapping_mul(8).wrapping_add(child + 1));
            let [x, y] = point_of(cluster);
            centre = [centre[0] + size * (x - 0.5), centre[1] + size * (y - 0.5)];
            size /= 8.0;
        }
        let x = centre[0] + size * self.stream.noise();
        [x, centre[1] + size * self.stream.noise()]
    }
}

/// [`Kind::Duplicates`](crate::Kind::Duplicates).
#[derive(Clone, Debug)]
pub(crate) struct Duplicates {
    stream: Stream,
    key: u64,
    places: u64,
}

impl Duplicates {
    pub(crate) fn new(n: u64, seed: u64) -> Self {
        Duplicates {
            stream: Stream::new(seed, Purpose::Points),
            key: mix(seed),
            places: (n / 8).max(1),
        }
    }
}

impl Source for Duplicates {
    fn next(&mut self) -> [f64; 2] {
        let popular = self.stream.below(16) == 0;
        let number = self.stream.below(if popular { 4 } else { self.places });
        point_of(self.key.wrapping_add(number))
    }
}
