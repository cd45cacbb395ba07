//! What there is to draw: points and edges, of all of a small file or of a sample of a large one.

use std::collections::BinaryHeap;

use anyhow::ensure;
use delaunay_tiles::geometry::{HalfEdge, Point, Rect};
use delaunay_tiles::mesh::{EngineKind, Triangulation};
use delaunay_tiles::store::{Tile, TileReader, VertexId};
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
        let mut scene = if m.triangles <= WHOLE && m.vertices <= WHOLE {
            Self::whole(reader).await?
        } else {
            Self::sample(reader).await?
        };
        // The picture's frame must not depend on which points a sample has.
        scene.bounds = m.bounds;
        Ok(scene)
    }

    async fn whole(reader: &TileReader) -> anyhow::Result<Self> {
        let directory = reader.directory();
        let first_of = directory.tiles.iter().scan(0u32, |next, entry| {
            let first = *next;
            *next += entry.vertices;
            Some(first)
        });
        let first_of: Vec<u32> = first_of.collect();
        let number = |tile: &Tile, id: VertexId| {
            let owner = id.tile.0 as usize;
            let known = directory.tiles.get(owner).is_some_and(|t| id.index.0 < t.vertices);
            ensure!(
                known,
                "{}: tile {} names vertex {id}, which is not there",
                reader.name(),
                tile.id()
            );
            Ok(first_of[owner] + id.index.0)
        };
        let limit = directory.metadata.triangles as usize;
        let mut points = Vec::new();
        let (mut triangles, mut border, mut holes) = (Vec::new(), Vec::new(), Vec::new());
        let (mut constraints, mut walls, mut sites) = (Vec::new(), Vec::new(), Vec::new());
        let mut tiles = reader.tiles();
        while let Some(tile) = tiles.try_next().await? {
            sites.extend(tile.sites().map(|site| points.len() as u32 + site.vertex.0));
            points.extend(tile.points());
            // Without triangles, edges stand alone.
            for edge in tile.owned_constraints().filter(|_| tile.triangle_count() == 0) {
                let [a, b] = tile.ends(edge).map(|vertex| number(&tile, vertex.id));
                match tile.is_wall(edge) {
                    true => walls.push([a?, b?]),
                    false => constraints.push([a?, b?]),
                }
            }
            for triangle in tile.owned_triangles() {
                let mut corners = [0; 3];
                for (corner, vertex) in corners.iter_mut().zip(tile.vertices(triangle)) {
                    *corner = number(&tile, vertex.id)?;
                }
                for side in (0..3).filter(|&s| tile.is_constraint(HalfEdge::new(triangle, s))) {
                    let [a, b] = [side, (side + 1) % 3].map(|s| corners[s as usize]);
                    let edges = match tile.is_wall(HalfEdge::new(triangle, side)) {
                        true => &mut walls,
                        false => &mut constraints,
                    };
                    edges.push([a.min(b), a.max(b)]);
                }
                triangles.push(corners);
                if triangle.0 >= tile.core_triangle_count() {
                    border.push(corners);
                }
                if tile.is_hole(triangle) {
                    holes.push(corners);
                }
                let owned = triangles.len() <= limit;
                ensure!(
                    owned,
                    "{}: tile {} has more triangles than the directory says",
                    reader.name(),
                    tile.id()
                );
            }
        }
        let (mut edges, mut outline) = edges_of(&triangles);
        for lines in [&mut constraints, &mut walls] {
            lines.sort_unstable();
            lines.dedup();
            for edges in [&mut edges, &mut outline] {
                edges.retain(|edge| lines.binary_search(edge).is_err());
            }
        }
        sites.dedup();
        Ok(Self {
            points,
            bounds: Rect::EMPTY,
            edges,
            constraints,
            walls,
            outline,
            border,
            holes,
            sites,
            triangles: triangles.len() as u64,
            thinned: false,
        })
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
            bounds: Rect::EMPTY,
            edges,
            constraints: Vec::new(),
            walls: Vec::new(),
            outline: Vec::new(),
            border: Vec::new(),
            holes: Vec::new(),
            sites: Vec::new(),
            triangles: mesh.triangles.len() as u64,
            thinned: true,
        })
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
