//! The edges along a segment, and the lines that have it.

use crate::edit::error::EditError;
use crate::edit::leaving::{Leaving, is_shorter_from_end, leave};
use crate::edit::tiles::Tiles;
use crate::edit::vertex::{EditVertex, owner};
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
    chain.sources.sort_unstable();
    Ok(Some(chain))
}
