//! One tile with its vertices and triangles.

use delaunay_tiles::geometry::Rect;
use delaunay_tiles::geometry::{HalfEdge, TriangleId};
use delaunay_tiles::mesh::Twin;
use delaunay_tiles::store::{Directory, Tile, TileEdge};
use serde::Serialize;

use super::tiles::TileRow;
use crate::common::thousands;
use crate::numbers::Table;

/// A tile with all its content. Its field names are stable keys of `--json`.
#[derive(Serialize)]
pub struct WholeTile {
    #[serde(flatten)]
    row: TileRow,
    cell: Cell,
    vertex_list: Vec<VertexRow>,
    triangle_list: Vec<TriangleRow>,
    /// The lines along the constraint edges that belong to the tile.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    line_list: Vec<LineRow>,
}

/// The cell of a tile, which owns its right and top sides. A side at infinity is null.
#[derive(Serialize)]
struct Cell {
    min_x: Option<f64>,
    min_y: Option<f64>,
    max_x: Option<f64>,
    max_y: Option<f64>,
}

#[derive(Serialize)]
struct VertexRow {
    index: u32,
    x: f64,
    y: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    z: Option<f64>,
    record: u64,
    /// Whether a point of the input lies at the vertex.
    input_point: bool,
}

/// A line along an edge.
#[derive(Serialize)]
struct LineRow {
    /// The tile and the vertex index of the ends of the edge.
    edge: [(u32, u32); 2],
    line: u64,
    kind: String,
    /// The side on which the interior of an obstacle is.
    #[serde(skip_serializing_if = "Option::is_none")]
    interior: Option<&'static str>,
    /// Whether a segment of the line begins at the first end of the edge, and ends at the second.
    begins: bool,
    ends: bool,
}

#[derive(Serialize)]
struct TriangleRow {
    number: u32,
    /// The tile and the vertex index of each corner, counter-clockwise.
    corners: [(u32, u32); 3],
    /// The neighbours at the edges from corner 0 to 1, from 1 to 2, and from 2 to 0.
    neighbours: [Neighbour; 3],
    part: &'static str,
    owned: bool,
}

/// The number of a triangle of the tile, or a word if the neighbour is not in the tile.
#[derive(Serialize)]
#[serde(untagged)]
enum Neighbour {
    Triangle(u32),
    None(&'static str),
}

impl WholeTile {
    /// Lists the content of a tile.
    pub fn new(directory: &Directory, tile: &Tile) -> Self {
        let id = tile.id();
        let finite = |v: f64| v.is_finite().then_some(v);
        let cells = directory.tree.cells().into_iter();
        let cell = cells.filter(|(tile, _)| *tile == id).map(|(_, cell)| cell).next();
        let cell = cell.unwrap_or(Rect::PLANE);
        let vertices = tile.vertex_indices().map(|index| VertexRow {
            index: index.0,
            x: tile.point(index).x,
            y: tile.point(index).y,
            z: tile.z(index),
            record: tile.record(index),
            input_point: tile.is_input_point(index),
        });
        Self {
            row: TileRow::new(id.0, &directory.tiles[id.0 as usize]),
            cell: Cell {
                min_x: finite(cell.min_x),
                min_y: finite(cell.min_y),
                max_x: finite(cell.max_x),
                max_y: finite(cell.max_y),
            },
            vertex_list: vertices.collect(),
            triangle_list: tile.triangle_ids().map(|id| triangle(tile, id)).collect(),
            line_list: tile.owned_constraints().flat_map(|edge| lines(tile, edge)).collect(),
        }
    }

    /// Returns the report for people. Coordinates have all their digits.
    pub fn report(&self) -> String {
        let row = &self.row;
        let count = |number: u32| thousands(number.into());
        let bound = |value: Option<f64>, infinite: &str| value.map_or(infinite.to_owned(), exact);
        let interval = |min, max: Option<f64>| {
            let end = if max.is_some() { "]" } else { ")" };
            format!("({}, {}{end}", bound(min, "-∞"), bound(max, "∞"))
        };
        let cell = format!(
            "x {}, y {}",
            interval(self.cell.min_x, self.cell.max_x),
            interval(self.cell.min_y, self.cell.max_y)
        );
        let bounds = row.bounds.map_or("none".to_owned(), |b| {
            let [x0, x1, y0, y1] = [b.min_x, b.max_x, b.min_y, b.max_y].map(exact);
            format!("x {x0} to {x1}, y {y0} to {y1}")
        });
        let triangles = format!(
            "{} in the core, {} in the border; {} owned by the tile",
            count(row.core_triangles),
            count(row.border_triangles),
            count(row.owned_triangles)
        );
        let extent = |[bytes, raw]: [u32; 2], offset, crc: &str| {
            let raw = match raw == bytes {
                true => String::new(),
                false => format!(" ({} raw)", count(raw)),
            };
            format!("{} bytes{raw} at {}, CRC-32C {crc}", count(bytes), thousands(offset))
        };
        let mut text = format!("tile {}\n", row.id);
        for (name, value) in [
            ("vertices", count(row.vertices)),
            ("triangles", triangles),
            ("generation", count(row.generation)),
            (
                "core",
                extent([row.core_bytes, row.core_raw_bytes], row.core_offset, &row.core_crc32c),
            ),
            (
                "border",
                extent(
                    [row.border_bytes, row.border_raw_bytes],
                    row.border_offset,
                    &row.border_crc32c,
                ),
            ),
            ("bounds", bounds),
            ("cell", cell),
        ] {
            text += &format!("  {name:<11} {value}\n");
        }
        text + &self.vertex_table() + &self.triangle_table() + &self.line_table()
    }

    fn vertex_table(&self) -> String {
        let has_z = self.vertex_list.iter().any(|v| v.z.is_some());
        let has_others = self.vertex_list.iter().any(|v| !v.input_point);
        let columns = [
            Some("vertex"),
            Some("x"),
            Some("y"),
            has_z.then_some("z"),
            Some("record"),
            has_others.then_some("input point"),
        ];
        let columns: Vec<&str> = columns.into_iter().flatten().collect();
        let mut table = Table::new(&columns);
        for v in &self.vertex_list {
            let z = has_z.then(|| v.z.map_or("-".to_owned(), exact));
            let start = [v.index.to_string(), exact(v.x), exact(v.y)].into_iter();
            let point = has_others.then(|| yes_or_no(v.input_point));
            table.row(start.chain(z).chain([v.record.to_string()]).chain(point));
        }
        format!("\n{}", table.show(0))
    }

    /// Returns the table of lines, or nothing if there are none.
    fn line_table(&self) -> String {
        if self.line_list.is_empty() {
            return String::new();
        }
        let mut table = Table::new(&["from", "to", "line", "kind", "interior", "begins", "ends"]);
        for row in &self.line_list {
            let ends = row.edge.map(|vertex| self.corner(vertex));
            let rest = [
                row.line.to_string(),
                row.kind.clone(),
                row.interior.unwrap_or("-").to_owned(),
                yes_or_no(row.begins),
                yes_or_no(row.ends),
            ];
            table.row(ends.into_iter().chain(rest));
        }
        format!("\n{}", table.show(0))
    }

    /// Returns a vertex by its index, and by its tile too if that is another one.
    fn corner(&self, (tile, index): (u32, u32)) -> String {
        match tile == self.row.id {
            true => index.to_string(),
            false => format!("{tile}:{index}"),
        }
    }

    fn triangle_table(&self) -> String {
        let mut table = Table::new(&[
            "triangle",
            "corner 0",
            "corner 1",
            "corner 2",
            "neighbour 0-1",
            "neighbour 1-2",
            "neighbour 2-0",
            "part",
            "owned",
        ]);
        for t in &self.triangle_list {
            let corners = t.corners.map(|corner| self.corner(corner));
            let neighbours = t.neighbours.iter().map(|neighbour| match neighbour {
                Neighbour::Triangle(number) => number.to_string(),
                Neighbour::None(word) => (*word).to_owned(),
            });
            let start = [t.number.to_string()].into_iter().chain(corners);
            table.row(start.chain(neighbours).chain([t.part.to_owned(), yes_or_no(t.owned)]));
        }
        format!("\n{}", table.show(0))
    }
}

fn triangle(tile: &Tile, triangle: TriangleId) -> TriangleRow {
    TriangleRow {
        number: triangle.0,
        corners: tile.vertices(triangle).map(|v| (v.id.tile.0, v.id.index.0)),
        neighbours: HalfEdge::of_triangle(triangle).map(|half_edge| match tile.twin(half_edge) {
            Twin::HalfEdge(twin) => Neighbour::Triangle(twin.triangle().0),
            Twin::Elsewhere => Neighbour::None("elsewhere"),
            Twin::Hull => Neighbour::None("hull"),
        }),
        part: if triangle.0 < tile.core_triangle_count() {
            "core"
        } else {
            "border"
        },
        owned: tile.owns(triangle),
    }
}

/// Returns the lines along an edge.
fn lines(tile: &Tile, edge: TileEdge) -> impl Iterator<Item = LineRow> {
    let ends = tile.ends(edge).map(|v| (v.id.tile.0, v.id.index.0));
    tile.edge_parts(edge).map(move |part| LineRow {
        edge: ends,
        line: part.number(),
        kind: part.kind().to_string(),
        interior: match part.depth_change() {
            0 => None,
            change => Some(if change > 0 { "left" } else { "right" }),
        },
        begins: part.begins(),
        ends: part.ends(),
    })
}

fn yes_or_no(value: bool) -> String {
    if value { "yes" } else { "no" }.to_owned()
}

/// Formats a number with all its digits, with an exponent instead of many zeros.
fn exact(value: f64) -> String {
    let text = format!("{value:?}");
    text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
}
