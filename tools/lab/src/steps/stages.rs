//! The steps of a build, as triangles: each cell alone, the merged triangulation, and that with
//! constraints.
//!
//! The cells and both triangulations are read from tile files. Each cell is triangulated by the
//! engine that builds use, and the certificate that builds use says which triangles are settled.

use std::cmp::Ordering;
use std::path::Path;

use delaunay_tiles::geometry::{HalfEdge, Point, Rect, disc_strictly_inside};
use delaunay_tiles::mesh::{EngineKind, Triangulation};
use delaunay_tiles::store::{TileId, TileReader};
use futures::TryStreamExt;

use super::ground::Ground;
use super::triangles::{Triangle, TriangleSet};

/// Maximum number of vertices of a tile: few tiles, so that each is seen.
const TILE_VERTICES: usize = 200;

/// A cell and its points, triangulated alone.
pub struct Leaf {
    pub id: TileId,
    pub cell: Rect,
    pub points: Vec<Point>,
    /// The triangles whose circumdiscs are inside the cell.
    pub settled: Vec<Triangle>,
    /// The other triangles.
    pub pending: Vec<Triangle>,
}

/// The merged triangulation: three groups of triangles, which have no triangle in common.
#[derive(Default)]
pub struct Merged {
    /// The triangles that were settled in a cell.
    pub settled: Vec<Triangle>,
    /// The triangles that were pending in a cell, and stay.
    pub confirmed: Vec<Triangle>,
    /// The triangles with corners in several cells.
    pub crossing: Vec<Triangle>,
}

/// A triangulation with constraints.
#[derive(Default)]
pub struct Constrained {
    pub triangles: Vec<Triangle>,
    /// The triangles that are in holes.
    pub holes: Vec<Triangle>,
    /// The edges that are break lines.
    pub breaks: Vec<[Point; 2]>,
    /// The edges that are walls.
    pub walls: Vec<[Point; 2]>,
    pub cells: Vec<(TileId, Rect)>,
}

/// All steps.
pub struct Stages {
    pub leaves: Vec<Leaf>,
    pub merged: Merged,
    pub constrained: Constrained,
    /// The triangles without constraints.
    pub delaunay: TriangleSet,
}

impl Stages {
    /// Builds the tile files in a scratch folder, and takes them apart.
    ///
    /// # Errors
    /// Fails if a build or a read fails.
    pub async fn build(ground: &Ground, scratch: &Path) -> anyhow::Result<Self> {
        let plain = ground.build(&scratch.join("plain.tiles"), TILE_VERTICES, false).await?;
        let with_lines = ground.build(&scratch.join("lines.tiles"), TILE_VERTICES, true).await?;
        let tree = plain.directory().await?.tree.clone();
        let mut leaves = Vec::new();
        for (id, cell) in tree.cells() {
            let points = plain.tile(id).await?.points().collect();
            leaves.push(Leaf::conquer(id, cell, points));
        }
        let settled: TriangleSet = leaves.iter().flat_map(|leaf| &leaf.settled).collect();
        let (mut merged, mut all) = (Merged::default(), Vec::new());
        let mut tiles = plain.tiles();
        while let Some(tile) = tiles.try_next().await? {
            for triangle in tile.owned_triangles().map(|id| tile.triangle_points(id)) {
                let [a, b, c] = triangle.map(|corner| tree.tile_at(corner));
                let group = match (a == b && b == c, settled.has(&triangle)) {
                    (false, _) => &mut merged.crossing,
                    (true, true) => &mut merged.settled,
                    (true, false) => &mut merged.confirmed,
                };
                group.push(triangle);
                all.push(triangle);
            }
        }
        Ok(Self {
            leaves,
            merged,
            constrained: Constrained::gather(&with_lines).await?,
            delaunay: all.iter().collect(),
        })
    }

    /// Returns the triangles that are there with constraints, but not without.
    pub fn changed(&self) -> Vec<Triangle> {
        let triangles = self.constrained.triangles.iter();
        triangles
            .filter(|triangle| !self.delaunay.has(triangle))
            .copied()
            .collect()
    }
}

impl Leaf {
    /// Triangulates the points of a cell.
    fn conquer(id: TileId, cell: Rect, points: Vec<Point>) -> Self {
        let mut mesh = Triangulation::default();
        EngineKind::default().create().triangulate(&points, &mut mesh);
        let corners = mesh
            .triangles
            .iter()
            .map(|corners| corners.map(|corner| points[corner as usize]));
        let (settled, pending) = corners.partition(|&[a, b, c]| disc_strictly_inside(a, b, c, cell));
        Self {
            id,
            cell,
            points,
            settled,
            pending,
        }
    }
}

impl Constrained {
    /// Reads the triangles and the constraints of a file.
    ///
    /// # Errors
    /// Fails if a tile cannot be read.
    pub async fn gather(reader: &TileReader) -> anyhow::Result<Self> {
        let mut this = Self {
            cells: reader.directory().await?.tree.cells(),
            ..Self::default()
        };
        let mut tiles = reader.tiles();
        while let Some(tile) = tiles.try_next().await? {
            for id in tile.owned_triangles() {
                let corners = tile.triangle_points(id);
                this.triangles.push(corners);
                if tile.is_hole(id) {
                    this.holes.push(corners);
                }
                for side in 0..3 {
                    let half_edge = HalfEdge::new(id, side);
                    let mut ends = [corners[side as usize], corners[(side as usize + 1) % 3]];
                    // Both triangles of an edge name it.
                    ends.sort_by(|a, b| a.lex_cmp(*b));
                    match (tile.is_constraint(half_edge), tile.is_wall(half_edge)) {
                        (_, true) => this.walls.push(ends),
                        (true, false) => this.breaks.push(ends),
                        _ => {}
                    }
                }
            }
        }
        for edges in [&mut this.breaks, &mut this.walls] {
            edges.sort_by(in_order);
            edges.dedup();
        }
        Ok(this)
    }
}

/// Compares edges by their ends.
fn in_order([a, b]: &[Point; 2], [c, d]: &[Point; 2]) -> Ordering {
    a.lex_cmp(*c).then(b.lex_cmp(*d))
}
