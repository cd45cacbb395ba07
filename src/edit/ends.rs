//! The vertices at the ends of segments, existing ones and new ones.

use crate::edit::error::EditError;
use crate::edit::held::GoingPoints;
use crate::edit::tile::{EditTile, NewVertex};
use crate::edit::tiles::Tiles;
use crate::edit::vertex::EditVertex;
use crate::edit::vertex_z::give_z;
use crate::edit::vertices;
use crate::edit::work::Work;
use crate::geometry::{Point, VertexIndex};
use crate::input::MissingZ;
use crate::mesh::point_table::PointTable;
use crate::store::{TileId, VertexId};

/// An end of a segment: its tile, its point, and its number among all ends.
type End = (TileId, Point, u32);

/// Finds the vertices at the ends of segments, and adds those that are missing. Vertices that
/// nothing holds after what went take the z of the ends; without `going`, nothing went. Returns the
/// vertices in the order of the ends, and the number of new vertices.
pub(crate) fn find_ends(
    tiles: &mut Tiles,
    work: &Work,
    going: Option<&GoingPoints>,
    is_stopped: &dyn Fn() -> bool,
) -> Result<(Vec<EditVertex>, u64), EditError> {
    let ends = by_tile(tiles, work)?;
    // A placeholder: each entry but those of segments of no length is replaced.
    let filler = EditVertex {
        id: VertexId {
            tile: TileId(0),
            index: VertexIndex(0),
        },
        point: Point::new(0.0, 0.0),
        z: 0.0,
    };
    let mut found = vec![filler; 2 * work.segments.len()];
    if ends.is_empty() {
        return Ok((found, 0));
    }
    let mut added = 0;
    let needs_z = tiles.metadata().has_z && work.missing_z != MissingZ::Zero;
    let mut without_z: Vec<u32> = Vec::new();
    let going = going.filter(|_| tiles.metadata().has_z);
    let mut groups = ends.chunk_by(|a, b| a.0 == b.0);
    while let Some(group) = groups.next() {
        if is_stopped() {
            return Err(EditError::Cancelled);
        }
        tiles.read_ahead(groups.clone().map(|group| group[0].0));
        let missing = find_in_tile(tiles, work, group, &mut found)?;
        if let Some(going) = going {
            renew(tiles, work, group, going, &mut found)?;
        }
        if needs_z {
            without_z.extend(missing.iter().map(|end| end.2).filter(|&end| work.z_of(end).is_nan()));
        }
        added += missing.len() as u64;
    }
    if let Some(&first) = without_z.iter().min() {
        let segment = &work.segments[first as usize / 2];
        return Err(EditError::NoZ {
            line: segment.source.number(),
            point: segment.ends[first as usize % 2],
            count: without_z.len() as u64,
        });
    }
    Ok((found, added))
}

/// Returns all ends, grouped by tile and sorted by point.
fn by_tile(tiles: &Tiles, work: &Work) -> Result<Vec<End>, EditError> {
    let tree = &tiles.directory().tree;
    let mut ends: Vec<End> = Vec::with_capacity(2 * work.segments.len());
    let all = work
        .segments
        .iter()
        .flat_map(|segment| segment.ends.map(|end| (end, segment)));
    for ((point, segment), end) in all.zip(0u32..) {
        // A segment of no length becomes no edge, which would hold its end.
        if segment.ends[0] == segment.ends[1] {
            continue;
        }
        let tile = tree.tile_at(point).ok_or_else(|| no_vertex(point))?;
        ends.push((tile, point, end));
    }
    ends.sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| a.1.lex_cmp(b.1)).then_with(|| a.2.cmp(&b.2)));
    Ok(ends)
}

/// Finds the vertices at ends in one tile, and writes them to `found`, by the numbers of the ends.
/// Returns the ends for which vertices were added.
fn find_in_tile(tiles: &mut Tiles, work: &Work, ends: &[End], found: &mut [EditVertex]) -> Result<Vec<End>, EditError> {
    let id = ends[0].0;
    let numbers_in = |tile: &EditTile| -> Vec<Option<u32>> {
        let index = PointTable::new(tile.points());
        ends.iter().map(|&(_, point, _)| index.at(point)).collect()
    };
    let mut tile = tiles.get(id)?;
    let mut numbers = numbers_in(&tile);
    let missing = ends.iter().zip(&numbers).filter(|(_, number)| number.is_none());
    let mut missing: Vec<End> = missing.map(|(end, _)| *end).collect();
    // Of several ends at one point, the first that has z determines the vertex's z.
    missing.dedup_by(|next, kept| {
        let equal = next.1 == kept.1;
        if equal && work.z_of(kept.2).is_nan() && !work.z_of(next.2).is_nan() {
            *kept = *next;
        }
        equal
    });
    if !missing.is_empty() {
        drop(tile);
        add_vertices(tiles, work, &missing)?;
        tile = tiles.get(id)?;
        numbers = numbers_in(&tile);
    }
    for (&(_, point, end), number) in ends.iter().zip(numbers) {
        found[end as usize] = tile.vertex(VertexIndex(number.ok_or_else(|| no_vertex(point))?));
    }
    Ok(missing)
}

/// Gives vertices that nothing holds the z of the new ends there, the first that has any.
fn renew(
    tiles: &mut Tiles,
    work: &Work,
    ends: &[End],
    going: &GoingPoints,
    found: &mut [EditVertex],
) -> Result<(), EditError> {
    for here in ends.chunk_by(|a, b| a.1 == b.1) {
        let z = here.iter().map(|end| work.z_of(end.2)).find(|z| !z.is_nan());
        let vertex = found[here[0].2 as usize];
        if let Some(z) = z
            && !going.is_held(tiles, vertex)?
        {
            give_z(tiles, vertex.id, z)?;
            let vertex = tiles.get(vertex.id.tile)?.vertex(vertex.id.index);
            here.iter().for_each(|end| found[end.2 as usize] = vertex);
        }
    }
    Ok(())
}

fn no_vertex(point: Point) -> EditError {
    EditError::Internal(format!("there is no vertex at ({}, {})", point.x, point.y))
}

/// Adds vertices at ends in one tile, each at another point. The ends of all segments get the next
/// record numbers of the file, in order.
fn add_vertices(tiles: &mut Tiles, work: &Work, ends: &[End]) -> Result<(), EditError> {
    let first_record = tiles.metadata().next_record.saturating_add(work.points.records);
    let z_or_zero = |end: u32| {
        let z = work.z_of(end);
        if z.is_nan() { 0.0 } else { z }
    };
    let new = ends.iter().map(|&(_, point, end)| NewVertex {
        point,
        z: z_or_zero(end),
        record: first_record.saturating_add(end.into()),
        is_input_point: false,
    });
    vertices::add(tiles, ends[0].0, new.collect()).map(drop)
}
