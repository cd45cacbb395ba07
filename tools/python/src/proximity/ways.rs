//! Many paths as columns.

use delaunay_tiles::Path;
use delaunay_tiles::store::{LineKind, Vertex};

use crate::columns::Column;

/// Paths, one after the other, with offsets at which each begins.
pub struct Ways {
    offsets: Vec<i64>,
    coordinates: Vec<f64>,
    certified: Vec<bool>,
    bend_offsets: Vec<i64>,
    /// Tile and index of the vertex of each bend.
    vertices: Vec<i64>,
    /// Tile and index of the other end of the edge that the path bends around, or -1 twice.
    edges_to: Vec<i64>,
    turns_left: Vec<bool>,
    line_offsets: Vec<i64>,
    kinds: Vec<u8>,
    lines: Vec<i64>,
}

impl Default for Ways {
    fn default() -> Self {
        let start = || vec![0];
        Self {
            offsets: start(),
            coordinates: Vec::new(),
            certified: Vec::new(),
            bend_offsets: start(),
            vertices: Vec::new(),
            edges_to: Vec::new(),
            turns_left: Vec::new(),
            line_offsets: start(),
            kinds: Vec::new(),
            lines: Vec::new(),
        }
    }
}

impl Ways {
    /// Appends a path, or one without points.
    pub fn push(&mut self, path: Option<&Path>) {
        self.certified.push(path.is_some_and(|path| path.is_certified));
        if let Some(path) = path {
            self.coordinates.extend(path.points.iter().flat_map(|p| [p.x, p.y]));
            for bend in &path.bends {
                self.vertices.extend(pair(&bend.vertex));
                self.edges_to.extend(bend.edge_to.as_ref().map_or([-1; 2], pair));
                self.turns_left.push(bend.turns_left);
                self.kinds.extend(bend.sources.iter().map(|source| code(source.kind())));
                self.lines
                    .extend(bend.sources.iter().map(|source| source.number() as i64));
                self.line_offsets.push(self.lines.len() as i64);
            }
        }
        self.offsets.push((self.coordinates.len() / 2) as i64);
        self.bend_offsets.push(self.turns_left.len() as i64);
    }

    /// Returns the ten columns.
    pub fn into_columns(self) -> Vec<Column> {
        vec![
            Column::I64(self.offsets),
            Column::F64Rows(self.coordinates, 2),
            Column::Bool(self.certified),
            Column::I64(self.bend_offsets),
            Column::I64Rows(self.vertices, 2),
            Column::I64Rows(self.edges_to, 2),
            Column::Bool(self.turns_left),
            Column::I64(self.line_offsets),
            Column::U8(self.kinds),
            Column::I64(self.lines),
        ]
    }
}

/// Returns the tile and the index of a vertex.
pub fn pair(vertex: &Vertex) -> [i64; 2] {
    [i64::from(vertex.id.tile.0), i64::from(vertex.id.index.0)]
}

/// Returns the index of a kind in the Python part's list of words.
const fn code(kind: LineKind) -> u8 {
    match kind {
        LineKind::BreakLine => 0,
        LineKind::Wall => 1,
        LineKind::Obstacle => 2,
    }
}
