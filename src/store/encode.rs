//! Tiles to bytes.

use bytes::Bytes;
use flatbuffers::FlatBufferBuilder;

use super::generated::tile as schema;
use super::packed::{self, mark};
use super::{TileId, VertexId};
use crate::geometry::Point;
use crate::io::Buffers;

/// Marks of the neighbours in a core.
pub(crate) const NOT_IN_CORE: u64 = mark(0);
/// Marks of the neighbours in a border.
pub(crate) const HULL: u64 = mark(0);
/// A neighbour without a vertex in the tile.
pub(crate) const ELSEWHERE: u64 = mark(1);

/// What a core is made of.
#[derive(Debug, Default)]
pub(crate) struct CoreDraft {
    /// The vertices.
    pub(crate) points: Vec<Point>,
    /// Their z, or nothing.
    pub(crate) z: Vec<f64>,
    /// Their record numbers.
    pub(crate) records: Vec<u64>,
    /// Corners of the triangles.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Sides across, or [`NONE`](crate::mesh::NONE).
    pub(crate) neighbours: Vec<[u32; 3]>,
    /// For each triangle a bit for each side that is a constraint; or nothing, if none is.
    pub(crate) constraints: Vec<u8>,
}

/// What a border is made of.
#[derive(Debug, Default)]
pub(crate) struct BorderDraft {
    /// Vertices of the tile.
    pub(crate) vertices: u32,
    /// Triangles of its core.
    pub(crate) core_triangles: u32,
    /// The vertices of other tiles, in order.
    pub(crate) foreign: Vec<(VertexId, Point)>,
    /// Corners: below `vertices` the tile's own, then foreign ones.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Sides across, numbered through core and border, or [`HULL`], or [`ELSEWHERE`].
    pub(crate) neighbours: Vec<[u64; 3]>,
    /// Pairs (side of the core, side of the border) in order.
    pub(crate) core_links: Vec<(u32, u32)>,
    /// Pairs (vertex, side that starts there) in order.
    pub(crate) vertex_sides: Vec<(u32, u32)>,
    /// For each triangle a bit for each side that is a constraint; or nothing, if none is.
    pub(crate) constraints: Vec<u8>,
}

impl CoreDraft {
    /// Empties it, and keeps its memory.
    pub(crate) fn clear(&mut self) {
        self.points.clear();
        self.z.clear();
        self.records.clear();
        self.triangles.clear();
        self.neighbours.clear();
        self.constraints.clear();
    }

    /// The FlatBuffer of the core, in one of these buffers.
    pub(crate) fn encode(&self, tile: TileId, generation: u32, buffers: &Buffers) -> Bytes {
        let vertices = self.points.len() as u64;
        let sides = 3 * self.triangles.len() as u64;
        let mut vertex_sides = vec![NOT_IN_CORE; self.points.len()];
        for (&vertex, side) in self.triangles.as_flattened().iter().zip(0u64..) {
            vertex_sides[vertex as usize] = side;
        }
        let mut builder = FlatBufferBuilder::from_vec(buffers.zeroed(56 * self.points.len() + 1024));
        let vertex_sides = packed::write(&mut builder, vertex_sides.into_iter(), sides, 1);
        let neighbours = self.neighbours.as_flattened().iter().map(|&side| match side {
            crate::mesh::NONE => NOT_IN_CORE,
            side => u64::from(side),
        });
        let neighbours = packed::write(&mut builder, neighbours, sides, 1);
        let corners = self.triangles.as_flattened().iter().map(|&v| u64::from(v));
        let triangles = packed::write(&mut builder, corners, vertices, 0);
        let first_record = self.records.iter().copied().min().unwrap_or(0);
        let last_record = self.records.iter().copied().max().unwrap_or(0);
        let records = self.records.iter().map(|record| record - first_record);
        let records = packed::write(&mut builder, records, last_record - first_record, 0);
        let z = (!self.z.is_empty()).then(|| builder.create_vector(&self.z));
        let coordinates: Vec<f64> = self.points.iter().flat_map(|p| [p.x, p.y]).collect();
        let coordinates = builder.create_vector(&coordinates);
        let constraints = constraint_bits(&self.constraints).map(|bits| builder.create_vector(&bits));
        let args = schema::CoreArgs {
            tile: tile.0,
            generation,
            coordinates: Some(coordinates),
            z,
            first_record,
            records: Some(records),
            triangles: Some(triangles),
            neighbours: Some(neighbours),
            vertex_sides: Some(vertex_sides),
            constraints,
        };
        let root = schema::Core::create(&mut builder, &args);
        builder.finish(root, None);
        finished(builder, buffers)
    }
}

impl BorderDraft {
    /// The FlatBuffer of the border, in one of these buffers.
    pub(crate) fn encode(&self, tile: TileId, generation: u32, buffers: &Buffers) -> Bytes {
        let corners = u64::from(self.vertices) + self.foreign.len() as u64;
        let core_sides = 3 * u64::from(self.core_triangles);
        let sides = core_sides + 3 * self.triangles.len() as u64;
        let mut builder = FlatBufferBuilder::from_vec(buffers.zeroed(64 * self.triangles.len() + 1024));
        let pairs = |pairs: &[(u32, u32)]| {
            pairs
                .iter()
                .flat_map(|&(a, b)| [a.into(), b.into()])
                .collect::<Vec<u64>>()
        };
        let vertex_sides = pairs(&self.vertex_sides).into_iter();
        let vertex_sides = packed::write(&mut builder, vertex_sides, sides.max(corners), 0);
        let core_links = packed::write(&mut builder, pairs(&self.core_links).into_iter(), sides, 0);
        let neighbours = self.neighbours.as_flattened().iter().copied();
        let neighbours = packed::write(&mut builder, neighbours, sides, 2);
        let triangles = self.triangles.as_flattened().iter().map(|&v| u64::from(v));
        let triangles = packed::write(&mut builder, triangles, corners, 0);
        let foreign: Vec<_> = self
            .foreign
            .iter()
            .map(|&(id, p)| schema::ForeignVertex::new(p.x, p.y, id.tile.0, id.index))
            .collect();
        let foreign = builder.create_vector(&foreign);
        let constraints = constraint_bits(&self.constraints).map(|bits| builder.create_vector(&bits));
        let args = schema::BorderArgs {
            tile: tile.0,
            generation,
            foreign: Some(foreign),
            triangles: Some(triangles),
            neighbours: Some(neighbours),
            core_links: Some(core_links),
            vertex_sides: Some(vertex_sides),
            constraints,
        };
        let root = schema::Border::create(&mut builder, &args);
        builder.finish(root, None);
        finished(builder, buffers)
    }
}

/// A bit for each side, from three for each triangle; none if no side is a constraint.
fn constraint_bits(triangles: &[u8]) -> Option<Vec<u8>> {
    if triangles.iter().all(|&sides| sides == 0) {
        return None;
    }
    let mut bits = vec![0u8; (3 * triangles.len()).div_ceil(8)];
    for (sides, first) in triangles.iter().zip((0..).step_by(3)) {
        for side in (0..3).filter(|s| sides >> s & 1 == 1).map(|s| first + s) {
            bits[side / 8] |= 1 << (side % 8);
        }
    }
    Some(bits)
}

/// The finished bytes, without a copy: they lie at the end of the builder's buffer.
fn finished(builder: FlatBufferBuilder<'_>, buffers: &Buffers) -> Bytes {
    let (buffer, start) = builder.collapse();
    buffers.freeze(buffer).slice(start..)
}
