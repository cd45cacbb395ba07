//! Removal of lines that are given by their numbers.

use std::collections::BTreeSet;

use crate::edit::error::EditError;
use crate::edit::tile::EditTile;
use crate::edit::tiles::Tiles;
use crate::edit::unconstrain::gone::GoneLines;
use crate::edit::unconstrain::remover::LineRemover;
use crate::edit::vertex::EditVertex;
use crate::memory::EditShares;
use crate::mesh::Topology;
use crate::store::{EdgeSource, PolygonLine, TileId, polygon_of};

/// An edge, and one of its sources as seen from the first end.
type SourceOfEdge = ([EditVertex; 2], EdgeSource);

/// Removes the lines that are given by their numbers. Of obstacles, all rings go. Reads all tiles,
/// since nothing says where a line is.
pub(super) fn remove(
    tiles: &mut Tiles,
    lines: &GoneLines,
    polygon_lines: &[PolygonLine],
    remover: &mut LineRemover,
    is_stopped: &dyn Fn() -> bool,
) -> Result<(), EditError> {
    if lines.numbers.is_empty() {
        return Ok(());
    }
    let polygon = |number: u64| polygon_of(polygon_lines, number);
    let wanted: BTreeSet<u64> = lines.numbers.iter().map(|&number| polygon(number)).collect();
    let mut found: BTreeSet<u64> = BTreeSet::new();
    let ids: Vec<TileId> = tiles.ids().collect();
    for id in ids {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        let is_wanted = |source: EdgeSource| wanted.contains(&polygon(source.number()));
        for (edge, source) in sources_in(tiles, id, is_wanted)? {
            found.insert(polygon(source.number()));
            remover.take(tiles, edge, source)?;
        }
        EditShares::check_removed(lines.memory, remover.removed.ends.len())?;
    }
    let missing: Vec<u64> = lines
        .numbers
        .iter()
        .copied()
        .filter(|&number| !found.contains(&polygon(number)))
        .collect();
    remover.removed.counts.removed_lines += (lines.numbers.len() - missing.len()) as u64;
    remover.removed.counts.skipped += missing.len() as u64;
    match missing.first() {
        Some(&line) if !lines.skip_missing => Err(EditError::NoLineNumber {
            line,
            count: missing.len() as u64,
        }),
        _ => Ok(()),
    }
}

/// Returns the sources of a tile's edges that are wanted.
pub(super) fn sources_in(
    tiles: &Tiles,
    id: TileId,
    is_wanted: impl Fn(EdgeSource) -> bool,
) -> Result<Vec<SourceOfEdge>, EditError> {
    if !tiles.is_changed(id) {
        let tile = tiles.read(id)?;
        let mut sources = tile.owned_constraints().flat_map(|edge| tile.edge_sources(edge));
        if !sources.any(&is_wanted) {
            return Ok(Vec::new());
        }
    }
    let tile: &EditTile = &*tiles.get(id)?;
    let mut all = Vec::new();
    for (half_edge, sources) in tile.owned_constraints() {
        // Sources are seen from the smaller corner.
        let mut corners = [tile.origin(half_edge), tile.destination(half_edge)];
        corners.sort_unstable();
        let edge = corners.map(|corner| tile.vertex(corner));
        let wanted = sources
            .iter()
            .map(|part| part.source())
            .filter(|&source| is_wanted(source));
        all.extend(wanted.map(|source| (edge, source)));
    }
    // The tile has its edges in no order.
    all.sort_unstable_by(|(one, source), (other, of_other)| {
        let points = |edge: &[EditVertex; 2], end: usize| edge[end].point;
        (points(one, 0).lex_cmp(points(other, 0)))
            .then_with(|| points(one, 1).lex_cmp(points(other, 1)))
            .then_with(|| source.cmp(of_other))
    });
    Ok(all)
}
