//! Candidates: of neighbours, the vertices that are farthest from a coarser triangulation.

use crate::geometry::{Point, VertexIndex};
use crate::overviews::hash::hash;
use crate::query::OnSurface;
use crate::store::Tile;

/// A vertex of the finer level that may be chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    /// How much it matters: not negative.
    pub(super) weight: f64,
    pub(super) point: Point,
    pub(super) z: f64,
    pub(super) record: u64,
}

/// The weight of vertices that are in the coarser triangulation.
const CHOSEN: f64 = -1.0;

/// Returns the candidates among the vertices of a tile. `found` has the coarser surface at all its
/// corners, and `seed` decides between equal weights.
///
/// A tile has all neighbours of its vertices. So the candidates do not depend on the tiles.
pub(super) fn candidates(tile: &Tile, found: &[OnSurface], seed: u64) -> Vec<Candidate> {
    let corners = (0..tile.corner_count() as u32).map(VertexIndex);
    let weights: Vec<f64> = corners
        .zip(found)
        .map(|(corner, at)| weight(tile, corner, *at))
        .collect();
    let mut is_candidate: Vec<bool> = tile.vertex_indices().map(|v| weights[v.index()] >= 0.0).collect();
    let mut lose = |corner: VertexIndex| {
        if let Some(is_candidate) = is_candidate.get_mut(corner.index()) {
            *is_candidate = false;
        }
    };
    for triangle in tile.triangle_ids() {
        let [a, b, c] = tile.corners(triangle);
        for [p, q] in [[a, b], [b, c], [c, a]] {
            let (of_p, of_q) = (weights[p.index()], weights[q.index()]);
            // A chosen vertex is no candidate, and is no reason why a neighbour should not be one.
            if of_p > of_q {
                lose(q);
            } else if of_p < of_q {
                lose(p);
            } else if of_p >= 0.0 {
                lose(lesser(tile, [p, q], seed));
            }
        }
    }
    let candidates = tile.vertex_indices().filter(|vertex| is_candidate[vertex.index()]);
    let candidate = |vertex: VertexIndex| Candidate {
        weight: weights[vertex.index()],
        point: tile.point(vertex),
        z: tile.z(vertex).unwrap_or(f64::NAN),
        record: tile.record(vertex),
    };
    candidates.map(candidate).collect()
}

/// Returns how much a corner matters: its difference in z, times the fourth root of the area of the
/// triangle that it is in. With equal differences, a vertex in a large triangle improves more of the
/// surface.
fn weight(tile: &Tile, corner: VertexIndex, at: OnSurface) -> f64 {
    match at {
        OnSurface::Vertex(_) => CHOSEN,
        OnSurface::Between { z, area } => {
            let difference = (tile.z(corner).unwrap_or(z) - z).abs();
            // A product of infinity and 0 is no number.
            (difference * area.sqrt().sqrt()).clamp(0.0, f64::MAX).max(0.0)
        }
        OnSurface::Outside => 0.0,
    }
}

/// Returns the one of two corners of equal weight that is no candidate.
fn lesser(tile: &Tile, [p, q]: [VertexIndex; 2], seed: u64) -> VertexIndex {
    let [a, b] = [p, q].map(|corner| tile.point(corner));
    let order = hash(a, seed).cmp(&hash(b, seed)).then_with(|| a.lex_cmp(b));
    if order.is_lt() { p } else { q }
}
