//! The columns that FlatGeobuf and GeoParquet have, and the values of each triangle, vertex or edge.

use super::error::Contradiction;
use super::feature::{Value, lines_of};
use super::numbering::Numbering;
use super::tile_part::TilePart;
use super::what::What;
use crate::geometry::VertexIndex;

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

/// Returns a number with a sign, as programs that read tables prefer.
pub(super) fn signed(number: u64) -> Result<i64, Contradiction> {
    i64::try_from(number).map_err(|_| Contradiction::TooLarge(number))
}

impl TilePart {
    /// Calls `take` with the corners and the values of each feature that is written.
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
