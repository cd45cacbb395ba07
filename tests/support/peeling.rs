//! What is peeled off from the hull, by a flood over all triangles in memory.

use std::collections::HashMap;

use delaunay_tiles::geometry::Point;

fn length(p: Point, q: Point) -> f64 {
    (p.x - q.x).hypot(p.y - q.y)
}

fn position(p: Point) -> [u64; 2] {
    [p.x, p.y].map(f64::to_bits)
}

/// Returns which of all triangles of a triangulation are peeled, because of an edge longer than `most`.
pub fn peeled(triangles: &[[Point; 3]], most: f64) -> Vec<bool> {
    let edges = |triangle: usize| {
        let corners = triangles[triangle];
        (0..3).map(move |i| {
            let mut ends = [corners[i], corners[(i + 1) % 3]].map(position);
            ends.sort_unstable();
            ends
        })
    };
    let mut at_edge: HashMap<[[u64; 2]; 2], Vec<usize>> = HashMap::new();
    for triangle in 0..triangles.len() {
        edges(triangle).for_each(|edge| at_edge.entry(edge).or_default().push(triangle));
    }
    let is_long = |triangle: usize| {
        let [a, b, c] = triangles[triangle];
        length(a, b).max(length(b, c)).max(length(c, a)) > most
    };
    let hull = at_edge.values().filter(|at| at.len() == 1).map(|at| at[0]);
    let mut waiting: Vec<usize> = hull.collect();
    let mut peeled = vec![false; triangles.len()];
    while let Some(triangle) = waiting.pop() {
        if is_long(triangle) && !std::mem::replace(&mut peeled[triangle], true) {
            waiting.extend(edges(triangle).flat_map(|edge| at_edge[&edge].iter().copied()));
        }
    }
    peeled
}
