//! The shortest way through a sleeve of triangles: the funnel algorithm (Lee and Preparata, "Euclidean shortest paths in the presence of
//! rectilinear barriers", Networks 14, 1984; Chazelle 1982).
//!
//! In: where the way starts and ends, and the edges that it crosses in between, its *portals*. Out: the vertices at which it bends. All turns are
//! of input points, so they are exact.
//!
//! ```text
//!           l1 ──── l2        the funnel from apex a to portal l2–r2: the left chain a l1 l2 turns left only, the right one a r2
//!          ╱  ╲    ╱ │        right only. A point beyond the other chain moves the apex along that.
//!         a    ╲  ╱  │
//!          ╲────r1───r2
//! ```

use crate::geometry::Orientation::{Clockwise, CounterClockwise};
use crate::geometry::{Orientation, orient2d};
use crate::query::answer::WayPoint;

/// An edge that a way crosses, with its ends as seen on the right and on the left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Portal {
    pub(crate) right: WayPoint,
    pub(crate) left: WayPoint,
}

/// What is seen of the last portal: two chains from the apex on, which comes first in both.
struct Funnel {
    chains: [Vec<WayPoint>; 2],
    way: Vec<WayPoint>,
}

/// The chains' places, and how each turns.
const RIGHT: usize = 0;
const LEFT: usize = 1;
const TURNS: [Orientation; 2] = [Clockwise, CounterClockwise];

impl Funnel {
    /// Narrows the funnel by the next point on one side.
    fn add(&mut self, side: usize, point: WayPoint) {
        let other = 1 - side;
        if self.chains[side].last().is_some_and(|last| last.0 == point.0) {
            return;
        }
        while let [.., before, last] = self.chains[side][..] {
            if orient2d(before.0, last.0, point.0) == TURNS[side] {
                break;
            }
            self.chains[side].pop();
        }
        if let [apex] = self.chains[side][..] {
            let mut apex = apex;
            while let [_, first, ..] = self.chains[other][..] {
                // Beyond the other chain's first leg.
                if orient2d(apex.0, first.0, point.0) != TURNS[other] {
                    break;
                }
                self.way.push(apex);
                self.chains[other].remove(0);
                apex = first;
            }
            self.chains[side][0] = apex;
        }
        if self.chains[side].last().is_none_or(|last| last.0 != point.0) {
            self.chains[side].push(point);
        }
    }
}

/// The shortest way from one point to another through portals.
pub(crate) fn pull(from: WayPoint, portals: &[Portal], to: WayPoint) -> Vec<WayPoint> {
    let touches = |portal: &Portal, point: WayPoint| portal.right.0 == point.0 || portal.left.0 == point.0;
    // Who stands in a portal need not go through it.
    let first = portals.iter().position(|portal| !touches(portal, from));
    let portals = &portals[first.unwrap_or(portals.len())..];
    let last = portals.iter().rposition(|portal| !touches(portal, to));
    let portals = &portals[..last.map_or(0, |last| last + 1)];
    let mut funnel = Funnel {
        chains: [vec![from], vec![from]],
        way: Vec::new(),
    };
    for portal in portals {
        funnel.add(RIGHT, portal.right);
        funnel.add(LEFT, portal.left);
    }
    funnel.add(LEFT, to);
    let [_, left] = funnel.chains;
    funnel.way.extend(left);
    if funnel.way.len() == 1 {
        funnel.way.push(to);
    }
    funnel.way
}

/// Portals without those that are passed there and back.
pub(crate) fn reduced(portals: Vec<Portal>) -> Vec<Portal> {
    let mut kept: Vec<Portal> = Vec::with_capacity(portals.len());
    for portal in portals {
        let is_back = |last: &Portal| last.right.0 == portal.left.0 && last.left.0 == portal.right.0;
        if kept.last().is_some_and(is_back) {
            kept.pop();
        } else {
            kept.push(portal);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    fn at(x: f64, y: f64) -> WayPoint {
        (Point::new(x, y), None)
    }

    fn through(from: WayPoint, portals: &[[(f64, f64); 2]], to: WayPoint) -> Vec<(f64, f64)> {
        let portals: Vec<Portal> = portals
            .iter()
            .map(|&[right, left]| Portal {
                right: at(right.0, right.1),
                left: at(left.0, left.1),
            })
            .collect();
        let way = pull(from, &portals, to).into_iter();
        way.map(|(point, _)| (point.x, point.y)).collect()
    }

    #[test]
    fn ways_through_portals() {
        let (from, to) = (at(0.0, 0.0), at(10.0, 0.0));
        assert_eq!(through(from, &[], to), [(0.0, 0.0), (10.0, 0.0)]);
        assert_eq!(
            through(from, &[[(2.0, -1.0), (2.0, 1.0)], [(4.0, -1.0), (2.0, 1.0)]], to),
            [(0.0, 0.0), (10.0, 0.0)]
        );
        // Over the left end of a wall, and under the right end of the next one.
        assert_eq!(
            through(from, &[[(2.0, 1.0), (2.0, 3.0)], [(6.0, -3.0), (6.0, -1.0)]], to),
            [(0.0, 0.0), (2.0, 1.0), (6.0, -1.0), (10.0, 0.0)]
        );
        // Ends on the line do not bend it.
        assert_eq!(
            through(from, &[[(2.0, 0.0), (2.0, 3.0)], [(6.0, -3.0), (6.0, 0.0)]], to),
            [(0.0, 0.0), (10.0, 0.0)]
        );
        // Round a vertex by more than a half-turn, each portal an edge of it.
        let around = [
            [(0.0, 0.0), (0.0, 4.0)],
            [(0.0, 0.0), (-4.0, 0.0)],
            [(0.0, 0.0), (0.0, -4.0)],
        ];
        assert_eq!(
            through(at(3.0, 1.0), &around.map(|[left, right]| [right, left]), at(3.0, -1.0)),
            [(3.0, 1.0), (0.0, 0.0), (3.0, -1.0)]
        );
    }

    #[test]
    fn what_is_passed_there_and_back_is_not_passed() {
        let portal = |a, b| Portal { right: a, left: b };
        let [a, b, c] = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)];
        assert_eq!(
            reduced(vec![portal(a, b), portal(c, b), portal(b, c), portal(b, a)]),
            []
        );
        assert_eq!(reduced(vec![portal(a, b), portal(c, b)]).len(), 2);
    }
}
