//! Encodes a changed tile as a core and a border.
//!
//! Triangles whose corners are all the tile's own go to the core, the others to the border. So a
//! triangle that was late when the tile was first written may be in the core now.

use bytes::Bytes;

use crate::edit::tile::parts::TileParts;
use crate::edit::tile::twin::PackedTwin;
use crate::edit::tile::{EditTile, TriangleOrder};
use crate::edit::vertex::EditVertex;
use crate::geometry::{HalfEdge, PackedHalfEdge, Rect, TriangleId};
use crate::io::Buffers;
use crate::mesh::{Topology, Twin};
use crate::store::{BorderDraft, CoreContent, Digest, DigestSum, Extent, LinePart, TablePlace, TileEntry};

/// The numbers of triangles and corners in the written tile.
pub(crate) struct Numbering {
    order: TriangleOrder,
    /// The number of the triangle at each position that has one.
    triangles: Vec<TriangleId>,
    /// The first `kept` triangles have their positions as numbers: after most edits, almost all.
    kept: usize,
    /// The vertices of other tiles that are corners.
    foreign: Vec<EditVertex>,
    /// The number of each corner.
    corners: Vec<u32>,
}

impl Numbering {
    pub(crate) fn of(tile: &EditTile, order: TriangleOrder) -> Self {
        let mut triangles = vec![TriangleId(0); tile.triangles.len()];
        for (triangle, number) in order.core.iter().zip((0..).map(TriangleId)) {
            triangles[triangle.index()] = number;
        }
        for (triangle, number) in order.border.iter().zip((order.core.len() as u32..).map(TriangleId)) {
            triangles[triangle.index()] = number;
        }
        let numbered = order.core.iter().zip((0..).map(TriangleId));
        let kept = numbered.take_while(|&(&triangle, number)| triangle == number).count();
        let (foreign, corners) = tile.foreign_in_order(&order.border);
        Self {
            order,
            triangles,
            kept,
            foreign,
            corners,
        }
    }

    #[inline]
    fn half_edge(&self, half_edge: HalfEdge) -> HalfEdge {
        HalfEdge::new(self.triangles[half_edge.triangle().index()], half_edge.corner())
    }

    /// Returns the number of a half-edge, if it is in the core.
    #[inline]
    fn in_core(&self, half_edge: HalfEdge) -> Option<HalfEdge> {
        if half_edge.index() < 3 * self.kept {
            return Some(half_edge);
        }
        let triangle = self.triangles[half_edge.triangle().index()];
        (triangle.index() < self.order.core.len()).then(|| HalfEdge::new(triangle, half_edge.corner()))
    }
}

impl EditTile {
    /// Encodes the core. The parts become components.
    pub(crate) fn encode_core(
        &self,
        numbering: &Numbering,
        parts: &TileParts,
        generation: u32,
        buffers: &Buffers,
    ) -> Bytes {
        let triangles = &numbering.order.core;
        let in_core = |twin: PackedTwin| match twin.get() {
            Twin::HalfEdge(twin) => numbering.in_core(twin).into(),
            Twin::Hull | Twin::Elsewhere => PackedHalfEdge::NONE,
        };
        let content = CoreContent {
            points: &self.points,
            z: &self.z,
            records: &self.records,
            input_points: &self.input_points,
            // All corners are the tile's own.
            triangles: triangles
                .iter()
                .map(|triangle| self.triangles[triangle.index()].map(|corner| corner.0)),
            neighbours: triangles
                .iter()
                .map(|triangle| self.twins[triangle.index()].map(in_core)),
            constraints: &self.bits_of(triangles),
            components: &components(parts, triangles),
            edge_sources: &self.edge_sources(numbering, true),
            sites: &self.sites,
            site_ids: &self.site_ids,
        };
        content.encode(self.id, generation, buffers)
    }

    /// Encodes the border. The parts become components.
    pub(crate) fn encode_border(
        &self,
        numbering: &Numbering,
        parts: &TileParts,
        generation: u32,
        buffers: &Buffers,
    ) -> Bytes {
        self.border_draft(numbering, parts).encode(self.id, generation, buffers)
    }

    fn border_draft(&self, numbering: &Numbering, parts: &TileParts) -> BorderDraft {
        let triangles = &numbering.order.border;
        let twin = |half_edge: HalfEdge| match self.twin(half_edge) {
            Twin::HalfEdge(twin) => Twin::HalfEdge(numbering.half_edge(twin)),
            twin => twin,
        };
        BorderDraft {
            vertices: self.points.len() as u32,
            core_triangles: numbering.order.core.len() as u32,
            foreign: numbering.foreign.iter().map(|v| (v.id, v.point)).collect(),
            foreign_z: (!self.z.is_empty()).then(|| numbering.foreign.iter().map(|v| v.z).collect()),
            triangles: triangles
                .iter()
                .map(|&triangle| self.triangles[triangle.index()].map(|corner| numbering.corners[corner.index()]))
                .collect(),
            neighbours: triangles
                .iter()
                .map(|&triangle| HalfEdge::of_triangle(triangle).map(twin))
                .collect(),
            core_links: self.core_links(numbering),
            vertex_sides: self.vertex_sides(numbering),
            constraints: self.bits_of(triangles),
            components: components(parts, triangles),
            edge_sources: self.edge_sources(numbering, false),
            // Files without triangles are not edited.
            edges: Vec::new(),
        }
    }

    /// Returns the bits of triangles; nothing if none is set.
    fn bits_of(&self, triangles: &[TriangleId]) -> Vec<u8> {
        let mut bits: Vec<u8> = triangles.iter().map(|&triangle| self.bits[triangle.index()]).collect();
        if bits.iter().all(|&bits| bits == 0) {
            bits.clear();
        }
        bits
    }

    /// Returns the pairs of a half-edge of the core and its twin in the border, in order.
    fn core_links(&self, numbering: &Numbering) -> Vec<(u32, u32)> {
        let border = numbering.order.border.iter();
        let half_edges = border.flat_map(|&triangle| HalfEdge::of_triangle(triangle));
        let links = half_edges.filter_map(|half_edge| {
            let twin = numbering.in_core(self.twin(half_edge).half_edge()?)?;
            Some((twin.0, numbering.half_edge(half_edge).0))
        });
        let mut links: Vec<(u32, u32)> = links.collect();
        links.sort_unstable();
        links
    }

    /// Returns a half-edge of the border that leaves each vertex of the tile that is a corner of the
    /// border but not of the core, by vertex.
    fn vertex_sides(&self, numbering: &Numbering) -> Vec<(u32, u32)> {
        let own = self.points.len();
        let is_in_core = |half_edge: HalfEdge| numbering.in_core(half_edge).is_some();
        let mut is_done = vec![false; own];
        let mut sides = Vec::new();
        for &triangle in &numbering.order.border {
            for half_edge in HalfEdge::of_triangle(triangle) {
                let corner = self.origin(half_edge);
                if let Some(is_done) = is_done.get_mut(corner.index())
                    && !std::mem::replace(is_done, true)
                    && !self.around(corner).any(is_in_core)
                {
                    sides.push((corner.0, numbering.half_edge(half_edge).0));
                }
            }
        }
        sides.sort_unstable();
        sides
    }

    /// Returns the vertices of other tiles that border triangles have, by id; and the number of
    /// each corner among the tile's own and these.
    fn foreign_in_order(&self, of_border: &[TriangleId]) -> (Vec<EditVertex>, Vec<u32>) {
        let own = self.points.len();
        let mut is_used = vec![false; self.foreign.len()];
        for &corner in of_border.iter().flat_map(|&triangle| &self.triangles[triangle.index()]) {
            if let Some(index) = corner.index().checked_sub(own) {
                is_used[index] = true;
            }
        }
        let mut used: Vec<usize> = (0..self.foreign.len()).filter(|&index| is_used[index]).collect();
        used.sort_unstable_by_key(|&index| self.foreign[index].id);
        let mut corner_now: Vec<u32> = (0..(own + self.foreign.len()) as u32).collect();
        for (&index, number) in used.iter().zip(own as u32..) {
            corner_now[own + index] = number;
        }
        let foreign = used.iter().map(|&index| self.foreign[index]);
        (foreign.collect(), corner_now)
    }

    /// Returns the box around the tile's vertices and the corners of the triangles that belong to
    /// it.
    fn bounds(&self, border: &[TriangleId]) -> Rect {
        let owned = border.iter().filter(|&&triangle| self.owns(triangle));
        let corners = owned.flat_map(|&triangle| self.corner_points(triangle));
        // The corners of all other triangles are vertices of the tile.
        Rect::around(self.points.iter().copied().chain(corners))
    }

    /// Returns the sources of the edges that belong to the tile, in order: of those between two
    /// triangles of the core, or of all others.
    fn edge_sources(&self, numbering: &Numbering, in_core: bool) -> Vec<(u32, LinePart)> {
        let mut all = Vec::new();
        for (half_edge, sources) in self.owned_constraints() {
            let twin = self.twin(half_edge).half_edge();
            let [this, other] = [half_edge, twin.unwrap_or(half_edge)].map(|half_edge| numbering.half_edge(half_edge));
            let is_in_core = twin.is_some() && this.max(other).triangle().index() < numbering.order.core.len();
            if is_in_core != in_core {
                continue;
            }
            // They are kept as seen from the smaller corner, and written as seen along the smaller
            // half-edge.
            let is_against = (self.origin(half_edge) > self.destination(half_edge)) != (other < this);
            all.extend(sources.iter().map(|source| {
                let source = if is_against { source.reversed() } else { *source };
                (this.min(other).0, source)
            }));
        }
        all.sort_unstable();
        all
    }

    /// Returns the data of the tile for the directory. `triangles` is the sum of the triangles that
    /// belong to it.
    pub(crate) fn counts(&self, numbering: &Numbering, triangles: DigestSum) -> Counts {
        let TriangleOrder { core, border } = &numbering.order;
        Counts {
            vertices: self.points.len() as u32,
            core_triangles: core.len() as u32,
            border_triangles: border.len() as u32,
            digest: self.digest_with(triangles),
            bounds: self.bounds(border),
        }
    }
}

/// Returns the component of each triangle; nothing if there is only one.
fn components(parts: &TileParts, triangles: &[TriangleId]) -> Vec<u32> {
    match parts.count() {
        0 | 1 => Vec::new(),
        _ => triangles.iter().map(|&triangle| parts.of_triangle(triangle)).collect(),
    }
}

/// The data of a tile for the directory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counts {
    vertices: u32,
    core_triangles: u32,
    border_triangles: u32,
    /// The digest of all elements that belong to the tile, without holes.
    pub(crate) digest: Digest,
    bounds: Rect,
}

impl Counts {
    /// Returns whether the tile has no vertices.
    pub(crate) fn is_empty(&self) -> bool {
        self.vertices == 0
    }

    /// Returns the directory entry of the tile, whose core and border were written to these
    /// extents, without its component table.
    pub(crate) fn entry(self, core: Extent, border: Extent, generation: u32) -> TileEntry {
        TileEntry {
            core,
            border,
            generation,
            vertices: self.vertices,
            core_triangles: self.core_triangles,
            border_triangles: self.border_triangles,
            owned_triangles: self.digest.triangles.count as u32,
            bounds: self.bounds,
            table: TablePlace::Nowhere,
        }
    }
}
