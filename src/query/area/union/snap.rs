//! Snap rounding: line segments become polylines on a grid that meet at their points only.
//!
//! Each grid point is the centre of a half-open square, its pixel. A pixel is hot if a segment ends
//! or two segments cross in it. Each segment is replaced by the polyline through the centres of the
//! hot pixels that it passes, in this order. Thus two segments that nearly meet do meet, and none
//! cross. All decisions are exact.
//!
//! Guibas and Marimont, "Rounding arrangements dynamically", 1998; Hobby, "Practical segment
//! intersection with finite precision output", 1999.

use super::buckets::Buckets;
use super::edge::Edge;
use super::segment::{Pixel, Segment, crossing};
use crate::geometry::Point;

/// Returns the step of a grid for rings: a power of two, such that the products of three differences
/// fit 128 bits, and no less than 16 units in the last place of any coordinate, because corners
/// are rounded by a few of them. Its multiples are within the limits of the exact predicates.
pub(super) fn step_for<'a>(rings: impl Iterator<Item = &'a [Point]>) -> f64 {
    let (mut least, mut greatest) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for point in rings.flatten() {
        for (axis, x) in [point.x, point.y].into_iter().enumerate() {
            least[axis] = least[axis].min(x);
            greatest[axis] = greatest[axis].max(x);
        }
    }
    let sizes = [0, 1].map(|axis| greatest[axis] - least[axis]);
    let magnitudes = [0, 1].map(|axis| greatest[axis].max(-least[axis]));
    let exponent = |[a, b]: [f64; 2]| a.max(b).max(f64::MIN_POSITIVE).log2().ceil();
    let step = (exponent(sizes) - 36.0).max(exponent(magnitudes) - 48.0).exp2();
    step.max(Point::MIN_MAGNITUDE)
}

/// Returns the edges of rings, snapped to a grid. Edges meet at their ends only, and differ.
pub(super) fn snap<'a>(rings: impl Iterator<Item = &'a [Point]>, step: f64) -> Vec<Edge> {
    let pixel = |p: &Point| [p.x, p.y].map(|x| (x / step).round() as i64);
    let mut segments = Vec::new();
    for ring in rings {
        let mut from = ring.last().map(pixel);
        for to in ring.iter().map(pixel) {
            segments.extend(from.and_then(|from| Segment::between(from, to, 1)));
            from = Some(to);
        }
    }
    let segments = merged(segments);
    let pieces = divided(&segments, &passed(&segments));
    let point = |[x, y]: Pixel| Point::new(x as f64 * step, y as f64 * step);
    merged(pieces)
        .into_iter()
        .map(|segment| Edge {
            low: point(segment.from),
            high: point(segment.to),
            change: segment.change,
        })
        .collect()
}

/// Unites equal segments and adds their changes. Those without a change are left out.
fn merged(mut segments: Vec<Segment>) -> Vec<Segment> {
    segments.sort_unstable_by_key(|segment| (segment.from, segment.to));
    segments.dedup_by(|next, kept| {
        let is_same = (next.from, next.to) == (kept.from, kept.to);
        if is_same {
            kept.change += next.change;
        }
        is_same
    });
    segments.retain(|segment| segment.change != 0);
    segments
}

/// Returns the hot pixels within each segment, as sorted pairs of the segment's index and the pixel.
fn passed(segments: &[Segment]) -> Vec<(u32, Pixel)> {
    let buckets = Buckets::new(segments);
    let mut hot: Vec<Pixel> = segments.iter().flat_map(|s| [s.from, s.to]).collect();
    for near in buckets.segments() {
        for (index, &first) in near.iter().enumerate() {
            let others = near[index + 1..].iter();
            hot.extend(others.filter_map(|&other| crossing(&segments[first as usize], &segments[other as usize])));
        }
    }
    hot.sort_unstable();
    hot.dedup();
    let mut passed = Vec::new();
    // A pixel is in one bucket, with all segments that pass it.
    for pixel in hot {
        let near = buckets.at(pixel).iter().copied();
        let near = near.filter(|&near| segments[near as usize].passes(pixel));
        passed.extend(near.map(|near| (near, pixel)));
    }
    passed.sort_unstable();
    passed
}

/// Divides segments at the pixels within them.
fn divided(segments: &[Segment], passed: &[(u32, Pixel)]) -> Vec<Segment> {
    let mut pieces = Vec::with_capacity(segments.len() + passed.len());
    let mut rest = passed;
    for (whole, index) in segments.iter().zip(0..) {
        let (own, others) = rest.split_at(rest.partition_point(|&(of, _)| of == index));
        rest = others;
        let mut corners: Vec<Pixel> = own.iter().map(|&(_, pixel)| pixel).collect();
        if whole.to[1] < whole.from[1] {
            corners.sort_unstable_by_key(|&[x, y]| (x, -y));
        }
        corners.push(whole.to);
        let mut from = whole.from;
        for to in corners {
            pieces.extend(Segment::between(from, to, whole.change));
            from = to;
        }
    }
    pieces
}
