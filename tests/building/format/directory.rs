//! The directory, read by the format's page alone.

use crc32c::crc32c;
use delaunay_tiles::geometry::Point;

use crate::format::page::Page;
use crate::format::reader::{Fields, structs};
use crate::support::flat::{Table, f64_at, u32_at};

pub struct Directory {
    pub tile_vertices: u32,
    pub vertices: u64,
    pub triangles: u64,
    pub hull_edges: u64,
    pub points: u64,
    pub duplicates: u64,
    pub has_z: bool,
    pub producer: String,
    /// The k-d tree, put together from its parts, in preorder.
    pub nodes: Vec<Node>,
    /// The number of entries of each page.
    pub page_entries: Vec<usize>,
    /// The number of component tables that lie in pages, and of those that lie apart.
    pub table_counts: [usize; 2],
    pub constraint_edges: u64,
    /// The numbers of regions, spanning regions, hole regions, hole triangles, sites and crossings.
    pub counts: [u64; 6],
    /// Name, kind, first line, number of lines, and edit.
    pub lines: Vec<(String, u8, u64, u64, u64)>,
    pub next_numbers: [u64; 3],
    pub exterior_is_hole: bool,
    pub hole_points: Vec<Point>,
    /// Lines, each with the first line of its polygon.
    pub polygon_lines: Vec<(u64, u64)>,
    /// The counts and the sums of the digest, in the order of their fields.
    pub digest: [(u64, u128); 7],
    /// Where the root and the lists of pages that follow it end.
    pub front_end: usize,
    /// Where the lists and pages behind the tiles start, if there are any.
    pub behind: Option<usize>,
}

/// A node of the k-d tree. Cuts have the number of their right child.
#[derive(Clone, Copy, Debug)]
pub enum Node {
    X(f64, usize),
    Y(f64, usize),
    Leaf(u32),
}

/// Where a part of the directory lies.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    pub offset: u64,
    pub length: u32,
    pub crc: u32,
}

impl Part {
    fn read(self, bytes: &[u8]) -> &[u8] {
        let part = &bytes[self.offset as usize..][..self.length as usize];
        assert_eq!((part.len() % 8, crc32c(part)), (0, self.crc));
        part
    }

    fn end(self) -> u64 {
        self.offset + u64::from(self.length)
    }
}

/// Where the component table of a tile lies.
#[derive(Clone, Copy)]
pub enum TablePlace<'b> {
    Nowhere,
    InPage(&'b [u8]),
    Apart(Part),
}

/// Returns the places of the component tables of a page with `count` entries.
fn table_places<'b>(page: &Page, table: Table<'b>, count: usize) -> Vec<TablePlace<'b>> {
    let slot = |field| page.slot("Page", field);
    let bytes = |field| {
        let (at, length) = table.vector(slot(field))?;
        Some(&table.bytes[at..at + length])
    };
    let mut rest = bytes("tables").unwrap_or_default();
    let mut apart = match table.field(slot("tables_apart")) {
        Some(_) => structs(page, "PartExtent", table, slot("tables_apart")),
        None => Vec::new(),
    }
    .into_iter();
    let longest = page.limits["a component table in a page"]
        .strip_suffix(" bytes")
        .unwrap();
    let longest: u8 = longest.parse().unwrap();
    let none = vec![0; count];
    let lengths = bytes("table_lengths").unwrap_or(&none);
    assert_eq!(lengths.len(), count);
    let places = lengths.iter().map(|&length| match length {
        0 => TablePlace::Nowhere,
        255 => {
            let part = part_of(&apart.next().unwrap());
            assert!(part.length > longest.into());
            TablePlace::Apart(part)
        }
        _ => {
            assert!(length <= longest);
            let (table, behind) = rest.split_at(length.into());
            rest = behind;
            TablePlace::InPage(table)
        }
    });
    let places = places.collect();
    assert!(rest.is_empty() && apart.next().is_none());
    places
}

/// Returns the nodes of a part of the tree. Right children have no numbers yet.
fn cells(page: &Page, table: Table<'_>, first: u32) -> Vec<Node> {
    let slot = |field| page.slot("Cells", field);
    let (at, length) = table.vector(slot("shape")).unwrap();
    let shape = &table.bytes[at..at + length];
    let (at, count) = table.vector(slot("cuts")).unwrap();
    let mut cuts = (0..count).map(|i| f64_at(table.bytes, at + 8 * i));
    let nodes = if shape.is_empty() { 0 } else { 2 * count + 1 };
    assert_eq!(shape.len(), nodes.div_ceil(4));
    let leaves = table.vector(slot("leaves"));
    let mut next = 0;
    let nodes = (0..nodes).map(|place| match shape[place / 4] >> (2 * (place % 4)) & 3 {
        1 => Node::X(cuts.next().unwrap(), 0),
        2 => Node::Y(cuts.next().unwrap(), 0),
        kind => {
            assert_eq!(kind, 0);
            next += 1;
            Node::Leaf(match leaves {
                Some((at, _)) => u32_at(table.bytes, at + 4 * (next - 1)),
                None => first + next as u32 - 1,
            })
        }
    });
    nodes.collect()
}

/// Replaces leaves by the parts that they name.
fn grafted(above: &[Node], parts: &[Vec<Node>]) -> Vec<Node> {
    let mut whole = Vec::new();
    for &node in above {
        match node {
            Node::Leaf(part) => whole.extend(&parts[part as usize]),
            cut => whole.push(cut),
        }
    }
    whole
}

/// Sets the numbers of right children: after a leaf comes the right child of the innermost cut that
/// has none.
fn with_right_children(mut nodes: Vec<Node>) -> Vec<Node> {
    let mut open = Vec::new();
    for number in 0..nodes.len() {
        if number > 0 && matches!(nodes[number - 1], Node::Leaf(_)) {
            let parent: usize = open.pop().unwrap();
            if let Node::X(_, right) | Node::Y(_, right) = &mut nodes[parent] {
                *right = number;
            }
        }
        if !matches!(nodes[number], Node::Leaf(_)) {
            open.push(number);
        }
    }
    assert!(open.is_empty());
    nodes
}

/// Checks that coarse bounds contain exact ones.
fn check_bounds(part: &Fields<'_>, exact: [f64; 4], whole: [f64; 4]) {
    for (side, name) in ["min_x", "min_y", "max_x", "max_y"].iter().enumerate() {
        let (low, high) = (whole[side % 2], whole[side % 2 + 2]);
        let step = part.u16(name);
        let share = f64::from(step) / 65535.0;
        let coarse = match step {
            0 => low,
            65535 => high,
            _ => low * (1.0 - share) + high * share,
        };
        match side {
            0 | 1 => assert!(coarse <= exact[side], "{name}"),
            _ => assert!(coarse >= exact[side], "{name}"),
        }
    }
}

fn bounds_of(entry: &Fields<'_>) -> [f64; 4] {
    ["min_x", "min_y", "max_x", "max_y"].map(|field| entry.f64(field))
}

fn around(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}

const NOWHERE: [f64; 4] = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];

/// Pages and the tree, as they are put together.
#[derive(Default)]
struct Pages<'b> {
    entries: Vec<&'b [u8]>,
    tables: Vec<TablePlace<'b>>,
    page_entries: Vec<usize>,
    trees: Vec<Vec<Node>>,
    /// The bytes of the pages, in order.
    bytes: Vec<u8>,
    first: Option<u64>,
}

impl<'b> Pages<'b> {
    /// Reads the pages of a list. Returns the list's part of the tree, and the bounds of its tiles.
    fn read_list(&mut self, page: &Page, file: &'b [u8], list: &[u8], whole: [f64; 4]) -> (Vec<Node>, [f64; 4]) {
        let table = Table::root(list);
        let slot = |field| page.slot("PageList", field);
        let first = table.u32(slot("first_page"));
        assert_eq!(first as usize, self.trees.len());
        let mut bounds = NOWHERE;
        for reference in structs(page, "PageRef", table, slot("pages")) {
            let part = Part {
                offset: 4096 * u64::from(reference.u32("offset")),
                length: reference.u16("length").into(),
                crc: reference.u32("crc"),
            };
            assert!(part.length <= 16384);
            let bytes = part.read(file);
            self.first.get_or_insert(part.offset);
            self.bytes.extend(bytes);
            let this = Table::root(bytes);
            let slot = |field| page.slot("Page", field);
            let tile = this.u32(slot("first_tile"));
            assert_eq!((tile, tile as usize), (reference.u32("first_tile"), self.entries.len()));
            let (at, count) = this.vector(slot("entries")).unwrap();
            let size = page.size("TileEntry");
            let mut of_page = NOWHERE;
            for entry in bytes[at..at + count * size].chunks(size) {
                self.entries.push(entry);
                let entry = Fields {
                    page,
                    table: "TileEntry",
                    bytes: entry,
                };
                of_page = around(of_page, bounds_of(&entry));
            }
            self.tables.extend(table_places(page, this, count));
            check_bounds(&reference, of_page, whole);
            bounds = around(bounds, of_page);
            self.page_entries.push(count);
            self.trees.push(cells(page, this.table(slot("cells")).unwrap(), tile));
        }
        (cells(page, table.table(slot("cells")).unwrap(), first), bounds)
    }
}

/// The directory, and what is read with it.
pub struct WithTiles<'b> {
    pub directory: Directory,
    /// The entries of tiles, and the places of their component tables.
    pub entries: Vec<&'b [u8]>,
    pub tables: Vec<TablePlace<'b>>,
    /// What the file's id is a hash of.
    pub hashed: Vec<u8>,
}

/// Reads the directory of a new file.
pub fn read_directory<'b>(page: &Page, file: &'b [u8], root: Part) -> WithTiles<'b> {
    assert_eq!(root.offset, 8192, "the root follows the superblocks");
    assert!(root.length <= 16384);
    let root_bytes = root.read(file);
    let table = Table::root(root_bytes);
    let slot = |field: &str| page.slot("Directory", field);
    let whole = ["min_x", "min_y", "max_x", "max_y"].map(|f| table.f64(slot(f)));
    let list_part = |field: &str| {
        table.field(slot(field)).map(|at| {
            part_of(&Fields {
                page,
                table: "PartExtent",
                bytes: &root_bytes[at..],
            })
        })
    };
    let names = [
        "sources",
        "crs",
        "lines",
        "hole_points",
        "cell_borders",
        "polygon_lines",
    ];
    let lists = names.map(list_part);
    // Each list that fits into what is left of 2560 bytes follows the root.
    let (mut end, mut room) = (root.end(), 2560);
    let mut behind = None;
    for list in lists.iter().flatten() {
        if list.length <= room {
            assert_eq!(list.offset, end, "short lists follow the root");
            room -= list.length;
            end = list.end();
        } else {
            behind = behind.or(Some(list.offset as usize));
        }
    }
    let mut pages = Pages::default();
    let (mut trees, mut list_bytes) = (Vec::new(), Vec::<u8>::new());
    let mut all = NOWHERE;
    for reference in structs(page, "PageListRef", table, slot("page_lists")) {
        let part = part_of(&reference);
        assert_eq!(part.offset, end, "lists of pages follow the short lists");
        end = part.end();
        assert_eq!(reference.u32("first_page") as usize, pages.trees.len());
        assert_eq!(reference.u32("first_tile") as usize, pages.entries.len());
        let (tree, bounds) = pages.read_list(page, file, part.read(file), whole);
        check_bounds(&reference, bounds, whole);
        all = around(all, bounds);
        trees.push(tree);
        list_bytes.extend(part.read(file));
    }
    assert_eq!(whole, all);
    let numbers = ["tiles", "next_tile", "pages"].map(|f| table.u32(slot(f)) as usize);
    assert_eq!(numbers, [pages.entries.len(), pages.entries.len(), pages.trees.len()]);
    let above = grafted(&cells(page, table.table(slot("cells")).unwrap(), 0), &trees);
    let nodes = with_right_children(grafted(&above, &pages.trees));

    let mut hashed: Vec<u8> = lists
        .iter()
        .flatten()
        .flat_map(|list| list.read(file))
        .copied()
        .collect();
    hashed.extend(&pages.bytes);
    hashed.extend(root_bytes);
    hashed.extend(list_bytes);
    assert!(lists[0].is_none() && lists[1].is_none());
    let directory = of_root(
        page,
        table,
        nodes,
        pages.page_entries,
        lists.map(|list| list.map(|list| list.read(file))),
    );
    let places = |wanted: fn(&TablePlace<'_>) -> bool| pages.tables.iter().filter(|place| wanted(place)).count();
    let directory = Directory {
        front_end: end as usize,
        behind,
        table_counts: [
            places(|place| matches!(place, TablePlace::InPage(_))),
            places(|place| matches!(place, TablePlace::Apart(_))),
        ],
        ..directory
    };
    WithTiles {
        directory,
        entries: pages.entries,
        tables: pages.tables,
        hashed,
    }
}

fn part_of(fields: &Fields<'_>) -> Part {
    Part {
        offset: fields.u64("offset"),
        length: fields.u32("length"),
        crc: fields.u32("crc"),
    }
}

fn of_root(
    page: &Page,
    table: Table<'_>,
    nodes: Vec<Node>,
    page_entries: Vec<usize>,
    lists: [Option<&[u8]>; 6],
) -> Directory {
    let slot = |field: &str| page.slot("Directory", field);
    let [vertices, triangles, hull_edges] = ["vertices", "triangles", "hull_edges"].map(|f| table.u64(slot(f)));
    assert_eq!(
        hull_edges,
        if triangles == 0 {
            0
        } else {
            2 * vertices - 2 - triangles
        }
    );
    let line = |of: Table<'_>| {
        let slot = |field| page.slot("LineSource", field);
        let name = of.string(slot("name")).unwrap().to_owned();
        let edit = of.u32(slot("edit"));
        (
            name,
            of.u8(slot("kind")),
            of.u64(slot("first")),
            of.u64(slot("lines")),
            u64::from(edit),
        )
    };
    let lines = lists[2].map(|bytes| Table::root(bytes).tables(page.slot("LineSources", "list")));
    let lines: Vec<_> = lines.into_iter().flatten().map(line).collect();
    let kinds = lines.iter().fold(0, |kinds, line| kinds | 1 << line.1);
    assert_eq!(table.u32(slot("line_kinds")), kinds);
    let hole_points = lists[3].map(|bytes| structs(page, "Place", Table::root(bytes), page.slot("Places", "list")));
    let hole_points = hole_points.into_iter().flatten();
    let polygon_lines = lists[5].map(|bytes| {
        let slot = page.slot("PolygonLines", "list");
        structs(page, "PolygonLine", Table::root(bytes), slot)
    });
    let polygon_lines = polygon_lines.into_iter().flatten();
    let sum = |field: &str| {
        let at = table.field(slot(field)).unwrap();
        let sum = Fields {
            page,
            table: "Sum",
            bytes: &table.bytes[at..],
        };
        let [low, high] = ["low", "high"].map(|half| u128::from(sum.u64(half)));
        (sum.u64("count"), high << 64 | low)
    };
    let sums = [
        "triangle_sum",
        "vertex_sum",
        "constraint_edge_sum",
        "hole_sum",
        "vertex_z_sum",
        "edge_source_sum",
        "site_sum",
    ];
    let counts = [
        "regions",
        "spanning_regions",
        "hole_regions",
        "hole_triangles",
        "sites",
        "crossings",
    ];
    // What later versions of the library fill in.
    assert_eq!(table.u64(slot("last_transaction")), 0);
    assert_eq!(
        (table.field(slot("free")), table.vector(slot("overviews"))),
        (None, None)
    );
    Directory {
        tile_vertices: table.u32(slot("tile_vertices")),
        vertices,
        triangles,
        hull_edges,
        points: table.u64(slot("points")),
        duplicates: table.u64(slot("duplicates")),
        has_z: table.u8(slot("has_z")) != 0,
        producer: table.string(slot("producer")).unwrap().to_owned(),
        nodes,
        page_entries,
        constraint_edges: table.u64(slot("constraint_edges")),
        counts: counts.map(|f| table.u64(slot(f))),
        lines,
        next_numbers: ["next_record", "next_line", "next_site"].map(|f| table.u64(slot(f))),
        exterior_is_hole: table.u8(slot("exterior_is_hole")) != 0,
        hole_points: hole_points.map(|at| Point::new(at.f64("x"), at.f64("y"))).collect(),
        polygon_lines: polygon_lines.map(|of| (of.u64("line"), of.u64("polygon"))).collect(),
        digest: sums.map(sum),
        table_counts: [0; 2],
        front_end: 0,
        behind: None,
    }
}
