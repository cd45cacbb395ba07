//! A tile in memory: its two FlatBuffers, which are checked once and then read in place.

mod copies;
mod edge_bits;
pub(crate) mod edges;
mod notes;
mod open;
pub(crate) mod regions;
pub(crate) mod sites;
#[cfg(test)]
mod tests;
mod topology;

use std::fmt;
use std::sync::Arc;

use bytes::Bytes;

use crate::geometry::{HalfEdge, Point, TriangleId, VertexIndex};
use crate::io::memory_of;
use crate::store::format::component_table::{Component, ComponentRecord};
use crate::store::format::ids::{TileId, VertexId};
use crate::store::format::packed::Packed;
use edge_bits::{EdgeSources, HalfEdgeBits};
pub use edges::TileEdge;
use notes::Notes;
pub(crate) use notes::{HalfEdgeNote, HalfEdgeNotes, VertexNotes};
use regions::Regions;

pub use sites::Site;
use sites::Sites;

/// A vertex: its id and its point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Vertex {
    /// The id of the vertex.
    pub id: VertexId,
    /// The point of the vertex.
    pub point: Point,
}

/// A tile in memory. Clones share its bytes.
///
/// Triangles are numbered from 0, first those of the core, then those of the border. Half-edges are
/// numbered in the same order. Corners are numbered from 0 within the tile, first the vertices that
/// the tile owns, then those of other tiles.
///
/// All numbers that a tile returns are in range, whatever its bytes are. Arguments out of range
/// cause a panic.
#[derive(Clone)]
pub struct Tile {
    id: TileId,
    coordinates: Bytes,
    z: Option<Bytes>,
    first_record: u64,
    records: Packed,
    /// A bit for each vertex: whether an input point lies there. `None` if one lies at all of them.
    input_points: Option<Bytes>,
    triangles: Packed,
    neighbours: Packed,
    vertex_sides: Packed,
    foreign: Bytes,
    /// The z of each foreign vertex. There is none if, and only if, `z` has none.
    foreign_z: Option<Bytes>,
    border_triangles: Packed,
    border_neighbours: Packed,
    core_links: Packed,
    border_vertex_sides: Packed,
    /// The constraint edges of a file without triangles, as pairs of corners.
    edges: Option<Packed>,
    /// The bits of the half-edges of the core, and of the border.
    half_edge_bits: [HalfEdgeBits; 2],
    /// The sources of the edges between two triangles of the core, and of the other edges that
    /// belong to the tile.
    sources: [Option<EdgeSources>; 2],
    regions: Regions,
    sites: Option<Sites>,
    /// Notes that queries store.
    notes: Arc<Notes>,
}

/// The size of a foreign vertex in a border, in bytes.
const FOREIGN: usize = 24;

impl Tile {
    /// Returns the number of the tile.
    #[must_use]
    pub fn id(&self) -> TileId {
        self.id
    }

    /// Returns the number of vertices that the tile owns.
    #[must_use]
    pub fn vertex_count(&self) -> u32 {
        self.records.len() as u32
    }

    /// Returns the indices of the vertices that the tile owns.
    #[inline]
    pub fn vertex_indices(&self) -> impl DoubleEndedIterator<Item = VertexIndex> + ExactSizeIterator + Clone + use<> {
        (0..self.vertex_count()).map(VertexIndex)
    }

    /// Returns whether a corner is a vertex that the tile owns.
    #[inline]
    #[must_use]
    pub fn has_vertex(&self, corner: VertexIndex) -> bool {
        corner.0 < self.vertex_count()
    }

    /// Returns the number of triangles in the core.
    #[must_use]
    pub fn core_triangle_count(&self) -> u32 {
        (self.triangles.len() / 3) as u32
    }

    /// Returns the number of triangles in core and border.
    #[must_use]
    pub fn triangle_count(&self) -> u32 {
        ((self.triangles.len() + self.border_triangles.len()) / 3) as u32
    }

    /// Returns the ids of the triangles in core and border.
    #[inline]
    pub fn triangle_ids(&self) -> impl DoubleEndedIterator<Item = TriangleId> + ExactSizeIterator + Clone + use<> {
        (0..self.triangle_count()).map(TriangleId)
    }

    /// Returns the ids of the triangles in the border.
    #[inline]
    pub(crate) fn border_triangle_ids(&self) -> impl ExactSizeIterator<Item = TriangleId> + use<> {
        (self.core_triangle_count()..self.triangle_count()).map(TriangleId)
    }

    /// Returns the number of corners: vertices of the tile, and vertices of other tiles that are
    /// corners of its triangles.
    #[inline]
    pub(crate) fn corner_count(&self) -> usize {
        self.records.len() + self.foreign_count()
    }

    /// Returns the number of corners that other tiles own.
    fn foreign_count(&self) -> usize {
        self.foreign.len() / FOREIGN
    }

    /// Returns the approximate number of bytes that the tile takes in memory.
    #[must_use]
    pub fn byte_size(&self) -> usize {
        let packed = [
            &self.records,
            &self.triangles,
            &self.neighbours,
            &self.vertex_sides,
            &self.border_triangles,
            &self.border_neighbours,
            &self.core_links,
            &self.border_vertex_sides,
        ];
        let of_file = self.coordinates.len()
            + self.edges.as_ref().map_or(0, Packed::byte_size)
            + self.z.as_ref().map_or(0, Bytes::len)
            + self.input_points.as_ref().map_or(0, Bytes::len)
            + self.foreign.len()
            + self.foreign_z.as_ref().map_or(0, Bytes::len)
            + self.half_edge_bits.iter().map(HalfEdgeBits::byte_size).sum::<usize>()
            + self.sources.iter().flatten().map(EdgeSources::byte_size).sum::<usize>()
            + self.regions.byte_size()
            + self.sites.as_ref().map_or(0, Sites::byte_size)
            + packed.iter().map(|p| p.byte_size()).sum::<usize>();
        let has_constraints = self.half_edge_bits.iter().any(HalfEdgeBits::any);
        let noted = Notes::byte_size(self.records.len(), 3 * self.triangle_count() as usize, has_constraints);
        size_of::<Self>() + memory_of(of_file) + noted
    }

    /// Returns the point of a corner, which is a vertex of this tile or of another one.
    #[inline]
    #[must_use]
    pub fn point(&self, corner: VertexIndex) -> Point {
        let (corner, vertices) = (corner.index(), self.records.len());
        let (bytes, at) = if corner < vertices {
            (&self.coordinates, 16 * corner)
        } else {
            (&self.foreign, FOREIGN * (corner - vertices))
        };
        Point::new(f64_at(bytes, at), f64_at(bytes, at + 8))
    }

    /// Returns the points of the vertices that the tile owns.
    pub fn points(&self) -> impl ExactSizeIterator<Item = Point> {
        self.vertex_indices().map(|vertex| self.point(vertex))
    }

    /// Returns the coordinates of the vertices that the tile owns, as the file has them: x and y of
    /// each, as little-endian f64. They share the memory of the tile.
    #[must_use]
    pub fn coordinate_bytes(&self) -> Bytes {
        self.coordinates.clone()
    }

    /// Returns the z of the vertices that the tile owns, as the file has them: little-endian f64.
    /// Returns `None` if the file has no z. They share the memory of the tile.
    #[must_use]
    pub fn z_bytes(&self) -> Option<Bytes> {
        self.z.clone()
    }

    /// Returns whether the corners have a z. All tiles of a sound file agree on this.
    #[must_use]
    pub(crate) fn has_z(&self) -> bool {
        self.z.is_some()
    }

    /// Returns the z of a corner, which is a vertex of this tile or of another one. Returns `None`
    /// if the file has no z.
    #[must_use]
    pub fn z(&self, corner: VertexIndex) -> Option<f64> {
        let (corner, vertices) = (corner.index(), self.records.len());
        let (bytes, index) = match corner.checked_sub(vertices) {
            None => (&self.z, corner),
            Some(foreign) => (&self.foreign_z, foreign),
        };
        bytes.as_ref().map(|z| f64_at(z, 8 * index))
    }

    /// Returns the number of the input record that a vertex of the tile came from.
    #[must_use]
    pub fn record(&self, vertex: VertexIndex) -> u64 {
        self.first_record + self.records.get(vertex.index())
    }

    /// Returns whether a point of the input lies at a vertex of the tile. Other vertices are ends
    /// of segments, sites, and points at which lines were split.
    #[must_use]
    pub fn is_input_point(&self, vertex: VertexIndex) -> bool {
        assert!(self.has_vertex(vertex), "tile {} has no vertex {vertex}", self.id);
        let bits = self.input_points.as_ref();
        bits.is_none_or(|bits| edge_bits::is_set(bits, vertex.index()))
    }

    /// Returns the vertex at a corner.
    #[must_use]
    pub fn vertex(&self, corner: VertexIndex) -> Vertex {
        let id = if self.has_vertex(corner) {
            VertexId {
                tile: self.id,
                index: corner,
            }
        } else {
            let at = FOREIGN * (corner.0 - self.vertex_count()) as usize;
            VertexId {
                tile: TileId(u32_at(&self.foreign, at + 16)),
                index: VertexIndex(u32_at(&self.foreign, at + 20)),
            }
        };
        Vertex {
            id,
            point: self.point(corner),
        }
    }

    /// Returns the corners of a triangle, counter-clockwise.
    #[inline]
    #[must_use]
    pub fn corners(&self, triangle: TriangleId) -> [VertexIndex; 3] {
        HalfEdge::of_triangle(triangle).map(|half_edge| self.origin(half_edge))
    }

    /// Returns the vertices of a triangle, counter-clockwise.
    #[must_use]
    pub fn vertices(&self, triangle: TriangleId) -> [Vertex; 3] {
        self.corners(triangle).map(|corner| self.vertex(corner))
    }

    /// Returns the points of a triangle's corners, counter-clockwise.
    #[inline]
    #[must_use]
    pub fn triangle_points(&self, triangle: TriangleId) -> [Point; 3] {
        self.corners(triangle).map(|corner| self.point(corner))
    }

    /// Returns whether a triangle belongs to this tile. Each triangle of the file belongs to
    /// exactly one tile.
    #[must_use]
    pub fn owns(&self, triangle: TriangleId) -> bool {
        if triangle.0 < self.core_triangle_count() {
            return true;
        }
        self.corners(triangle)
            .into_iter()
            .min_by(|&a, &b| self.point(a).lex_cmp(self.point(b)))
            .is_some_and(|smallest| self.has_vertex(smallest))
    }

    /// Returns the triangles that belong to this tile.
    pub fn owned_triangles(&self) -> impl Iterator<Item = TriangleId> {
        self.triangle_ids().filter(|&triangle| self.owns(triangle))
    }

    /// Returns the number of the region of a triangle. A region is a set of triangles that are
    /// connected without crossing a constraint. Returns 0 in files without regions.
    #[must_use]
    pub fn region(&self, triangle: TriangleId) -> u64 {
        self.component(triangle).region
    }

    /// Returns the number of obstacles that cover a triangle.
    #[must_use]
    pub fn depth(&self, triangle: TriangleId) -> i32 {
        self.component(triangle).depth
    }

    /// Returns whether a triangle belongs to a hole.
    #[must_use]
    pub fn is_hole(&self, triangle: TriangleId) -> bool {
        self.component(triangle).is_hole
    }

    /// Returns the properties of the component of a triangle. A component is a set of triangles
    /// that are connected within the tile without crossing a constraint.
    pub(crate) fn component(&self, triangle: TriangleId) -> Component {
        self.component_at(self.component_number(triangle))
    }

    /// Returns the number of the component of a triangle.
    pub(crate) fn component_number(&self, triangle: TriangleId) -> u32 {
        let count = self.triangle_count();
        assert!(triangle.0 < count, "tile {} has no triangle {triangle}", self.id);
        self.regions.number(triangle.index()) as u32
    }

    /// Returns the properties of a component by its number.
    pub(crate) fn component_at(&self, number: u32) -> Component {
        self.regions.component(number as usize)
    }

    /// Returns what the component table says of each component, or nothing if there is no table.
    pub(crate) fn component_records(&self) -> Vec<ComponentRecord> {
        self.regions.records(self.id)
    }

    /// Returns the number of components, at least 1.
    pub(crate) fn component_count(&self) -> u32 {
        self.regions.count() as u32
    }

    /// Returns the sites at the tile's vertices, ordered by vertex and number. There may be several
    /// at one vertex.
    pub fn sites(&self) -> impl Iterator<Item = Site<'_>> {
        let sites = self.sites.iter();
        sites.flat_map(|sites| (0..sites.len()).map(|index| sites.get(index)))
    }

    /// Returns the sites at a vertex of the tile, ordered by number.
    pub fn sites_at(&self, vertex: VertexIndex) -> impl Iterator<Item = Site<'_>> {
        let sites = self.sites.iter();
        sites.flat_map(move |sites| sites.at(vertex))
    }

    /// Returns the notes that queries store for this tile. Clones share them.
    #[inline]
    pub(crate) fn notes(&self) -> &Notes {
        &self.notes
    }

    /// Returns the number of sites at the tile's vertices.
    #[must_use]
    pub fn site_count(&self) -> u32 {
        self.sites.as_ref().map_or(0, |sites| sites.len() as u32)
    }

    /// Returns whether there is a site at a vertex of the tile.
    #[must_use]
    pub fn is_site(&self, vertex: VertexIndex) -> bool {
        assert!(self.has_vertex(vertex), "tile {} has no vertex {vertex}", self.id);
        self.sites.as_ref().is_some_and(|sites| sites.is_site(vertex))
    }
}

impl fmt::Debug for Tile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tile")
            .field("id", &self.id)
            .field("vertices", &self.vertex_count())
            .field("triangles", &self.triangle_count())
            .finish_non_exhaustive()
    }
}

fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"))
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}
