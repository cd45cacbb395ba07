//! A tile in memory: its two FlatBuffers, checked once, read in place.

mod notes;
mod open;
mod regions;
mod sides;
mod sites;
#[cfg(test)]
mod tests;

use std::fmt;
use std::sync::Arc;

use bytes::Bytes;

use crate::geometry::{HalfEdge, Point};
use crate::io::memory_of;
use crate::mesh::{Embedded, Topology, Twin, next_side};
use crate::store::format::edge_source::EdgeSource;
use crate::store::format::ids::{TileId, VertexId};
use crate::store::format::packed::{Packed, partition_point};
pub(crate) use notes::Marks;
pub(crate) use notes::Noted;
pub(crate) use notes::NotedSide;
pub(crate) use notes::NotedSides;
use notes::Notes;
pub(crate) use regions::Component;
use regions::Regions;
use sides::SideBits;
use sides::Sources;
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

/// What lies on the other side of a triangle's side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// This side of another triangle of the same tile, which runs the other way.
    Side(u32),
    /// A triangle that no vertex of this tile is a corner of: the tiles of the side's vertices have it, unless it is the
    /// hull.
    Elsewhere,
    /// Nothing: the side is on the hull.
    Hull,
}

/// A tile in memory. Clones share its bytes.
///
/// Triangles are numbered from 0, first those of the core, then those of the border, and so are their sides: side `3t + s`
/// of triangle `t` runs counter-clockwise from its corner `s`. Corners are numbered from 0 within the tile, first the
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

    /// Where a vertex of the tile is.
    #[inline]
    #[must_use]
    pub fn point(&self, vertex: u32) -> Point {
        assert!(vertex < self.vertex_count(), "tile {} has no vertex {vertex}", self.id);
        self.corner_point(vertex as usize)
    }

    /// All vertices of the tile.
    pub fn points(&self) -> impl ExactSizeIterator<Item = Point> {
        (0..self.vertex_count()).map(|vertex| self.point(vertex))
    }

    /// The z of a vertex of the tile, if the file has any.
    #[must_use]
    pub fn z(&self, vertex: u32) -> Option<f64> {
        self.z.as_ref().map(|z| f64_at(z, 8 * vertex as usize))
    }

    /// The number of the input record that a vertex of the tile came from.
    #[must_use]
    pub fn record(&self, vertex: u32) -> u64 {
        self.first_record + self.records.get(vertex as usize)
    }

    /// Where a corner is: a vertex of the tile, or of another one.
    #[inline]
    fn corner_point(&self, corner: usize) -> Point {
        let vertices = self.records.len();
        let (bytes, at) = if corner < vertices {
            (&self.coordinates, 16 * corner)
        } else {
            (&self.foreign, FOREIGN * (corner - vertices))
        };
        Point::new(f64_at(bytes, at), f64_at(bytes, at + 8))
    }

    /// Where a corner is: a vertex of the tile, or of another one.
    #[inline]
    pub(crate) fn corner(&self, corner: u32) -> Point {
        self.corner_point(corner as usize)
    }

    /// The vertex behind a corner.
    #[must_use]
    pub fn vertex(&self, corner: u32) -> Vertex {
        let id = if corner < self.vertex_count() {
            VertexId {
                tile: self.id,
                index: corner,
            }
        } else {
            let at = FOREIGN * (corner - self.vertex_count()) as usize;
            VertexId {
                tile: TileId(u32_at(&self.foreign, at + 16)),
                index: u32_at(&self.foreign, at + 20),
            }
        };
        Vertex {
            id,
            point: self.corner_point(corner as usize),
        }
    }

    /// The corners of a triangle, counter-clockwise.
    #[inline]
    #[must_use]
    pub fn corners(&self, triangle: u32) -> [u32; 3] {
        [0, 1, 2].map(|s| self.origin(3 * triangle + s))
    }

    /// The corner that a side starts at.
    #[inline]
    #[must_use]
    pub fn origin(&self, side: u32) -> u32 {
        let side = side as usize;
        match side.checked_sub(self.triangles.len()) {
            None => self.triangles.get(side) as u32,
            Some(side) => self.border_triangles.get(side) as u32,
        }
    }

    /// The vertices of a triangle, counter-clockwise.
    #[must_use]
    pub fn vertices(&self, triangle: u32) -> [Vertex; 3] {
        self.corners(triangle).map(|corner| self.vertex(corner))
    }

    /// The places of a triangle's corners.
    #[inline]
    #[must_use]
    pub fn triangle_points(&self, triangle: u32) -> [Point; 3] {
        self.corners(triangle).map(|corner| self.corner_point(corner as usize))
    }

    /// Whether a triangle belongs to this tile: in a scan over all tiles each triangle belongs to exactly one.
    #[must_use]
    pub fn owns(&self, triangle: u32) -> bool {
        if triangle < self.core_triangle_count() {
            return true;
        }
        self.corners(triangle)
            .into_iter()
            .min_by(|&a, &b| self.corner_point(a as usize).lex_cmp(self.corner_point(b as usize)))
            .is_some_and(|smallest| smallest < self.vertex_count())
    }

    /// The triangles that belong to this tile.
    pub fn owned_triangles(&self) -> impl Iterator<Item = u32> {
        (0..self.triangle_count()).filter(|&triangle| self.owns(triangle))
    }

    /// What lies across a side.
    #[must_use]
    pub fn across(&self, side: u32) -> Across {
        let side = side as usize;
        if let Some(side) = side.checked_sub(self.triangles.len()) {
            let value = self.border_neighbours.get(side);
            return match self.border_neighbours.largest() - value {
                0 => Across::Hull,
                1 => Across::Elsewhere,
                _ => Across::Side(value as u32),
            };
        }
        let value = self.neighbours.get(side);
        if value != self.neighbours.largest() {
            return Across::Side(value as u32);
        }
        find(&self.core_links, side as u64).map_or(Across::Hull, Across::Side)
    }

    /// Whether a side is on a constraint.
    #[must_use]
    pub fn is_constraint(&self, side: u32) -> bool {
        if side < self.edge_count() {
            return true;
        }
        let (bits, side) = self.side_bits(side);
        bits.is_constraint(side)
    }

    /// Whether a side is on a wall: a constraint that blocks the way.
    #[must_use]
    pub fn is_wall(&self, side: u32) -> bool {
        if side < self.edge_count() {
            return self.edge_sources(side).any(EdgeSource::is_wall);
        }
        let (bits, side) = self.side_bits(side);
        bits.is_wall(side)
    }

    /// The bits of the core or of the border, and the place of a side in them.
    fn side_bits(&self, side: u32) -> (&SideBits, usize) {
        assert!(side < 3 * self.triangle_count(), "tile {} has no side {side}", self.id);
        let side = side as usize;
        match side.checked_sub(self.triangles.len()) {
            None => (&self.side_bits[0], side),
            Some(side) => (&self.side_bits[1], side),
        }
    }

    /// Why the edge of a side is a constraint: the lines along it, as seen in the direction of the side.
    ///
    /// None if it is no constraint, or belongs to another tile: to that of its lexicographically smaller end.
    pub fn edge_sources(&self, side: u32) -> impl Iterator<Item = EdgeSource> {
        let across = match side < self.edge_count() {
            true => Across::Hull,
            false => self.across(side),
        };
        let other = match across {
            Across::Side(other) => other,
            Across::Elsewhere | Across::Hull => side,
        };
        let in_core = matches!(across, Across::Side(_)) && side.max(other) < 3 * self.core_triangle_count();
        let entered = side.min(other);
        let sources = self.sources[usize::from(!in_core)].as_ref();
        let sources = sources.into_iter().flat_map(move |sources| sources.of(entered));
        sources.map(move |source| if side == entered { source } else { source.reversed() })
    }

    /// How many constraint edges the tile has in place of sides: some only in a file without triangles.
    pub(crate) fn edge_count(&self) -> u32 {
        self.edges.as_ref().map_or(0, |edges| edges.len() as u32 / 2)
    }

    /// How many edges the tile has sources for.
    pub(crate) fn edges_with_sources(&self) -> usize {
        self.sources.iter().flatten().map(Sources::edge_count).sum()
    }

    /// The number of the region that a triangle belongs to: what is connected without passing a constraint. 0 in files
    /// that know no regions.
    #[must_use]
    pub fn region(&self, triangle: u32) -> u64 {
        self.component(triangle).region
    }

    /// By how many obstacles a triangle is covered.
    #[must_use]
    pub fn depth(&self, triangle: u32) -> i32 {
        self.component(triangle).depth
    }

    /// Whether a triangle belongs to a hole.
    #[must_use]
    pub fn is_hole(&self, triangle: u32) -> bool {
        self.component(triangle).is_hole
    }

    /// What is true of a triangle and all that it is connected with in the tile.
    pub(crate) fn component(&self, triangle: u32) -> Component {
        self.component_at(self.component_number(triangle))
    }

    /// The number of the component that a triangle belongs to.
    pub(crate) fn component_number(&self, triangle: u32) -> u32 {
        let count = self.triangle_count();
        assert!(triangle < count, "tile {} has no triangle {triangle}", self.id);
        self.regions.number(triangle as usize) as u32
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
    pub fn sites_at(&self, vertex: u32) -> impl Iterator<Item = Site<'_>> {
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
    pub fn is_site(&self, vertex: u32) -> bool {
        assert!(vertex < self.vertex_count(), "tile {} has no vertex {vertex}", self.id);
        self.sites.as_ref().is_some_and(|sites| sites.is_site(vertex))
    }

    /// The sides of the tile that are on constraint edges which belong to it, one for each. In a file without triangles numbers
    /// from 0 stand for the edges themselves, and [`ends`](Self::ends), [`edge_sources`](Self::edge_sources) and
    /// [`is_wall`](Self::is_wall) take them too.
    pub fn owned_constraints(&self) -> impl Iterator<Item = u32> {
        let is_first = |side: u32| match self.across(side) {
            Across::Side(other) => side < other,
            Across::Hull => true,
            // Both ends are other tiles'.
            Across::Elsewhere => false,
        };
        let owned = self.constraint_sides().filter(move |&side| {
            is_first(side) && {
                let [from, to] = self.ends(side);
                let smallest = if from.point.lex_cmp(to.point).is_lt() { from } else { to };
                smallest.id.tile == self.id
            }
        });
        owned.chain(0..self.edge_count())
    }

    /// All sides that are on constraints.
    pub(crate) fn constraint_sides(&self) -> impl Iterator<Item = u32> {
        let any = self.side_bits.iter().any(SideBits::any);
        let sides = 0..if any { 3 * self.triangle_count() } else { 0 };
        sides.filter(|&side| self.is_constraint(side))
    }

    /// The vertices of a side.
    #[must_use]
    pub fn ends(&self, side: u32) -> [Vertex; 2] {
        if let Some(edges) = &self.edges {
            let first = 2 * side as usize;
            return [first, first + 1].map(|place| self.vertex(edges.get(place) as u32));
        }
        [side, next_side(side)].map(|side| self.vertex(self.origin(side)))
    }

    /// A side that starts at a vertex of the tile, if it has any triangles.
    #[must_use]
    pub fn side_leaving(&self, vertex: u32) -> Option<u32> {
        let side = self.vertex_sides.get(vertex as usize);
        if side != self.vertex_sides.largest() {
            return Some(side as u32);
        }
        find(&self.border_vertex_sides, vertex.into())
    }
}

impl Topology for Tile {
    #[inline]
    fn triangle_count(&self) -> u32 {
        Self::triangle_count(self)
    }

    #[inline]
    fn origin(&self, half_edge: HalfEdge) -> u32 {
        Self::origin(self, half_edge.0)
    }

    #[inline]
    fn twin(&self, half_edge: HalfEdge) -> Twin {
        match self.across(half_edge.0) {
            Across::Side(twin) => Twin::HalfEdge(HalfEdge(twin)),
            Across::Hull => Twin::Hull,
            Across::Elsewhere => Twin::Elsewhere,
        }
    }
}

/// Vertices are corners: those of other tiles have numbers too.
impl Embedded for Tile {
    #[inline]
    fn point(&self, corner: u32) -> Point {
        self.corner(corner)
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

/// Looks up a key in sorted pairs.
fn find(pairs: &Packed, key: u64) -> Option<u32> {
    let place = partition_point(pairs.len() / 2, |place| pairs.get(2 * place) < key);
    let found = place < pairs.len() / 2 && pairs.get(2 * place) == key;
    found.then(|| pairs.get(2 * place + 1) as u32)
}

fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"))
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}
