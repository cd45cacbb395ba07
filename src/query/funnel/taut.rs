//! A way over edges, pulled taut.

use super::pull::{pull, reduced};
use super::sleeve::Piece;
use crate::geometry::{Orientation, orient2d};
use crate::query::answer::{WayPoint, distance};
use crate::query::edges::Node;
use crate::query::funnel::sleeve;
use crate::query::request::{QueryError, Tiles};

/// How often sleeves are led round vertices. The way may be a little longer than need be where that does not suffice.
const ROUNDS: usize = 32;

/// Lengths that differ by less than this part may be equal but for rounding.
const TIE: f64 = 1.0 + 1e-12;

/// Pulls a way along edges taut.
///
/// # Errors
/// If a tile cannot be read, tiles contradict each other, or time is over.
pub(crate) async fn taut(tiles: &mut Tiles, way: &[Node]) -> Result<Vec<WayPoint>, QueryError> {
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
pub(crate) fn length(way: &[WayPoint]) -> f64 {
    way.windows(2).map(|leg| distance(leg[0].0, leg[1].0)).sum()
}
