//! A reader of tile files that depends only on the format's page.

use crc32c::crc32c;
use delaunay_tiles::geometry::Point;

use crate::format::codec;
use crate::format::components::{Component, read_table};
use crate::format::directory::{Directory, Node, Part, TablePlace, WithTiles, read_directory};
use crate::format::labels::{Source, bits, bits_or, optional, read_components, read_sites, sources};
use crate::format::page::Page;
use crate::support::flat::{Table, f64_at, u16_at, u32_at, u64_at};

pub struct File {
    pub file_id: u128,
    pub directory: Directory,
    pub tiles: Vec<Tile>,
}

pub struct Tile {
    pub core_offset: u64,
    pub border_offset: u64,
    pub owned: u32,
    pub bounds: [f64; 4],
    pub points: Vec<Point>,
    pub z: Vec<f64>,
    pub records: Vec<u64>,
    /// Whether a point of the input lies at each vertex.
    pub input_points: Vec<bool>,
    /// Whether the tile stores what holds its vertices and edges. Otherwise points do, and all segments are whole.
    pub stores_held: bool,
    pub core_triangles: usize,
    corners: Vec<usize>,
    neighbours: Vec<Option<usize>>,
    vertex_half_edges: Vec<Option<usize>>,
    /// Point, tile and index in that tile.
    foreign: Vec<(Point, usize, usize)>,
    pub foreign_z: Vec<f64>,
    border_neighbours: Vec<Twin>,
    core_links: Vec<(usize, usize)>,
    border_vertex_half_edges: Vec<(usize, usize)>,
    /// One flag for each half-edge.
    pub constraints: Vec<bool>,
    pub walls: Vec<bool>,
    /// The component of each triangle.
    pub components: Vec<usize>,
    /// The component table.
    pub table: Vec<Component>,
    /// Half-edge and source, for edges within the core and for other edges.
    edge_sources: [Vec<(usize, Source)>; 2],
    /// The corners of edges, in a file without triangles.
    pub edges: Vec<(usize, usize)>,
    /// Vertex, number and id of each site.
    pub sites: Vec<(usize, u64, String)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Twin {
    HalfEdge(usize),
    Hull,
    Elsewhere,
}

/// The fields of a struct or superblock, by name.
pub struct Fields<'a> {
    pub page: &'a Page,
    pub table: &'a str,
    pub bytes: &'a [u8],
}

impl Fields<'_> {
    pub fn raw(&self, field: &str, size: usize) -> &[u8] {
        let position = self.page.position(self.table, field);
        assert_eq!(position.bytes, size, "bytes of {field}");
        &self.bytes[position.offset..position.offset + size]
    }

    pub fn u16(&self, field: &str) -> u16 {
        u16_at(self.raw(field, 2), 0)
    }

    pub fn u32(&self, field: &str) -> u32 {
        u32_at(self.raw(field, 4), 0)
    }

    pub fn u64(&self, field: &str) -> u64 {
        u64_at(self.raw(field, 8), 0)
    }

    pub fn f64(&self, field: &str) -> f64 {
        f64_at(self.raw(field, 8), 0)
    }
}

/// Returns the structs of a vector.
pub fn structs<'a>(page: &'a Page, name: &'a str, table: Table<'a>, slot: usize) -> Vec<Fields<'a>> {
    let (first, count) = table.vector(slot).unwrap();
    assert_eq!(first % 4, 0, "structs are aligned");
    let size = page.size(name);
    let chunks = table.bytes[first..first + count * size].chunks(size);
    let fields = |bytes| Fields {
        page,
        table: name,
        bytes,
    };
    chunks.map(fields).collect()
}

/// Returns integers, or `Err(k)` for mark `k`; the largest `marks` values are marks.
pub fn packed(page: &Page, table: Table<'_>, marks: u64) -> Vec<Result<u64, u64>> {
    let width = usize::from(table.u8(page.slot("Packed", "width")));
    assert!((1..=8).contains(&width));
    let (first, length) = table.vector(page.slot("Packed", "data")).unwrap();
    let data = &table.bytes[first..first + length];
    let count = (length - (8 - width)) / width;
    assert_eq!(length, count * width + 8 - width);
    assert!(data[count * width..].iter().all(|&b| b == 0), "padding is zero");
    let largest = u64::MAX >> (64 - 8 * width);
    let values = data[..count * width].chunks(width).map(|bytes| {
        let mut word = [0; 8];
        word[..width].copy_from_slice(bytes);
        u64::from_le_bytes(word)
    });
    values
        .map(|v| if largest - v < marks { Err(largest - v) } else { Ok(v) })
        .collect()
}

fn unmarked(page: &Page, table: Table<'_>) -> Vec<usize> {
    packed(page, table, 0)
        .into_iter()
        .map(|v| v.unwrap() as usize)
        .collect()
}

fn pairs(values: &[usize]) -> Vec<(usize, usize)> {
    let pairs: Vec<_> = values.chunks(2).map(|pair| (pair[0], pair[1])).collect();
    assert!(pairs.is_sorted_by(|a, b| a.0 < b.0), "pairs ascend");
    pairs
}

impl File {
    /// Reads a file as the writer leaves it, and checks what the page promises of its layout.
    pub fn read(page: &Page, bytes: &[u8]) -> Self {
        let block = page.size("Superblock");
        assert_eq!(
            bytes[..block],
            bytes[block..2 * block],
            "a new file has twice the same superblock"
        );
        let superblock = Fields {
            page,
            table: "Superblock",
            bytes: &bytes[..block],
        };
        assert_eq!(superblock.raw("magic", 8), b"DELTILES");
        assert_eq!((superblock.u32("version"), superblock.u32("features")), (2, 0));
        assert_eq!(superblock.u64("generation"), 1);
        assert_eq!(superblock.u64("file_length"), bytes.len() as u64);
        assert!(
            superblock
                .raw("reserved", page.position("Superblock", "reserved").bytes)
                .iter()
                .all(|&b| b == 0)
        );
        let crc = page.position("Superblock", "crc").offset;
        assert_eq!(superblock.u32("crc"), crc32c(&bytes[..crc]));
        let file_id = u128::from_le_bytes(superblock.raw("file_id", 16).try_into().unwrap());

        let root = Part {
            offset: superblock.u64("root_offset"),
            length: superblock.u32("root_length"),
            crc: superblock.u32("root_crc"),
        };
        let WithTiles {
            directory,
            entries,
            tables,
            hashed,
        } = read_directory(page, bytes, root);
        assert_eq!(
            file_id,
            xxhash_rust::xxh3::xxh3_128(&hashed),
            "the file id is the hash of the directory"
        );

        // Cores follow the room for the root, aligned to 4096; borders follow, aligned to 8, each
        // with its component table, if that lies apart; gaps are zero.
        let mut end = directory.front_end;
        let mut extent = |offset: u64, length: u32, crc: u32, alignment: usize| {
            let offset = offset as usize;
            if end == directory.front_end {
                end = offset;
            }
            assert_eq!(offset, end.next_multiple_of(alignment));
            assert!(bytes[end..offset].iter().all(|&b| b == 0), "gaps are zero");
            end = offset + length as usize;
            assert_eq!(crc32c(&bytes[offset..end]), crc);
            &bytes[offset..end]
        };
        let entries: Vec<Fields<'_>> = entries
            .iter()
            .map(|bytes| Fields {
                page,
                table: "TileEntry",
                bytes,
            })
            .collect();
        let part = |e: &Fields<'_>, p: &str| {
            (
                e.u64(&format!("{p}_offset")),
                e.u32(&format!("{p}_length")),
                e.u32(&format!("{p}_crc")),
            )
        };
        let cores: Vec<_> = entries
            .iter()
            .map(|e| part(e, "core"))
            .map(|(offset, length, crc)| extent(offset, length, crc, 4096))
            .collect();
        let borders: Vec<_> = entries
            .iter()
            .map(|e| part(e, "border"))
            .zip(tables)
            .map(|((offset, length, crc), table)| {
                let border = extent(offset, length, crc, 8);
                let table = match table {
                    TablePlace::Nowhere => &[],
                    TablePlace::InPage(table) => table,
                    TablePlace::Apart(part) => extent(part.offset, part.length, part.crc, 8),
                };
                assert!(directory.triangles == 0 || !table.is_empty(), "tiles have tables");
                (border, table)
            })
            .collect();
        assert!(directory.behind.is_none_or(|behind| behind == end.next_multiple_of(8)));

        let decoded = |entry: &Fields<'_>, part: &str, stored: &[u8], codec: u32| {
            let length = entry.u32(&format!("{part}_decoded")) as usize;
            codec::decoded(stored, codec, length)
        };
        let parts = entries.iter().zip(cores.into_iter().zip(borders)).zip(0..);
        let tiles = parts
            .map(|((entry, (core, (border, table))), id)| {
                let codecs = entry.u32("codecs");
                let core = decoded(entry, "core", core, codecs & 0xff);
                let border = decoded(entry, "border", border, codecs >> 8);
                Tile {
                    table: read_table(id as usize, table),
                    ..read_tile(page, entry, id, &core, &border)
                }
            })
            .collect();
        Self {
            file_id,
            directory,
            tiles,
        }
    }

    /// Returns the tile whose cell contains `p`.
    pub fn tile_at(&self, p: Point) -> usize {
        let mut node = 0;
        loop {
            node = match self.directory.nodes[node] {
                Node::X(cut, _) if p.x <= cut => node + 1,
                Node::Y(cut, _) if p.y <= cut => node + 1,
                Node::X(_, right) | Node::Y(_, right) => right,
                Node::Leaf(tile) => return tile as usize,
            };
        }
    }
}

fn read_tile(page: &Page, entry: &Fields<'_>, id: u32, core_bytes: &[u8], border_bytes: &[u8]) -> Tile {
    let (core, border) = (Table::root(core_bytes), Table::root(border_bytes));
    let in_core = |field| page.slot("Core", field);
    let in_border = |field| page.slot("Border", field);
    let tiles = [core.u32(in_core("tile")), border.u32(in_border("tile"))];
    assert_eq!(tiles, [id; 2]);
    let generations = [core.u32(in_core("generation")), border.u32(in_border("generation"))];
    assert_eq!((generations, entry.u32("generation")), ([1; 2], 1));
    let doubles = |(table, bytes): (Table<'_>, &[u8]), slot| {
        let (first, count) = table.vector(slot).unwrap_or((0, 0));
        (0..count).map(|i| f64_at(bytes, first + 8 * i)).collect::<Vec<f64>>()
    };
    let (core_z, foreign_z) = (in_core("z"), in_border("foreign_z"));
    assert_eq!(core.vector(core_z).is_some(), border.vector(foreign_z).is_some());
    let of_core = |field, marks| packed(page, core.table(in_core(field)).unwrap(), marks);
    let of_border = |field| unmarked(page, border.table(in_border(field)).unwrap());
    let half_edge = |value: Result<u64, u64>| value.ok().map(|v| v as usize);
    let first_record = core.u64(in_core("first_record"));
    let points: Vec<Point> = doubles((core, core_bytes), in_core("coordinates"))
        .chunks(2)
        .map(|xy| Point::new(xy[0], xy[1]))
        .collect();
    let mut corners = unmarked(page, core.table(in_core("triangles")).unwrap());
    let core_triangles = corners.len() / 3;
    let late = of_border("triangles");
    assert_eq!(
        (points.len(), core_triangles, late.len() / 3),
        (
            entry.u32("vertices") as usize,
            entry.u32("core_triangles") as usize,
            entry.u32("border_triangles") as usize
        )
    );
    corners.extend(late);
    let foreign = structs(page, "ForeignVertex", border, in_border("foreign"));
    let foreign: Vec<_> = foreign
        .iter()
        .map(|f| {
            (
                Point::new(f.f64("x"), f.f64("y")),
                f.u32("tile") as usize,
                f.u32("index") as usize,
            )
        })
        .collect();
    assert!(foreign.is_sorted_by_key(|f| (f.1, f.2)));
    assert!(foreign.iter().all(|f| f.1 != id as usize));
    let border_neighbours = packed(page, border.table(in_border("neighbours")).unwrap(), 2);
    let triangles = [core_triangles, corners.len() / 3 - core_triangles];
    let both = |field: &str| [(core, page.slot("Core", field)), (border, page.slot("Border", field))];
    let of_half_edges = |field| -> Vec<bool> {
        let parts = both(field).into_iter().zip(triangles);
        parts
            .flat_map(|((table, slot), count)| bits(table, slot, 3 * count))
            .collect()
    };
    let (constraints, walls) = (of_half_edges("constraints"), of_half_edges("walls"));
    assert!(
        walls
            .iter()
            .zip(&constraints)
            .all(|(wall, constraint)| *constraint || !wall)
    );
    let edges = optional(page, border, in_border("edges")).unwrap_or_default();
    let of_edges = |field| both(field).map(|(table, slot)| optional(page, table, slot).unwrap_or_default());
    let (edge_half_edges, edge_sources) = (of_edges("edge_sides"), of_edges("edge_sources"));
    let segment_ends = both("segment_ends").into_iter().zip(&edge_sources);
    let segment_ends: Vec<Vec<bool>> = segment_ends
        .map(|((table, slot), sources)| bits_or(true, table, slot, 2 * sources.len()))
        .collect();
    let has_segment_ends = both("segment_ends")
        .iter()
        .any(|(table, slot)| table.vector(*slot).is_some());
    Tile {
        core_offset: entry.u64("core_offset"),
        border_offset: entry.u64("border_offset"),
        owned: entry.u32("owned_triangles"),
        bounds: ["min_x", "min_y", "max_x", "max_y"].map(|f| entry.f64(f)),
        input_points: bits_or(true, core, in_core("input_points"), points.len()),
        stores_held: core.vector(in_core("input_points")).is_some() || has_segment_ends,
        points,
        z: doubles((core, core_bytes), core_z),
        foreign_z: doubles((border, border_bytes), foreign_z),
        records: of_core("records", 0)
            .into_iter()
            .map(|r| first_record + r.unwrap())
            .collect(),
        core_triangles,
        corners,
        neighbours: of_core("neighbours", 1).into_iter().map(half_edge).collect(),
        vertex_half_edges: of_core("vertex_sides", 1).into_iter().map(half_edge).collect(),
        foreign,
        border_neighbours: border_neighbours
            .into_iter()
            .map(|value| match value {
                Ok(half_edge) => Twin::HalfEdge(half_edge as usize),
                Err(0) => Twin::Hull,
                Err(_) => Twin::Elsewhere,
            })
            .collect(),
        core_links: pairs(&of_border("core_links")),
        border_vertex_half_edges: pairs(&of_border("vertex_sides")),
        constraints,
        walls,
        components: read_components(page, both("components"), triangles),
        table: Vec::new(),
        edges: edges
            .chunks(2)
            .map(|ends| (ends[0] as usize, ends[1] as usize))
            .collect(),
        edge_sources: [0, 1].map(|part| sources(&edge_half_edges[part], &edge_sources[part], &segment_ends[part])),
        sites: read_sites(page, core),
    }
}

impl Tile {
    /// Returns the corners of all triangles.
    pub fn triangles(&self) -> impl Iterator<Item = [usize; 3]> + '_ {
        self.corners.chunks(3).map(|c| [c[0], c[1], c[2]])
    }

    /// Returns the tile and the point of a corner, both checked against the tile that owns it.
    pub fn corner(&self, file: &File, corner: usize) -> (usize, Point) {
        match corner.checked_sub(self.points.len()) {
            None => (file.tile_at(self.points[corner]), self.points[corner]),
            Some(foreign) => {
                let (p, tile, index) = self.foreign[foreign];
                assert_eq!(file.tiles[tile].points[index], p);
                let [z, right] = [self.foreign_z.get(foreign), file.tiles[tile].z.get(index)];
                assert_eq!(z.map(|z| z.to_bits()), right.map(|z| z.to_bits()));
                (tile, p)
            }
        }
    }

    /// Returns the tile of a corner and its index in that tile.
    pub fn id(&self, tile: usize, corner: usize) -> (usize, usize) {
        match corner.checked_sub(self.points.len()) {
            None => (tile, corner),
            Some(foreign) => (self.foreign[foreign].1, self.foreign[foreign].2),
        }
    }

    /// Returns the number of corners that other tiles own.
    pub fn foreign_count(&self) -> usize {
        self.foreign.len()
    }

    /// Returns the component of a triangle.
    pub fn component(&self, triangle: usize) -> &Component {
        &self.table[self.components[triangle]]
    }

    pub fn twin(&self, half_edge: usize) -> Twin {
        let Some(core) = self.neighbours.get(half_edge) else {
            return self.border_neighbours[half_edge - self.neighbours.len()];
        };
        match core {
            Some(other) => Twin::HalfEdge(*other),
            None => self
                .core_links
                .iter()
                .find(|l| l.0 == half_edge)
                .map_or(Twin::Hull, |l| Twin::HalfEdge(l.1)),
        }
    }

    pub fn half_edge_leaving(&self, vertex: usize) -> Option<usize> {
        let in_border = self.border_vertex_half_edges.iter().find(|s| s.0 == vertex);
        self.vertex_half_edges[vertex].or(in_border.map(|s| s.1))
    }

    /// Returns the sources of an edge in a file without triangles.
    pub fn sources_of_edge(&self, edge: usize) -> Vec<Source> {
        let list = self.edge_sources[1].iter().filter(|entry| entry.0 == edge);
        list.map(|&(_, source)| source).collect()
    }

    /// Returns the sources of a half-edge's edge, as seen along the half-edge.
    pub fn sources(&self, half_edge: usize) -> Vec<Source> {
        let core_half_edges = 3 * self.core_triangles;
        let other = match self.twin(half_edge) {
            Twin::HalfEdge(other) => other,
            Twin::Hull | Twin::Elsewhere => half_edge,
        };
        let in_core = other != half_edge && half_edge.max(other) < core_half_edges;
        let entered = half_edge.min(other);
        let list = self.edge_sources[usize::from(!in_core)].iter();
        let of_half_edge = list.filter(|entry| entry.0 == entered);
        let turned = |(number, code, [begins, ends]): Source| match half_edge == entered {
            true => (number, code, [begins, ends]),
            false => (number, if code >= 2 { 5 - code } else { code }, [ends, begins]),
        };
        of_half_edge.map(|&(_, source)| turned(source)).collect()
    }
}
