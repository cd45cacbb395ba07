//! Polygons that are inside out, put right: what their rings go round in whatever direction, they cover once.
//!
//! In: the pieces of all polygons, which do not cross. Out: pieces that know where the interior is: the depth changes along them
//! by what the polygon covers on their left, 1 or 0, less what it covers on their right. Where that is nothing they come once in
//! each direction. Polygons whose winding is nowhere negative stay as they are.

use crate::constraints::crossings::split::Segment as Bent;
use crate::constraints::polygons::check::{Inverted, InvertedPolygons};
use crate::constraints::polygons::sweep::{Outcome, Part, Sweep};
use crate::geometry::Point;

/// What was put right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PutRight {
    /// The polygons.
    pub(crate) inverted: Option<InvertedPolygons>,
    /// How many parts of them were inside out.
    pub(crate) parts: u64,
}

/// Puts polygons right. `polygon_of` tells which polygon a piece is of, if it is of one, and the number of its line; the pieces
/// of a polygon come one after another.
pub(crate) fn put_right<T: Copy>(
    pieces: &mut Vec<Bent<T>>,
    polygon_of: impl Fn(&Bent<T>) -> Option<(u64, u64)>,
) -> PutRight {
    let mut done = PutRight::default();
    let mut changed: Vec<Bent<T>> = Vec::new();
    // How many of the pieces went over to the changed ones, if any did.
    let mut copied = 0;
    let mut start = 0;
    let polygon = |piece: &Bent<T>| polygon_of(piece).map(|(polygon, _)| polygon);
    for its in pieces.chunk_by(|one, other| polygon(one) == polygon(other)) {
        let end = start + its.len();
        if let Some((_, obstacle)) = polygon_of(&its[0]) {
            let sweep = Sweep::new(its.iter().map(|piece| piece.ends));
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
                changed.extend_from_slice(&pieces[copied..start]);
                direct(its, &sweep, &mut changed);
                copied = end;
            }
        }
        start = end;
    }
    if copied > 0 {
        changed.extend_from_slice(&pieces[copied..]);
        *pieces = changed;
    }
    done
}

/// Directs the pieces of a polygon.
fn direct<T: Copy>(its: &[Bent<T>], sweep: &Sweep, out: &mut Vec<Bent<T>>) {
    let mut parts: Vec<Part> = Vec::new();
    sweep.run(None, &mut |part| parts.push(part));
    // Those of an edge in their order along it.
    parts.sort_by_key(|part| part.edge);
    let mut is_directed = vec![false; sweep.edge_count()];
    for piece in its {
        let Some(edge) = sweep.edge_between(piece.ends[0], piece.ends[1]) else {
            // It goes there and back.
            out.push(*piece);
            continue;
        };
        let is_first = !std::mem::replace(&mut is_directed[edge], true);
        let along = &parts[parts.partition_point(|part| part.edge < edge)..];
        for part in along.iter().take_while(|part| part.edge == edge) {
            let [low, high] = part.ends;
            let [below, above] = part.windings.map(|winding| i32::from(winding != 0));
            let change = if is_first && part.is_first { above - below } else { 0 };
            let mut push = |ends: [Point; 2]| out.push(Bent { ends, ..*piece });
            if change >= 0 {
                push([low, high]);
            }
            if change <= 0 {
                push([high, low]);
            }
        }
    }
}
