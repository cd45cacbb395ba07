//! What there is to draw: points and edges, of all of a small file or of a sample of a large one.

use std::collections::BinaryHeap;

use anyhow::ensure;
use delaunay_tiles::geometry::{HalfEdge, Point, Rect, TriangleId};
use delaunay_tiles::mesh::{EngineKind, Triangulation};
use delaunay_tiles::store::{Tile, TileEdge, TileReader, Vertex};
use distributions::mix;
use futures::TryStreamExt;

/// The most triangles, and the most vertices, of a file that is drawn whole.
const WHOLE: u64 = 60_000;
/// Vertices of a sample.
const SAMPLE: usize = 10_000;

/// Points by number, and what joins them.
pub struct Scene {
    /// The points.
    pub points: Vec<Point>,
    /// Around all vertices of the file.
    pub bounds: Rect,
    /// Each edge once, without the outline and constraints.
    pub edges: Vec<[u32; 2]>,
    /// The edges that are constraints and no walls, if the file is drawn whole.
    pub constraints: Vec<[u32; 2]>,
    /// The edges that are walls, if the file is drawn whole.
    pub walls: Vec<[u32; 2]>,
    /// The edges of the hull, if the file is drawn whole.
    pub outline: Vec<[u32; 2]>,
    /// Triangles that stand in no core, if the file is drawn whole.
    pub border: Vec<[u32; 3]>,
    /// Triangles in holes, if the file is drawn whole.
    pub holes: Vec<[u32; 3]>,
    /// Points that are sites, if the file is drawn whole.
    pub sites: Vec<u32>,
    /// Triangles that the edges are of.
    pub triangles: u64,
    /// Whether this is a sample.
    pub thinned: bool,
}

impl Scene {
    /// Reads the tiles one after the other, and keeps a bounded part of them.
    pub async fn gather(reader: &TileReader) -> anyhow::Result<Self> {
        let m = &reader.directory().metadata;
        if m.triangles <= WHOLE && m.vertices <= WHOLE {
            Self::whole(reader).await
        } else {
            Self::sample(reader).await
        }
    }

    /// Without anything in it. The picture's frame must not depend on which points a sample has.
    fn empty(reader: &TileReader) -> Self {
        Self {
            points: Vec::new(),
            bounds: reader.directory().metadata.bounds,
            edges: Vec::new(),
            constraints: Vec::new(),
            walls: Vec::new(),
            outline: Vec::new(),
            border: Vec::new(),
            holes: Vec::new(),
            sites: Vec::new(),
            triangles: 0,
            thinned: false,
        }
    }

    async fn whole(reader: &TileReader) -> anyhow::Result<Self> {
        let (mut scene, numbers) = (Self::empty(reader), Numbers::new(reader));
        let limit = reader.directory().metadata.triangles as usize;
        let mut triangles = Vec::new();
        let mut tiles = reader.tiles();
        while let Some(tile) = tiles.try_next().await? {
            let first = scene.points.len() as u32;
            scene.sites.extend(tile.sites().map(|site| first + site.vertex.0));
            scene.points.extend(tile.points());
            // Without triangles, edges stand alone.
            for edge in tile.owned_constraints().filter(|_| tile.triangle_count() == 0) {
                let ends = numbers.of(&tile, tile.ends(edge))?;
                scene.lines(&tile, edge).push(ends);
            }
            for triangle in tile.owned_triangles() {
                let corners = numbers.of(&tile, tile.vertices(triangle))?;
                scene.take_triangle(&tile, triangle, corners);
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

    /// The list of constraints to which an edge of a tile belongs.
    fn lines(&mut self, tile: &Tile, edge: impl Into<TileEdge>) -> &mut Vec<[u32; 2]> {
        match tile.is_wall(edge) {
            true => &mut self.walls,
            false => &mut self.constraints,
        }
    }

    /// Takes what is to be told of a triangle: its constraints, whether it is of a border, and whether of a hole.
    fn take_triangle(&mut self, tile: &Tile, triangle: TriangleId, corners: [u32; 3]) {
        let sides = (0..3).map(|side| HalfEdge::new(triangle, side));
        for (side, place) in sides.zip(0..).filter(|&(side, _)| tile.is_constraint(side)) {
            let [a, b] = [corners[place], corners[(place + 1) % 3]];
            self.lines(tile, side).push([a.min(b), a.max(b)]);
        }
        if triangle.0 >= tile.core_triangle_count() {
            self.border.push(corners);
        }
        if tile.is_hole(triangle) {
            self.holes.push(corners);
        }
    }

    /// Sorts out the edges of all triangles, and what came twice.
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

    /// The vertices with the smallest hashes: a sample that depends on nothing but the set of vertices.
    async fn sample(reader: &TileReader) -> anyhow::Result<Self> {
        let mut smallest = BinaryHeap::with_capacity(SAMPLE + 1);
        let mut tiles = reader.tiles();
        while let Some(tile) = tiles.try_next().await? {
            for p in tile.points() {
                let p = p.normalized();
                let (x, y) = (p.x.to_bits(), p.y.to_bits());
                let hash = mixed(mixed(x).wrapping_add(y));
                if smallest.len() < SAMPLE {
                    smallest.push((hash, x, y));
                } else if smallest.peek().is_some_and(|largest| hash < largest.0) {
                    smallest.pop();
                    smallest.push((hash, x, y));
                }
            }
        }
        let mut points = smallest.into_sorted_vec();
        // A damaged file may have equal ones, which the engine must not see.
        points.dedup();
        let points = points
            .into_iter()
            .map(|(_, x, y)| Point::new(f64::from_bits(x), f64::from_bits(y)));
        let points: Vec<_> = points.collect();
        let mut mesh = Triangulation::default();
        EngineKind::Native.create().triangulate(&points, &mut mesh);
        let (mut edges, outline) = edges_of(&mesh.triangles);
        edges.extend(outline);
        Ok(Self {
            points,
            edges,
            triangles: mesh.triangles.len() as u64,
            thinned: true,
            ..Self::empty(reader)
        })
    }
}

/// The numbers of all vertices, tile by tile.
struct Numbers<'a> {
    reader: &'a TileReader,
    /// That of the first vertex of each tile.
    first_of: Vec<u32>,
}

impl<'a> Numbers<'a> {
    fn new(reader: &'a TileReader) -> Self {
        let first_of = reader.directory().tiles.iter().scan(0, |next, entry| {
            let first = *next;
            *next += entry.vertices;
            Some(first)
        });
        let first_of = first_of.collect();
        Self { reader, first_of }
    }

    /// The numbers of vertices that a tile names; fails if one is not there.
    fn of<const N: usize>(&self, tile: &Tile, vertices: [Vertex; N]) -> anyhow::Result<[u32; N]> {
        let mut numbers = [0; N];
        for (number, Vertex { id, .. }) in numbers.iter_mut().zip(vertices) {
            let entry = self.reader.directory().tiles.get(id.tile.0 as usize);
            ensure!(
                entry.is_some_and(|entry| id.index.0 < entry.vertices),
                "{}: tile {} names vertex {id}, which is not there",
                self.reader.name(),
                tile.id()
            );
            *number = self.first_of[id.tile.0 as usize] + id.index.0;
        }
        Ok(numbers)
    }
}

/// A step of SplitMix64 (Steele, Lea and Flood 2014).
fn mixed(bits: u64) -> u64 {
    mix(bits.wrapping_add(0x9e37_79b9_7f4a_7c15))
}

/// Each edge once: those between two triangles, and those of one.
fn edges_of(triangles: &[[u32; 3]]) -> (Vec<[u32; 2]>, Vec<[u32; 2]>) {
    let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut sides: Vec<_> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    sides.sort_unstable();
    let (mut between, mut outer) = (Vec::new(), Vec::new());
    for same in sides.chunk_by(|a, b| a == b) {
        let edges = if same.len() == 1 { &mut outer } else { &mut between };
        edges.push(same[0]);
    }
    (between, outer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_edge_is_there_once() {
        let (between, outer) = edges_of(&[[0, 1, 2], [2, 1, 3]]);
        assert_eq!(between, [[1, 2]]);
        assert_eq!(outer, [[0, 1], [0, 2], [1, 3], [2, 3]]);
    }
}
