//! Ends of new lines without z take it from the triangulation before the edit.

use crate::constraints::segment::Segment;
use crate::edit::error::EditError;
use crate::edit::target::Target;
use crate::geometry::{MortonSquare, Point, Rect};
use crate::terrain::Surface;

/// Fills in the z of ends that have none, in a file with z. An end at the position of another one
/// that has z stays without. So do ends outside the hull. About `memory` bytes
/// are for tiles.
pub(crate) async fn drape_ends(
    target: &Target,
    segments: &[Segment],
    z: &mut Vec<[f64; 2]>,
    memory: u64,
) -> Result<(), EditError> {
    if segments.is_empty() {
        return Ok(());
    }
    let reader = target.read_within(memory).await?;
    if !reader.metadata().has_z {
        return Ok(());
    }
    z.resize(segments.len(), [f64::NAN; 2]);
    let point = |end: u32| segments[end as usize / 2].ends[end as usize % 2];
    for ends in by_point(segments).chunk_by(|&a, &b| point(a) == point(b)) {
        let has_z = ends.iter().any(|&end| !z[end as usize / 2][end as usize % 2].is_nan());
        let Point { x, y } = point(ends[0]);
        if !has_z && let Some(draped) = reader.surface_z(x, y, Surface::default().holes(true)).await? {
            for &end in ends {
                z[end as usize / 2][end as usize % 2] = draped;
            }
        }
    }
    Ok(())
}

/// Returns the numbers of all ends, sorted along a curve, those at one position together.
fn by_point(segments: &[Segment]) -> Vec<u32> {
    let all = || segments.iter().flat_map(|segment| segment.ends);
    let square = MortonSquare::around(Rect::around(all()));
    let mut ends: Vec<(u64, u32, Point)> = all().zip(0u32..).map(|(p, end)| (square.key(p), end, p)).collect();
    ends.sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| a.2.lex_cmp(b.2)).then_with(|| a.1.cmp(&b.1)));
    ends.into_iter().map(|(_, end, _)| end).collect()
}
