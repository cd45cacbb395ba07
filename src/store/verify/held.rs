//! Checks of what holds the vertices of a tile: points of the input, sites, and ends of segments.
//!
//! A vertex without any of these is a point at which lines were split. A line that passes a vertex
//! runs along two edges there. The sources of an edge are in the tile of its smaller end only, so a
//! tile judges the vertices whose constraint edges all belong to it;
//! [`shared_vertices`](super::shared_vertices) has the others.

use crate::geometry::VertexIndex;
use crate::mesh::{StarEnd, Topology};
use crate::store::format::directory::Directory;
use crate::store::format::edge_source::LineKind;
use crate::store::format::line_part::LinePart;
use crate::store::format::polygon_lines::{PolygonLine, polygon_of};
use crate::store::format::tile::Tile;
use crate::store::verify::error::{Fault, TileEdge};
use crate::store::verify::star::Fans;

/// What the directory says of lines.
#[derive(Debug)]
pub(super) struct LineRules {
    /// Whether lines were split where they cross each other or cell borders.
    is_split: bool,
    /// The lines that belong to the polygon of a smaller line. `None` if the file does not list its
    /// lines: then nobody knows which rings belong together.
    polygon_lines: Option<Vec<PolygonLine>>,
}

/// A constraint edge at a vertex, in its direction.
#[derive(Clone, Copy)]
pub(super) struct Incident {
    pub(super) edge: TileEdge,
    /// Whether the vertex is its first end.
    pub(super) is_leaving: bool,
}

/// The lines along the edges at a vertex: for each edge, each line once.
#[derive(Default)]
pub(super) struct LinesHere {
    lines: Vec<LineHere>,
    /// The lines of one edge.
    of_edge: Vec<LineHere>,
}

/// A line along an edge at a vertex. The line's number with two bits: whether the line passes the
/// vertex on its way along the edge, and whether a segment of it ends there. All lines of a polygon
/// are one: where its rings overlap, the file has only one of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct LineHere(u64);

const ENDS: u64 = 1;
const PASSES: u64 = 2;

impl LineRules {
    pub(super) fn of(directory: &Directory) -> Self {
        let lists = &directory.lists;
        Self {
            is_split: directory.has_split_lines(),
            polygon_lines: (!lists.lines.is_empty()).then(|| lists.polygon_lines.clone()),
        }
    }

    /// Returns what is wrong with a vertex, given all lines there, in order. `has_other` says whether
    /// a point of the input or a site is there.
    pub(super) fn fault(&self, vertex: VertexIndex, lines: &[LineHere], has_other: bool) -> Option<Fault> {
        let mut by_line = lines.chunk_by(|a, b| a.line() == b.line());
        if let Some(line) = by_line.find(|line| line.len() == 1 && line[0].0 & PASSES != 0) {
            return Some(Fault::new(format!(
                "line {} passes vertex {vertex}, but runs along one edge there only",
                line[0].line()
            )));
        }
        let is_held = has_other || lines.iter().any(|line| line.0 & ENDS != 0);
        let may_be_split = self.is_split && !lines.is_empty();
        (!is_held && !may_be_split).then(|| {
            Fault::new(format!(
                "vertex {vertex} is no point of the input, no site, and no end of a segment"
            ))
        })
    }
}

impl LineHere {
    fn new(part: LinePart, is_end: bool, rules: &LineRules) -> Self {
        let passes = if is_end { ENDS } else { PASSES };
        let (line, bit) = match (part.kind(), &rules.polygon_lines) {
            (LineKind::Obstacle, Some(lines)) => (polygon_of(lines, part.number()), passes),
            // It may go on as another ring of its polygon.
            (LineKind::Obstacle, None) => (part.number(), passes & ENDS),
            (LineKind::BreakLine | LineKind::Wall, _) => (part.number(), passes),
        };
        Self(line << 2 | bit)
    }

    fn line(self) -> u64 {
        self.0 >> 2
    }
}

/// Returns the number of vertices of a tile at which no point of the input lies.
pub(super) fn without_point(tile: &Tile) -> u64 {
    let others = tile.vertex_indices().filter(|&vertex| !tile.is_input_point(vertex));
    others.count() as u64
}

/// Checks what holds the vertices of a tile of a file without triangles, whose edges have been
/// checked.
pub(super) fn check_on_line(tile: &Tile, rules: &LineRules) -> Result<(), Fault> {
    check_equal_sources(tile)?;
    let mut here = LinesHere::default();
    let mut incident = Vec::new();
    let mut on_line = edges_on_line(tile).into_iter().peekable();
    let first = first_on_line(tile);
    for vertex in tile.vertex_indices() {
        incident.clear();
        while let Some((_, edge)) = on_line.next_if(|(at, _)| *at == vertex) {
            incident.push(edge);
        }
        if first != Some(vertex) {
            here.check(tile, vertex, &incident, rules)?;
        }
    }
    Ok(())
}

/// Returns the first vertex on the line of a tile without triangles. An edge of another tile may
/// lead to it.
pub(super) fn first_on_line(tile: &Tile) -> Option<VertexIndex> {
    let order = |a: &VertexIndex, b: &VertexIndex| tile.point(*a).lex_cmp(tile.point(*b));
    tile.vertex_indices().min_by(order)
}

/// Returns whether a point of the input or a site is at a vertex.
pub(super) fn has_point_or_site(tile: &Tile, vertex: VertexIndex) -> bool {
    tile.is_input_point(vertex) || tile.is_site(vertex)
}

/// Checks what holds the vertices of a tile, whose stars have been checked.
pub(super) fn check(tile: &Tile, fans: &Fans, rules: &LineRules) -> Result<(), Fault> {
    check_equal_sources(tile)?;
    let mut here = LinesHere::default();
    let mut incident = Vec::new();
    for vertex in tile.vertex_indices() {
        if incident_constraints(tile, fans, vertex, &mut incident) {
            here.check(tile, vertex, &incident, rules)?;
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
    fn check(&mut self, tile: &Tile, vertex: VertexIndex, edges: &[Incident], rules: &LineRules) -> Result<(), Fault> {
        self.lines.clear();
        for &incident in edges {
            self.of_edge(tile, incident, rules);
            self.lines.extend_from_slice(&self.of_edge);
        }
        self.lines.sort_unstable();
        rules
            .fault(vertex, &self.lines, has_point_or_site(tile, vertex))
            .map_or(Ok(()), Err)
    }

    /// Returns the lines along an edge.
    pub(super) fn of_edge(&mut self, tile: &Tile, incident: Incident, rules: &LineRules) -> &[LineHere] {
        let Incident { edge, is_leaving } = incident;
        let is_end = |part: LinePart| if is_leaving { part.begins() } else { part.ends() };
        let lines = tile
            .edge_parts(edge)
            .map(|part| LineHere::new(part, is_end(part), rules));
        self.of_edge.clear();
        self.of_edge.extend(lines);
        self.of_edge.sort_unstable();
        self.of_edge.dedup_by(|next, kept| {
            let is_same = next.line() == kept.line();
            kept.0 |= if is_same { next.0 } else { 0 };
            is_same
        });
        &self.of_edge
    }
}
