//! The promise: `schema/FORMAT.md` describes what the code writes. A reader that depends only on
//! the tables of that page, without the library's generated code, finds in files what was put into
//! them.

pub mod codec;
mod components;
mod digest;
mod directory;
mod labels;
mod page;
mod reader;
mod requests;
mod segment_ends;

use std::collections::HashSet;

use self::page::{Page, schemas};
use self::reader::{File, Twin};
use self::segment_ends::check_segment_ends;
use crate::support::{Scratch, batches, file_bytes, open_bytes, points_of, reference, runtime};
use delaunay_tiles::geometry::{HalfEdge, Point, Rect};
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::mesh::EngineKind;
use delaunay_tiles::store::{Digest, EdgeSource, FORMAT_VERSION, LineKind, LineSource, Site, TileEdge, TileId};
use delaunay_tiles::{BuildOptions, Builder, Description};
use distributions::Kind;

fn options(tile_vertices: usize) -> BuildOptions {
    BuildOptions::default().tile_vertices(tile_vertices).threads(2)
}

fn built(points: &[Point], z: &[f64], tile_vertices: usize) -> Vec<u8> {
    runtime().block_on(file_bytes(&batches(points, z), options(tile_vertices)))
}

fn compressed(points: &[Point], z: &[f64], tile_vertices: usize) -> Vec<u8> {
    let options = options(tile_vertices).compress(true);
    runtime().block_on(file_bytes(&batches(points, z), options))
}

#[test]
fn the_format_page_lists_the_fields_of_the_schemas() {
    let page = Page::read();
    let schemas = schemas();
    assert_eq!(schemas.len(), 23);
    let size = |kind: &str| match kind {
        "ubyte" | "bool" => 1,
        "ushort" => 2,
        "uint" => 4,
        "PartExtent" => 16,
        "ulong" | "double" => 8,
        other => panic!("structs have no {other}"),
    };
    for page::Declared {
        is_struct,
        name,
        fields,
    } in &schemas
    {
        if *is_struct {
            let mut offset = 0;
            let positions = &page.positions[name];
            assert_eq!(positions.len(), fields.len(), "{name}");
            for ((found, position), (field, kind)) in positions.iter().zip(fields) {
                assert_eq!(
                    (found, position.offset, position.bytes),
                    (field, offset, size(kind)),
                    "{name}"
                );
                offset += position.bytes;
            }
        } else {
            assert_eq!(&page.slots[name], fields, "{name}");
        }
    }
    let tables = page.positions.len() + page.slots.len();
    assert_eq!(
        tables,
        1 + schemas.len(),
        "the page has one table for each of the schemas, and the superblock's"
    );
}

#[test]
fn superblocks_have_no_gaps() {
    let page = Page::read();
    let mut end = 0;
    for (name, position) in &page.positions["Superblock"] {
        assert_eq!(position.offset, end, "{name}");
        end += position.bytes;
    }
    assert_eq!(end, 4096);
}

#[test]
fn a_grid_is_readable_from_the_format_page_alone() {
    let points = points_of(Kind::Grid, 600, 3);
    for tile_vertices in [8, 100, 65536] {
        let bytes = built(&points, &[], tile_vertices);
        let file = check(&bytes, &points, &[]);
        assert_eq!(file.directory.tile_vertices, tile_vertices as u32);
    }
}

#[test]
fn uniform_points_with_z_are_readable_from_the_format_page_alone() {
    let points = points_of(Kind::Uniform, 500, 4);
    let z: Vec<f64> = (0..500).map(|i| f64::from(i) / 8.0 - 7.0).collect();
    check(&built(&points, &z, 16), &points, &z);
}

/// Integers, decimals with errors of rounding, doubles; tiles of one and of many.
#[test]
fn compressed_files_are_readable_from_the_format_page_alone() {
    let uniform = points_of(Kind::Uniform, 700, 4);
    let rounded = |p: &Point| Point::new((p.x * 1e4).round() * 0.01 + 637_000.0, (p.y * 1e3).round() / 4.0 - 3.0);
    let lidar: Vec<Point> = uniform.iter().map(rounded).collect();
    let z: Vec<f64> = (0..700).map(|i| f64::from(i % 37) * 0.01).collect();
    let other: Vec<f64> = uniform.iter().map(|p| p.x.sin()).collect();
    for tile_vertices in [16, 300, 65536] {
        let grid = points_of(Kind::Grid, 600, 3);
        check(&compressed(&grid, &[], tile_vertices), &grid, &[]);
        check(&compressed(&lidar, &z, tile_vertices), &lidar, &z);
        check(&compressed(&uniform, &other, tile_vertices), &uniform, &other);
    }
    let line: Vec<Point> = (0..50).map(|i| Point::new(f64::from(i), f64::from(3 * i))).collect();
    check(&compressed(&line, &[], 8), &line, &[]);
}

#[test]
fn collinear_points_and_empty_files_are_readable_from_the_format_page_alone() {
    let line: Vec<Point> = (0..50).map(|i| Point::new(f64::from(i), f64::from(3 * i))).collect();
    for count in [0, 1, 2, 50] {
        let file = check(&built(&line[..count], &[], 8), &line[..count], &[]);
        assert_eq!(file.directory.triangles, 0);
    }
}

#[test]
fn pages_have_as_many_entries_as_the_page_allows_and_subtrees_give() {
    let page = Page::read();
    let most: usize = page.limits["entries of a page"].parse().unwrap();
    let points = points_of(Kind::Uniform, 20_000, 5);
    let bytes = built(&points, &[], 4);
    let file = check(&bytes, &points, &[]);
    let entries = &file.directory.page_entries;
    assert!(entries.len() > 20 && entries.iter().all(|&n| (1..=most).contains(&n)));
    // Two subtrees that fit into one page are in one page.
    assert!(entries.iter().sum::<usize>() / entries.len() > most / 3);
}

#[test]
fn edges_of_collinear_points_are_readable_from_the_format_page_alone() {
    let at = |i: i32| Point::new(f64::from(i), f64::from(-2 * i));
    let points: Vec<Point> = (0..50).map(at).collect();
    for tile_vertices in [8, 65536] {
        let scratch = Scratch::new();
        let bytes = runtime().block_on(async {
            let mut builder = Builder::new(&scratch.path, options(tile_vertices)).unwrap();
            builder.push_segments(&[[at(40), at(3)], [at(20), at(30)]]).unwrap();
            let walls = SegmentBatch {
                ends: vec![[at(7), at(9)]],
                lines: vec![0],
                ..SegmentBatch::default()
            };
            builder.push_lines(LineKind::Wall, 2, &walls).unwrap();
            for batch in batches(&points, &[]) {
                builder.push(&batch).await.unwrap();
            }
            builder.finish().await.unwrap();
            std::fs::read(&scratch.path).unwrap()
        });
        let file = File::read(&Page::read(), &bytes);
        assert_eq!((file.directory.triangles, file.directory.constraint_edges), (0, 37));
        assert_eq!(file.tiles.iter().map(|tile| tile.edges.len()).sum::<usize>(), 37);
        runtime().block_on(compare(&file, bytes));
    }
}

/// Lines across a grid; some end within it, some share vertices and edges.
#[test]
fn constraints_are_readable_from_the_format_page_alone() {
    let points = points_of(Kind::Grid, 400, 6);
    let bounds = Rect::around(points.iter().copied());
    let (width, height) = bounds.size();
    let at = |x: f64, y: f64| Point::new(bounds.min_x + x * width, bounds.min_y + y * height);
    let segments = [
        [at(0.0, 0.0), at(1.0, 0.0)],
        [at(0.1, 0.2), at(0.8, 0.9)],
        [at(0.8, 0.9), at(0.9, 0.1)],
        [at(0.9, 0.1), at(0.1, 0.2)],
        [at(0.03, 0.5), at(0.11, 0.97)],
    ];
    for tile_vertices in [8, 50, 65536] {
        let scratch = Scratch::new();
        let bytes = runtime().block_on(async {
            let mut builder = Builder::new(&scratch.path, options(tile_vertices)).unwrap();
            builder.push_segments(&segments).unwrap();
            for batch in batches(&points, &[]) {
                builder.push(&batch).await.unwrap();
            }
            builder.finish().await.unwrap();
            std::fs::read(&scratch.path).unwrap()
        });
        let file = File::read(&Page::read(), &bytes);
        assert!(file.directory.constraint_edges > 20);
        check_segment_ends(&file, &segments);
        runtime().block_on(compare(&file, bytes));
    }
}

/// A polygon with a court, each ring a line of its own, between two polygons of one line.
#[test]
fn polygons_of_several_lines_are_readable_from_the_format_page_alone() {
    let square = |x: f64, size: f64, turned: bool| {
        let mut corners = [[x, x], [x + size, x], [x + size, x + size], [x, x + size]].map(|[x, y]| Point::new(x, y));
        if turned {
            corners.reverse();
        }
        (0..4).map(move |i| [corners[i], corners[(i + 1) % 4]])
    };
    let rings = [
        (0.0, 3.0, false),
        (10.0, 8.0, false),
        (12.0, 2.0, true),
        (15.0, 1.0, true),
        (20.0, 3.0, false),
    ];
    let mut batch = SegmentBatch::default();
    for ((x, size, turned), line) in rings.into_iter().zip(0..) {
        batch.ends.extend(square(x, size, turned));
        batch.lines.resize(batch.ends.len(), line);
        batch.polygons.resize(batch.ends.len(), [0, 1, 1, 1, 2][line as usize]);
    }
    for tile_vertices in [8, 65536] {
        let scratch = Scratch::new();
        let bytes = runtime().block_on(async {
            let mut builder = Builder::new(&scratch.path, options(tile_vertices)).unwrap();
            builder.describe(Description {
                lines: vec![LineSource {
                    name: "rings".to_owned(),
                    kind: LineKind::Obstacle,
                    first: 0,
                    lines: 5,
                    edit: 0,
                }],
                ..Description::default()
            });
            builder.push_lines(LineKind::Obstacle, 0, &batch).unwrap();
            builder.finish().await.unwrap();
            std::fs::read(&scratch.path).unwrap()
        });
        let file = File::read(&Page::read(), &bytes);
        assert_eq!(file.directory.polygon_lines, [(2, 1), (3, 1)]);
        runtime().block_on(compare(&file, bytes));
    }
}

/// Checks that lines, regions and sites as the page describes them are those that the library
/// reads.
async fn compare(file: &File, bytes: Vec<u8>) {
    let reader = open_bytes(bytes).await.unwrap();
    let (m, d) = (reader.metadata(), &file.directory);
    assert_eq!(m.constraint_edges, d.constraint_edges);
    let counts = [
        m.regions,
        m.spanning_regions,
        m.hole_regions,
        m.hole_triangles,
        m.sites,
        m.crossings,
    ];
    assert_eq!(counts, d.counts);
    let kinds = [LineKind::BreakLine, LineKind::Wall, LineKind::Obstacle];
    let lines = d.lines.iter().map(|(name, kind, first, lines, edit)| LineSource {
        name: name.clone(),
        kind: kinds[usize::from(*kind)],
        first: *first,
        lines: *lines,
        edit: *edit as u32,
    });
    let lists = reader.lists().await.unwrap();
    assert_eq!(lists.lines, lines.collect::<Vec<_>>());
    assert_eq!([m.next_record, m.next_line, m.next_site], d.next_numbers);
    assert_eq!(
        (m.exterior_is_hole, &lists.hole_points),
        (d.exterior_is_hole, &d.hole_points)
    );
    let polygon_lines = lists.polygon_lines.iter().map(|of| (of.line, of.polygon));
    assert_eq!(polygon_lines.collect::<Vec<_>>(), d.polygon_lines);
    assert_eq!(digest::sums(file), d.digest);
    assert_eq!(digest::of_library(&m.digest), d.digest);
    let (mut owned, mut vertices_without_point) = (0, 0);
    for (number, expected) in file.tiles.iter().enumerate() {
        let tile = reader.tile(TileId(number as u32)).await.unwrap();
        let code = |source: EdgeSource| match (source.kind(), source.depth_change()) {
            (LineKind::BreakLine, 0) => 0,
            (LineKind::Wall, 0) => 1,
            (LineKind::Obstacle, 1) => 2,
            (LineKind::Obstacle, -1) => 3,
            other => panic!("{other:?}"),
        };
        let sources = |edge: TileEdge| -> Vec<_> {
            let parts = tile.edge_parts(edge);
            parts
                .map(|part| (part.number(), code(part.source()), [part.begins(), part.ends()]))
                .collect()
        };
        let input_points: Vec<bool> = tile.vertex_indices().map(|v| tile.is_input_point(v)).collect();
        assert_eq!(input_points, expected.input_points);
        vertices_without_point += input_points.iter().filter(|is_point| !**is_point).count() as u64;
        for half_edge in (0..3 * tile.triangle_count()).map(HalfEdge) {
            let index = half_edge.index();
            let found = (tile.is_constraint(half_edge), tile.is_wall(half_edge));
            assert_eq!(found, (expected.constraints[index], expected.walls[index]));
            assert_eq!(sources(half_edge.into()), expected.sources(index));
        }
        for (number, &(from, to)) in (0..).zip(&expected.edges) {
            let edge = TileEdge::OnLine(number);
            assert_eq!(tile.triangle_count(), 0);
            let corner = |corner| expected.corner(file, corner).1;
            assert_eq!(tile.ends(edge).map(|end| end.point), [corner(from), corner(to)]);
            let edge_sources = expected.sources_of_edge(number as usize);
            assert_eq!(tile.is_wall(edge), edge_sources.iter().any(|&(_, code, _)| code > 0));
            assert_eq!(sources(edge), edge_sources);
        }
        for triangle in tile.triangle_ids() {
            let found = (
                tile.region(triangle),
                tile.depth(triangle).into(),
                tile.is_hole(triangle),
            );
            let component = expected.component(triangle.index());
            assert_eq!(found, (component.region, component.depth, component.is_hole()));
        }
        let id = |site: &Site<'_>| site.id.map_or_else(|| site.number.to_string(), str::to_owned);
        let sites: Vec<_> = tile.sites().map(|s| (s.vertex.index(), s.number, id(&s))).collect();
        assert_eq!(sites, expected.sites);
        owned += tile.owned_constraints().count() as u64;
    }
    assert_eq!(owned, d.constraint_edges);
    components::check(file);
    assert_eq!(vertices_without_point, m.ends);
}

#[test]
fn limits_on_the_format_page_are_those_of_the_code() {
    let page = Page::read();
    assert_eq!(FORMAT_VERSION, 2);
    let (least, most) = (BuildOptions::MIN_TILE_VERTICES, BuildOptions::MAX_TILE_VERTICES);
    assert_eq!(
        page.limits["vertices that a tile is cut for"],
        format!("{least} to {most}")
    );
    let changes = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../schema/CHANGES.md")).unwrap();
    assert!(changes.contains(&format!("| {FORMAT_VERSION} |")));
}

/// Reads a file as the page describes it, and compares it with its points and with what the library
/// reads.
fn check(bytes: &[u8], points: &[Point], z: &[f64]) -> File {
    let file = File::read(&Page::read(), bytes);
    let directory = &file.directory;
    assert_eq!(directory.points, points.len() as u64);
    assert_eq!(directory.points - directory.duplicates, directory.vertices);
    assert_eq!(
        directory.vertices,
        file.tiles.iter().map(|t| t.points.len() as u64).sum::<u64>()
    );
    assert_eq!(directory.has_z, !z.is_empty());

    let mut digest = Digest::default();
    for (number, tile) in file.tiles.iter().enumerate() {
        assert!(!tile.points.is_empty() && tile.points.len() <= directory.tile_vertices as usize);
        assert!(!tile.stores_held, "what holds points alone takes no space");
        let heights = |corners: usize| if directory.has_z { corners } else { 0 };
        assert_eq!(tile.z.len(), heights(tile.points.len()));
        assert_eq!(tile.foreign_z.len(), heights(tile.foreign_count()));
        for (v, &p) in tile.points.iter().enumerate() {
            assert_eq!(file.tile_at(p), number, "cells are half-open");
            assert_eq!(
                p,
                points[tile.records[v] as usize].normalized(),
                "records are positions in the input"
            );
            if directory.has_z {
                assert_eq!(tile.z[v], z[tile.records[v] as usize]);
            }
            digest.add_vertex(p);
        }
        let mut owned = 0;
        for corners in tile.triangles() {
            let at = corners.map(|c| tile.corner(&file, c));
            if at.iter().min_by(|a, b| a.1.lex_cmp(b.1)).unwrap().0 == number {
                owned += 1;
                digest.add_triangle(at.map(|a| a.1));
            }
        }
        assert_eq!(owned, tile.owned);
        check_half_edges(&file, number);
    }
    assert_eq!(digest.triangles.count, directory.triangles);
    assert_eq!(digest, reference(EngineKind::Native, points));
    for (tile, vertex) in file.tiles.iter().flat_map(|t| (0..t.z.len()).map(move |v| (t, v))) {
        digest.add_z(tile.points[vertex], tile.z[vertex]);
    }

    let reader = runtime().block_on(open_bytes(bytes.to_vec())).unwrap();
    assert_eq!(reader.metadata().digest, digest);
    assert_eq!(digest::sums(&file), file.directory.digest);
    components::check(&file);
    assert_eq!(reader.file_id().0, file.file_id);
    assert_eq!((reader.generation(), reader.file_length()), (1, bytes.len() as u64));
    let metadata = reader.metadata();
    assert_eq!(
        (metadata.points, metadata.duplicates),
        (directory.points, directory.duplicates)
    );
    assert_eq!(metadata.producer, directory.producer);
    assert_eq!(metadata.hull_edges, directory.hull_edges);
    let directory = runtime().block_on(reader.directory()).unwrap();
    for (entry, tile) in directory.tiles.iter().zip(&file.tiles) {
        assert_eq!(
            (entry.core.offset, entry.border.offset),
            (tile.core_offset, tile.border_offset)
        );
        let b = entry.bounds;
        assert_eq!([b.min_x, b.min_y, b.max_x, b.max_y], tile.bounds);
    }
    file
}

/// Checks that twins agree, and that the star of every vertex is found as a whole.
fn check_half_edges(file: &File, number: usize) {
    let tile = &file.tiles[number];
    let triangles: Vec<_> = tile.triangles().collect();
    let origin = |half_edge: usize| triangles[half_edge / 3][half_edge % 3];
    let next = |half_edge: usize| half_edge / 3 * 3 + (half_edge + 1) % 3;
    let own = tile.points.len();
    for half_edge in 0..3 * triangles.len() {
        let (from, to) = (origin(half_edge), origin(next(half_edge)));
        match tile.twin(half_edge) {
            Twin::HalfEdge(other) => {
                assert_eq!((origin(other), origin(next(other))), (to, from));
                assert_eq!(tile.twin(other), Twin::HalfEdge(half_edge));
            }
            Twin::Hull => assert!(from < own || to < own),
            Twin::Elsewhere => assert!(from >= own && to >= own),
        }
    }
    let in_core: HashSet<usize> = triangles[..tile.core_triangles].iter().flatten().copied().collect();
    let anywhere: HashSet<usize> = triangles.iter().flatten().copied().collect();
    for vertex in 0..own {
        let half_edge = tile.half_edge_leaving(vertex);
        assert_eq!(half_edge.is_some(), anywhere.contains(&vertex));
        if let Some(half_edge) = half_edge {
            assert_eq!(origin(half_edge), vertex);
            assert_eq!(half_edge < 3 * tile.core_triangles, in_core.contains(&vertex));
        }
    }
    assert!(
        triangles[..tile.core_triangles]
            .iter()
            .flatten()
            .all(|&corner| corner < own)
    );
    // The star of a vertex over all tiles is its star in its own tile.
    let star = |t: usize, id: (usize, usize)| -> HashSet<Vec<(usize, usize)>> {
        let tile = &file.tiles[t];
        let named = tile.triangles().map(|c| c.map(|c| tile.id(t, c)));
        named
            .filter(|ids| ids.contains(&id))
            .map(|mut ids| {
                let first = (0..3).min_by_key(|&i| ids[i]).unwrap();
                ids.rotate_left(first);
                ids.to_vec()
            })
            .collect()
    };
    if file.tiles.len() <= 80 {
        for vertex in 0..own {
            let mine = star(number, (number, vertex));
            for other in 0..file.tiles.len() {
                assert!(star(other, (number, vertex)).is_subset(&mine));
            }
        }
    }
}
