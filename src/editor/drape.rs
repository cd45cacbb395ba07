//! New vertices without z take it from the triangulation before the edit.

use crate::edit::{EditError, Target};
use crate::geometry::{MortonSquare, Point, Rect};
use crate::terrain::Surface;

/// Fills in the z of points that have none, in a file with z. A point at the position of another one
/// that has z stays without. So do points outside the hull. About `memory` bytes are for tiles.
pub(crate) async fn drape(target: &Target, points: &[Point], z: &mut Vec<f64>, memory: u64) -> Result<(), EditError> {
    if points.is_empty() {
        return Ok(());
    }
    let reader = target.read_within(memory).await?;
    if !reader.metadata().has_z {
        return Ok(());
    }
    z.resize(points.len(), f64::NAN);
    let point = |number: u32| points[number as usize];
    for numbers in by_point(points).chunk_by(|&a, &b| point(a) == point(b)) {
        let has_z = numbers.iter().any(|&number| !z[number as usize].is_nan());
        let Point { x, y } = point(numbers[0]);
        if !has_z && let Some(draped) = reader.surface_z(x, y, Surface::default().holes(true)).await? {
            numbers.iter().for_each(|&number| z[number as usize] = draped);
        }
    }
    Ok(())
}

/// Returns the numbers of all points, sorted along a curve, those at one position together.
fn by_point(points: &[Point]) -> Vec<u32> {
    let square = MortonSquare::around(Rect::around(points.iter().copied()));
    let keys = points.iter().zip(0u32..).map(|(&p, number)| (square.key(p), number, p));
    let mut order: Vec<(u64, u32, Point)> = keys.collect();
    order.sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| a.2.lex_cmp(b.2)).then_with(|| a.1.cmp(&b.1)));
    order.into_iter().map(|(_, number, _)| number).collect()
}
