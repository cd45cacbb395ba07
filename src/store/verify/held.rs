//! Checks of what holds the vertices of a tile: points of the input, sites, and ends of segments.
//!
//! A vertex without any of these is a point at which lines were split. A line that passes a vertex
//! runs along two edges there. The sources of an edge are in the tile of its smaller end only, so a
//! tile judges the vertices whose constraint edges all belong to it. Comparing the file with its
//! input ([`TileReader::verify_lines`](crate::store::TileReader::verify_lines)) judges all of them.

use crate::geometry::VertexIndex;
use crate::mesh::{StarEnd, Topology};
use crate::store::format::line_part::LinePart;
use crate::store::format::lists::Lists;
use crate::store::format::metadata::Metadata;
use crate::store::format::tile::Tile;
use crate::store::verify::error::{Fault, TileEdge};
use crate::store::verify::star::Fans;

/// A constraint edge at a vertex, in its direction.
#[derive(Clone, Copy)]
struct Incident {
    edge: TileEdge,
    /// Whether the vertex is its first end.
    is_leaving: bool,
}

/// The lines along the edges at a vertex: for each edge, each line once.
#[derive(Default)]
struct LinesHere {
    /// The lines' numbers, each with two bits: whether the line passes the vertex on its way along
    /// the edge, and whether a segment of it ends there.
    lines: Vec<u64>,
}

const ENDS: u64 = 1;
const PASSES: u64 = 2;

/// Returns whether lines of a file were split where they cross each other or borders.
pub(super) fn is_split(metadata: &Metadata, lists: &Lists) -> bool {
    metadata.crossings > 0 || !lists.cell_borders.is_empty()
}

/// Returns the number of vertices of a tile at which no point of the input lies.
pub(super) fn without_point(tile: &Tile) -> u64 {
    let others = tile.vertex_indices().filter(|&vertex| !tile.is_input_point(vertex));
    others.count() as u64
}

/// Checks what holds the vertices of a tile of a file without triangles, whose edges have been
/// checked.
pub(super) fn check_on_line(tile: &Tile, is_split: bool) -> Result<(), Fault> {
    check_equal_sources(tile)?;
    let mut here = LinesHere::default();
    let mut incident = Vec::new();
    let mut on_line = edges_on_line(tile).into_iter().peekable();
    // An edge of another tile may lead to the first vertex on the line.
    let first = tile
        .vertex_indices()
        .min_by(|&a, &b| tile.point(a).lex_cmp(tile.point(b)));
    for vertex in tile.vertex_indices() {
        incident.clear();
        while let Some((_, edge)) = on_line.next_if(|(at, _)| *at == vertex) {
            incident.push(edge);
        }
        if first != Some(vertex) {
            here.check(tile, vertex, &incident, is_split)?;
        }
    }
    Ok(())
}

/// Checks what holds the vertices of a tile, whose stars have been checked. `is_split` says whether
/// lines of the file were split where they cross each other or borders.
pub(super) fn check(tile: &Tile, fans: &Fans, is_split: bool) -> Result<(), Fault> {
    check_equal_sources(tile)?;
    let mut here = LinesHere::default();
    let mut incident = Vec::new();
    for vertex in tile.vertex_indices() {
        if incident_constraints(tile, fans, vertex, &mut incident) {
            here.check(tile, vertex, &incident, is_split)?;
        }
    }
    Ok(())
}

/// Checks that sources that an edge has several times say the same about the ends of segments.
fn check_equal_sources(tile: &Tile) -> Result<(), Fault> {
    for edge in tile.owned_constraints() {
        let mut last: Option<LinePart> = None;
        for part in tile.edge_parts(edge) {
            if last.is_some_and(|last| last.source() == part.source() && last != part) {
                let reason = format!("its edge comes from {:?} with different ends", part.source());
                return Err(Fault::on(edge, reason));
            }
            last = Some(part);
        }
    }
    Ok(())
}

/// Finds the constraint edges at a vertex. Returns whether all of them belong to the tile.
fn incident_constraints(tile: &Tile, fans: &Fans, vertex: VertexIndex, found: &mut Vec<Incident>) -> bool {
    found.clear();
    let Some(first) = fans.first(vertex) else { return true };
    let mut star = tile.star(first);
    let leaving = |edge| Incident { edge, is_leaving: true };
    found.extend(star.by_ref().map(|half_edge| leaving(TileEdge::HalfEdge(half_edge))));
    if let Some(StarEnd::Hull(arriving)) = star.end() {
        found.push(Incident {
            edge: TileEdge::HalfEdge(arriving),
            is_leaving: false,
        });
    }
    found.retain(|incident| tile.is_constraint(incident.edge));
    let is_elsewhere = |incident: &Incident| {
        let ends = tile.corners_of_edge(incident.edge);
        let other = ends[usize::from(incident.is_leaving)];
        !tile.has_vertex(other) && tile.point(other).lex_cmp(tile.point(vertex)).is_lt()
    };
    !found.iter().any(is_elsewhere)
}

/// Returns the edges of a tile without triangles at each of its vertices, by vertex.
fn edges_on_line(tile: &Tile) -> Vec<(VertexIndex, Incident)> {
    let both = tile.owned_constraints().flat_map(|edge| {
        let [from, to] = tile.corners_of_edge(edge);
        [(from, true), (to, false)].map(|(vertex, is_leaving)| (vertex, Incident { edge, is_leaving }))
    });
    let mut edges: Vec<_> = both.filter(|(vertex, _)| tile.has_vertex(*vertex)).collect();
    edges.sort_by_key(|(vertex, _)| *vertex);
    edges
}

impl LinesHere {
    /// Checks a vertex, given all its constraint edges.
    fn check(&mut self, tile: &Tile, vertex: VertexIndex, edges: &[Incident], is_split: bool) -> Result<(), Fault> {
        self.lines.clear();
        for &incident in edges {
            self.add(tile, incident);
        }
        self.lines.sort_unstable();
        let mut by_line = self.lines.chunk_by(|a, b| a >> 2 == b >> 2);
        if let Some(line) = by_line.find(|line| line.len() == 1 && line[0] & PASSES != 0) {
            return Err(Fault::new(format!(
                "line {} passes vertex {vertex}, but runs along one edge there only",
                line[0] >> 2
            )));
        }
        let is_end = self.lines.iter().any(|line| line & ENDS != 0);
        let is_held = tile.is_input_point(vertex) || tile.is_site(vertex) || is_end;
        if is_held || (is_split && !self.lines.is_empty()) {
            return Ok(());
        }
        Err(Fault::new(format!(
            "vertex {vertex} is no point of the input, no site, and no end of a segment"
        )))
    }

    /// Adds the lines along an edge.
    fn add(&mut self, tile: &Tile, Incident { edge, is_leaving }: Incident) {
        let mut last: Option<LinePart> = None;
        for part in tile.edge_parts(edge) {
            let is_end = if is_leaving { part.begins() } else { part.ends() };
            let bit = if is_end { ENDS } else { PASSES };
            match self.lines.last_mut() {
                // Both sides of an obstacle are one line.
                Some(line) if last.is_some_and(|last| last.number() == part.number()) => *line |= bit,
                _ => self.lines.push(part.number() << 2 | bit),
            }
            last = Some(part);
        }
    }
}
