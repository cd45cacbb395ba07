//! The shortest path within a sleeve of triangles: the funnel algorithm (Lee and Preparata,
//! "Euclidean shortest paths in the presence of rectilinear barriers", Networks 14, 1984; Chazelle
//! 1982).
//!
//! The input is the start and the end of the path, and the edges that it crosses in between, its
//! *portals*. The output is the vertices at which it bends. All turns are turns of input points, so
//! they are exact.
//!
//! ```text
//!           l1 ──── l2    The funnel from apex a to portal l2–r2. The left chain a l1 l2 turns
//!          ╱  ╲    ╱ │    left only, the right chain a r2 turns right only. A point beyond the
//!         a    ╲  ╱  │    other chain moves the apex along that chain.
//!          ╲────r1───r2
//! ```

use crate::geometry::Orientation::{Clockwise, CounterClockwise};
use crate::geometry::{Orientation, orient2d};
use crate::query::answer::WayPoint;

/// An edge that a path crosses, with its ends as seen on the right and on the left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Portal {
    pub(crate) right: WayPoint,
    pub(crate) left: WayPoint,
}

/// The funnel to the last portal: two chains that both start at the apex, and the path up to there.
struct Funnel {
    chains: [Vec<WayPoint>; 2],
    way: Vec<WayPoint>,
}

/// The indices of the chains, and the direction in which each turns.
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
                // The point is beyond the first leg of the other chain.
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

/// Returns the shortest path from `from` to `to` through portals.
pub(crate) fn shortest_through(from: WayPoint, portals: &[Portal], to: WayPoint) -> Vec<WayPoint> {
    let touches = |portal: &Portal, point: WayPoint| portal.right.0 == point.0 || portal.left.0 == point.0;
    // A portal with an end at the point itself need not be crossed.
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

/// Returns the portals without pairs that are crossed back and forth.
pub(crate) fn without_detours(portals: Vec<Portal>) -> Vec<Portal> {
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
        let way = shortest_through(from, &portals, to).into_iter();
        way.map(|(point, _)| (point.x, point.y)).collect()
    }

    #[test]
    fn shortest_paths_bend_at_the_ends_of_portals() {
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
        // Round a vertex by more than a half-turn, where each portal is an edge at it.
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
    fn portals_crossed_back_and_forth_are_removed() {
        let portal = |a, b| Portal { right: a, left: b };
        let [a, b, c] = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)];
        assert_eq!(
            without_detours(vec![portal(a, b), portal(c, b), portal(b, c), portal(b, a)]),
            []
        );
        assert_eq!(without_detours(vec![portal(a, b), portal(c, b)]).len(), 2);
    }
}
