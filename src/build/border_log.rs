//! The border log: triangles that became final above the leaves, until their tiles' borders are put together.

use super::node::SeamVertex;
use crate::store::TileId;

/// A triangle that was settled by a merge: crossing, or late. Corners counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub(super) struct LateTriangle(pub(super) [SeamVertex; 3]);

impl LateTriangle {
    /// The tiles that it stands in, each once.
    fn tiles(&self) -> impl Iterator<Item = TileId> {
        let [a, b, c] = self.0.map(|v| v.id.tile);
        [Some(a), (b != a).then_some(b), (c != a && c != b).then_some(c)]
            .into_iter()
            .flatten()
    }
}

/// All late triangles, found by tile.
#[derive(Debug)]
pub(super) struct BorderLog {
    triangles: Vec<LateTriangle>,
    /// Numbers of triangles, tile by tile.
    numbers: Vec<u32>,
    /// For each tile where its numbers start; and the end.
    starts: Vec<usize>,
}

impl BorderLog {
    pub(super) fn new(triangles: Vec<LateTriangle>, tiles: usize) -> Self {
        let mut starts = vec![0; tiles + 1];
        for tile in triangles.iter().flat_map(LateTriangle::tiles) {
            starts[tile.0 as usize + 1] += 1;
        }
        for tile in 0..tiles {
            starts[tile + 1] += starts[tile];
        }
        let mut ends = starts.clone();
        let mut numbers = vec![0; starts[tiles]];
        for (triangle, number) in triangles.iter().zip(0..) {
            for tile in triangle.tiles() {
                let end = &mut ends[tile.0 as usize];
                numbers[*end] = number;
                *end += 1;
            }
        }
        Self {
            triangles,
            numbers,
            starts,
        }
    }

    /// The late triangles with a vertex in a tile.
    pub(super) fn of_tile(&self, tile: TileId) -> impl Iterator<Item = &LateTriangle> {
        let tile = tile.0 as usize;
        let numbers = &self.numbers[self.starts[tile]..self.starts[tile + 1]];
        numbers.iter().map(|&number| &self.triangles[number as usize])
    }
}
