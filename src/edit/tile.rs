//! A tile that can be changed: arrays of all triangles with a vertex in it, and of their adjacency.
//!
//! It is read from a [`Tile`], and encoded (`encode`) as a core and a border.

mod digest;
pub(crate) mod encode;
pub(crate) mod hubs;
pub(crate) mod made;
pub(crate) mod parts;
pub(crate) mod points;
mod replace;
mod room;
mod sites;
mod sources;
mod topology;
mod twin;

use foldhash::HashMap;

use crate::edit::vertex::EditVertex;
use crate::geometry::{HalfEdge, PackedHalfEdge, Point, TriangleId, VertexIndex};
use crate::mesh::{Topology, WALLS};
use crate::store::{DigestSum, LinePart, Tile, TileId, Vertex, VertexId, Weight, triangle_hash};
use hubs::Hubs;
use room::{bytes_of, make_room, room, with_room};
use twin::PackedTwin;

/// The corners of a removed triangle.
const GONE: [VertexIndex; 3] = [VertexIndex(u32::MAX); 3];
/// The bit of a triangle that is being replaced.
const REMOVED: u8 = 1 << 7;

/// A tile in memory that can be changed. Corners and half-edges are numbered as in a [`Tile`], but
/// triangles are in any order.
#[derive(Clone, Debug)]
pub(crate) struct EditTile {
    pub(crate) id: TileId,
    points: Vec<Point>,
    /// The z of each vertex of the tile; empty if the file has no z.
    z: Vec<f64>,
    records: Vec<u64>,
    /// Whether a point of the input lies at each vertex. Empty if one does at all of them.
    input_points: Vec<bool>,
    sites: Vec<(u32, u64)>,
    site_ids: Vec<String>,
    foreign: Vec<EditVertex>,
    foreign_corners: HashMap<VertexId, VertexIndex>,
    /// The corners of each triangle, or [`GONE`].
    triangles: Vec<[VertexIndex; 3]>,
    twins: Vec<[PackedTwin; 3]>,
    bits: Vec<u8>,
    /// The number of the triangles that belong to the tile, and the sum of their hashes. `None` if that is
    /// not known, as in a file with regions, where each part of a tile has a sum, found when it is written.
    owned: Option<DigestSum>,
    /// Positions of removed triangles.
    free: Vec<TriangleId>,
    /// A half-edge that leaves each vertex of the tile.
    leaving: Vec<PackedHalfEdge>,
    hubs: Hubs,
    /// The sources of each constraint edge that belongs to the tile, by its corners, the smaller
    /// one first. They are seen from the smaller corner.
    sources: HashMap<[VertexIndex; 2], Vec<LinePart>>,
    /// Number of all sources.
    source_count: usize,
}

/// The positions of the triangles of a tile, in the order in which they are written.
pub(crate) struct TriangleOrder {
    /// Those whose corners are all the tile's own. They belong to it.
    pub(crate) core: Vec<TriangleId>,
    pub(crate) border: Vec<TriangleId>,
}

impl TriangleOrder {
    pub(crate) fn all(&self) -> impl Iterator<Item = TriangleId> {
        self.core.iter().chain(&self.border).copied()
    }
}

/// A vertex to be added to a tile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NewVertex {
    pub(crate) point: Point,
    pub(crate) z: f64,
    pub(crate) record: u64,
    /// Whether a point lies there. Otherwise it is the end of a line.
    pub(crate) is_input_point: bool,
}

impl EditTile {
    /// Copies a tile's content. In a file without regions, the component table has the sum of its
    /// triangles.
    pub(crate) fn of(tile: &Tile, has_regions: bool) -> Self {
        Self::joined(Self::vertices_of(tile), Self::triangles_of(tile, has_regions))
    }

    /// Joins what [`vertices_of`](Self::vertices_of) and [`triangles_of`](Self::triangles_of) return.
    pub(crate) fn joined(vertices: Self, triangles: Self) -> Self {
        Self {
            points: vertices.points,
            z: vertices.z,
            records: vertices.records,
            input_points: vertices.input_points,
            sites: vertices.sites,
            site_ids: vertices.site_ids,
            leaving: vertices.leaving,
            sources: vertices.sources,
            source_count: vertices.source_count,
            ..triangles
        }
    }

    /// Copies the vertices that the tile owns, with their sites, and the sources of its edges.
    pub(crate) fn vertices_of(tile: &Tile) -> Self {
        let mut this = Self {
            points: with_room(tile.points()),
            z: match tile.has_z() {
                true => with_room(tile.vertex_indices().map(|v| tile.z(v).unwrap_or(0.0))),
                false => Vec::new(),
            },
            records: with_room(tile.vertex_indices().map(|v| tile.record(v))),
            input_points: match tile.vertex_indices().all(|v| tile.is_input_point(v)) {
                true => Vec::new(),
                false => tile.vertex_indices().map(|v| tile.is_input_point(v)).collect(),
            },
            sites: tile.sites().map(|site| (site.vertex.0, site.number)).collect(),
            leaving: with_room(tile.vertex_indices().map(|v| tile.leaving(v).into())),
            ..Self::empty(tile.id())
        };
        if tile.sites().any(|site| site.id.is_some()) {
            this.site_ids = tile
                .sites()
                .map(|site| site.id.unwrap_or_default().to_owned())
                .collect();
        }
        this.load_sources(tile);
        this
    }

    /// Copies the triangles, and the vertices of other tiles at their corners.
    pub(crate) fn triangles_of(tile: &Tile, has_regions: bool) -> Self {
        let vertices = tile.vertex_count();
        let more = room(tile.triangle_count() as usize);
        let triangles = tile.all_corners(more);
        let corners = triangles.as_flattened().iter().map(|&corner| corner.0 + 1).max();
        let foreign: Vec<EditVertex> = (vertices..corners.unwrap_or(0))
            .map(|corner| {
                let Vertex { id, point } = tile.vertex(VertexIndex(corner));
                let z = tile.z(VertexIndex(corner)).unwrap_or(0.0);
                EditVertex { id, point, z }
            })
            .collect();
        Self {
            foreign_corners: foreign
                .iter()
                .zip((vertices..).map(VertexIndex))
                .map(|(vertex, corner)| (vertex.id, corner))
                .collect(),
            foreign,
            twins: tile.all_twins(more),
            bits: tile.all_edge_bits(WALLS, more),
            hubs: Hubs::of(vertices as usize, &triangles),
            triangles,
            owned: match has_regions {
                true => None,
                false => match &tile.component_records()[..] {
                    [record] => Some(record.triangles),
                    _ => None,
                },
            },
            ..Self::empty(tile.id())
        }
    }

    /// Returns about how many bytes of memory it takes, including the spare capacity of lists.
    pub(crate) fn byte_size(&self) -> usize {
        /// Bytes of an entry of a hash table, besides its content. Tables are at most seven eighths
        /// full, and at least half of that.
        const OF_ENTRY: usize = 8;
        /// Bytes of a list of one source, which is an allocation of its own.
        const OF_SOURCES: usize = 48;
        bytes_of(&self.points)
            + bytes_of(&self.z)
            + bytes_of(&self.records)
            + bytes_of(&self.input_points)
            + bytes_of(&self.leaving)
            + bytes_of(&self.triangles)
            + bytes_of(&self.twins)
            + bytes_of(&self.bits)
            + bytes_of(&self.free)
            + bytes_of(&self.foreign)
            + (size_of::<(VertexId, VertexIndex)>() + OF_ENTRY) * self.foreign_corners.capacity()
            + (size_of::<([VertexIndex; 2], Vec<LinePart>)>() + OF_ENTRY) * self.sources.capacity()
            + OF_SOURCES * self.sources.len()
            + 8 * self.source_count
            + 32 * self.sites.len()
            + self
                .site_ids
                .iter()
                .map(|id| size_of::<String>() + id.len())
                .sum::<usize>()
            + self.hubs.byte_size()
    }

    /// Returns the number of the triangles that belong to the tile, and the sum of their hashes.
    pub(crate) fn owned(&self) -> DigestSum {
        self.owned.unwrap_or_else(|| self.hashed())
    }

    pub(crate) fn points(&self) -> &[Point] {
        &self.points
    }

    /// Returns the vertex of a corner, the tile's own or another's.
    pub(crate) fn vertex(&self, corner: VertexIndex) -> EditVertex {
        match self.points.get(corner.index()) {
            Some(&point) => EditVertex {
                id: VertexId {
                    tile: self.id,
                    index: corner,
                },
                point,
                z: self.z.get(corner.index()).copied().unwrap_or(0.0),
            },
            None => self.foreign[corner.index() - self.points.len()],
        }
    }

    /// Returns the points of the corners of a triangle.
    pub(crate) fn corner_points(&self, triangle: TriangleId) -> [Point; 3] {
        let own = &self.points;
        self.triangles[triangle.index()].map(|corner| match own.get(corner.index()) {
            Some(&point) => point,
            None => self.foreign[corner.index() - own.len()].point,
        })
    }

    /// Returns the vertex that a half-edge starts from.
    pub(crate) fn origin_vertex(&self, half_edge: HalfEdge) -> EditVertex {
        self.vertex(self.origin(half_edge))
    }

    /// Returns the corners of a half-edge's triangle, from the half-edge's origin on, and the bits
    /// of the triangle's half-edges, from this one on.
    pub(crate) fn triangle(&self, half_edge: HalfEdge) -> ([EditVertex; 3], u8) {
        let half_edges = [half_edge, half_edge.next(), half_edge.prev()];
        (
            half_edges.map(|half_edge| self.origin_vertex(half_edge)),
            self.bits_from(half_edge),
        )
    }

    /// Returns the bits of the half-edges of a half-edge's triangle, from this one on.
    pub(crate) fn bits_from(&self, half_edge: HalfEdge) -> u8 {
        let bits = self.bits[half_edge.triangle().index()];
        let turned = |bits: u8| {
            let (bits, first) = (bits & 0b111, half_edge.corner());
            (bits >> first | bits << (3 - first)) & 0b111
        };
        turned(bits) | turned(bits >> WALLS) << WALLS
    }

    /// Returns the bits of one half-edge, in the positions of a first one.
    fn half_edge_bits(&self, half_edge: HalfEdge) -> u8 {
        self.bits[half_edge.triangle().index()] >> half_edge.corner() & (1 | 1 << WALLS)
    }

    pub(crate) fn is_constraint(&self, half_edge: HalfEdge) -> bool {
        self.half_edge_bits(half_edge) & 1 == 1
    }

    /// Returns the number of triangles at a vertex of the tile.
    pub(crate) fn degree(&self, vertex: VertexIndex) -> u32 {
        self.hubs.degree(vertex)
    }

    /// Changes the bits of the first half-edge of a triangle with these corners: a constraint, or also
    /// a wall. Returns whether the tile has the triangle.
    pub(crate) fn mark(&mut self, corners: [VertexId; 3], change: impl Fn(u8) -> u8) -> bool {
        let half_edge = self.half_edge_of(corners);
        if let Some(half_edge) = half_edge {
            let bits = self.half_edge_bits(half_edge);
            let of_triangle = &mut self.bits[half_edge.triangle().index()];
            *of_triangle ^= (bits ^ change(bits)) << half_edge.corner();
        }
        half_edge.is_some()
    }

    /// Adds vertices, which no triangle has yet. Returns the index of the first one.
    pub(crate) fn add_vertices(&mut self, new: &[NewVertex], has_z: bool) -> u32 {
        let own = self.points.len() as u32;
        let more = new.len() as u32;
        make_room(&mut self.points, new.len());
        self.points.extend(new.iter().map(|vertex| vertex.point));
        make_room(&mut self.records, new.len());
        self.records.extend(new.iter().map(|vertex| vertex.record));
        if !self.input_points.is_empty() || new.iter().any(|vertex| !vertex.is_input_point) {
            self.input_points.resize(own as usize, true);
            self.input_points.extend(new.iter().map(|vertex| vertex.is_input_point));
        }
        make_room(&mut self.leaving, new.len());
        if has_z {
            make_room(&mut self.z, new.len());
            self.z.extend(new.iter().map(|vertex| vertex.z));
        }
        self.leaving.resize(self.points.len(), PackedHalfEdge::NONE);
        // The corners of other tiles come after the tile's own.
        let behind = |corner: &mut VertexIndex| {
            if corner.0 >= own {
                corner.0 += more;
            }
        };
        let triangles = self.triangles.iter_mut().filter(|corners| **corners != GONE);
        triangles.flatten().for_each(behind);
        self.foreign_corners.values_mut().for_each(behind);
        let sources = std::mem::take(&mut self.sources);
        self.sources = sources
            .into_iter()
            .map(|(mut ends, sources)| {
                ends.iter_mut().for_each(behind);
                (ends, sources)
            })
            .collect();
        if !self.hubs.add_vertices(new.len()) {
            self.hubs = Hubs::of(self.points.len(), &self.triangles);
        }
        own
    }

    /// Returns its triangles in the order in which they are written.
    pub(crate) fn in_order(&self) -> TriangleOrder {
        let own = self.points.len() as u32;
        let (mut core, mut border) = (Vec::with_capacity(self.triangles.len()), Vec::new());
        for (triangle, corners) in self.triangle_ids().zip(&self.triangles) {
            if corners.iter().all(|&corner| corner.0 < own) {
                core.push(triangle);
            } else if *corners != GONE {
                border.push(triangle);
            }
        }
        TriangleOrder { core, border }
    }

    /// Returns whether the triangle at a position was removed.
    fn is_removed(&self, triangle: TriangleId) -> bool {
        self.triangles[triangle.index()] == GONE
    }

    /// Adds a triangle to the sum of those that belong to the tile, if it does.
    fn count_in(&mut self, triangle: TriangleId) {
        self.count(triangle, DigestSum::add_hash);
    }

    /// Takes a triangle out of the sum of those that belong to the tile, if it does.
    fn count_out(&mut self, triangle: TriangleId) {
        self.count(triangle, DigestSum::remove_hash);
    }

    fn count(&mut self, triangle: TriangleId, change: impl Fn(&mut DigestSum, u128)) {
        if let Some(mut sum) = self.owned
            && self.owns(triangle)
        {
            change(&mut sum, triangle_hash(self.corner_points(triangle)));
            self.owned = Some(sum);
        }
    }

    /// Returns whether a triangle belongs to the tile.
    pub(crate) fn owns(&self, triangle: TriangleId) -> bool {
        let corners = self.triangles[triangle.index()].map(|corner| self.vertex(corner));
        let smallest = corners.iter().min_by(|a, b| a.point.lex_cmp(b.point));
        smallest.is_some_and(|vertex| vertex.id.tile == self.id)
    }
}

impl Weight for EditTile {
    fn weight(&self) -> usize {
        self.byte_size()
    }
}
