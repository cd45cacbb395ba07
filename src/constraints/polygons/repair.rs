//! Repair of polygons that are inside out: they cover once what their rings enclose, in any
//! direction.
//!
//! In: the subsegments of all polygons, which do not cross. Out: subsegments whose direction says
//! where the interior is. Along each, the depth changes by what the polygon covers on its left, 1
//! or 0, minus what the polygon covers on its right. Where this difference is 0, the subsegment
//! occurs once in each direction. Polygons whose winding is nowhere negative are unchanged.

use crate::constraints::crossings::split::TaggedSegment;
use crate::constraints::polygons::check::{Inverted, InvertedPolygons};
use crate::constraints::polygons::sweep::{EdgePart, Outcome, Sweep};
use crate::geometry::Point;

/// The result of a repair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PolygonRepair {
    /// The polygons that were repaired.
    pub(crate) inverted: Option<InvertedPolygons>,
    /// Number of parts of them that were inside out.
    pub(crate) parts: u64,
}

/// Repairs polygons. `polygon_of` returns the polygon of a subsegment and the number of its line,
/// or `None` if it belongs to no polygon. The subsegments of a polygon must be consecutive.
pub(crate) fn repair<T: Copy>(
    subsegments: &mut Vec<TaggedSegment<T>>,
    polygon_of: impl Fn(&TaggedSegment<T>) -> Option<(u64, u64)>,
) -> PolygonRepair {
    let mut done = PolygonRepair::default();
    let mut changed: Vec<TaggedSegment<T>> = Vec::new();
    // Number of subsegments that were copied to `changed`, if any polygon was repaired.
    let mut copied = 0;
    let mut start = 0;
    let polygon = |subsegment: &TaggedSegment<T>| polygon_of(subsegment).map(|(polygon, _)| polygon);
    for its in subsegments.chunk_by(|one, other| polygon(one) == polygon(other)) {
        let end = start + its.len();
        if let Some((_, obstacle)) = polygon_of(&its[0]) {
            let sweep = Sweep::new(its.iter().map(|subsegment| subsegment.ends));
            if let Outcome::Seen {
                first: Some(point),
                faces,
                ..
            } = sweep.run(None, &mut |_| {})
            {
                let first = Inverted { obstacle, point };
                let inverted = done.inverted.get_or_insert(InvertedPolygons { first, polygons: 0 });
                inverted.polygons += 1;
                done.parts += faces;
                changed.extend_from_slice(&subsegments[copied..start]);
                direct(its, &sweep, &mut changed);
                copied = end;
            }
        }
        start = end;
    }
    if copied > 0 {
        changed.extend_from_slice(&subsegments[copied..]);
        *subsegments = changed;
    }
    done
}

/// Directs the subsegments of a polygon.
fn direct<T: Copy>(its: &[TaggedSegment<T>], sweep: &Sweep, out: &mut Vec<TaggedSegment<T>>) {
    let mut parts: Vec<EdgePart> = Vec::new();
    sweep.run(None, &mut |part| parts.push(part));
    // The parts of an edge are in their order along it.
    parts.sort_by_key(|part| part.edge);
    let mut is_directed = vec![false; sweep.edge_count()];
    for subsegment in its {
        let Some(edge) = sweep.edge_between(subsegment.ends[0], subsegment.ends[1]) else {
            // Its edge is traversed equally often in both directions.
            out.push(*subsegment);
            continue;
        };
        let is_first = !std::mem::replace(&mut is_directed[edge], true);
        let along = &parts[parts.partition_point(|part| part.edge < edge)..];
        for part in along.iter().take_while(|part| part.edge == edge) {
            let [low, high] = part.ends;
            let [below, above] = part.windings.map(|winding| i32::from(winding != 0));
            let change = if is_first && part.is_first { above - below } else { 0 };
            let mut push = |ends: [Point; 2]| out.push(TaggedSegment { ends, ..*subsegment });
            if change >= 0 {
                push([low, high]);
            }
            if change <= 0 {
                push([high, low]);
            }
        }
    }
}
