//! Checks of what holds the vertices that have constraint edges of other tiles.
//!
//! The sources of an edge are in the tile of its smaller end. If the vertex at its larger end
//! belongs to another tile, neither tile can judge that vertex. So both write notes of what they
//! know about it, and the notes of all tiles are put together. If they do not fit in memory, the
//! vertices are divided into parts, each of which takes one pass over the tiles that have notes.

use std::sync::Arc;

use futures::stream::StreamExt;

use crate::geometry::{HalfEdge, VertexIndex};
use crate::mesh::Topology;
use crate::store::format::ids::{TileId, VertexId};
use crate::store::format::tile::Tile;
use crate::store::format::tile::edges::TileEdge;
use crate::store::pass::{Needs, PassReader, list_for, spawn};
use crate::store::verify::error::{Fault, VerifyError};
use crate::store::verify::held::{Incident, LineHere, LineRules, LinesHere, first_on_line, has_point_or_site};

/// What a tile knows of a vertex.
type Note = (VertexId, Known);

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Known {
    /// The vertex belongs to the tile. Whether a point of the input or a site is there.
    Vertex { has_other: bool },
    /// A line runs along an edge of the tile there.
    Line(LineHere),
}

/// Bytes of a note while notes are put together, and in the list of its tile.
const BYTES: u64 = 2 * size_of::<Note>() as u64;
/// The minimum number of notes that are in memory at once.
const LEAST_NOTES: u64 = 1 << 12;

/// The number of notes in a file.
#[derive(Debug, Default)]
pub(super) struct SharedVertices {
    /// The tiles that have notes.
    tiles: Vec<TileId>,
    notes: u64,
}

impl SharedVertices {
    pub(super) fn add(&mut self, tile: TileId, notes: u64) {
        if notes > 0 {
            self.tiles.push(tile);
            self.notes += notes;
        }
    }
}

/// Returns the number of notes of a tile.
pub(super) fn count(tile: &Tile, rules: &LineRules) -> u64 {
    let mut notes = 0;
    for_each_note(tile, rules, |_| notes += 1);
    notes
}

/// Passes the notes of a tile to `take`.
fn for_each_note(tile: &Tile, rules: &LineRules, mut take: impl FnMut(Note)) {
    let shared = shared(tile);
    let mut here = LinesHere::default();
    for edge in tile.owned_constraints() {
        for (corner, is_leaving) in tile.corners_of_edge(edge).into_iter().zip([true, false]) {
            if !tile.has_vertex(corner) || shared.binary_search(&corner).is_ok() {
                let vertex = tile.vertex(corner).id;
                let lines = here.of_edge(tile, Incident { edge, is_leaving }, rules);
                lines.iter().for_each(|&line| take((vertex, Known::Line(line))));
            }
        }
    }
    for vertex in shared {
        let has_other = has_point_or_site(tile, vertex);
        take((tile.vertex(vertex).id, Known::Vertex { has_other }));
    }
}

/// Returns the vertices of a tile that may have constraint edges of other tiles, in order.
fn shared(tile: &Tile) -> Vec<VertexIndex> {
    if tile.triangle_count() == 0 {
        return first_on_line(tile).into_iter().collect();
    }
    let constraints = tile.half_edges().filter(|&edge| tile.is_constraint(edge));
    let larger_end = |half_edge: HalfEdge| {
        let mut corners = tile.corners_of_edge(TileEdge::HalfEdge(half_edge));
        corners.sort_unstable_by(|&a, &b| tile.point(a).lex_cmp(tile.point(b)));
        let [smaller, larger] = corners;
        (!tile.has_vertex(smaller) && tile.has_vertex(larger)).then_some(larger)
    };
    let mut shared: Vec<VertexIndex> = constraints.filter_map(larger_end).collect();
    shared.sort_unstable();
    shared.dedup();
    shared
}

impl PassReader {
    /// Checks the vertices that have constraint edges of other tiles. `shared` was collected from
    /// all tiles.
    pub(super) async fn verify_shared_vertices(
        &self,
        shared: SharedVertices,
        rules: &Arc<LineRules>,
    ) -> Result<(), VerifyError> {
        if shared.notes == 0 {
            return Ok(());
        }
        let needs = |notes: u64| Needs {
            fixed: notes.saturating_mul(BYTES),
            ..Needs::default()
        };
        let (plan, at_once) = self.plan_lookups(needs, LEAST_NOTES..shared.notes, BYTES)?;
        let parts = match shared.notes <= at_once as u64 {
            true => 1,
            // Vertices have different numbers of notes, so parts differ in size.
            false => shared.notes.div_ceil(at_once as u64 / 2),
        };
        let tiles: Vec<(TileId, ())> = shared.tiles.into_iter().map(|tile| (tile, ())).collect();
        let mut first: Option<(VertexId, Fault)> = None;
        for part in 0..parts {
            let of_tile = Arc::clone(rules);
            let mut lists = self.for_some_tiles(tiles.clone(), plan, move |tile, ()| {
                let mut notes = Vec::new();
                for_each_note(&tile, &of_tile, |note| {
                    if part_of(note.0, parts) == part {
                        notes.push(note);
                    }
                });
                notes
            });
            let mut notes: Vec<Note> = list_for(at_once);
            while let Some(list) = lists.next().await {
                notes.extend(list?);
                if notes.len() > at_once {
                    return Err(self.too_little_memory(2 * notes.len() as u64 * BYTES).into());
                }
            }
            drop(lists);
            let rules = Arc::clone(rules);
            let fault = spawn(move || first_fault(notes, &rules)).await?;
            // The first fault of all parts does not depend on the parts.
            first = match (first, fault) {
                (Some(first), Some(fault)) if first.0 < fault.0 => Some(first),
                (first, fault) => fault.or(first),
            };
        }
        first.map_or(Ok(()), |(vertex, fault)| Err(fault.of(vertex.tile)))
    }
}

/// Returns the part of all vertices that has a vertex.
fn part_of(vertex: VertexId, parts: u64) -> u64 {
    let bits = u64::from(vertex.tile.0) << 32 | u64::from(vertex.index.0);
    (bits.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) % parts
}

/// Returns the first vertex that contradicts its notes, and how.
fn first_fault(mut notes: Vec<Note>, rules: &LineRules) -> Option<(VertexId, Fault)> {
    notes.sort_unstable();
    let mut lines: Vec<LineHere> = Vec::new();
    notes.chunk_by(|a, b| a.0 == b.0).find_map(|its| {
        let vertex = its[0].0;
        lines.clear();
        let mut of_tile = None;
        for (_, known) in its {
            match known {
                Known::Vertex { has_other } => of_tile = Some(*has_other),
                Known::Line(line) => lines.push(*line),
            }
        }
        let fault = match of_tile {
            Some(has_other) => rules.fault(vertex.index, &lines, has_other)?,
            None => Fault::new(format!(
                "another tile has an edge at vertex {} that it does not have",
                vertex.index
            )),
        };
        Some((vertex, fault))
    })
}
