//! The union of polygons.
//!
//! The edges of all outlines are snapped to a grid ([`snap`]), on which they meet at their ends
//! only. A sweep ([`sweep`]) finds the winding numbers beside each edge. An edge is part of
//! the union's boundary if the winding number is positive on one side only.

mod buckets;
mod edge;
mod segment;
mod snap;
mod sweep;
#[cfg(test)]
mod tests;

use std::iter;

use super::polygon::AreaPolygon;
use super::rings::{is_clockwise, rings_of, straightened};
use crate::geometry::Point;
use edge::Edge;
use snap::{snap, step_for};
use sweep::sweep;

/// The number of rings, or of unions of them, that are united at once where many overlap.
const AT_ONCE: usize = 8;

/// Returns the union of rings, with the winding number rule "positive", without `holes`. The holes
/// lie in the union and meet the boundary of the union nowhere. Many of the rings in `piled` may
/// overlap at the same place.
///
/// Points that are at most `slack` away from straight lines are removed.
pub(super) fn united(
    mut rings: Vec<Vec<Point>>,
    piled: Vec<Vec<Point>>,
    holes: Vec<Vec<Point>>,
    slack: f64,
) -> Vec<AreaPolygon> {
    let step = step_for(rings.iter().chain(&piled).map(Vec::as_slice));
    rings.extend(united_in_groups(piled, step));
    let unions = boundary(&rings, step);
    // Without these points, lines may touch.
    let straight: Vec<_> = unions.iter().map(|ring| straightened(ring, slack)).collect();
    polygons(boundary(&straight, step), holes)
}

/// Returns the boundary of the union of rings.
fn boundary(rings: &[Vec<Point>], step: f64) -> Vec<Vec<Point>> {
    let edges = snap(rings.iter().map(Vec::as_slice), step);
    let below = sweep(&edges);
    let directed = edges.iter().zip(below).filter_map(|(edge, below)| {
        match [below.winding, below.winding + edge.change].map(|winding| winding > 0) {
            [false, true] => Some([edge.low, edge.high]),
            [true, false] => Some([edge.high, edge.low]),
            _ => None,
        }
    });
    rings_of(directed.collect())
}

/// Returns the boundary of the union of rings: unites some at a time, then some of these unions, and
/// so on. If all rings cross each other, all of them at once have a crossing for each pair, and the
/// unions have few.
fn united_in_groups(rings: Vec<Vec<Point>>, step: f64) -> Vec<Vec<Point>> {
    let mut unions: Vec<Vec<Vec<Point>>> = rings.into_iter().map(|ring| vec![ring]).collect();
    while unions.len() > 1 {
        let groups = unions.chunks(AT_ONCE);
        unions = groups.map(|group| boundary(&group.concat(), step)).collect();
    }
    unions.pop().unwrap_or_default()
}

/// Returns the polygons of a boundary and of further holes in them.
fn polygons(rings: Vec<Vec<Point>>, mut holes: Vec<Vec<Point>>) -> Vec<AreaPolygon> {
    let (inner, outer): (Vec<_>, Vec<_>) = rings.into_iter().partition(|ring| is_clockwise(ring));
    holes.extend(inner);
    let around = if outer.len() > 1 {
        around(&outer, &holes)
    } else {
        vec![0; holes.len()]
    };
    let whole = |outline| AreaPolygon {
        outline,
        holes: Vec::new(),
    };
    let mut polygons: Vec<_> = outer.into_iter().map(whole).collect();
    for (hole, around) in holes.into_iter().zip(around) {
        if let Some(polygon) = polygons.get_mut(around) {
            polygon.holes.push(hole);
        }
    }
    polygons
}

/// Returns the outline around each hole.
fn around(outlines: &[Vec<Point>], holes: &[Vec<Point>]) -> Vec<usize> {
    let mut edges: Vec<(Edge, usize)> = Vec::new();
    for (number, ring) in outlines.iter().chain(holes).enumerate() {
        let next = ring.iter().cycle().skip(1);
        edges.extend(ring.iter().zip(next).map(|(&from, &to)| (Edge::of(from, to), number)));
    }
    edges.sort_unstable_by(|(a, _), (b, _)| a.cmp(b));
    let (edges, rings): (Vec<Edge>, Vec<usize>) = edges.into_iter().unzip();
    // The ring below the least corner of each ring. The area is below the lower edge of a hole there,
    // and that is the first of its edges that go to the left.
    let mut below = vec![None; outlines.len() + holes.len()];
    for ((edge, next), &ring) in edges.iter().zip(sweep(&edges)).zip(&rings) {
        if edge.change < 0 && below[ring].is_none() {
            below[ring] = next.edge.map(|edge| rings[edge]);
        }
    }
    let outline = |hole: usize| {
        let mut rings = iter::successors(Some(outlines.len() + hole), |&ring| below[ring]);
        rings.find(|&ring| ring < outlines.len()).unwrap_or(0)
    };
    (0..holes.len()).map(outline).collect()
}
