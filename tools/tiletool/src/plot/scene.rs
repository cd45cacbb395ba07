//! The points and edges of a file that is small enough to be drawn line by line.

use std::sync::Arc;

use anyhow::ensure;
use delaunay_tiles::geometry::{HalfEdge, Point, Rect, TriangleId};
use delaunay_tiles::store::{Directory, Tile, TileEdge, TileReader, Vertex};
use futures::TryStreamExt;

/// Maximum number of triangles, and of vertices, of a file that is drawn line by line.
pub const MAX_DRAWN: u64 = 60_000;

/// Numbered points, and the edges and triangles between them.
pub struct Scene {
    /// The points.
    pub points: Vec<Point>,
    /// The bounds of all vertices of the file.
    pub bounds: Rect,
    /// The edges, without the outline and constraints; each edge occurs once.
    pub edges: Vec<[u32; 2]>,
    /// The edges that are constraints but not walls.
    pub constraints: Vec<[u32; 2]>,
    /// The edges that are walls.
    pub walls: Vec<[u32; 2]>,
    /// The edges of the hull.
    pub outline: Vec<[u32; 2]>,
    /// The triangles that are in no tile's core.
    pub border: Vec<[u32; 3]>,
    /// The triangles in holes.
    pub holes: Vec<[u32; 3]>,
    /// The points that are sites.
    pub sites: Vec<u32>,
    /// The number of triangles.
    pub triangles: u64,
}

impl Scene {
    /// Reads the tiles one by one. `None` if the file is too large.
    ///
    /// # Errors
    /// Fails if a tile cannot be read, or if there are more triangles than the directory says.
    pub async fn gather(reader: &TileReader) -> anyhow::Result<Option<Self>> {
        let m = reader.metadata();
        match m.triangles <= MAX_DRAWN && m.vertices <= MAX_DRAWN {
            true => Ok(Some(Self::whole(reader).await?)),
            false => Ok(None),
        }
    }

    /// Creates a scene of the bounds of a file.
    fn empty(reader: &TileReader) -> Self {
        Self {
            points: Vec::new(),
            bounds: reader.metadata().bounds,
            edges: Vec::new(),
            constraints: Vec::new(),
            walls: Vec::new(),
            outline: Vec::new(),
            border: Vec::new(),
            holes: Vec::new(),
            sites: Vec::new(),
            triangles: 0,
        }
    }

    async fn whole(reader: &TileReader) -> anyhow::Result<Self> {
        let (mut scene, numbers) = (Self::empty(reader), VertexNumbers::new(reader).await?);
        let limit = reader.metadata().triangles as usize;
        let mut triangles = Vec::new();
        let mut tiles = reader.tiles();
        while let Some(tile) = tiles.try_next().await? {
            let first = scene.points.len() as u32;
            scene.sites.extend(tile.sites().map(|site| first + site.vertex.0));
            scene.points.extend(tile.points());
            // Without triangles, edges are stored on their own.
            for edge in tile.owned_constraints().filter(|_| tile.triangle_count() == 0) {
                let ends = numbers.of(&tile, tile.ends(edge))?;
                scene.lines(&tile, edge).push(ends);
            }
            for triangle in tile.owned_triangles() {
                let corners = numbers.of(&tile, tile.vertices(triangle))?;
                scene.add_triangle(&tile, triangle, corners);
                triangles.push(corners);
                ensure!(
                    triangles.len() <= limit,
                    "{}: tile {} has more triangles than the directory says",
                    reader.name(),
                    tile.id()
                );
            }
        }
        scene.join(&triangles);
        Ok(scene)
    }

    /// Returns the list of constraints that an edge of a tile belongs to.
    fn lines(&mut self, tile: &Tile, edge: impl Into<TileEdge>) -> &mut Vec<[u32; 2]> {
        match tile.is_wall(edge) {
            true => &mut self.walls,
            false => &mut self.constraints,
        }
    }

    /// Adds a triangle to the lists: its constraints, and itself if it is in a border or in a hole.
    fn add_triangle(&mut self, tile: &Tile, triangle: TriangleId, corners: [u32; 3]) {
        let half_edges = (0..3).map(|index| HalfEdge::new(triangle, index));
        for (half_edge, index) in half_edges
            .zip(0..)
            .filter(|&(half_edge, _)| tile.is_constraint(half_edge))
        {
            let [a, b] = [corners[index], corners[(index + 1) % 3]];
            self.lines(tile, half_edge).push([a.min(b), a.max(b)]);
        }
        if triangle.0 >= tile.core_triangle_count() {
            self.border.push(corners);
        }
        if tile.is_hole(triangle) {
            self.holes.push(corners);
        }
    }

    /// Computes the edges of all triangles, and removes duplicates.
    fn join(&mut self, triangles: &[[u32; 3]]) {
        self.triangles = triangles.len() as u64;
        (self.edges, self.outline) = edges_of(triangles);
        for lines in [&mut self.constraints, &mut self.walls] {
            lines.sort_unstable();
            lines.dedup();
            for edges in [&mut self.edges, &mut self.outline] {
                edges.retain(|edge| lines.binary_search(edge).is_err());
            }
        }
        self.sites.dedup();
    }
}

/// The numbers of all vertices, in the order of the tiles.
struct VertexNumbers<'a> {
    reader: &'a TileReader,
    directory: Arc<Directory>,
    /// The number of the first vertex of each tile.
    first_of: Vec<u32>,
}

impl<'a> VertexNumbers<'a> {
    async fn new(reader: &'a TileReader) -> anyhow::Result<Self> {
        let directory = reader.directory().await?;
        let mut first_of = vec![0; directory.tiles.len()];
        let mut next = 0;
        for id in directory.tile_ids() {
            first_of[id.0 as usize] = next;
            next += directory.tiles[id.0 as usize].vertices;
        }
        Ok(Self {
            reader,
            directory,
            first_of,
        })
    }

    /// Returns the numbers of vertices that a tile refers to.
    ///
    /// # Errors
    /// Fails if a vertex does not exist.
    fn of<const N: usize>(&self, tile: &Tile, vertices: [Vertex; N]) -> anyhow::Result<[u32; N]> {
        let mut numbers = [0; N];
        for (number, Vertex { id, .. }) in numbers.iter_mut().zip(vertices) {
            let entry = self.directory.tiles.get(id.tile.0 as usize);
            ensure!(
                entry.is_some_and(|entry| id.index.0 < entry.vertices),
                "{}: tile {} refers to vertex {id}, which does not exist",
                self.reader.name(),
                tile.id()
            );
            *number = self.first_of[id.tile.0 as usize] + id.index.0;
        }
        Ok(numbers)
    }
}

/// Returns each edge once: those between two triangles, and those of a single triangle.
fn edges_of(triangles: &[[u32; 3]]) -> (Vec<[u32; 2]>, Vec<[u32; 2]>) {
    let half_edges = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut half_edges: Vec<_> = half_edges.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    half_edges.sort_unstable();
    let (mut between, mut outer) = (Vec::new(), Vec::new());
    for same in half_edges.chunk_by(|a, b| a == b) {
        let edges = if same.len() == 1 { &mut outer } else { &mut between };
        edges.push(same[0]);
    }
    (between, outer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_edge_is_listed_once() {
        let (between, outer) = edges_of(&[[0, 1, 2], [2, 1, 3]]);
        assert_eq!(between, [[1, 2]]);
        assert_eq!(outer, [[0, 1], [0, 2], [1, 3], [2, 3]]);
    }
}
