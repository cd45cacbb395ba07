//! A sweep over edges that meet at their ends only.

use std::cmp::Ordering;

use super::edge::Edge;
use crate::geometry::{Orientation, orient2d};

/// What is on the right side of an edge, which is its lower side.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Below {
    /// The next edge below, where this one begins.
    pub(super) edge: Option<usize>,
    /// The winding number there.
    pub(super) winding: i32,
}

/// Returns what is below each edge. The edges are sorted by their lower ends.
///
/// A line moves from left to right over the edges and keeps those that it crosses, from below.
/// Shamos and Hoey, "Geometric intersection problems", 1976.
pub(super) fn sweep(edges: &[Edge]) -> Vec<Below> {
    let mut found = vec![Below::default(); edges.len()];
    let mut ends: Vec<usize> = (0..edges.len()).collect();
    ends.sort_unstable_by(|&a, &b| edges[a].high.lex_cmp(edges[b].high));
    let mut ends = ends.into_iter().map(|edge| edges[edge].high).peekable();
    let mut line: Vec<usize> = Vec::new();
    let mut next = 0;
    loop {
        let starting = edges.get(next).map(|edge| edge.low);
        let ending = ends.peek().copied();
        let Some(at) = (match (starting, ending) {
            (Some(a), Some(b)) if a.lex_cmp(b).is_lt() => Some(a),
            (_, Some(b)) => Some(b),
            (a, None) => a,
        }) else {
            return found;
        };
        while ends.next_if(|end| *end == at).is_some() {}
        let count = edges[next..].iter().take_while(|edge| edge.low == at).count();
        let mut started: Vec<usize> = (next..next + count).collect();
        next += count;
        started.sort_unstable_by(|&a, &b| match orient2d(at, edges[a].high, edges[b].high) {
            Orientation::CounterClockwise => Ordering::Less,
            Orientation::Clockwise => Ordering::Greater,
            Orientation::Collinear => Ordering::Equal,
        });
        let is_below = |&edge: &usize| orient2d(edges[edge].low, edges[edge].high, at) == Orientation::CounterClockwise;
        let place = line.partition_point(is_below);
        let ended = line[place..].iter().take_while(|&&edge| edges[edge].high == at).count();
        let mut below = Below::default();
        if let Some(&edge) = line[..place].last() {
            let winding = found[edge].winding + edges[edge].change;
            below = Below {
                edge: Some(edge),
                winding,
            };
        }
        for &edge in &started {
            found[edge] = below;
            below = Below {
                edge: Some(edge),
                winding: below.winding + edges[edge].change,
            };
        }
        line.splice(place..place + ended, started);
    }
}
