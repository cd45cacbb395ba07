//! Triangles of several tiles that are taken out together, and others in their place.
//!
//! Corners and sides are numbered within the patch, once for all tiles, and what lies side by side in it is known by these numbers. So a
//! tile has little to look for: where its old triangles are, unless that was noted when they were found.

use foldhash::{HashMap, HashMapExt};

use crate::geometry::{HalfEdge, TriangleId};
use crate::mesh::Twin;
use crate::store::{TileId, Vertex, VertexId};

/// A patch: triangles on their way out and in. Side s of the triangle at place t is number 3 t + s, of old and of new ones.
#[derive(Default)]
pub(crate) struct Patch {
    pub(crate) vertices: Vec<Vertex>,
    numbers: HashMap<VertexId, u32>,
    pub(crate) old: Vec<OldTriangle>,
    pub(crate) new: Vec<NewTriangle>,
    /// The tiles of the vertices, and the triangles that each of them has, which are those with a corner in it.
    pub(crate) shares: Vec<TileShare>,
    /// Keeps its memory.
    pub(crate) positions: TilePositions,
}

/// A triangle on its way out.
pub(crate) struct OldTriangle {
    /// Their numbers.
    pub(crate) corners: [u32; 3],
    /// The bits of its sides.
    pub(crate) bits: u8,
    /// Its first side in a tile that has it. That number is good only until the tile leaves the cache.
    pub(crate) found: (TileId, HalfEdge),
    /// For each side the new side on the same edge; none inside the patch.
    pub(crate) replacement: [Option<HalfEdge>; 3],
}

/// A triangle on its way in.
pub(crate) struct NewTriangle {
    /// Their numbers.
    pub(crate) corners: [u32; 3],
    /// The bits of its sides.
    pub(crate) bits: u8,
    /// What lies across each side.
    pub(crate) twins: [PatchTwin; 3],
}

/// What lies across a side of a new triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PatchTwin {
    /// This side of a new triangle.
    New(HalfEdge),
    /// What lay across this side of an old one.
    Old(HalfEdge),
    /// The outside, where no old triangle had an edge.
    Hull,
}

/// What one tile has of a patch.
pub(crate) struct TileShare {
    pub(crate) tile: TileId,
    pub(crate) old: Vec<TriangleId>,
    pub(crate) new: Vec<TriangleId>,
}

/// Where a tile has the triangles of a patch.
#[derive(Default)]
pub(crate) struct TilePositions {
    /// Where each old triangle is, or was.
    pub(crate) old: Vec<Option<OldPosition>>,
    /// The place of each new one.
    pub(crate) new: Vec<Option<TriangleId>>,
}

/// Where a tile has an old triangle.
#[derive(Clone, Copy)]
pub(crate) struct OldPosition {
    /// Its first side.
    pub(crate) first: HalfEdge,
    /// What the tile says of the other side of its three.
    pub(crate) twins: [Twin; 3],
}

impl TilePositions {
    fn prepare(&mut self, patch: &Patch) {
        self.old.clear();
        self.old.resize(patch.old.len(), None);
        self.new.clear();
        self.new.resize(patch.new.len(), None);
    }

    /// Forgets the tile that it was for.
    pub(crate) fn clear(&mut self, share: &TileShare) {
        share.old.iter().for_each(|&old| self.old[old.index()] = None);
        share.new.iter().for_each(|&new| self.new[new.index()] = None);
    }

    /// What the tile says of the other side of an old half-edge of the patch, if it has its triangle.
    pub(crate) fn twin_of_old(&self, old: HalfEdge) -> Option<Twin> {
        let position = self.old[old.triangle().index()].as_ref()?;
        Some(position.twins[old.corner() as usize])
    }

    /// The tile's half-edge for a new one of the patch, if it has its triangle.
    pub(crate) fn half_edge_of_new(&self, new: HalfEdge) -> Option<HalfEdge> {
        let triangle = self.new[new.triangle().index()]?;
        Some(HalfEdge::new(triangle, new.corner()))
    }
}

impl TileShare {
    fn of(tile: TileId) -> Self {
        Self {
            tile,
            old: Vec::new(),
            new: Vec::new(),
        }
    }
}

impl OldTriangle {
    pub(crate) fn new(corners: [u32; 3], bits: u8, found: (TileId, HalfEdge)) -> Self {
        Self {
            corners,
            bits,
            found,
            replacement: [None; 3],
        }
    }
}

impl NewTriangle {
    /// Says what lies across one of its sides, and sets bits of it, which are in the places of a first side.
    pub(crate) fn set(&mut self, half_edge: HalfEdge, twin: PatchTwin, bits: u8) {
        self.twins[half_edge.corner() as usize] = twin;
        self.bits |= bits << half_edge.corner();
    }
}

impl Patch {
    pub(crate) fn clear(&mut self) {
        self.vertices.clear();
        self.numbers.clear();
        self.old.clear();
        self.new.clear();
    }

    /// The number of a vertex, and whether it is a new one.
    pub(crate) fn number(&mut self, vertex: Vertex) -> (u32, bool) {
        let next = self.vertices.len() as u32;
        let number = *self.numbers.entry(vertex.id).or_insert(next);
        if number == next {
            self.vertices.push(vertex);
        }
        (number, number == next)
    }

    pub(crate) fn ids(&self, corners: [u32; 3]) -> [VertexId; 3] {
        corners.map(|corner| self.vertices[corner as usize].id)
    }

    /// Finds out which new half-edge follows each old one, which tile has which triangles; and gives the seats for them.
    pub(crate) fn share_out(&mut self) -> TilePositions {
        self.find_replacements();
        self.find_shares();
        let mut positions = std::mem::take(&mut self.positions);
        positions.prepare(self);
        positions
    }

    fn find_replacements(&mut self) {
        for (new, number) in self.new.iter().zip((0..).map(TriangleId)) {
            for (twin, half_edge) in new.twins.iter().zip(HalfEdge::of_triangle(number)) {
                if let &PatchTwin::Old(old) = twin {
                    self.old[old.triangle().index()].replacement[old.corner() as usize] = Some(half_edge);
                }
            }
        }
    }

    /// Finds out which tile has which triangles.
    fn find_shares(&mut self) {
        let mut shares: Vec<TileShare> = Vec::new();
        let mut share_of: HashMap<TileId, usize> = HashMap::new();
        let mut of_vertex: Vec<usize> = Vec::with_capacity(self.vertices.len());
        for vertex in &self.vertices {
            let tile = vertex.id.tile;
            // Mostly that of the vertex before.
            let last = of_vertex.last().copied().filter(|&share| shares[share].tile == tile);
            let share = last.unwrap_or_else(|| {
                *share_of.entry(tile).or_insert_with(|| {
                    shares.push(TileShare::of(tile));
                    shares.len() - 1
                })
            });
            of_vertex.push(share);
        }
        let shares_of = |corners: [u32; 3]| {
            let [a, b, c] = corners.map(|corner| of_vertex[corner as usize]);
            [Some(a), (b != a).then_some(b), (c != a && c != b).then_some(c)]
                .into_iter()
                .flatten()
        };
        for (old, number) in self.old.iter().zip((0..).map(TriangleId)) {
            shares_of(old.corners).for_each(|share| shares[share].old.push(number));
        }
        for (new, number) in self.new.iter().zip((0..).map(TriangleId)) {
            shares_of(new.corners).for_each(|share| shares[share].new.push(number));
        }
        shares.sort_unstable_by_key(|share| share.tile);
        self.shares = shares;
    }
}
