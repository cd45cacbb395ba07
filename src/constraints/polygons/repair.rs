//! Polygons that are inside out, put right: what their rings go round in whatever direction, they cover once.
//!
//! In: the pieces of all polygons, which do not cross. Out: pieces that know where the interior is: the depth changes along them
//! by what the polygon covers on their left, 1 or 0, less what it covers on their right. Where that is nothing they come once in
//! each direction. Polygons whose winding is nowhere negative stay as they are.

use crate::constraints::crossings::split::TaggedSegment;
use crate::constraints::polygons::check::{Inverted, InvertedPolygons};
use crate::constraints::polygons::sweep::{EdgePart, Outcome, Sweep};
use crate::geometry::Point;

/// What was put right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PolygonRepair {
    /// The polygons.
    pub(crate) inverted: Option<InvertedPolygons>,
    /// How many parts of them were inside out.
    pub(crate) parts: u64,
}

/// Puts polygons right. `polygon_of` tells which polygon a piece is of, if it is of one, and the number of its line; the pieces
/// of a polygon come one after another.
pub(crate) fn repair<T: Copy>(
    subsegments: &mut Vec<TaggedSegment<T>>,
    polygon_of: impl Fn(&TaggedSegment<T>) -> Option<(u64, u64)>,
) -> PolygonRepair {
    let mut done = PolygonRepair::default();
    let mut changed: Vec<TaggedSegment<T>> = Vec::new();
    // How many of the pieces went over to the changed ones, if any did.
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

/// Directs the pieces of a polygon.
fn direct<T: Copy>(its: &[TaggedSegment<T>], sweep: &Sweep, out: &mut Vec<TaggedSegment<T>>) {
    let mut parts: Vec<EdgePart> = Vec::new();
    sweep.run(None, &mut |part| parts.push(part));
    // Those of an edge in their order along it.
    parts.sort_by_key(|part| part.edge);
    let mut is_directed = vec![false; sweep.edge_count()];
    for subsegment in its {
        let Some(edge) = sweep.edge_between(subsegment.ends[0], subsegment.ends[1]) else {
            // It goes there and back.
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
