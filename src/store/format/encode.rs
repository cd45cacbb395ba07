//! Encodes tiles.

use bytes::Bytes;
use flatbuffers::{FlatBufferBuilder, Vector, WIPOffset};

use crate::geometry::{HalfEdge, PackedHalfEdge, Point, TriangleId};
use crate::io::Buffers;
use crate::mesh::{Twin, WALLS};
use crate::store::format::generated::tile as schema;
use crate::store::format::ids::{TileId, VertexId};
use crate::store::format::line_part::LinePart;
use crate::store::format::packed;
use crate::store::format::packed::mark;

/// The mark for a neighbour that is not in the core, or for a vertex that has no triangle in the
/// core.
const NOT_IN_CORE: u64 = mark(0);
/// The mark for a missing neighbour in a border: the edge is on the hull.
const HULL: u64 = mark(0);
/// The mark for a neighbour in a border that has no vertex in the tile.
const ELSEWHERE: u64 = mark(1);

type PackedOffset<'b> = WIPOffset<schema::Packed<'b>>;
type BitsOffset<'b> = WIPOffset<Vector<'b, u8>>;

/// The content of a core.
///
/// There is no `Default` outside tests: code that writes a tile must name each attribute, so that
/// none is forgotten when one is added.
#[derive(Debug)]
#[cfg_attr(test, derive(Clone, Default))]
pub(crate) struct CoreDraft {
    /// The vertices.
    pub(crate) points: Vec<Point>,
    /// The z of each vertex; empty if the file has no z.
    pub(crate) z: Vec<f64>,
    /// The record number of each vertex.
    pub(crate) records: Vec<u64>,
    /// Whether a point of the input lies at each vertex. Empty if one does at all of them.
    pub(crate) input_points: Vec<bool>,
    /// The corners of the triangles.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The twin of each half-edge, if it is in the core.
    pub(crate) neighbours: Vec<[PackedHalfEdge; 3]>,
    /// For each triangle, a bit per half-edge that says whether the edge is a constraint, and from
    /// bit [`WALLS`] on a bit per half-edge that says whether it is a wall. Empty if there are no
    /// constraints.
    pub(crate) constraints: Vec<u8>,
    /// For each triangle the number of its component: the triangles that are connected within the
    /// tile without crossing a constraint. Empty if all are of component 0.
    pub(crate) components: Vec<u32>,
    /// For each constraint edge between two triangles of the core: its smaller half-edge, and a
    /// part of a line as seen along that half-edge. In order.
    pub(crate) edge_sources: Vec<(u32, LinePart)>,
    /// Pairs (vertex, number of the site there), in order.
    pub(crate) sites: Vec<(u32, u64)>,
    /// The ids of the sites; an id is empty where the number is the id. The list is empty if this
    /// holds for all sites.
    pub(crate) site_ids: Vec<String>,
}

/// The content of a border. As for cores, there is no `Default` outside tests.
#[derive(Debug)]
#[cfg_attr(test, derive(Clone, Default))]
pub(crate) struct BorderDraft {
    /// The number of vertices of the tile.
    pub(crate) vertices: u32,
    /// The number of triangles of its core.
    pub(crate) core_triangles: u32,
    /// The vertices of other tiles, in order.
    pub(crate) foreign: Vec<(VertexId, Point)>,
    /// The z of each of these; `None` if the file has no z.
    pub(crate) foreign_z: Option<Vec<f64>>,
    /// The corners of the triangles: numbers below `vertices` are the tile's own vertices, the
    /// others index `foreign`.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The twin of each half-edge. Half-edges are numbered through core and border.
    pub(crate) neighbours: Vec<[Twin; 3]>,
    /// Pairs (half-edge of the core, half-edge of the border), in order.
    pub(crate) core_links: Vec<(u32, u32)>,
    /// Pairs (vertex, half-edge that starts there), in order.
    pub(crate) vertex_sides: Vec<(u32, u32)>,
    /// Constraints and walls, as in [`CoreDraft::constraints`].
    pub(crate) constraints: Vec<u8>,
    /// For each triangle its component, as in [`CoreDraft::components`].
    pub(crate) components: Vec<u32>,
    /// For each constraint edge that belongs to the tile, except those between two triangles of the
    /// core: the smaller half-edge that the tile knows, numbered through core and border, and a
    /// part of a line as seen along that half-edge. In order.
    pub(crate) edge_sources: Vec<(u32, LinePart)>,
    /// In a file without triangles: the constraint edges, each from a vertex of the tile to the
    /// next corner on the line, in order. `edge_sources` then contains indices into this list in
    /// place of half-edges.
    pub(crate) edges: Vec<[u32; 2]>,
}

impl CoreDraft {
    /// Returns the draft of a tile without vertices.
    pub(crate) const fn empty() -> Self {
        Self {
            points: Vec::new(),
            z: Vec::new(),
            records: Vec::new(),
            input_points: Vec::new(),
            triangles: Vec::new(),
            neighbours: Vec::new(),
            constraints: Vec::new(),
            components: Vec::new(),
            edge_sources: Vec::new(),
            sites: Vec::new(),
            site_ids: Vec::new(),
        }
    }

    /// Clears all lists and keeps their memory.
    pub(crate) fn clear(&mut self) {
        let Self {
            points,
            z,
            records,
            input_points,
            triangles,
            neighbours,
            constraints,
            components,
            edge_sources,
            sites,
            site_ids,
        } = self;
        points.clear();
        z.clear();
        records.clear();
        input_points.clear();
        triangles.clear();
        neighbours.clear();
        constraints.clear();
        components.clear();
        edge_sources.clear();
        sites.clear();
        site_ids.clear();
    }

    /// Encodes the core as a FlatBuffer in one of `buffers`.
    pub(crate) fn encode(&self, tile: TileId, generation: u32, buffers: &Buffers) -> Bytes {
        let content = CoreContent {
            points: &self.points,
            z: &self.z,
            records: &self.records,
            input_points: &self.input_points,
            triangles: self.triangles.iter().copied(),
            neighbours: self.neighbours.iter().copied(),
            constraints: &self.constraints,
            components: &self.components,
            edge_sources: &self.edge_sources,
            sites: &self.sites,
            site_ids: &self.site_ids,
        };
        content.encode(tile, generation, buffers)
    }
}

/// The content of a core where it is. The fields are those of [`CoreDraft`].
pub(crate) struct CoreContent<'a, T, N> {
    pub(crate) points: &'a [Point],
    pub(crate) z: &'a [f64],
    pub(crate) records: &'a [u64],
    pub(crate) input_points: &'a [bool],
    pub(crate) triangles: T,
    pub(crate) neighbours: N,
    pub(crate) constraints: &'a [u8],
    pub(crate) components: &'a [u32],
    pub(crate) edge_sources: &'a [(u32, LinePart)],
    pub(crate) sites: &'a [(u32, u64)],
    pub(crate) site_ids: &'a [String],
}

impl<T, N> CoreContent<'_, T, N>
where
    T: ExactSizeIterator<Item = [u32; 3]> + Clone,
    N: ExactSizeIterator<Item = [PackedHalfEdge; 3]>,
{
    /// Encodes the core as a FlatBuffer in one of `buffers`.
    pub(crate) fn encode(self, tile: TileId, generation: u32, buffers: &Buffers) -> Bytes {
        let vertices = self.points.len() as u64;
        let half_edges = 3 * self.triangles.len() as u64;
        let mut builder = FlatBufferBuilder::from_vec(buffers.zeroed(56 * self.points.len() + 1024));
        let vertex_sides = vertex_sides(self.points.len(), self.triangles.clone());
        let vertex_sides = packed::write(&mut builder, vertex_sides.into_iter().map(in_core), half_edges, 1);
        let neighbours = self.neighbours.map(|twins| twins.map(in_core));
        let neighbours = packed::write_groups(&mut builder, neighbours, half_edges, 1);
        let corners = self.triangles.map(|corners| corners.map(u64::from));
        let triangles = packed::write_groups(&mut builder, corners, vertices, 0);
        let first_record = self.records.iter().copied().min().unwrap_or(0);
        let last_record = self.records.iter().copied().max().unwrap_or(0);
        let records = self.records.iter().map(|record| record - first_record);
        let records = packed::write(&mut builder, records, last_record - first_record, 0);
        let z = (!self.z.is_empty()).then(|| builder.create_vector(self.z));
        let coordinates: Vec<[f64; 2]> = self.points.iter().map(|p| [p.x, p.y]).collect();
        let coordinates = builder.create_vector(coordinates.as_flattened());
        let constraints = half_edge_bits(&mut builder, self.constraints, 0);
        let walls = half_edge_bits(&mut builder, self.constraints, WALLS);
        let components = optional(&mut builder, self.components.iter().map(|&c| c.into()));
        let segment_ends = segment_ends(&mut builder, self.edge_sources);
        let [edge_sides, edge_sources] = edge_sources(&mut builder, self.edge_sources);
        let input_points = bits_unless_all(&mut builder, self.input_points.iter().copied());
        let sites = (!self.sites.is_empty()).then(|| {
            let largest = self.sites.iter().map(|&(_, number)| number).max().unwrap_or(0);
            pairs(&mut builder, self.sites, largest.max(vertices))
        });
        let ids = (!self.site_ids.is_empty()).then(|| texts(&mut builder, self.site_ids));
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
            walls,
            components,
            edge_sides,
            edge_sources,
            sites,
            site_ids: ids.map(|(_, text)| text),
            site_id_ends: ids.map(|(ends, _)| ends),
            input_points,
            segment_ends,
        };
        let root = schema::Core::create(&mut builder, &args);
        builder.finish(root, None);
        finished(builder, buffers)
    }
}

/// Returns a half-edge that leaves each vertex: the last one, in the order of the triangles.
fn vertex_sides(vertices: usize, triangles: impl Iterator<Item = [u32; 3]>) -> Vec<PackedHalfEdge> {
    let mut sides = vec![PackedHalfEdge::NONE; vertices];
    for (corners, triangle) in triangles.zip((0..).map(TriangleId)) {
        for (vertex, half_edge) in corners.into_iter().zip(HalfEdge::of_triangle(triangle)) {
            sides[vertex as usize] = half_edge.into();
        }
    }
    sides
}

fn in_core(half_edge: PackedHalfEdge) -> u64 {
    half_edge.get().map_or(NOT_IN_CORE, |twin| twin.0.into())
}

impl BorderDraft {
    /// Encodes the border as a FlatBuffer in one of `buffers`.
    pub(crate) fn encode(&self, tile: TileId, generation: u32, buffers: &Buffers) -> Bytes {
        let corners = u64::from(self.vertices) + self.foreign.len() as u64;
        let core_half_edges = 3 * u64::from(self.core_triangles);
        let half_edges = core_half_edges + 3 * self.triangles.len() as u64;
        let mut builder = FlatBufferBuilder::from_vec(buffers.zeroed(64 * self.triangles.len() + 1024));
        let vertex_sides = pairs(&mut builder, &self.vertex_sides, half_edges.max(corners));
        let core_links = pairs(&mut builder, &self.core_links, half_edges);
        let neighbours = self.neighbours.as_flattened().iter().map(|twin| match twin {
            Twin::HalfEdge(twin) => twin.0.into(),
            Twin::Hull => HULL,
            Twin::Elsewhere => ELSEWHERE,
        });
        let neighbours = packed::write(&mut builder, neighbours, half_edges, 2);
        let triangles = self.triangles.iter().map(|corners| corners.map(u64::from));
        let triangles = packed::write_groups(&mut builder, triangles, corners, 0);
        let foreign: Vec<_> = self
            .foreign
            .iter()
            .map(|&(id, p)| schema::ForeignVertex::new(p.x, p.y, id.tile.0, id.index.0))
            .collect();
        let foreign = builder.create_vector(&foreign);
        let foreign_z = self.foreign_z.as_ref().map(|z| builder.create_vector(z));
        let constraints = half_edge_bits(&mut builder, &self.constraints, 0);
        let walls = half_edge_bits(&mut builder, &self.constraints, WALLS);
        let components = optional(&mut builder, self.components.iter().map(|&c| c.into()));
        let segment_ends = segment_ends(&mut builder, &self.edge_sources);
        let [edge_sides, edge_sources] = edge_sources(&mut builder, &self.edge_sources);
        let edges = (!self.edges.is_empty()).then(|| {
            let ends = self.edges.as_flattened().iter().map(|&corner| corner.into());
            packed::write(&mut builder, ends, corners, 0)
        });
        let args = schema::BorderArgs {
            tile: tile.0,
            generation,
            foreign: Some(foreign),
            triangles: Some(triangles),
            neighbours: Some(neighbours),
            core_links: Some(core_links),
            vertex_sides: Some(vertex_sides),
            constraints,
            walls,
            components,
            edge_sides,
            edge_sources,
            edges,
            foreign_z,
            segment_ends,
        };
        let root = schema::Border::create(&mut builder, &args);
        builder.finish(root, None);
        finished(builder, buffers)
    }
}

/// Writes pairs one after the other. Their largest number is at most `largest`.
fn pairs<'b>(
    builder: &mut FlatBufferBuilder<'b>,
    pairs: &[(u32, impl Copy + Into<u64>)],
    largest: u64,
) -> PackedOffset<'b> {
    let numbers: Vec<u64> = pairs.iter().flat_map(|&(a, b)| [a.into(), b.into()]).collect();
    packed::write(builder, numbers.into_iter(), largest, 0)
}

/// Writes texts one after the other. Returns the end offset of each, and the concatenated text.
fn texts<'b>(builder: &mut FlatBufferBuilder<'b>, texts: &[String]) -> (PackedOffset<'b>, WIPOffset<&'b str>) {
    let ends = texts.iter().scan(0, |end, text| {
        *end += text.len() as u64;
        Some(*end)
    });
    let (ends, all): (Vec<u64>, _) = (ends.collect(), texts.concat());
    let ends = packed::write(builder, ends.into_iter(), all.len() as u64, 0);
    (ends, builder.create_string(&all))
}

/// Writes one bit per half-edge. `triangles` holds three bits per triangle, from bit `first` on.
/// Returns `None` if no bit is set.
fn half_edge_bits<'b>(builder: &mut FlatBufferBuilder<'b>, triangles: &[u8], first: u32) -> Option<BitsOffset<'b>> {
    let (eights, rest) = triangles.as_chunks::<8>();
    let bits_of = |triangles: &[u8; 8]| {
        // In each step, adjacent groups of bits are joined: 8 of 3 bits, 4 of 6, 2 of 12.
        let groups = u64::from_le_bytes(*triangles) >> first & 0x0707_0707_0707_0707;
        let groups = (groups | groups >> 5) & 0x003f_003f_003f_003f;
        let groups = (groups | groups >> 10) & 0x0000_0fff_0000_0fff;
        let [a, b, c, ..] = (groups | groups >> 20).to_le_bytes();
        [a, b, c]
    };
    let mut bytes: Vec<u8> = Vec::with_capacity(3 * triangles.len().div_ceil(8));
    bytes.extend(eights.iter().flat_map(bits_of));
    if !rest.is_empty() {
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        bytes.extend_from_slice(&bits_of(&last)[..(3 * rest.len()).div_ceil(8)]);
    }
    bytes
        .iter()
        .any(|&byte| byte != 0)
        .then(|| builder.create_vector(&bytes))
}

/// Writes bits, from the lowest of the first byte on. Returns `None` if all bits are set.
fn bits_unless_all<'b>(
    builder: &mut FlatBufferBuilder<'b>,
    mut values: impl Iterator<Item = bool> + Clone,
) -> Option<BitsOffset<'b>> {
    let all = values.clone();
    values.any(|bit| !bit).then(|| all_bits(builder, all))
}

fn all_bits<'b>(builder: &mut FlatBufferBuilder<'b>, values: impl Iterator<Item = bool>) -> BitsOffset<'b> {
    let mut bytes: Vec<u8> = Vec::new();
    for (value, index) in values.zip(0..) {
        if index % 8 == 0 {
            bytes.push(0);
        }
        bytes[index / 8] |= u8::from(value) << (index % 8);
    }
    builder.create_vector(&bytes)
}

/// Writes whether each part of a line begins and ends a segment. Returns `None` if all parts do
/// both.
fn segment_ends<'b>(builder: &mut FlatBufferBuilder<'b>, edges: &[(u32, LinePart)]) -> Option<BitsOffset<'b>> {
    bits_unless_all(builder, edges.iter().flat_map(|(_, part)| part.end_bits()))
}

/// Writes values, each in as few bytes as the largest needs. Returns `None` if all are 0.
fn optional<'b>(
    builder: &mut FlatBufferBuilder<'b>,
    values: impl ExactSizeIterator<Item = u64> + Clone,
) -> Option<PackedOffset<'b>> {
    let largest = values.clone().max().filter(|&largest| largest > 0)?;
    Some(packed::write(builder, values, largest, 0))
}

/// Writes the half-edges and the sources of their edges.
fn edge_sources<'b>(builder: &mut FlatBufferBuilder<'b>, edges: &[(u32, LinePart)]) -> [Option<PackedOffset<'b>>; 2] {
    if edges.is_empty() {
        return [None; 2];
    }
    let mut write = |values: &dyn Fn(&(u32, LinePart)) -> u64| {
        let largest = edges.iter().map(values).max().unwrap_or(0);
        Some(packed::write(builder, edges.iter().map(values), largest, 0))
    };
    [write(&|edge| edge.0.into()), write(&|edge| edge.1.source().to_bits())]
}

/// Returns the finished bytes without a copy: they are at the end of the builder's buffer.
fn finished(builder: FlatBufferBuilder<'_>, buffers: &Buffers) -> Bytes {
    let (buffer, start) = builder.collapse();
    buffers.freeze(buffer).slice(start..)
}
