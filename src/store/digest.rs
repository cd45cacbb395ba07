//! The digest identifies a triangulation, independent of how it is cut into tiles.
//!
//! A digest contains one sum modulo 2¹²⁸ for each of triangles, vertices, constraint edges and
//! holes. Each sum adds one hash per element. The hash is XXH3 (128 bits, seed 0) of the f64 bits
//! of the coordinates, little-endian: x and y of each corner, counter-clockwise, starting with the
//! lexicographically smallest corner.

use std::fmt;
use std::ops::AddAssign;

use futures::stream::TryStreamExt;
use xxhash_rust::xxh3::xxh3_128;

use crate::geometry::Point;
use crate::store::error::ReadError;
use crate::store::format::tile::Tile;
use crate::store::pass::Needs;
use crate::store::reader::TileReader;

/// A number of elements and the sum of their hashes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DigestSum {
    /// The number of elements.
    pub count: u64,
    /// The sum of the hashes, modulo 2¹²⁸.
    pub sum: u128,
}

impl DigestSum {
    fn add(&mut self, bytes: &[u8]) {
        self.count += 1;
        self.sum = self.sum.wrapping_add(xxh3_128(bytes));
    }
}

impl AddAssign for DigestSum {
    fn add_assign(&mut self, other: Self) {
        self.count += other.count;
        self.sum = self.sum.wrapping_add(other.sum);
    }
}

/// The digest of a triangulation.
///
/// Its [`Display`](fmt::Display) output has one line each for triangles, vertices, constraint edges
/// and holes, with the name, the count, and the sum in hexadecimal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Digest {
    /// All triangles.
    pub triangles: DigestSum,
    /// All vertices.
    pub vertices: DigestSum,
    /// Constraint edges. Each is hashed from its lexicographically smaller end to its larger end.
    pub constraint_edges: DigestSum,
    /// Triangles in holes, with the same hashes as in `triangles`.
    pub holes: DigestSum,
}

impl Digest {
    /// Adds a vertex.
    pub fn add_vertex(&mut self, p: Point) {
        self.vertices.add(point_bytes([p]).as_flattened());
    }

    /// Adds a triangle. Its `corners` must be in counter-clockwise order.
    pub fn add_triangle(&mut self, corners: [Point; 3]) {
        self.triangles.add(point_bytes(smallest_first(corners)).as_flattened());
    }

    /// Adds a triangle to the holes. It must be added with [`add_triangle`](Self::add_triangle)
    /// too.
    pub fn add_hole(&mut self, corners: [Point; 3]) {
        self.holes.add(point_bytes(smallest_first(corners)).as_flattened());
    }

    /// Adds a constraint edge.
    pub fn add_constraint_edge(&mut self, [a, b]: [Point; 2]) {
        let ends = if a.lex_cmp(b).is_lt() { [a, b] } else { [b, a] };
        self.constraint_edges.add(point_bytes(ends).as_flattened());
    }

    fn add_tile(&mut self, tile: &Tile) {
        tile.points().for_each(|p| self.add_vertex(p));
        for triangle in tile.owned_triangles() {
            self.add_triangle(tile.triangle_points(triangle));
            if tile.is_hole(triangle) {
                self.add_hole(tile.triangle_points(triangle));
            }
        }
        for edge in tile.owned_constraints() {
            self.add_constraint_edge(tile.ends(edge).map(|end| end.point));
        }
    }
}

/// Rotates the corners so that the lexicographically smallest one comes first.
fn smallest_first([a, b, c]: [Point; 3]) -> [Point; 3] {
    if a.lex_cmp(b).is_lt() && a.lex_cmp(c).is_lt() {
        [a, b, c]
    } else if b.lex_cmp(c).is_lt() {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

fn point_bytes<const N: usize>(points: [Point; N]) -> [[u8; 16]; N] {
    points.map(|p| {
        let mut bytes = [0; 16];
        bytes[..8].copy_from_slice(&p.x.to_le_bytes());
        bytes[8..].copy_from_slice(&p.y.to_le_bytes());
        bytes
    })
}

impl AddAssign for Digest {
    fn add_assign(&mut self, other: Self) {
        self.triangles += other.triangles;
        self.vertices += other.vertices;
        self.constraint_edges += other.constraint_edges;
        self.holes += other.holes;
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = |name, DigestSum { count, sum }| format!("{name:<16} {count:>12} {sum:032x}");
        writeln!(f, "{}", line("triangles", self.triangles))?;
        writeln!(f, "{}", line("vertices", self.vertices))?;
        writeln!(f, "{}", line("constraint-edges", self.constraint_edges))?;
        write!(f, "{}", line("holes", self.holes))
    }
}

impl TileReader {
    /// Computes the digest of the whole file in one pass. Must be awaited within a tokio runtime.
    ///
    /// # Errors
    ///
    /// Returns an error if a tile cannot be read, or does not fit into the memory that the reader
    /// may use.
    pub async fn digest(&self) -> Result<Digest, ReadError> {
        let passes = self.for_passes().await?;
        let digests = passes.for_each_tile(Needs::default(), |tile| {
            let mut digest = Digest::default();
            digest.add_tile(&tile);
            digest
        })?;
        let sum = |mut sum: Digest, digest| async move {
            sum += digest;
            Ok(sum)
        };
        digests.try_fold(Digest::default(), sum).await
    }
}
