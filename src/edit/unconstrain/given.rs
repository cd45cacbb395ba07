//! Removal of lines that are given by geometry.

use std::collections::{BTreeMap, BTreeSet};

use foldhash::HashSet;

use crate::constraints::segment::Segment;
use crate::edit::error::EditError;
use crate::edit::tile_vertices::find_vertices;
use crate::edit::tiles::Tiles;
use crate::edit::unconstrain::chains;
use crate::edit::unconstrain::gone::GoneLines;
use crate::edit::unconstrain::numbered::sources_in;
use crate::edit::unconstrain::remover::LineRemover;
use crate::edit::vertex::EditVertex;
use crate::geometry::{Point, Rect};
use crate::store::{EdgeSource, LineKind, PolygonLine, TileId, polygon_of};

/// Removes the lines that are given by geometry.
pub(super) fn remove(
    tiles: &mut Tiles,
    lines: &GoneLines,
    polygon_lines: &[PolygonLine],
    remover: &mut LineRemover,
    is_stopped: &dyn Fn() -> bool,
) -> Result<(), EditError> {
    let ends = lines.segments.iter().flat_map(|segment| segment.ends);
    let vertices = find_vertices(tiles, ends.collect(), is_stopped)?;
    let mut vertices = &vertices[..];
    let mut missing: Option<[Point; 2]> = None;
    // The rectangles of obstacles that were removed, by their numbers.
    let mut obstacles: BTreeMap<u64, Rect> = BTreeMap::new();
    for segments in lines.groups() {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        let group = Group {
            segments,
            vertices: &vertices[..2 * segments.len()],
        };
        vertices = &vertices[2 * segments.len()..];
        let found = match segments[0].source.kind() {
            LineKind::Obstacle => group.remove_obstacle(tiles, remover, polygon_lines, &mut obstacles)?,
            LineKind::BreakLine | LineKind::Wall => group.remove_line(tiles, remover)?,
        };
        missing = missing.or(found);
    }
    match missing.filter(|_| !lines.skip_missing) {
        Some(ends) => Err(EditError::NoLine {
            ends,
            count: remover.removed.counts.skipped,
        }),
        None => check_whole(tiles, polygon_lines, &obstacles, is_stopped),
    }
}

/// A given line, or a given obstacle: its segments, and the vertices at their ends.
struct Group<'a> {
    segments: &'a [Segment],
    vertices: &'a [Option<EditVertex>],
}

impl Group<'_> {
    /// Returns the segments, with the vertices at their ends if these are there.
    fn parts(&self) -> impl Iterator<Item = (&Segment, Option<[EditVertex; 2]>)> {
        let ends = self.vertices.as_chunks::<2>().0.iter();
        let ends = ends.map(|&[from, to]| from.zip(to).map(|(from, to)| [from, to]));
        self.segments.iter().zip(ends)
    }

    /// Returns the numbers that all segments have in common. `number_of` returns the number of a
    /// source. Segments that no line has count if `is_whole`.
    fn common(
        &self,
        tiles: &Tiles,
        is_whole: bool,
        number_of: impl Fn(EdgeSource) -> u64,
    ) -> Result<BTreeSet<u64>, EditError> {
        let mut common: Option<BTreeSet<u64>> = None;
        for (segment, ends) in self.parts() {
            let sources = sources_of(tiles, segment, ends)?;
            if sources.is_empty() && !is_whole {
                continue;
            }
            let numbers = sources.iter().map(|&source| number_of(source));
            let both = match &common {
                None => numbers.collect(),
                Some(common) => numbers.filter(|number| common.contains(number)).collect(),
            };
            common = Some(both);
            if common.as_ref().is_some_and(BTreeSet::is_empty) {
                break;
            }
        }
        Ok(common.unwrap_or_default())
    }

    /// Removes a line, segment by segment. Returns the first one that is not there.
    fn remove_line(&self, tiles: &mut Tiles, remover: &mut LineRemover) -> Result<Option<[Point; 2]>, EditError> {
        let whole = self.common(tiles, false, EdgeSource::number)?.first().copied();
        let mut missing = None;
        // An edge has a line once, however often the line runs along it.
        let mut done: HashSet<[[u64; 2]; 2]> = HashSet::default();
        for (segment, ends) in self.parts() {
            let mut key = segment.ends.map(Point::bits);
            key.sort_unstable();
            let is_removed = done.contains(&key)
                || remove_segment(tiles, remover, segment, ends, |source| {
                    whole.is_none_or(|whole| source.number() == whole)
                })?;
            if is_removed {
                done.insert(key);
                remover.removed.counts.removed_segments += 1;
            } else {
                remover.removed.counts.skipped += 1;
                missing = missing.or(Some(segment.ends));
            }
        }
        Ok(missing)
    }

    /// Removes an obstacle, and notes its number and its rectangle. Returns its first segment if it
    /// is not there.
    fn remove_obstacle(
        &self,
        tiles: &mut Tiles,
        remover: &mut LineRemover,
        polygon_lines: &[PolygonLine],
        obstacles: &mut BTreeMap<u64, Rect>,
    ) -> Result<Option<[Point; 2]>, EditError> {
        let number_of = |source: EdgeSource| polygon_of(polygon_lines, source.number());
        let Some(&number) = self.common(tiles, true, number_of)?.first() else {
            remover.removed.counts.skipped += self.segments.len() as u64;
            return Ok(Some(self.segments[0].ends));
        };
        let bounds = Rect::around(self.segments.iter().flat_map(|segment| segment.ends));
        let all = obstacles.entry(number).or_insert(bounds);
        *all = all.union(bounds);
        for (segment, ends) in self.parts() {
            // A segment of the obstacle may be there once only, although it is given twice.
            if !remove_segment(tiles, remover, segment, ends, |source| number_of(source) == number)? {
                return Err(EditError::NoLine {
                    ends: segment.ends,
                    count: 1,
                });
            }
            remover.removed.counts.removed_segments += 1;
        }
        Ok(None)
    }
}

/// Returns the sources that a segment has, in order.
fn sources_of(tiles: &Tiles, segment: &Segment, ends: Option<[EditVertex; 2]>) -> Result<Vec<EdgeSource>, EditError> {
    let Some(ends) = ends else { return Ok(Vec::new()) };
    let chain = chains::find(tiles, ends, segment.source)?;
    Ok(chain.map_or(Vec::new(), |chain| chain.sources))
}

/// Removes a segment of the first line that is wanted. Returns whether it is there.
fn remove_segment(
    tiles: &mut Tiles,
    remover: &mut LineRemover,
    segment: &Segment,
    ends: Option<[EditVertex; 2]>,
    is_wanted: impl Fn(EdgeSource) -> bool,
) -> Result<bool, EditError> {
    let Some(ends) = ends else { return Ok(false) };
    let Some(chain) = chains::find(tiles, ends, segment.source)? else {
        return Ok(false);
    };
    let Some(source) = chain.sources.into_iter().find(|&source| is_wanted(source)) else {
        return Ok(false);
    };
    for edge in chain.edges {
        remover.take(tiles, edge, source)?;
    }
    Ok(true)
}

/// Checks that nothing is left of obstacles that were removed. Their other rings lie within the
/// rectangles of those that were given.
fn check_whole(
    tiles: &Tiles,
    polygon_lines: &[PolygonLine],
    obstacles: &BTreeMap<u64, Rect>,
    is_stopped: &dyn Fn() -> bool,
) -> Result<(), EditError> {
    let mut within: BTreeSet<TileId> = BTreeSet::new();
    for (tile, cell) in tiles.directory().tree.cells() {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        if obstacles.values().any(|bounds| cell.intersects(*bounds)) {
            within.insert(tile);
        }
    }
    let is_left = |source: EdgeSource| {
        source.kind() == LineKind::Obstacle && obstacles.contains_key(&polygon_of(polygon_lines, source.number()))
    };
    for id in tiles.ids().filter(|id| within.contains(id)) {
        if let Some(&(edge, source)) = sources_in(tiles, id, is_left)?.first() {
            return Err(EditError::PartOfObstacle {
                line: source.number(),
                point: edge[0].point,
            });
        }
    }
    Ok(())
}
