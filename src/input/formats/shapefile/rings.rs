//! The rings of a record, sorted into polygons.
//!
//! A record has the rings of all its polygons in any order; outer rings go clockwise, holes
//! counter-clockwise. A hole belongs to the smallest outer ring around it. A hole that is in no
//! outer ring counts as one, whatever its direction, as does a ring without area.

use crate::geometry::{Orientation, Point, area_sign, orient2d};
use std::cmp::Ordering;

/// The limit on the number of comparisons of a hole with an outer ring and its edges.
const MOST_STEPS: u64 = 1 << 30;

/// The number of comparisons so far, and its limit.
struct Steps {
    taken: u64,
    most: u64,
}

/// An outer ring, and the holes in it.
struct Outer {
    ring: usize,
    bounds: Bounds,
    holes: Vec<usize>,
}

#[derive(Clone, Copy)]
struct Bounds {
    min: [f64; 2],
    max: [f64; 2],
}

/// The rings of a record, sorted.
#[derive(Debug, PartialEq, Eq)]
pub struct Sorted {
    /// The numbers of the rings of each polygon, the outer one first, in the order of the outer
    /// rings.
    pub polygons: Vec<Vec<usize>>,
    /// The number of holes that are in no outer ring.
    pub lone_holes: u64,
}

/// Sorts the rings of a record into polygons.
pub fn sort_rings(rings: &[Vec<[f64; 3]>]) -> Result<Sorted, String> {
    let is_valid = |&[x, y, _]: &[f64; 3]| Point::new(x, y).is_valid();
    if rings.len() < 2 || !rings.iter().flatten().all(is_valid) {
        // An invalid position is reported when it is read.
        return Ok(Sorted {
            polygons: (0..rings.len()).map(|ring| vec![ring]).collect(),
            lone_holes: 0,
        });
    }
    let is_hole = |ring: &Vec<[f64; 3]>| area_sign(ring.iter().map(point)) == Ordering::Greater;
    let (holes, outers): (Vec<usize>, Vec<usize>) = (0..rings.len()).partition(|&ring| is_hole(&rings[ring]));
    let mut outers: Vec<Outer> = outers.into_iter().map(|ring| Outer::new(ring, &rings[ring])).collect();
    outers.sort_by(|one, other| one.bounds.area().total_cmp(&other.bounds.area()));
    let mut lone = Vec::new();
    let mut steps = Steps {
        taken: 0,
        most: MOST_STEPS,
    };
    for hole in holes {
        match find_outer(&rings[hole], &outers, rings, &mut steps)? {
            Some(outer) => outers[outer].holes.push(hole),
            None => lone.push(Outer::new(hole, &rings[hole])),
        }
    }
    let lone_holes = lone.len() as u64;
    outers.append(&mut lone);
    outers.sort_by_key(|outer| outer.ring);
    let rings = |outer: Outer| std::iter::once(outer.ring).chain(outer.holes).collect();
    Ok(Sorted {
        polygons: outers.into_iter().map(rings).collect(),
        lone_holes,
    })
}

/// Returns which of the outer rings, the smallest first, is the smallest around a hole.
fn find_outer(
    hole: &[[f64; 3]],
    outers: &[Outer],
    rings: &[Vec<[f64; 3]>],
    steps: &mut Steps,
) -> Result<Option<usize>, String> {
    if let [_] = outers {
        return Ok(Some(0));
    }
    let bounds = Bounds::of(hole);
    let mut touching = None;
    for (number, outer) in outers.iter().enumerate() {
        steps.taken += 1;
        if !outer.bounds.contains(bounds) {
            continue;
        }
        match side(hole, &rings[outer.ring], steps) {
            Some(true) => return Ok(Some(number)),
            Some(false) => {}
            None => touching = touching.or(Some(number)),
        }
        if steps.is_over() {
            return Err(format!(
                "its {} rings overlap too often to tell which holes belong to which outer rings; split it into polygons",
                rings.len()
            ));
        }
    }
    Ok(touching)
}

/// Returns whether the first vertex of a hole that is not on a ring is inside of it; `None` if all
/// are on it, or if there are too many steps.
fn side(hole: &[[f64; 3]], ring: &[[f64; 3]], steps: &mut Steps) -> Option<bool> {
    for vertex in hole.iter().map(point) {
        steps.taken += ring.len() as u64;
        let is_inside = is_inside(vertex, ring);
        if is_inside.is_some() || steps.is_over() {
            return is_inside;
        }
    }
    None
}

/// Returns whether a point is inside of a ring; `None` if it is on the ring. The ring may be closed
/// or not.
fn is_inside(p: Point, ring: &[[f64; 3]]) -> Option<bool> {
    let mut is_inside = false;
    let mut from = point(ring.last()?);
    for to in ring.iter().map(point) {
        let (low, high) = if from.y <= to.y { (from, to) } else { (to, from) };
        if p.y >= low.y && p.y <= high.y {
            let side = orient2d(low, high, p);
            let is_between = p.x >= low.x.min(high.x) && p.x <= low.x.max(high.x);
            if side == Orientation::Collinear && is_between {
                return None;
            }
            // Of the two ends, only the lower one counts.
            is_inside ^= p.y < high.y && side == Orientation::CounterClockwise;
        }
        from = to;
    }
    Some(is_inside)
}

fn point(&[x, y, _]: &[f64; 3]) -> Point {
    Point::new(x, y).normalized()
}

impl Steps {
    fn is_over(&self) -> bool {
        self.taken > self.most
    }
}

impl Outer {
    fn new(ring: usize, positions: &[[f64; 3]]) -> Self {
        Self {
            ring,
            bounds: Bounds::of(positions),
            holes: Vec::new(),
        }
    }
}

impl Bounds {
    fn of(ring: &[[f64; 3]]) -> Self {
        let empty = Self {
            min: [f64::INFINITY; 2],
            max: [f64::NEG_INFINITY; 2],
        };
        ring.iter().fold(empty, |bounds, &[x, y, _]| Self {
            min: [bounds.min[0].min(x), bounds.min[1].min(y)],
            max: [bounds.max[0].max(x), bounds.max[1].max(y)],
        })
    }

    fn area(self) -> f64 {
        (self.max[0] - self.min[0]) * (self.max[1] - self.min[1])
    }

    fn contains(self, other: Self) -> bool {
        (0..2).all(|axis| self.min[axis] <= other.min[axis] && other.max[axis] <= self.max[axis])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square with its lower left corner at `corner`: clockwise, or counter-clockwise as a hole.
    fn square(corner: f64, side: f64, is_hole: bool) -> Vec<[f64; 3]> {
        let (low, high) = (corner, corner + side);
        let mut ring = vec![[low, low], [low, high], [high, high], [high, low], [low, low]];
        if is_hole {
            ring.reverse();
        }
        ring.into_iter().map(|[x, y]| [x, y, 0.0]).collect()
    }

    fn sorted(polygons: &[&[usize]], lone_holes: u64) -> Result<Sorted, String> {
        Ok(Sorted {
            polygons: polygons.iter().map(|rings| rings.to_vec()).collect(),
            lone_holes,
        })
    }

    #[test]
    fn holes_belong_to_the_smallest_outer_ring_around_them() {
        let rings = [
            square(4.0, 1.0, true),
            square(0.0, 20.0, false),
            square(1.0, 10.0, true),
            square(2.0, 6.0, false),
            square(30.0, 2.0, false),
            square(30.5, 0.5, true),
        ];
        assert_eq!(sort_rings(&rings), sorted(&[&[1, 2], &[3, 0], &[4, 5]], 0));
    }

    #[test]
    fn a_hole_that_touches_its_outer_ring_belongs_to_it() {
        let diamond = [[5.0, 0.0], [10.0, 5.0], [5.0, 10.0], [0.0, 5.0], [5.0, 0.0]];
        let diamond = diamond.map(|[x, y]| [x, y, 0.0]).to_vec();
        let rings = [diamond, square(0.0, 10.0, false), square(20.0, 10.0, false)];
        assert_eq!(sort_rings(&rings), sorted(&[&[1, 0], &[2]], 0));
    }

    #[test]
    fn a_hole_in_no_outer_ring_is_a_polygon() {
        let rings = [
            square(0.0, 10.0, true),
            square(20.0, 1.0, false),
            square(40.0, 1.0, false),
        ];
        assert_eq!(sort_rings(&rings), sorted(&[&[0], &[1], &[2]], 1));
        let holes = [square(0.0, 10.0, true), square(20.0, 1.0, true)];
        assert_eq!(sort_rings(&holes), sorted(&[&[0], &[1]], 2));
    }

    /// Each vertex of the hole would be compared with all edges of the ring that it is on.
    #[test]
    fn a_long_hole_on_a_long_ring_takes_a_bounded_number_of_steps() {
        let ring: Vec<[f64; 3]> = (0..1000).map(|i| [f64::from(i), 0.0, 0.0]).collect();
        let mut steps = Steps { taken: 0, most: 20_000 };
        assert_eq!(side(&ring, &ring, &mut steps), None);
        assert_eq!(steps.taken, 21_000);
        assert!(steps.is_over());
    }
}
