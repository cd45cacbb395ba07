//! One tile with its vertices and triangles.

use delaunay_tiles::geometry::Rect;
use delaunay_tiles::geometry::{HalfEdge, TriangleId};
use delaunay_tiles::mesh::Twin;
use delaunay_tiles::store::{Directory, Tile};
use serde::Serialize;

use super::numbers::Table;
use super::tiles::TileRow;
use crate::common::thousands;

/// A tile with all its content. Its field names are stable keys of `--json`.
#[derive(Serialize)]
pub struct WholeTile {
    #[serde(flatten)]
    row: TileRow,
    cell: Cell,
    vertex_list: Vec<VertexRow>,
    triangle_list: Vec<TriangleRow>,
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
        text + &self.vertex_table() + &self.triangle_table()
    }

    fn vertex_table(&self) -> String {
        let has_z = self.vertex_list.iter().any(|v| v.z.is_some());
        let columns: &[&str] = if has_z {
            &["vertex", "x", "y", "z", "record"]
        } else {
            &["vertex", "x", "y", "record"]
        };
        let mut table = Table::new(columns);
        for v in &self.vertex_list {
            let z = has_z.then(|| v.z.map_or("-".to_owned(), exact));
            let start = [v.index.to_string(), exact(v.x), exact(v.y)].into_iter();
            table.row(start.chain(z).chain([v.record.to_string()]));
        }
        format!("\n{}", table.show(0))
    }

    fn triangle_table(&self) -> String {
        let id = self.row.id;
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
            let corners = t.corners.map(|(tile, index)| match tile == id {
                true => index.to_string(),
                false => format!("{tile}:{index}"),
            });
            let neighbours = t.neighbours.iter().map(|neighbour| match neighbour {
                Neighbour::Triangle(number) => number.to_string(),
                Neighbour::None(word) => (*word).to_owned(),
            });
            let owned = if t.owned { "yes" } else { "no" };
            let start = [t.number.to_string()].into_iter().chain(corners);
            table.row(start.chain(neighbours).chain([t.part.to_owned(), owned.to_owned()]));
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

/// Formats a number with all its digits, with an exponent instead of many zeros.
fn exact(value: f64) -> String {
    let text = format!("{value:?}");
    text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
}
