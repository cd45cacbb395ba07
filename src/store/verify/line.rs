//! Checks of a file without triangles: all its vertices are on one line, and its constraint edges
//! connect consecutive vertices.
//!
//! Cells are convex, so each tile has an interval of the line. For each tile, the check notes the
//! first vertex of its interval, and the vertex of another tile that its last edge leads to. That
//! vertex must be the first one of the next interval.

use futures::stream::StreamExt;

use crate::geometry::{Orientation, Point, VertexIndex, orient2d};
use crate::store::format::ids::{TileId, VertexId};
use crate::store::format::line_source::LineSource;
use crate::store::format::tile::{Tile, Vertex};
use crate::store::reader::TileReader;
use crate::store::verify::error::{Fault, VerifyError};
use crate::store::verify::held::{self, LineRules};

/// The interval of the line that a tile has.
struct LineInterval {
    tile: TileId,
    first: OnLine,
    /// The vertex of another tile that an edge leads to.
    next: Option<OnLine>,
}

/// A vertex, and its z as a tile stores it.
#[derive(Clone, Copy)]
struct OnLine {
    vertex: Vertex,
    z: Option<f64>,
}

impl OnLine {
    fn of(tile: &Tile, corner: VertexIndex) -> Self {
        Self {
            vertex: tile.vertex(corner),
            z: tile.z(corner),
        }
    }
}

impl TileReader {
    /// Checks a file without triangles. `rules` are what its directory says of lines.
    pub(super) async fn verify_on_line(&self, rules: &LineRules) -> Result<(), VerifyError> {
        let lists = self.lists().await?;
        let lines = &lists.lines;
        let mut start: Vec<Point> = Vec::with_capacity(2);
        let mut intervals = Vec::new();
        let mut tiles = self.tiles();
        while let Some(tile) = tiles.next().await {
            let tile = tile?;
            check_collinear(&tile, &mut start).map_err(|fault| fault.of(tile.id()))?;
            let checked = check_edges(&tile, lines).and_then(|interval| {
                held::check_on_line(&tile, rules)?;
                Ok(interval)
            });
            intervals.extend(checked.map_err(|fault| fault.of(tile.id()))?);
        }
        intervals.sort_unstable_by(|a, b| a.first.vertex.point.lex_cmp(b.first.vertex.point));
        for (index, interval) in intervals.iter().enumerate() {
            let Some(next) = interval.next else { continue };
            let follows = intervals.get(index + 1).map(|next| next.first);
            let Some(follows) = follows.filter(|follows| follows.vertex == next.vertex) else {
                let reason = "its last edge leads to a vertex that is not the next one on the line";
                return Err(Fault::new(reason).of(interval.tile));
            };
            if next.z.map(f64::to_bits) != follows.z.map(f64::to_bits) {
                let [z, right] = [next.z, follows.z].map(Option::unwrap_or_default);
                let reason = format!(
                    "it says that vertex {} has z {z:?}, but the tile that owns it says {right:?}",
                    next.vertex.id
                );
                return Err(Fault::new(reason).of(interval.tile));
            }
        }
        Ok(())
    }
}

/// Checks that the vertices of a tile are collinear with the first two vertices of the file.
fn check_collinear(tile: &Tile, start: &mut Vec<Point>) -> Result<(), Fault> {
    for (p, vertex) in tile.points().zip(0u32..) {
        match start[..] {
            [a, b] if orient2d(a, b, p) != Orientation::Collinear => {
                let reason = format!("vertex {vertex} is not collinear with the others, but there are no triangles");
                return Err(Fault::new(reason));
            }
            [_, _] => {}
            _ => start.push(p),
        }
    }
    Ok(())
}

/// Checks that each edge leads from a vertex to the next one on the line, and has sources that the
/// directory lists.
fn check_edges(tile: &Tile, lines: &[LineSource]) -> Result<Option<LineInterval>, Fault> {
    let mut along: Vec<VertexIndex> = tile.vertex_indices().collect();
    along.sort_unstable_by(|&a, &b| tile.point(a).lex_cmp(tile.point(b)));
    let mut positions = vec![0; along.len()];
    for (&vertex, position) in along.iter().zip(0usize..) {
        positions[vertex.index()] = position;
    }
    let Some(&first) = along.first() else {
        return Ok(None);
    };
    let mut next = None;
    for edge in tile.owned_constraints() {
        let [from, to] = tile.ends(edge);
        let follows = along.get(positions[from.id.index.index()] + 1);
        let is_next = match follows {
            Some(&index) => to.id == VertexId { tile: tile.id(), index },
            None => to.id.tile != tile.id(),
        };
        if !is_next || from.point.lex_cmp(to.point).is_ge() {
            return Err(Fault::new(format!(
                "its edge from ({}, {}) to ({}, {}) does not lead to the next vertex on the line",
                from.point.x, from.point.y, to.point.x, to.point.y
            )));
        }
        if to.id.tile != tile.id() {
            let [_, corner] = tile.corners_of_edge(edge);
            next = Some(OnLine::of(tile, corner));
        }
        let mut sources = tile.edge_sources(edge).peekable();
        if sources.peek().is_none() {
            return Err(Fault::new("one of its edges is a constraint without a source"));
        }
        if let Some(source) = sources.find(|&source| !LineSource::knows(lines, source)) {
            let reason = format!("one of its edges comes from {source:?}, which the directory does not know");
            return Err(Fault::new(reason));
        }
    }
    Ok(Some(LineInterval {
        tile: tile.id(),
        first: OnLine::of(tile, first),
        next,
    }))
}
