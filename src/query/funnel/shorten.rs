//! Shortens a path along edges, sleeve by sleeve.

use super::portals::{shortest_through, without_detours};
use super::sleeve::Sleeve;
use crate::geometry::{Orientation, orient2d};
use crate::query::answer::{WayPoint, distance};
use crate::query::edges::Node;
use crate::query::funnel::sleeve;
use crate::query::request::{QueryError, Tiles};

/// The maximum number of rounds in which sleeves are moved round vertices. If that does not
/// suffice, the path may be a little longer than necessary.
const ROUNDS: usize = 32;

/// Lengths that differ by less than this factor may be equal except for rounding.
const TIE: f64 = 1.0 + 1e-12;

/// Shortens a path along edges within its sleeves.
///
/// # Errors
/// If a tile cannot be read, tiles contradict each other, or the time limit is reached.
pub(crate) async fn shorten(tiles: &mut Tiles, way: &[Node]) -> Result<Vec<WayPoint>, QueryError> {
    let mut shortened: Vec<WayPoint> = Vec::new();
    for sleeve in sleeve::sleeves(tiles, way).await? {
        let sleeve = shorten_in_sleeve(tiles, sleeve).await?;
        // Each sleeve starts where the last one ended.
        let begin = usize::from(!shortened.is_empty());
        shortened.extend_from_slice(&sleeve[begin..]);
    }
    Ok(shortened)
}

async fn shorten_in_sleeve(tiles: &mut Tiles, mut sleeve: Sleeve) -> Result<Vec<WayPoint>, QueryError> {
    sleeve.portals = without_detours(sleeve.portals);
    let mut best = shortest_through(sleeve.from, &sleeve.portals, sleeve.to);
    for _ in 0..ROUNDS {
        tokio::task::yield_now().await;
        tiles.check_time()?;
        let mut behind = 0;
        let mut is_changed = false;
        for around in best.windows(3) {
            let Some(vertex) = around[1].1 else { continue };
            let turns_left = orient2d(around[0].0, around[1].0, around[2].0) == Orientation::CounterClockwise;
            if let Some(end) = sleeve.flip(tiles, vertex, turns_left, behind).await? {
                (behind, is_changed) = (end, true);
            }
        }
        if !is_changed {
            break;
        }
        sleeve.portals = without_detours(std::mem::take(&mut sleeve.portals));
        let way = shortest_through(sleeve.from, &sleeve.portals, sleeve.to);
        // Without rounding errors, the path is never longer than before.
        if length(&way) > length(&best) * TIE {
            break;
        }
        best = way;
    }
    Ok(best)
}

/// Returns the length of a path.
pub(crate) fn length(way: &[WayPoint]) -> f64 {
    way.windows(2).map(|leg| distance(leg[0].0, leg[1].0)).sum()
}
