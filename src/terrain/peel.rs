//! The triangles that are peeled off from the hull inwards, because they have a long edge.
//!
//! In: the tiles of a file and a length. Out: which triangles with a longer edge the outside reaches
//! through others of them, from edge to edge. It is a function of the triangulation alone.
//!
//! Long triangles that are connected within a tile are a *cluster*. Those that other tiles have too join
//! the clusters of several tiles, and nothing else does: two triangles that share an edge are both in
//! the tiles of its ends. A cluster without such triangles is *closed*: the tile says all of it. So only
//! a bit for each of the others is kept, and the clusters of a tile are found again when it is needed.
//!
//! ```text
//! tile ──▶ clusters ──▶ joined with those of other tiles ──▶ bits
//! tile ──▶ clusters, bits ──▶ its triangles that are peeled
//! ```

use std::collections::hash_map::Entry;

use foldhash::{HashMap, HashMapExt};
use futures::stream::StreamExt;

use crate::collections::union_find::UnionFind;
use crate::geometry::{HalfEdge, Point, TriangleId};
use crate::memory::FileShares;
use crate::mesh::Twin;
use crate::store::{Needs, PassReader, ReadError, Tile, TileId, TileInPass, VertexId};

/// A bit for each number from 0.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bits(Vec<u64>);

impl Bits {
    fn new(numbers: usize) -> Self {
        Self(vec![0; numbers.div_ceil(64)])
    }

    fn set(&mut self, number: usize) {
        self.0[number / 64] |= 1 << (number % 64);
    }

    /// Returns whether a bit is set.
    pub(crate) fn has(&self, number: usize) -> bool {
        self.0
            .get(number / 64)
            .is_some_and(|word| word >> (number % 64) & 1 != 0)
    }

    fn is_empty(&self) -> bool {
        self.0.iter().all(|&word| word == 0)
    }
}

/// Returns whether a triangle of a tile has an edge that is longer than `most`.
pub(crate) fn is_long(tile: &Tile, triangle: TriangleId, most: f64) -> bool {
    let [a, b, c] = tile.triangle_points(triangle);
    !([(a, b), (b, c), (c, a)].into_iter().all(|(p, q)| length(p, q) <= most))
}

/// Returns the length of an edge; the same for both directions.
fn length(a: Point, b: Point) -> f64 {
    (a.x - b.x).hypot(a.y - b.y)
}

/// The clusters of a tile. The least triangle of a cluster stands for it.
struct Clusters {
    /// The triangles that have a long edge.
    long: Bits,
    sets: UnionFind,
    /// The clusters that have an edge of the hull.
    outer: Bits,
    /// The clusters that are not closed, in order.
    open: Vec<u32>,
}

impl Clusters {
    /// Finds the clusters of a tile; `None` if it has none.
    fn of(tile: &Tile, most: f64) -> Option<Self> {
        let triangles = tile.triangle_count();
        let mut long = Bits::new(triangles as usize);
        let is_long = |&triangle: &TriangleId| is_long(tile, triangle, most);
        for triangle in tile.triangle_ids().filter(is_long) {
            long.set(triangle.index());
        }
        if long.is_empty() {
            return None;
        }
        let mut sets = UnionFind::new(triangles);
        let mut on_hull = Bits::new(triangles as usize);
        for triangle in tile.triangle_ids().filter(|t| long.has(t.index())) {
            for half_edge in HalfEdge::of_triangle(triangle) {
                match tile.twin(half_edge) {
                    Twin::HalfEdge(twin) if long.has(twin.triangle().index()) => {
                        sets.union(triangle.0, twin.triangle().0);
                    }
                    Twin::Hull => on_hull.set(triangle.index()),
                    // On the hull or not: the tiles of the ends of the edge know.
                    Twin::HalfEdge(_) | Twin::Elsewhere => {}
                }
            }
        }
        let mut outer = Bits::new(triangles as usize);
        for triangle in (0..triangles).filter(|&t| on_hull.has(t as usize)) {
            outer.set(sets.find(triangle) as usize);
        }
        let shared = tile.border_triangle_ids().filter(|t| long.has(t.index()));
        let mut open: Vec<u32> = shared.map(|triangle| sets.find(triangle.0)).collect();
        open.sort_unstable();
        open.dedup();
        Some(Self {
            long,
            sets,
            outer,
            open,
        })
    }

    /// Returns the cluster of a long triangle, and its number among the open ones.
    fn cluster(&mut self, triangle: TriangleId) -> (u32, Option<u32>) {
        let cluster = self.sets.find(triangle.0);
        let number = self.open.binary_search(&cluster).ok();
        (cluster, number.map(|number| number as u32))
    }

    /// Returns the memory for the clusters of the largest tile, and for the triangles that it shares, in
    /// bytes.
    fn memory(reader: &PassReader) -> [u64; 2] {
        let most = |of: fn(u64, u64) -> u64| {
            let tiles = reader.directory().tiles.iter();
            let numbers = tiles.map(|tile| of(tile.core_triangles.into(), tile.border_triangles.into()));
            numbers.max().unwrap_or(0)
        };
        let (all, shared) = (most(|core, border| core + border), most(|_, border| border));
        let number = size_of::<u32>() as u64;
        // Four bits: the three of a search, and the result. Lists grow.
        [
            all * number + all.div_ceil(2) + 3 * shared * number,
            shared * size_of::<Shared>() as u64,
        ]
    }
}

/// A triangle that several tiles have: its vertices in order, and the number of its cluster in a tile.
type Shared = ([VertexId; 3], u32);

/// The open clusters of a tile.
struct Found {
    tile: TileId,
    /// For each of them, whether it has an edge of the hull.
    is_outer: Vec<bool>,
    shared: Vec<Shared>,
}

impl Found {
    fn in_tile(tile: &Tile, most: f64) -> Self {
        let mut found = Self {
            tile: tile.id(),
            is_outer: Vec::new(),
            shared: Vec::new(),
        };
        let Some(mut clusters) = Clusters::of(tile, most) else {
            return found;
        };
        let is_outer = clusters
            .open
            .iter()
            .map(|&cluster| clusters.outer.has(cluster as usize));
        found.is_outer = is_outer.collect();
        let long = tile.border_triangle_ids().filter(|t| clusters.long.has(t.index()));
        found.shared = Vec::with_capacity(long.count());
        for triangle in tile.border_triangle_ids() {
            if clusters.long.has(triangle.index())
                && let (_, Some(number)) = clusters.cluster(triangle)
            {
                let mut vertices = tile.vertices(triangle).map(|vertex| vertex.id);
                vertices.sort_unstable();
                found.shared.push((vertices, number));
            }
        }
        found
    }
}

/// A triangle that further tiles have.
struct Waiting {
    cluster: u32,
    /// The number of these tiles.
    tiles: u32,
}

/// The open clusters of some tiles, numbered in the order in which the tiles come.
struct Joining {
    sets: UnionFind,
    /// Whether a cluster has an edge of the hull.
    is_outer: Vec<bool>,
    /// The number of the first cluster of each tile.
    starts: Vec<u32>,
    waiting: HashMap<[VertexId; 3], Waiting>,
}

impl Joining {
    fn new(tiles: usize) -> Self {
        Self {
            sets: UnionFind::new(0),
            is_outer: Vec::new(),
            starts: vec![0; tiles],
            waiting: HashMap::new(),
        }
    }

    /// Adds the clusters of a tile. Returns whether there are not too many.
    fn take(&mut self, found: Found) -> bool {
        let start = self.is_outer.len();
        if u32::try_from(start + found.is_outer.len()).is_err() {
            return false;
        }
        let start = start as u32;
        self.starts[found.tile.0 as usize] = start;
        self.sets.grow(found.is_outer.len() as u32);
        self.is_outer.extend(found.is_outer);
        for (vertices, number) in found.shared {
            let cluster = start + number;
            match self.waiting.entry(vertices) {
                Entry::Occupied(mut entry) => {
                    let other = entry.get_mut();
                    self.sets.union(cluster, other.cluster);
                    other.tiles -= 1;
                    if other.tiles == 0 {
                        entry.remove();
                    }
                }
                Entry::Vacant(entry) => {
                    let pairs = vertices.windows(2);
                    let tiles = pairs.filter(|pair| pair[0].tile != pair[1].tile).count() as u32;
                    if tiles > 0 {
                        entry.insert(Waiting { cluster, tiles });
                    }
                }
            }
        }
        true
    }

    /// Returns the memory that is taken, and that may be taken when another tile is added.
    fn bytes(&self) -> u64 {
        let entry = size_of::<([VertexId; 3], Waiting)>() + 1;
        let cluster = size_of::<u32>() + size_of::<bool>();
        // What grows is in memory twice, the new one with twice the room.
        3 * (self.waiting.capacity() / 7 * 8 * entry + self.is_outer.len() * cluster) as u64
    }

    /// Returns a triangle that is not in all tiles that should have it.
    fn missing(&self) -> Option<[VertexId; 3]> {
        self.waiting.keys().min().copied()
    }

    /// Returns the number of the first cluster of each tile, and the clusters that the outside reaches.
    fn finish(mut self) -> (Vec<u32>, Bits) {
        let mut peeled = Bits::new(self.is_outer.len());
        let clusters = 0..self.is_outer.len();
        for cluster in clusters.clone().filter(|&cluster| self.is_outer[cluster]) {
            peeled.set(self.sets.find(cluster as u32) as usize);
        }
        for cluster in clusters {
            if peeled.has(self.sets.find(cluster as u32) as usize) {
                peeled.set(cluster);
            }
        }
        (self.starts, peeled)
    }
}

/// The triangles of a file that are peeled.
#[derive(Debug)]
pub(crate) struct Peeled {
    /// The length.
    most: f64,
    /// The number of the first open cluster of each tile.
    starts: Vec<u32>,
    /// The open clusters that are peeled.
    clusters: Bits,
    /// The memory to find the triangles of a tile, in bytes.
    per_thread: u64,
}

impl Peeled {
    /// Finds the triangles that are peeled because they have an edge longer than `most`. Reads all tiles,
    /// and calls `advance` after each.
    ///
    /// # Errors
    /// Fails if a tile cannot be read, if tiles contradict each other, or if the memory that the reader
    /// may use does not suffice.
    pub(crate) async fn of(
        reader: &PassReader,
        most: f64,
        mut advance: impl FnMut() + Send,
    ) -> Result<Self, ReadError> {
        let directory = reader.directory();
        let [per_thread, of_result] = Clusters::memory(reader);
        let starts = (directory.tiles.len() * size_of::<u32>()) as u64;
        let needs = |fixed: u64| Needs {
            // A result that is being joined, and one of each thread that waits.
            fixed: fixed + starts + of_result,
            per_thread: per_thread + of_result,
            per_vertex: 0,
        };
        let least = needs(0).least(directory);
        // The other half of what is left is for further tiles.
        let share = FileShares(reader.memory()).pass();
        let allowed = share.map(|share| share.saturating_sub(least) / 2);
        let work = move |tile: TileInPass| Found::in_tile(&tile, most);
        let mut tiles = reader.for_each_tile(needs(allowed.unwrap_or(0)), work)?;
        let mut joining = Joining::new(directory.tiles.len());
        while let Some(found) = tiles.next().await {
            let found = found?;
            let id = found.tile;
            if !joining.take(found) {
                return Err(reader.damaged(
                    id,
                    "with it, there are more clusters of long triangles than have numbers",
                ));
            }
            let used = joining.bytes();
            if allowed.is_some_and(|allowed| used > allowed) {
                // More may follow.
                let needed = least + 2 * 2 * used;
                return Err(reader.too_little_memory(needed + needed / 15));
            }
            advance();
        }
        if let Some([a, b, c]) = joining.missing() {
            let reason = format!("its triangle {a}, {b}, {c} is not in all tiles that have a corner of it");
            return Err(reader.damaged(a.tile, reason));
        }
        let (starts, clusters) = joining.finish();
        Ok(Self {
            most,
            starts,
            clusters,
            per_thread,
        })
    }

    /// Returns the memory that a pass needs for it.
    pub(crate) fn needs(&self) -> Needs {
        Needs {
            fixed: (size_of_val(&*self.starts) + size_of_val(&*self.clusters.0)) as u64,
            per_thread: self.per_thread,
            per_vertex: 0,
        }
    }

    /// Returns the triangles of a tile that are peeled; `None` if there are none.
    pub(crate) fn in_tile(&self, tile: &Tile) -> Option<Bits> {
        let mut clusters = Clusters::of(tile, self.most)?;
        let start = self.starts.get(tile.id().0 as usize).map_or(0, |&start| start as usize);
        let mut peeled = Bits::new(tile.triangle_count() as usize);
        for triangle in tile.triangle_ids() {
            if clusters.long.has(triangle.index())
                && match clusters.cluster(triangle) {
                    (_, Some(number)) => self.clusters.has(start + number as usize),
                    (cluster, None) => clusters.outer.has(cluster as usize),
                }
            {
                peeled.set(triangle.index());
            }
        }
        Some(peeled)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::VertexIndex;

    fn vertex(tile: u32) -> VertexId {
        VertexId {
            tile: TileId(tile),
            index: VertexIndex(7),
        }
    }

    /// Three tiles with a triangle in common; the first two share another one, whose third corner is of
    /// the second tile too, and the last has a cluster that it shares with nobody.
    #[test]
    fn clusters_join_and_a_tile_without_its_triangle_is_found() {
        let all = [0, 1, 2].map(vertex);
        let pair = [
            vertex(0),
            vertex(1),
            VertexId {
                index: VertexIndex(9),
                ..vertex(1)
            },
        ];
        let tiles = [
            (vec![false, false], vec![(all, 0), (pair, 1)]),
            (vec![false, true], vec![(pair, 0), (all, 1)]),
            (vec![false, false], vec![(all, 1)]),
        ];
        for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
            let mut joining = Joining::new(3);
            for tile in order {
                assert!(tile == order[0] || joining.missing().is_some());
                let (is_outer, shared) = tiles[tile].clone();
                let tile = TileId(tile as u32);
                assert!(joining.take(Found { tile, is_outer, shared }));
                assert!(joining.bytes() > 0);
            }
            assert_eq!(joining.missing(), None);
            let (starts, peeled) = joining.finish();
            let of_tile = |tile: usize| [0, 1].map(|number| peeled.has(starts[tile] as usize + number));
            assert_eq!([0, 1, 2].map(of_tile), [[true, false], [false, true], [false, true]]);
        }
    }
}
