//! A way over edges, pulled taut among the obstacles.
//!
//! In: the vertices of a way along edges, each in its sector. Out: a way that is not longer, and bends, as a rule, only where it is in
//! the way of something. The triangles along the way make a *sleeve*, through which the [funnel](funnel) finds the shortest way. Where that bends round a
//! vertex with nothing behind it, the sleeve is led round the vertex on the other side (as edges of a path are flipped by Sharp
//! and Crane, "You can find geodesic paths in triangle meshes by just flipping edges", 2020), and so on, for some rounds.
//!
//! The sleeve only goes over edges that nothing blocks, within one sector of each vertex, so nothing leaks. What is walked outside the
//! hull, along its edges, stays as it is.

mod funnel;
mod sleeve;

use super::QueryError;
use super::edges::Node;
use super::route::WayPoint;
use super::tiles::Tiles;
use super::wave::distance;
use crate::geometry::{Orientation, orient2d};
use funnel::{pull, reduced};
use sleeve::Piece;

/// How often sleeves are led round vertices. The way may be a little longer than need be where that does not suffice.
const ROUNDS: usize = 32;

/// Lengths that differ by less than this part may be equal but for rounding.
const TIE: f64 = 1.0 + 1e-12;

/// Pulls a way along edges taut.
///
/// # Errors
/// If a tile cannot be read, tiles contradict each other, or time is over.
pub(super) async fn taut(tiles: &mut Tiles, way: &[Node]) -> Result<Vec<WayPoint>, QueryError> {
    let mut taut: Vec<WayPoint> = Vec::new();
    for piece in sleeve::pieces(tiles, way).await? {
        let piece = taut_piece(tiles, piece).await?;
        // Each begins where the last one ended.
        let begin = usize::from(!taut.is_empty());
        taut.extend_from_slice(&piece[begin..]);
    }
    Ok(taut)
}

async fn taut_piece(tiles: &mut Tiles, mut piece: Piece) -> Result<Vec<WayPoint>, QueryError> {
    piece.portals = reduced(piece.portals);
    let mut best = pull(piece.from, &piece.portals, piece.to);
    for _ in 0..ROUNDS {
        tokio::task::yield_now().await;
        tiles.check_time()?;
        let mut behind = 0;
        let mut is_changed = false;
        for around in best.windows(3) {
            let Some(vertex) = around[1].1 else { continue };
            let turns_left = orient2d(around[0].0, around[1].0, around[2].0) == Orientation::CounterClockwise;
            if let Some(end) = piece.flip(tiles, vertex, turns_left, behind).await? {
                (behind, is_changed) = (end, true);
            }
        }
        if !is_changed {
            break;
        }
        piece.portals = reduced(std::mem::take(&mut piece.portals));
        let way = pull(piece.from, &piece.portals, piece.to);
        // It is shorter, or as long but for rounding.
        if length(&way) > length(&best) * TIE {
            break;
        }
        best = way;
    }
    Ok(best)
}

/// The length of a way.
pub(super) fn length(way: &[WayPoint]) -> f64 {
    way.windows(2).map(|leg| distance(leg[0].0, leg[1].0)).sum()
}
