//! The features of formats of features: the geometry and the values of one triangle, vertex or edge.
//!
//! FlatGeobuf and GeoParquet have the same columns, from here.

use super::error::Contradiction;
use super::numbering::Numbering;
use super::tile_part::{CutBy, TilePart};
use super::what::What;
use crate::geometry::VertexIndex;
use crate::store::{LineKind, Tile, TileEdge};

/// A value of a feature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value {
    Number(u64),
    Text(&'static str),
    Missing,
}

/// The type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColumnKind {
    Number,
    /// A number that may be missing.
    OptionalNumber,
    /// One of the texts of [`KINDS`], which may be missing.
    Kinds,
}

/// The names and types of the columns of features.
pub(super) type Columns = &'static [(&'static str, ColumnKind)];

impl What {
    pub(super) fn cut(self) -> CutBy {
        match self {
            Self::Triangles => CutBy::Triangles,
            Self::Vertices => CutBy::Points,
            Self::Edges => CutBy::Edges,
        }
    }

    pub(super) fn columns(self) -> Columns {
        use ColumnKind::{Kinds, Number, OptionalNumber};
        match self {
            Self::Triangles => &[("a", Number), ("b", Number), ("c", Number), ("region", Number)],
            Self::Vertices => &[("vertex", Number), ("record", Number)],
            Self::Edges => &[
                ("from", Number),
                ("to", Number),
                ("kind", Kinds),
                ("line", OptionalNumber),
            ],
        }
    }
}

/// The kinds of the lines along an edge, by the sum of their bits: 1 for break lines, 2 for walls and
/// 4 for obstacles.
pub(super) const KINDS: [&str; 8] = [
    "",
    "break_line",
    "wall",
    "break_line,wall",
    "obstacle",
    "break_line,obstacle",
    "wall,obstacle",
    "break_line,wall,obstacle",
];

/// Returns the kinds of the lines along an edge, and the number of the first line. Both are missing if
/// the edge is on no line, but on the border of a cell.
pub(super) fn lines_of(tile: &Tile, edge: TileEdge) -> [Value; 2] {
    let (mut kinds, mut first) = (0, None::<u64>);
    for source in tile.edge_sources(edge) {
        kinds |= match source.kind() {
            LineKind::BreakLine => 1,
            LineKind::Wall => 2,
            LineKind::Obstacle => 4,
        };
        first = Some(first.map_or(source.number(), |first| first.min(source.number())));
    }
    match first {
        Some(first) => [Value::Text(KINDS[kinds]), Value::Number(first)],
        None => [Value::Missing; 2],
    }
}

/// Returns a number with a sign, as programs that read tables prefer.
pub(super) fn signed(number: u64) -> Result<i64, Contradiction> {
    i64::try_from(number).map_err(|_| Contradiction::TooLarge(number))
}

impl TilePart {
    /// Calls `take` with the corners and the values of each feature that is written.
    #[cfg_attr(
        not(any(feature = "flatgeobuf", feature = "parquet")),
        allow(dead_code, reason = "GeoJSON has other properties")
    )]
    pub(super) fn for_each_feature(
        &self,
        numbering: &Numbering,
        what: What,
        mut take: impl FnMut(&[VertexIndex], &[Value]) -> Result<(), Contradiction>,
    ) -> Result<(), Contradiction> {
        match what {
            What::Triangles => self.for_each_triangle(numbering, |triangle, corners, vertices| {
                let [a, b, c] = vertices.map(Value::Number);
                let region = Value::Number(self.tile.region(triangle));
                take(&corners, &[a, b, c, region])
            }),
            What::Vertices => self.points(numbering).try_for_each(|(vertex, number)| {
                let record = self.tile.record(vertex);
                take(&[vertex], &[Value::Number(number), Value::Number(record)])
            }),
            What::Edges => self.edges(numbering).try_for_each(|edge| {
                let [from, to] = numbering.ends(&self.tile, edge)?.map(Value::Number);
                let [kinds, line] = lines_of(&self.tile, edge);
                take(&self.tile.corners_of_edge(edge), &[from, to, kinds, line])
            }),
        }
    }
}

impl Numbering {
    /// Returns the numbers of the ends of an edge.
    pub(super) fn ends(&self, tile: &Tile, edge: TileEdge) -> Result<[u64; 2], Contradiction> {
        let [from, to] = tile.ends(edge);
        Ok([self.number(from.id)?, self.number(to.id)?])
    }
}
