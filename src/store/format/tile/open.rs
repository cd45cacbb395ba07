//! Opens a tile from its bytes, with all checks that keep later accesses from panicking.
//!
//! Checks of ranges have no early exit, so that the compiler can vectorise them. Nothing is decoded
//! or copied here, so a scan of tiles whose bytes are in memory waits for these checks.

use std::sync::Arc;

use bytes::Bytes;

use crate::geometry::{Point, VertexIndex};
use crate::store::format::damage::Damage;
use crate::store::format::entry::TileEntry;
use crate::store::format::extent::Extent;
use crate::store::format::flat_buffer::{check_crc, verified};
use crate::store::format::generated::tile as schema;
use crate::store::format::ids::TileId;
use crate::store::format::packed::Packed;
use crate::store::format::table_place::TablePlace;
use crate::store::format::tile::edge_bits::{EdgeSources, HalfEdgeBits};
use crate::store::format::tile::regions::Regions;
use crate::store::format::tile::sites::Sites;
use crate::store::format::tile::{FOREIGN, Tile};

/// Checks that a part belongs to the tile and the generation that the directory names.
fn check_identity(id: TileId, entry: &TileEntry, part: &str, tile: u32, generation: u32) -> Result<(), Damage> {
    if (tile, generation) == (id.0, entry.generation) {
        return Ok(());
    }
    Err(Damage::new(format!(
        "the {part} is that of tile {tile}, generation {generation}"
    )))
}

impl Tile {
    /// Opens a tile from its stored bytes, and checks these against its entry and all indices in
    /// them. `table` is its component table if that lies apart. The error says what is wrong.
    pub(crate) fn open(
        id: TileId,
        entry: &TileEntry,
        [core, border]: [&Bytes; 2],
        table: Option<&Bytes>,
    ) -> Result<Self, Damage> {
        check_crc("the core", core, entry.core.crc)?;
        check_crc("the border", border, entry.border.crc)?;
        let decode = |extent: Extent, stored: &Bytes| extent.codec.decode(stored, extent.decoded);
        let core = &decode(entry.core, core).map_err(|damage| damage.of("the core"))?;
        let border = &decode(entry.border, border).map_err(|damage| damage.of("the border"))?;
        let core_table: schema::Core<'_> = verified(core, "the core")?;
        let border_table: schema::Border<'_> = verified(border, "the border")?;
        check_identity(id, entry, "core", core_table.tile(), core_table.generation())?;
        check_identity(id, entry, "border", border_table.tile(), border_table.generation())?;
        let table = match (entry.table, table) {
            (TablePlace::Apart(extent), Some(table)) => {
                check_crc("the component table", table, extent.crc)?;
                table.clone()
            }
            (TablePlace::InPage(table), _) => Bytes::copy_from_slice(table.bytes()),
            _ => Bytes::new(),
        };
        let triangles = [entry.core_triangles, entry.border_triangles].map(|count| count as usize);
        let [in_core, in_border] = triangles.map(|count| 3 * count);
        let edges = border_table.edges();
        let edges = edges.map(|edges| Packed::open(border, edges)).transpose()?;
        // Without triangles, sources refer to edges in place of half-edges.
        let edge_limit = edges.as_ref().map_or(in_core + in_border, |edges| edges.len() / 2);
        let (c, b) = (core_table, border_table);
        let of_border = |damage: Damage| damage.of("the border");
        let open = |buffer: &Bytes, what: &str, table| Packed::open(buffer, table).map_err(|damage| damage.of(what));
        let this = Self {
            id,
            coordinates: core.slice_ref(core_table.coordinates().bytes()),
            z: core_table.z().map(|z| core.slice_ref(z.bytes())),
            first_record: core_table.first_record(),
            records: open(core, "records", core_table.records())?,
            input_points: core_table.input_points().map(|bits| core.slice_ref(bits.bytes())),
            triangles: open(core, "triangles", core_table.triangles())?,
            neighbours: open(core, "neighbours", core_table.neighbours())?,
            vertex_sides: open(core, "vertex sides", core_table.vertex_sides())?,
            foreign: border.slice_ref(border_table.foreign().bytes()),
            foreign_z: border_table.foreign_z().map(|z| border.slice_ref(z.bytes())),
            border_triangles: open(border, "border triangles", border_table.triangles())?,
            border_neighbours: open(border, "border neighbours", border_table.neighbours())?,
            core_links: open(border, "core links", border_table.core_links())?,
            border_vertex_sides: open(border, "border vertex sides", border_table.vertex_sides())?,
            half_edge_bits: [
                HalfEdgeBits::open(core, c.constraints(), c.walls(), in_core)?,
                HalfEdgeBits::open(border, b.constraints(), b.walls(), in_border).map_err(of_border)?,
            ],
            sources: [
                EdgeSources::open(core, c.edge_sides(), c.edge_sources(), c.segment_ends(), in_core)?,
                EdgeSources::open(border, b.edge_sides(), b.edge_sources(), b.segment_ends(), edge_limit)
                    .map_err(of_border)?,
            ],
            regions: Regions::open(id, (core, core_table), (border, border_table), table, triangles)?,
            edges,
            sites: Sites::open(core, core_table, entry.vertices.into())?,
            notes: Arc::default(),
        };
        this.check(entry)?;
        Ok(this)
    }

    /// Checks that there are as many numbers of each kind as the entry asks for.
    fn check_lengths(&self, entry: &TileEntry) -> Result<(), Damage> {
        let vertices = entry.vertices as usize;
        let (core, border) = (entry.core_triangles as usize, entry.border_triangles as usize);
        if self.z.is_some() != self.foreign_z.is_some() {
            return Err(Damage::new("its core and its border disagree on whether there is a z"));
        }
        let z_count = |z: &Option<Bytes>, expected: usize| z.as_ref().map_or(expected, |z| z.len() / 8);
        let foreign = self.foreign_count();
        let bytes_of_points = vertices.div_ceil(8);
        let input_points = self.input_points.as_ref().map_or(bytes_of_points, Bytes::len);
        for (what, found, expected) in [
            ("coordinates", self.coordinates.len(), 16 * vertices),
            ("z", z_count(&self.z, vertices), vertices),
            ("z of foreign vertices", z_count(&self.foreign_z, foreign), foreign),
            ("records", self.records.len(), vertices),
            ("bytes of input points", input_points, bytes_of_points),
            ("corners of the core", self.triangles.len(), 3 * core),
            ("neighbours of the core", self.neighbours.len(), 3 * core),
            ("vertex sides", self.vertex_sides.len(), vertices),
            ("corners of the border", self.border_triangles.len(), 3 * border),
            ("neighbours of the border", self.border_neighbours.len(), 3 * border),
            ("unpaired core links", self.core_links.len() % 2, 0),
            ("unpaired border vertex sides", self.border_vertex_sides.len() % 2, 0),
        ] {
            if found != expected {
                return Err(Damage::new(format!("there are {found} {what}, not {expected}")));
            }
        }
        Ok(())
    }

    /// Checks lengths and ranges, so that no later access panics.
    fn check(&self, entry: &TileEntry) -> Result<(), Damage> {
        self.check_lengths(entry)?;
        let vertices = entry.vertices as usize;
        let (core, border) = (entry.core_triangles as usize, entry.border_triangles as usize);
        let corners = self.corner_count() as u64;
        let core_half_edges = 3 * core as u64;
        let half_edges = core_half_edges + 3 * border as u64;
        let below = |what: &str, values: &Packed, limit: u64, marks: u64| {
            // Marks are the largest values.
            match values.find_within(limit..=values.largest() - marks) {
                Some(value) => Err(Damage::new(format!("{what} {value} is not below {limit}"))),
                None => Ok(()),
            }
        };
        below("corner", &self.triangles, vertices as u64, 0)?;
        below("neighbour", &self.neighbours, core_half_edges, 1)?;
        below("vertex side", &self.vertex_sides, core_half_edges, 1)?;
        below("border corner", &self.border_triangles, corners, 0)?;
        below("border neighbour", &self.border_neighbours, half_edges, 2)?;
        let pairs = |values: &Packed| -> Vec<(u64, u64)> {
            (0..values.len() / 2)
                .map(|i| (values.get(2 * i), values.get(2 * i + 1)))
                .collect()
        };
        for (what, values, keys) in [
            ("core link", &self.core_links, core_half_edges),
            ("border vertex side", &self.border_vertex_sides, vertices as u64),
        ] {
            let pairs = pairs(values);
            let in_range = pairs
                .iter()
                .all(|&(key, half_edge)| key < keys && half_edge < half_edges);
            if !in_range || !pairs.is_sorted_by(|a, b| a.0 < b.0) {
                return Err(Damage::new(format!("a {what} is out of range or out of order")));
            }
        }
        self.check_edges(entry)?;
        let overflows = |record: u64| self.first_record.checked_add(record).is_none();
        if overflows(self.records.largest()) && self.records.iter().any(overflows) {
            return Err(Damage::new("a record number exceeds 64 bits"));
        }
        self.check_points()?;
        self.check_z()
    }

    /// Checks that all coordinates are valid.
    fn check_points(&self) -> Result<(), Damage> {
        // No early exit, so that the compiler can vectorise the comparisons.
        let all = |bytes: &[u8]| {
            bytes
                .as_chunks()
                .0
                .iter()
                .fold(true, |all, &v| all & is_stored(f64::from_le_bytes(v)))
        };
        if all(&self.coordinates) && self.foreign.chunks_exact(FOREIGN).all(|vertex| all(&vertex[..16])) {
            return Ok(());
        }
        let points = (0..self.corner_count() as u32).map(|corner| self.point(VertexIndex(corner)));
        match points.zip(0..).find(|(p, _)| !is_stored(p.x) || !is_stored(p.y)) {
            Some((p, corner)) => Err(Damage::new(format!(
                "corner {corner} has the invalid coordinates ({}, {})",
                p.x, p.y
            ))),
            None => Ok(()),
        }
    }

    /// Checks that each z is finite.
    fn check_z(&self) -> Result<(), Damage> {
        // As for coordinates, no early exit.
        let all = |bytes: &Bytes| {
            let values = bytes.as_chunks().0.iter();
            values.fold(true, |all, &z| all & f64::from_le_bytes(z).is_finite())
        };
        if [&self.z, &self.foreign_z].into_iter().flatten().all(all) {
            return Ok(());
        }
        let is_infinite = |&corner: &u32| self.z(VertexIndex(corner)).is_some_and(|z| !z.is_finite());
        match (0..self.corner_count() as u32).find(is_infinite) {
            Some(vertex) if vertex < self.vertex_count() => {
                Err(Damage::new(format!("vertex {vertex} has no finite z")))
            }
            Some(corner) => {
                let id = self.vertex(VertexIndex(corner)).id;
                Err(Damage::new(format!("vertex {id} of another tile has no finite z")))
            }
            None => Ok(()),
        }
    }

    /// Checks the edge list. Only a tile without triangles has one; each edge leads from a
    /// different vertex of the tile, in order, to another corner.
    fn check_edges(&self, entry: &TileEntry) -> Result<(), Damage> {
        let Some(edges) = &self.edges else { return Ok(()) };
        if entry.core_triangles > 0 || entry.border_triangles > 0 {
            return Err(Damage::new("it has both triangles and a list of edges"));
        }
        if edges.len() % 2 == 1 {
            return Err(Damage::new("an edge has only one end"));
        }
        let vertices = u64::from(entry.vertices);
        let corners = vertices + self.foreign_count() as u64;
        let mut next = 0;
        for index in (0..edges.len()).step_by(2) {
            let [from, to] = [edges.get(index), edges.get(index + 1)];
            if from < next || from >= vertices || to >= corners || from == to {
                return Err(Damage::new(format!(
                    "the edge from {from} to {to} is out of range or out of order"
                )));
            }
            next = from + 1;
        }
        Ok(())
    }
}

/// Returns whether a file may contain the coordinate: it is valid, and not a negative zero.
fn is_stored(coordinate: f64) -> bool {
    // Compared as numbers, since SSE2 does not compare integers of 64 bits. No comparison holds for NaN.
    let magnitude = coordinate.abs();
    (Point::MIN_MAGNITUDE..=Point::MAX_MAGNITUDE).contains(&magnitude) | (coordinate.to_bits() == 0)
}
