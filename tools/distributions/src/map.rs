//! Maps for proximity queries: obstacles that do not touch, and sites on the free ground.
//!
//! The input is a kind, a number of obstacles and a seed. The output is polygons and points.
//! Each obstacle has a square lot of its own and stays within the circle inscribed in it, so
//! obstacles are disjoint. Streets run between blocks of lots. A lot is a function of the seed and
//! its number, and so is a site: nothing is kept in memory.

use crate::degenerate::ceil_sqrt;
use crate::random::{cos_sin, mix, unit_of};

/// A kind of [`Map`]. Lengths are in metres; coordinates are multiples of 0.01.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MapKind {
    /// Buildings: rotated rectangles of 6 to 19 by 5 to 12, one on each lot of 24, in blocks of 10
    /// by 4 lots with streets 14 wide between them.
    City,
    /// Parks: star-shaped polygons with 6 to 20 corners, 8 to 48 from the middle to the farthest
    /// possible corner, one on each lot of 100.
    Parks,
}

/// How the lots of a map are arranged.
struct Plan {
    /// The side of a lot.
    lot: f64,
    /// The numbers of lots in a block, and the width of the streets between blocks.
    block: [u64; 2],
    street: f64,
}

impl MapKind {
    /// All kinds.
    pub const ALL: [Self; 2] = [Self::City, Self::Parks];

    /// Returns the name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::City => "city",
            Self::Parks => "parks",
        }
    }

    /// Returns a short description for a list of kinds.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::City => "buildings and sites: obstacles as .geojson, sites as .sites.csv",
            Self::Parks => "parks of a dozen corners and sites, in the same files",
        }
    }

    fn plan(self) -> Plan {
        match self {
            Self::City => Plan {
                lot: 24.0,
                block: [10, 4],
                street: 14.0,
            },
            Self::Parks => Plan {
                lot: 100.0,
                block: [1, 1],
                street: 0.0,
            },
        }
    }
}

/// A map: `n` polygons that do not touch each other, and any number of sites outside them.
///
/// ```
/// use distributions::{Map, MapKind};
///
/// let city = Map::new(MapKind::City, 100, 7);
/// assert_eq!(city.obstacles().count(), 100);
/// assert!(city.obstacles().all(|building| building.len() == 4));
/// assert_eq!(city.sites(250).count(), 250);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Map {
    kind: MapKind,
    n: u64,
    seed: u64,
}

impl Map {
    /// Creates a map with `n` obstacles.
    #[must_use]
    pub fn new(kind: MapKind, n: u64, seed: u64) -> Self {
        Self { kind, n, seed }
    }

    /// Returns the obstacles: the corners of each, counter-clockwise, the first one not repeated.
    pub fn obstacles(self) -> impl Iterator<Item = Vec<[f64; 2]>> {
        (0..self.n).map(move |lot| self.obstacle(lot))
    }

    /// Returns `count` sites in the streets and on the free parts of the lots. There are none if
    /// there are no obstacles.
    pub fn sites(self, count: u64) -> impl Iterator<Item = [f64; 2]> {
        let count = if self.n == 0 { 0 } else { count };
        (0..count).map(move |number| self.site(number))
    }

    /// Returns the lower left corner of a lot, and the width and height of it with the streets on
    /// its right and above it.
    fn place(self, lot: u64) -> [[f64; 2]; 2] {
        let plan = self.kind.plan();
        let columns = ceil_sqrt(self.n).max(1);
        let at = [lot % columns, lot / columns];
        let corner = [0, 1].map(|i| at[i] as f64 * plan.lot + (at[i] / plan.block[i]) as f64 * plan.street);
        let is_last = [0, 1].map(|i| at[i] % plan.block[i] == plan.block[i] - 1);
        [
            corner,
            is_last.map(|is_last| if is_last { plan.lot + plan.street } else { plan.lot }),
        ]
    }

    fn obstacle(self, lot: u64) -> Vec<[f64; 2]> {
        let mut random = Numbers::new(self.seed, 2 * lot);
        let corners = match self.kind {
            MapKind::City => building(&mut random),
            MapKind::Parks => park(&mut random),
        };
        let radius = corners.iter().map(|[x, y]| (x * x + y * y).sqrt()).fold(0.0, f64::max);
        // The middle moves within a square in which the circle stays in the lot. Rounding moves a
        // corner by less than 0.01.
        let half_lot = self.kind.plan().lot / 2.0;
        let slack = half_lot - radius - 0.02;
        let [corner, _] = self.place(lot);
        let middle = corner.map(|x| x + half_lot + slack * (2.0 * random.unit() - 1.0));
        let corners = corners
            .iter()
            .map(|[x, y]| [middle[0] + x, middle[1] + y].map(hundredths));
        corners.collect()
    }

    fn site(self, number: u64) -> [f64; 2] {
        let mut random = Numbers::new(self.seed, 2 * number + 1);
        loop {
            let lot = random.below(self.n);
            let [corner, size] = self.place(lot);
            let point = [0, 1].map(|i| hundredths(corner[i] + size[i] * random.unit()));
            if !contains(&self.obstacle(lot), point) {
                return point;
            }
        }
    }
}

/// Returns the corners of a building round its middle.
fn building(random: &mut Numbers) -> Vec<[f64; 2]> {
    let half = [3.0 + 6.5 * random.unit(), 2.5 + 3.5 * random.unit()];
    let [cos, sin] = cos_sin(random.unit());
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let turned = corners.map(|[x, y]| {
        let [x, y] = [x * half[0], y * half[1]];
        [cos * x - sin * y, sin * x + cos * y]
    });
    turned.to_vec()
}

/// Returns the corners of a park round its middle, in ascending order of their angle.
fn park(random: &mut Numbers) -> Vec<[f64; 2]> {
    let count = 6 + random.below(15);
    let size = random.unit();
    let radius = 8.0 + 40.0 * size * size;
    let corners = (0..count).map(|corner| {
        let turns = (corner as f64 + 0.1 + 0.8 * random.unit()) / count as f64;
        let length = radius * (0.35 + 0.65 * random.unit());
        cos_sin(turns).map(|x| length * x)
    });
    corners.collect()
}

/// Rounds to the double that is nearest to a multiple of 0.01, so that it is written shortly.
fn hundredths(x: f64) -> f64 {
    (x * 100.0).round() / 100.0
}

/// Returns whether a polygon contains a point, by the parity of the edges that a ray to the right
/// crosses.
fn contains(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let ends = corners.iter().zip(corners.iter().cycle().skip(1));
    let crossed =
        ends.filter(|&(&[ax, ay], &[bx, by])| (ay > y) != (by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax));
    crossed.count() % 2 == 1
}

/// The random numbers of one obstacle or site.
struct Numbers {
    key: u64,
    drawn: u64,
}

impl Numbers {
    fn new(seed: u64, number: u64) -> Self {
        let key = mix(mix(seed ^ 0x6a09_e667_f3bc_c908).wrapping_add(number));
        Self { key, drawn: 0 }
    }

    fn bits(&mut self) -> u64 {
        self.drawn += 1;
        mix(self.key.wrapping_add(self.drawn.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }

    /// Returns a number in [0, 1).
    fn unit(&mut self) -> f64 {
        unit_of(self.bits())
    }

    /// Returns an integer in [0, n).
    fn below(&mut self, n: u64) -> u64 {
        ((u128::from(self.bits()) * u128::from(n)) >> 64) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn obstacles_stay_on_their_lots_and_turn_left() {
        for kind in MapKind::ALL {
            let map = Map::new(kind, 2000, 5);
            let lot = kind.plan().lot;
            for (number, corners) in map.obstacles().enumerate() {
                let [corner, _] = map.place(number as u64);
                let is_inside = |p: &[f64; 2]| (0..2).all(|i| corner[i] < p[i] && p[i] < corner[i] + lot);
                assert!(corners.iter().all(is_inside), "{kind:?} {number}");
                let ends = corners.iter().zip(corners.iter().cycle().skip(1));
                let doubled: f64 = ends.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
                assert!(doubled > 0.0, "{kind:?} {number}");
            }
        }
    }

    #[test]
    fn sites_are_on_free_ground() {
        for kind in MapKind::ALL {
            let map = Map::new(kind, 200, 5);
            let obstacles: Vec<_> = map.obstacles().collect();
            let sites: Vec<_> = map.sites(1000).collect();
            assert_eq!(sites.len(), 1000);
            for site in sites {
                assert!(!obstacles.iter().any(|corners| contains(corners, site)), "{kind:?}");
            }
        }
        assert_eq!(Map::new(MapKind::City, 0, 1).sites(10).count(), 0);
    }
}
