//! The values of features: what GeoJSON, FlatGeobuf and GeoParquet tell of an edge.

use super::error::Contradiction;
use super::numbering::Numbering;
use crate::store::{LineKind, Tile, TileEdge};

/// A value of a feature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value {
    Number(u64),
    Text(&'static str),
    Missing,
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

impl Numbering {
    /// Returns the numbers of the ends of an edge.
    pub(super) fn ends(&self, tile: &Tile, edge: TileEdge) -> Result<[u64; 2], Contradiction> {
        let [from, to] = tile.ends(edge);
        Ok([self.number(from.id)?, self.number(to.id)?])
    }
}
