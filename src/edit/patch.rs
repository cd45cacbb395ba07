//! Triangles of several tiles that are removed together, and the triangles that replace them.
//!
//! Corners and half-edges are numbered within the patch, once for all tiles, and adjacency within
//! it refers to these numbers. So a tile has little to search for: only its old triangles, unless
//! their positions were recorded when they were found.

use foldhash::{HashMap, HashMapExt};

use crate::edit::vertex::EditVertex;
use crate::geometry::{HalfEdge, TriangleId};
use crate::mesh::Twin;
use crate::store::{TileId, VertexId};

/// A patch: triangles to remove and triangles to add. Half-edge s of triangle t has the number 3 t
/// + s, among the old as among the new triangles.
#[derive(Default)]
pub(crate) struct Patch {
    pub(crate) vertices: Vec<EditVertex>,
    numbers: HashMap<VertexId, u32>,
    pub(crate) old: Vec<OldTriangle>,
    pub(crate) new: Vec<NewTriangle>,
    /// The half-edges of old triangles that no new triangle replaces, so that the other sides of
    /// their edges are on the hull.
    pub(crate) bared: Vec<HalfEdge>,
    /// The tiles of the vertices, and the triangles of each tile: those with a corner in it.
    pub(crate) shares: Vec<TileShare>,
    /// A buffer, kept for its capacity.
    pub(crate) positions: TilePositions,
}

/// A triangle to remove.
pub(crate) struct OldTriangle {
    /// The numbers of its corners.
    pub(crate) corners: [u32; 3],
    /// The bits of its half-edges.
    pub(crate) bits: u8,
    /// Its first half-edge in a tile that has it. This number is valid only until the tile leaves
    /// the cache.
    pub(crate) found: (TileId, HalfEdge),
    /// For each half-edge, the new half-edge on the same edge; `None` inside the patch.
    pub(crate) replacement: [Option<HalfEdge>; 3],
}

/// A triangle to add.
pub(crate) struct NewTriangle {
    /// The numbers of its corners.
    pub(crate) corners: [u32; 3],
    /// The bits of its half-edges.
    pub(crate) bits: u8,
    /// The twin of each half-edge.
    pub(crate) twins: [PatchTwin; 3],
}

/// The twin of a half-edge of a new triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PatchTwin {
    /// This half-edge of a new triangle.
    New(HalfEdge),
    /// The former twin of this half-edge of an old triangle.
    Old(HalfEdge),
    /// The half-edge of a triangle that stays, on an edge that was on the hull.
    Stays,
    /// The outside: no old triangle had this edge.
    Hull,
}

/// The triangles of a patch that one tile has.
pub(crate) struct TileShare {
    pub(crate) tile: TileId,
    pub(crate) old: Vec<TriangleId>,
    pub(crate) new: Vec<TriangleId>,
}

/// The positions in a tile of the triangles of a patch.
#[derive(Default)]
pub(crate) struct TilePositions {
    /// The position of each old triangle, before its removal.
    pub(crate) old: Vec<Option<OldPosition>>,
    /// The position of each new triangle.
    pub(crate) new: Vec<Option<TriangleId>>,
    /// For new half-edges of the patch, the half-edges of triangles that stay.
    pub(crate) staying: Vec<(HalfEdge, HalfEdge)>,
}

/// The position of an old triangle in a tile.
#[derive(Clone, Copy)]
pub(crate) struct OldPosition {
    /// Its first half-edge.
    pub(crate) first: HalfEdge,
    /// The twins of its three half-edges in the tile.
    pub(crate) twins: [Twin; 3],
}

impl TilePositions {
    fn prepare(&mut self, patch: &Patch) {
        self.old.clear();
        self.old.resize(patch.old.len(), None);
        self.new.clear();
        self.new.resize(patch.new.len(), None);
        self.staying.clear();
    }

    /// Clears the positions of a tile's share.
    pub(crate) fn clear(&mut self, share: &TileShare) {
        share.old.iter().for_each(|&old| self.old[old.index()] = None);
        share.new.iter().for_each(|&new| self.new[new.index()] = None);
        self.staying.clear();
    }

    /// Returns the tile's half-edge of a triangle that stays, at a new half-edge of the patch.
    pub(crate) fn staying_at(&self, new: HalfEdge) -> Option<HalfEdge> {
        let found = self.staying.iter().find(|(at, _)| *at == new);
        found.map(|(_, half_edge)| *half_edge)
    }

    /// Returns the tile's twin of an old half-edge of the patch, if the tile has its triangle.
    pub(crate) fn twin_of_old(&self, old: HalfEdge) -> Option<Twin> {
        let position = self.old[old.triangle().index()].as_ref()?;
        Some(position.twins[old.corner() as usize])
    }

    /// Returns the tile's half-edge for a new half-edge of the patch, if the tile has its triangle.
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

    /// Returns whether nothing changes in the tile.
    pub(crate) fn is_empty(&self) -> bool {
        self.old.is_empty() && self.new.is_empty()
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
    /// Sets the twin of one of its half-edges, and adds bits to that half-edge. `bits` are those of
    /// a first half-edge.
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
        self.bared.clear();
    }

    /// Returns the number of a vertex, and whether the vertex is new to the patch.
    pub(crate) fn number(&mut self, vertex: EditVertex) -> (u32, bool) {
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

    /// Finds the new half-edge that replaces each old one, and the triangles of each tile. Returns
    /// the buffer for their positions.
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

    /// Finds the triangles of each tile.
    fn find_shares(&mut self) {
        let mut shares: Vec<TileShare> = Vec::new();
        let mut share_of: HashMap<TileId, usize> = HashMap::new();
        let mut of_vertex: Vec<usize> = Vec::with_capacity(self.vertices.len());
        for vertex in &self.vertices {
            let tile = vertex.id.tile;
            // Usually the share of the vertex before.
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
