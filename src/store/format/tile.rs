//! A tile in memory: its two FlatBuffers, checked once, read in place.

pub(crate) mod edges;
mod notes;
mod open;
pub(crate) mod regions;
mod sides;
pub(crate) mod sites;
#[cfg(test)]
mod tests;
mod topology;

use std::fmt;
use std::sync::Arc;

use bytes::Bytes;

use crate::geometry::{HalfEdge, Point, TriangleId, VertexIndex};
use crate::io::memory_of;
use crate::store::format::ids::{TileId, VertexId};
use crate::store::format::packed::Packed;
pub use edges::TileEdge;
use notes::Notes;
pub(crate) use notes::{VertexNotes, NoteKind, HalfEdgeNote, HalfEdgeNotes};
pub(crate) use regions::Component;
use regions::Regions;
use sides::{SideBits, Sources};
pub use sites::Site;
use sites::Sites;

/// A vertex: its number, and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Vertex {
    /// Its number.
    pub id: VertexId,
    /// Where it is.
    pub point: Point,
}

/// A tile in memory. Clones share its bytes.
///
/// Triangles are numbered from 0, first those of the core, then those of the border, and so are their half-edges. Corners are numbered from 0 within the tile, first the
/// tile's own vertices, then those of other tiles. All numbers that a tile hands out are within range, whatever its
/// bytes were; arguments out of range panic.
#[derive(Clone)]
pub struct Tile {
    id: TileId,
    coordinates: Bytes,
    z: Option<Bytes>,
    first_record: u64,
    records: Packed,
    triangles: Packed,
    neighbours: Packed,
    vertex_sides: Packed,
    foreign: Bytes,
    border_triangles: Packed,
    border_neighbours: Packed,
    core_links: Packed,
    border_vertex_sides: Packed,
    /// Pairs of corners: the constraint edges of a file without triangles.
    edges: Option<Packed>,
    /// Of the sides of the core, and of the border.
    side_bits: [SideBits; 2],
    /// Of the edges between two triangles of the core, and of the others that belong to the tile.
    sources: [Option<Sources>; 2],
    regions: Regions,
    sites: Option<Sites>,
    /// What queries note.
    notes: Arc<Notes>,
}

/// Bytes of a foreign vertex in a border.
const FOREIGN: usize = 24;

impl Tile {
    /// The number of the tile.
    #[must_use]
    pub fn id(&self) -> TileId {
        self.id
    }

    /// Vertices that the tile owns.
    #[must_use]
    pub fn vertex_count(&self) -> u32 {
        self.records.len() as u32
    }

    /// The vertices that the tile owns.
    #[inline]
    pub fn vertex_indices(&self) -> impl DoubleEndedIterator<Item = VertexIndex> + ExactSizeIterator + Clone + use<> {
        (0..self.vertex_count()).map(VertexIndex)
    }

    /// Whether a corner is a vertex that the tile owns.
    #[inline]
    #[must_use]
    pub fn has_vertex(&self, corner: VertexIndex) -> bool {
        corner.0 < self.vertex_count()
    }

    /// Triangles of the core.
    #[must_use]
    pub fn core_triangle_count(&self) -> u32 {
        (self.triangles.len() / 3) as u32
    }

    /// Triangles of core and border.
    #[must_use]
    pub fn triangle_count(&self) -> u32 {
        ((self.triangles.len() + self.border_triangles.len()) / 3) as u32
    }

    /// The triangles of core and border.
    #[inline]
    pub fn triangle_ids(&self) -> impl DoubleEndedIterator<Item = TriangleId> + ExactSizeIterator + Clone + use<> {
        (0..self.triangle_count()).map(TriangleId)
    }

    /// The triangles of the border.
    #[inline]
    pub(crate) fn border_triangle_ids(&self) -> impl ExactSizeIterator<Item = TriangleId> + use<> {
        (self.core_triangle_count()..self.triangle_count()).map(TriangleId)
    }

    /// Vertices of the tile, and those of others at corners of its triangles.
    #[inline]
    pub(crate) fn corner_count(&self) -> usize {
        self.records.len() + self.foreign_count()
    }

    /// Corners that other tiles own.
    fn foreign_count(&self) -> usize {
        self.foreign.len() / FOREIGN
    }

    /// Bytes that the tile takes in memory, more or less.
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
            + self.foreign.len()
            + self.side_bits.iter().map(SideBits::byte_size).sum::<usize>()
            + self.sources.iter().flatten().map(Sources::byte_size).sum::<usize>()
            + self.regions.byte_size()
            + self.sites.as_ref().map_or(0, Sites::byte_size)
            + packed.iter().map(|p| p.byte_size()).sum::<usize>();
        let noted = Notes::byte_size(self.records.len(), 3 * self.triangle_count() as usize);
        size_of::<Self>() + memory_of(of_file) + noted
    }

    /// Where a corner is: a vertex of the tile, or of another one.
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

    /// All vertices of the tile.
    pub fn points(&self) -> impl ExactSizeIterator<Item = Point> {
        self.vertex_indices().map(|vertex| self.point(vertex))
    }

    /// The z of a vertex of the tile, if the file has any.
    #[must_use]
    pub fn z(&self, vertex: VertexIndex) -> Option<f64> {
        self.z.as_ref().map(|z| f64_at(z, 8 * vertex.index()))
    }

    /// The number of the input record that a vertex of the tile came from.
    #[must_use]
    pub fn record(&self, vertex: VertexIndex) -> u64 {
        self.first_record + self.records.get(vertex.index())
    }

    /// The vertex behind a corner.
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

    /// The corners of a triangle, counter-clockwise.
    #[inline]
    #[must_use]
    pub fn corners(&self, triangle: TriangleId) -> [VertexIndex; 3] {
        HalfEdge::of_triangle(triangle).map(|half_edge| self.origin(half_edge))
    }

    /// The vertices of a triangle, counter-clockwise.
    #[must_use]
    pub fn vertices(&self, triangle: TriangleId) -> [Vertex; 3] {
        self.corners(triangle).map(|corner| self.vertex(corner))
    }

    /// The places of a triangle's corners.
    #[inline]
    #[must_use]
    pub fn triangle_points(&self, triangle: TriangleId) -> [Point; 3] {
        self.corners(triangle).map(|corner| self.point(corner))
    }

    /// Whether a triangle belongs to this tile: in a scan over all tiles each triangle belongs to exactly one.
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

    /// The triangles that belong to this tile.
    pub fn owned_triangles(&self) -> impl Iterator<Item = TriangleId> {
        self.triangle_ids().filter(|&triangle| self.owns(triangle))
    }

    /// The number of the region that a triangle belongs to: what is connected without passing a constraint. 0 in files
    /// that know no regions.
    #[must_use]
    pub fn region(&self, triangle: TriangleId) -> u64 {
        self.component(triangle).region
    }

    /// By how many obstacles a triangle is covered.
    #[must_use]
    pub fn depth(&self, triangle: TriangleId) -> i32 {
        self.component(triangle).depth
    }

    /// Whether a triangle belongs to a hole.
    #[must_use]
    pub fn is_hole(&self, triangle: TriangleId) -> bool {
        self.component(triangle).is_hole
    }

    /// What is true of a triangle and all that it is connected with in the tile.
    pub(crate) fn component(&self, triangle: TriangleId) -> Component {
        self.component_at(self.component_number(triangle))
    }

    /// The number of the component that a triangle belongs to.
    pub(crate) fn component_number(&self, triangle: TriangleId) -> u32 {
        let count = self.triangle_count();
        assert!(triangle.0 < count, "tile {} has no triangle {triangle}", self.id);
        self.regions.number(triangle.index()) as u32
    }

    /// What is true of a component, by its number.
    pub(crate) fn component_at(&self, number: u32) -> Component {
        self.regions.component(number as usize)
    }

    /// How many components there are: one at least.
    pub(crate) fn component_count(&self) -> u32 {
        self.regions.count() as u32
    }

    /// The sites at the tile's vertices, by vertex and number. There may be several at one vertex.
    pub fn sites(&self) -> impl Iterator<Item = Site<'_>> {
        let sites = self.sites.iter();
        sites.flat_map(|sites| (0..sites.len()).map(|place| sites.get(place)))
    }

    /// The sites at a vertex of the tile, by number.
    pub fn sites_at(&self, vertex: VertexIndex) -> impl Iterator<Item = Site<'_>> {
        let sites = self.sites.iter();
        sites.flat_map(move |sites| sites.at(vertex))
    }

    /// What queries note of the tile; its clones share it.
    #[inline]
    pub(crate) fn notes(&self) -> &Notes {
        &self.notes
    }

    /// How many sites there are at the tile's vertices.
    #[must_use]
    pub fn site_count(&self) -> u32 {
        self.sites.as_ref().map_or(0, |sites| sites.len() as u32)
    }

    /// Whether a site lies at a vertex of the tile.
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
