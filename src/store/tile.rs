//! A tile in memory: its two FlatBuffers, checked once, read in place.

use std::fmt;

use bytes::Bytes;

use super::directory::{check_crc, verified};
use super::generated::tile as schema;
use super::packed::Packed;
use super::{TileEntry, TileId, VertexId};
use crate::geometry::Point;
use crate::mesh::next_side;

/// A vertex: its number, and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// Bits of the sides of the core, and of the border; empty if none is a constraint.
    constraints: [Bytes; 2],
}

/// Bytes of a foreign vertex in a border.
const FOREIGN: usize = 24;

impl Tile {
    /// Checks the bytes of a tile against its entry, and every index in them; an error says what is wrong.
    pub(crate) fn open(id: TileId, entry: &TileEntry, core: &Bytes, border: &Bytes) -> Result<Self, String> {
        check_crc("the core", core, entry.core.crc)?;
        check_crc("the border", border, entry.border.crc)?;
        let core_table: schema::Core<'_> = verified(core, "the core")?;
        let border_table: schema::Border<'_> = verified(border, "the border")?;
        for (part, tile, generation) in [
            ("core", core_table.tile(), core_table.generation()),
            ("border", border_table.tile(), border_table.generation()),
        ] {
            if (tile, generation) != (id.0, entry.generation) {
                return Err(format!("the {part} is that of tile {tile}, generation {generation}"));
            }
        }
        let open = |buffer: &Bytes, what: &str, table| Packed::open(buffer, table).map_err(|e| format!("{what}: {e}"));
        let this = Self {
            id,
            coordinates: core.slice_ref(core_table.coordinates().bytes()),
            z: core_table.z().map(|z| core.slice_ref(z.bytes())),
            first_record: core_table.first_record(),
            records: open(core, "records", core_table.records())?,
            triangles: open(core, "triangles", core_table.triangles())?,
            neighbours: open(core, "neighbours", core_table.neighbours())?,
            vertex_sides: open(core, "vertex sides", core_table.vertex_sides())?,
            foreign: border.slice_ref(border_table.foreign().bytes()),
            border_triangles: open(border, "border triangles", border_table.triangles())?,
            border_neighbours: open(border, "border neighbours", border_table.neighbours())?,
            core_links: open(border, "core links", border_table.core_links())?,
            border_vertex_sides: open(border, "border vertex sides", border_table.vertex_sides())?,
            constraints: [
                core_table
                    .constraints()
                    .map_or_else(Bytes::new, |bits| core.slice_ref(bits.bytes())),
                border_table
                    .constraints()
                    .map_or_else(Bytes::new, |bits| border.slice_ref(bits.bytes())),
            ],
        };
        this.check(entry)?;
        Ok(this)
    }

    /// Checks lengths and ranges, so that nothing panics later.
    fn check(&self, entry: &TileEntry) -> Result<(), String> {
        let vertices = entry.vertices as usize;
        let (core, border) = (entry.core_triangles as usize, entry.border_triangles as usize);
        let bits = |part: usize, triangles: usize| match self.constraints[part].is_empty() {
            true => 0,
            false => (3 * triangles).div_ceil(8),
        };
        for (what, found, expected) in [
            ("coordinates", self.coordinates.len(), 16 * vertices),
            ("z", self.z.as_ref().map_or(8 * vertices, Bytes::len), 8 * vertices),
            ("records", self.records.len(), vertices),
            ("corners of the core", self.triangles.len(), 3 * core),
            ("neighbours of the core", self.neighbours.len(), 3 * core),
            ("vertex sides", self.vertex_sides.len(), vertices),
            ("corners of the border", self.border_triangles.len(), 3 * border),
            ("neighbours of the border", self.border_neighbours.len(), 3 * border),
            ("bytes of constraints", self.constraints[0].len(), bits(0, core)),
            (
                "bytes of constraints of the border",
                self.constraints[1].len(),
                bits(1, border),
            ),
            ("half links", self.core_links.len() % 2, 0),
            ("half vertex sides", self.border_vertex_sides.len() % 2, 0),
        ] {
            if found != expected {
                return Err(format!("there are {found} {what}, not {expected}"));
            }
        }
        let corners = (vertices + self.foreign_count()) as u64;
        let core_sides = 3 * core as u64;
        let sides = core_sides + 3 * border as u64;
        let below = |what: &str, values: &Packed, limit: u64, marks: u64| {
            let first_mark = if marks == 0 {
                u64::MAX
            } else {
                values.largest() - (marks - 1)
            };
            match values.iter().find(|&v| v >= limit && v < first_mark) {
                Some(value) => Err(format!("{what} {value} is beyond {limit}")),
                None => Ok(()),
            }
        };
        below("corner", &self.triangles, vertices as u64, 0)?;
        below("neighbour", &self.neighbours, core_sides, 1)?;
        below("vertex side", &self.vertex_sides, core_sides, 1)?;
        below("border corner", &self.border_triangles, corners, 0)?;
        below("border neighbour", &self.border_neighbours, sides, 2)?;
        let pairs = |values: &Packed| -> Vec<(u64, u64)> {
            (0..values.len() / 2)
                .map(|i| (values.get(2 * i), values.get(2 * i + 1)))
                .collect()
        };
        for (what, values, keys) in [
            ("core link", &self.core_links, core_sides),
            ("border vertex side", &self.border_vertex_sides, vertices as u64),
        ] {
            let pairs = pairs(values);
            let in_range = pairs.iter().all(|&(key, side)| key < keys && side < sides);
            if !in_range || !pairs.is_sorted_by(|a, b| a.0 < b.0) {
                return Err(format!("a {what} is out of range or out of order"));
            }
        }
        if self.records.iter().any(|r| self.first_record.checked_add(r).is_none()) {
            return Err("a record number exceeds 64 bits".to_owned());
        }
        let points = (0..corners as usize).map(|corner| self.corner_point(corner));
        let negative_zero = |v: f64| v == 0.0 && v.is_sign_negative();
        match points
            .zip(0..)
            .find(|(p, _)| !p.is_valid() || negative_zero(p.x) || negative_zero(p.y))
        {
            Some((p, corner)) => Err(format!("corner {corner} is at ({}, {})", p.x, p.y)),
            None => Ok(()),
        }
    }

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
        size_of::<Self>()
            + self.coordinates.len()
            + self.z.as_ref().map_or(0, Bytes::len)
            + self.foreign.len()
            + self.constraints.iter().map(Bytes::len).sum::<usize>()
            + packed.iter().map(|p| p.byte_size()).sum::<usize>()
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
        assert!(side < 3 * self.triangle_count(), "tile {} has no side {side}", self.id);
        let side = side as usize;
        let (bits, side) = match side.checked_sub(self.triangles.len()) {
            None => (&self.constraints[0], side),
            Some(side) => (&self.constraints[1], side),
        };
        bits.get(side / 8).is_some_and(|byte| byte >> (side % 8) & 1 == 1)
    }

    /// The sides of the tile that are on constraint edges which belong to it, one for each.
    pub fn owned_constraints(&self) -> impl Iterator<Item = u32> {
        let is_first = |side: u32| match self.across(side) {
            Across::Side(other) => side < other,
            Across::Hull => true,
            // Both ends are other tiles'.
            Across::Elsewhere => false,
        };
        let any = self.constraints.iter().any(|bits| !bits.is_empty());
        let sides = 0..if any { 3 * self.triangle_count() } else { 0 };
        sides.filter(move |&side| {
            self.is_constraint(side) && is_first(side) && {
                let [from, to] = self.ends(side);
                let smallest = if from.point.lex_cmp(to.point).is_lt() { from } else { to };
                smallest.id.tile == self.id
            }
        })
    }

    /// The vertices of a side.
    #[must_use]
    pub fn ends(&self, side: u32) -> [Vertex; 2] {
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
    let (mut low, mut high) = (0, pairs.len() / 2);
    while low < high {
        let middle = (low + high) / 2;
        let found = pairs.get(2 * middle);
        if found == key {
            return Some(pairs.get(2 * middle + 1) as u32);
        }
        if found < key {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    None
}

fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"))
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}
