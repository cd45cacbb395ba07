//! What becomes constraints, and what goes, of segments.

use crate::constraints::polygons::normalize::PolygonNormalizer;
use crate::constraints::segment::Segment;
use crate::edit::Piece;
use crate::geometry::Point;

/// Returns the segments that are not of zero length, after obstacles were normalised.
pub(crate) fn normalized(mut segments: Vec<Segment>, normalizer: Option<PolygonNormalizer>) -> Vec<Segment> {
    segments.retain(|segment| segment.ends[0] != segment.ends[1]);
    let Some(mut normalizer) = normalizer else {
        return segments;
    };
    let mut ready = Vec::with_capacity(segments.len());
    segments
        .into_iter()
        .for_each(|segment| normalizer.take(segment, &mut ready));
    ready
}

/// Returns the segments after obstacles were normalised, by the numbers of their ends. These are
/// ends of the segments of the same obstacle.
pub(crate) fn normalized_pieces(segments: &[Segment], mut normalizer: PolygonNormalizer) -> Vec<Piece> {
    let (mut pieces, mut ready, mut start) = (Vec::new(), Vec::new(), 0);
    let mut ends: Vec<(Point, u32)> = Vec::new();
    for (segment, number) in segments.iter().zip(0u32..) {
        normalizer.take(*segment, &mut ready);
        if normalizer.is_within() {
            continue;
        }
        // Ends of segments of no length become no vertices.
        let its = (start..=number).map(|number| (number, segments[number as usize].ends));
        let numbered = its
            .filter(|(_, [a, b])| a != b)
            .flat_map(|(number, ends)| [2 * number, 2 * number + 1].into_iter().zip(ends));
        ends.clear();
        ends.extend(numbered.map(|(end, point)| (point, end)));
        ends.sort_unstable_by(|(p, one), (q, other)| p.lex_cmp(*q).then(one.cmp(other)));
        let end_at = |point: Point| ends[ends.partition_point(|(other, _)| other.lex_cmp(point).is_lt())].1;
        pieces.extend(ready.drain(..).map(|segment| Piece {
            ends: segment.ends.map(end_at),
            source: segment.source,
        }));
        start = number + 1;
    }
    pieces
}
