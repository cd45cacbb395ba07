//! Repair of polygons that are inside out, and of obstacles that cover a place more than once: they
//! cover once what their rings enclose, in any direction.
//!
//! In: the subsegments of all polygons, which do not cross. Out: subsegments whose direction says
//! where the interior is. First each polygon that is inside out is normalised by itself, then each
//! obstacle that covers a place more than once. Other polygons are unchanged.

use crate::constraints::crossings::split::TaggedSegment;
use crate::constraints::polygons::check::{Inverted, InvertedPolygons};
use crate::constraints::polygons::normalize::{DirectedPart, direct};
use crate::constraints::polygons::segment_ends::SegmentEnds;
use crate::geometry::Point;
use crate::mesh::windings::sweep::{Outcome, Sweep};

/// The segment that a subsegment is a part of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PartOf {
    /// The number of the segment.
    pub(crate) segment: u32,
    /// Which ends of the subsegment are ends of the segment, or of others along it that this one
    /// replaces.
    pub(crate) is_end: [bool; 2],
}

/// A part of a segment.
pub(crate) type Subsegment = TaggedSegment<PartOf>;

/// The result of a repair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PolygonRepair {
    /// The polygons that were inside out.
    pub(crate) inverted: Option<InvertedPolygons>,
    /// Number of parts of them that were inside out.
    pub(crate) parts: u64,
    /// Whether any subsegments were changed.
    pub(crate) changes: bool,
}

/// Repairs polygons. `polygon_of` returns the polygon of a subsegment and the number of its line,
/// or `None` if it belongs to no polygon. The subsegments of a polygon must be consecutive, and so
/// must be those of a line.
pub(crate) fn repair(
    subsegments: &mut Vec<Subsegment>,
    polygon_of: impl Fn(&Subsegment) -> Option<(u64, u64)>,
) -> PolygonRepair {
    let mut done = PolygonRepair::default();
    let mut changed: Vec<Subsegment> = Vec::new();
    // Number of subsegments that were copied to `changed`, if any polygon was repaired.
    let (mut copied, mut start) = (0, 0);
    for its in subsegments.chunk_by(|one, other| match (polygon_of(one), polygon_of(other)) {
        (Some((polygon, line)), Some((other, of_other))) => polygon == other || line == of_other,
        (one, other) => one == other,
    }) {
        let end = start + its.len();
        if polygon_of(&its[0]).is_some()
            && let Some(repaired) = repair_obstacle(its, &polygon_of, &mut done)
        {
            changed.extend_from_slice(&subsegments[copied..start]);
            changed.extend(repaired);
            copied = end;
        }
        start = end;
    }
    if copied > 0 {
        changed.extend_from_slice(&subsegments[copied..]);
        *subsegments = changed;
        done.changes = true;
    }
    done
}

/// Returns the repaired subsegments of an obstacle, or `None` if they need no repair.
fn repair_obstacle(
    its: &[Subsegment],
    polygon_of: &impl Fn(&Subsegment) -> Option<(u64, u64)>,
    done: &mut PolygonRepair,
) -> Option<Vec<Subsegment>> {
    let polygon = |subsegment: &Subsegment| polygon_of(subsegment).map(|(polygon, _)| polygon);
    let line = |subsegment: &Subsegment| polygon_of(subsegment).map_or(0, |(_, line)| line);
    let (mut all, mut polygons, mut overlaps, mut is_inverted) = (Vec::new(), 0, false, false);
    for its in its.chunk_by(|one, other| polygon(one) == polygon(other)) {
        polygons += 1;
        let sweep = sweep(its);
        let Outcome::Seen {
            first, faces, overlap, ..
        } = sweep.run(None, &mut |_| {})
        else {
            all.extend_from_slice(its);
            continue;
        };
        match first {
            Some(point) => {
                let obstacle = line(&its[0]);
                let first = Inverted { obstacle, point };
                let inverted = done.inverted.get_or_insert(InvertedPolygons { first, polygons: 0 });
                inverted.polygons += 1;
                done.parts += faces;
                all.extend(directed(its, line, &sweep));
                is_inverted = true;
            }
            None => {
                all.extend_from_slice(its);
                overlaps |= overlap.is_some();
            }
        }
    }
    if polygons > 1 || overlaps {
        let sweep = sweep(&all);
        if let Outcome::Seen { overlap: Some(_), .. } = sweep.run(None, &mut |_| {}) {
            return Some(directed(&all, line, &sweep));
        }
    }
    is_inverted.then_some(all)
}

fn sweep(its: &[Subsegment]) -> Sweep {
    Sweep::new(its.iter().map(|subsegment| subsegment.ends))
}

fn directed(its: &[Subsegment], line: impl Fn(&Subsegment) -> u64, sweep: &Sweep) -> Vec<Subsegment> {
    let segment_ends = SegmentEnds::of(its.iter().map(|subsegment| (subsegment.ends, subsegment.tag.is_end)));
    let ends: Vec<[Point; 2]> = its.iter().map(|subsegment| subsegment.ends).collect();
    let parts = direct(&ends, |at| line(&its[at]), sweep);
    let subsegment = |(at, ends): DirectedPart| {
        let is_end = segment_ends.of_part(ends);
        let tag = PartOf { is_end, ..its[at].tag };
        TaggedSegment { ends, tag }
    };
    parts.into_iter().map(subsegment).collect()
}
