//! The edges along a segment, and the lines that have it.

use crate::edit::error::EditError;
use crate::edit::leaving::{Leaving, is_shorter_from_end, leave};
use crate::edit::tiles::Tiles;
use crate::edit::vertex::{EditVertex, owner};
use crate::geometry::{Orientation, orient2d};
use crate::store::{EdgeSource, LinePart};

/// The edges along a segment, in order, and the lines that have it.
pub(super) struct EdgeChain {
    pub(super) edges: Vec<[EditVertex; 2]>,
    /// The sources of the segment, in order, as seen from its first end to its second.
    pub(super) sources: Vec<EdgeSource>,
}

/// Finds the edges along a segment between two vertices. `part` is the source of the segment,
/// whatever its number. Returns `None` if no line has the segment.
pub(super) fn find(tiles: &Tiles, ends: [EditVertex; 2], part: LinePart) -> Result<Option<EdgeChain>, EditError> {
    if is_shorter_from_end(tiles, ends)? {
        let [from, to] = ends;
        let found = find_from([to, from], part.reversed(), tiles)?;
        return Ok(found.map(|EdgeChain { mut edges, sources }| {
            edges.reverse();
            edges.iter_mut().for_each(|ends| ends.reverse());
            let sources = sources.into_iter().map(EdgeSource::reversed);
            EdgeChain {
                edges,
                sources: sources.collect(),
            }
        }));
    }
    find_from(ends, part, tiles)
}

fn find_from([from, to]: [EditVertex; 2], part: LinePart, tiles: &Tiles) -> Result<Option<EdgeChain>, EditError> {
    let mut chain = EdgeChain {
        edges: Vec::new(),
        sources: Vec::new(),
    };
    let mut at = from;
    while at.id != to.id {
        let tile = tiles.get(at.id.tile)?;
        let Some(Leaving::Along(_, next)) = leave(&tile, at, to.point, &mut 0) else {
            return Ok(None);
        };
        drop(tile);
        // Beyond the end, the way back would lead here.
        if next.id != to.id && next.point.lex_cmp(to.point) != at.point.lex_cmp(to.point) {
            return Ok(None);
        }
        let edge = [at, next];
        let tile = tiles.get(owner(edge))?;
        let Some(along) = tile.sources_along(edge.map(|end| end.id)) else {
            return Ok(None);
        };
        // Where another segment of the line begins on the way, the segment is not this one.
        let expected = [part.begins() && at.id == from.id, part.ends() && next.id == to.id];
        let fits = |other: &&LinePart| {
            let is_alike = other.kind() == part.kind() && other.depth_change() == part.depth_change();
            is_alike && other.end_bits() == expected
        };
        let mut fitting: Vec<EdgeSource> = along.iter().filter(fits).map(|other| other.source()).collect();
        fitting.dedup();
        if chain.edges.is_empty() {
            chain.sources = fitting;
        } else {
            chain.sources.retain(|source| fitting.contains(source));
        }
        if chain.sources.is_empty() {
            return Ok(None);
        }
        chain.edges.push(edge);
        at = next;
    }
    for (end, edge, is_end) in [
        (from, chain.edges.first(), part.begins()),
        (to, chain.edges.last(), part.ends()),
    ] {
        if let Some(edge) = edge.filter(|_| is_end) {
            let others = passing(tiles, end, edge)?;
            chain.sources.retain(|source| !others.contains(source));
        }
    }
    chain.sources.sort_unstable();
    Ok((!chain.sources.is_empty()).then_some(chain))
}

/// Returns the sources of the edge that continues an edge beyond one of its ends, in the same
/// direction, except those that have the end of a segment there. If such a line has the edge too, it
/// passes the end, and another of its segments runs along the edge: the two overlap.
fn passing(tiles: &Tiles, end: EditVertex, edge: &[EditVertex; 2]) -> Result<Vec<EdgeSource>, EditError> {
    let is_start = edge[0].id == end.id;
    let other = if is_start { edge[1] } else { edge[0] };
    let tile = tiles.get(end.id.tile)?;
    let is_beyond = |vertex: &EditVertex| {
        vertex.point.lex_cmp(end.point) == end.point.lex_cmp(other.point)
            && orient2d(other.point, end.point, vertex.point) == Orientation::Collinear
    };
    let mut around = tile
        .around(end.id.index)
        .flat_map(|half_edge| [half_edge.next(), half_edge.prev()]);
    let beyond = around.find_map(|half_edge| Some(tile.origin_vertex(half_edge)).filter(is_beyond));
    drop(around);
    drop(tile);
    let Some(beyond) = beyond else { return Ok(Vec::new()) };
    let continued = if is_start { [beyond, end] } else { [end, beyond] };
    let along = tiles
        .get(owner(continued))?
        .sources_along(continued.map(|vertex| vertex.id));
    let passes = |part: &&LinePart| !(if is_start { part.ends() } else { part.begins() });
    Ok(along
        .iter()
        .flatten()
        .filter(passes)
        .map(|part| part.source())
        .collect())
}
