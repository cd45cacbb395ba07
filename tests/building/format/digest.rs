//! The digest as the page describes it, computed from what the page's reader reads.

use std::collections::HashSet;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::store::Digest;
use xxhash_rust::xxh3::xxh3_128;

use crate::format::components::from_smallest;
use crate::format::labels::Source;
use crate::format::reader::File;

/// Counts and sums, in the order of the directory's fields.
pub type Sums = [(u64, u128); 7];

const TRIANGLES: usize = 0;
const VERTICES: usize = 1;
const CONSTRAINT_EDGES: usize = 2;
const HOLES: usize = 3;
const VERTICES_WITH_Z: usize = 4;
const EDGE_SOURCES: usize = 5;
const SITES: usize = 6;

fn bytes(points: &[Point]) -> Vec<u8> {
    let numbers = points.iter().flat_map(|p| [p.x, p.y]);
    numbers.flat_map(f64::to_le_bytes).collect()
}

/// Returns the hash of an element that consists of points.
pub fn hash(points: &[Point]) -> u128 {
    xxh3_128(&bytes(points))
}

fn add(sums: &mut Sums, kind: usize, bytes: &[u8]) {
    let (count, sum) = &mut sums[kind];
    *count += 1;
    *sum = sum.wrapping_add(xxh3_128(bytes));
}

/// Computes the digest of a file.
pub fn sums(file: &File) -> Sums {
    let mut sums = Sums::default();
    for (number, tile) in file.tiles.iter().enumerate() {
        for (vertex, &p) in tile.points.iter().enumerate() {
            add(&mut sums, VERTICES, &bytes(&[p]));
            if let Some(z) = tile.z.get(vertex) {
                add(
                    &mut sums,
                    VERTICES_WITH_Z,
                    &[bytes(&[p]), z.to_le_bytes().to_vec()].concat(),
                );
            }
        }
        for (vertex, number, id) in &tile.sites {
            let id = match *id == number.to_string() {
                true => [vec![0], number.to_le_bytes().to_vec()].concat(),
                false => [&[1], id.as_bytes()].concat(),
            };
            add(&mut sums, SITES, &[bytes(&[tile.points[*vertex]]), id].concat());
        }
        let mut seen = HashSet::new();
        // The ends of an edge, and its sources as seen from the first end to the second.
        let mut edge = |ends: [(usize, Point); 2], sources: &[Source]| {
            let is_turned = ends[1].1.lex_cmp(ends[0].1).is_lt();
            let [first, second] = if is_turned { [ends[1], ends[0]] } else { ends };
            let edge = bytes(&[first.1, second.1]);
            if first.0 != number || !seen.insert(edge.clone()) {
                return;
            }
            add(&mut sums, CONSTRAINT_EDGES, &edge);
            for &(_, code, _) in sources {
                let code = if is_turned && code > 1 { 5 - code } else { code };
                add(
                    &mut sums,
                    EDGE_SOURCES,
                    &[&edge[..], &u64::from(code).to_le_bytes()].concat(),
                );
            }
        };
        for (triangle, corners) in tile.triangles().enumerate() {
            let corners = corners.map(|corner| tile.corner(file, corner));
            for side in (0..3).filter(|side| tile.constraints[3 * triangle + side]) {
                edge(
                    [corners[side], corners[(side + 1) % 3]],
                    &tile.sources(3 * triangle + side),
                );
            }
        }
        for (number, &(from, to)) in tile.edges.iter().enumerate() {
            edge(
                [from, to].map(|corner| tile.corner(file, corner)),
                &tile.sources_of_edge(number),
            );
        }
        for (triangle, corners) in tile.triangles().enumerate() {
            let corners = from_smallest(corners.map(|corner| tile.corner(file, corner)));
            if corners[0].0 == number {
                let corners = bytes(&corners.map(|corner| corner.1));
                add(&mut sums, TRIANGLES, &corners);
                if tile.component(triangle).is_hole() {
                    add(&mut sums, HOLES, &corners);
                }
            }
        }
    }
    sums
}

/// Returns a digest of the library in the order of the directory's fields.
pub fn of_library(digest: &Digest) -> Sums {
    [
        digest.triangles,
        digest.vertices,
        digest.constraint_edges,
        digest.holes,
        digest.vertices_with_z,
        digest.edge_sources,
        digest.sites,
    ]
    .map(|sum| (sum.count, sum.sum))
}
