//! A tile has the constraints, regions and sites of its drafts; drafts that contradict themselves
//! are rejected.

use crate::geometry::{HalfEdge, PackedHalfEdge, TriangleId, VertexIndex};
use crate::io::Buffers;
use crate::mesh::Twin;
use crate::store::format::component_table::{Component, ComponentRecord, encode};
use crate::store::format::damage::Damage;
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::encode::{BorderDraft, CoreDraft};
use crate::store::format::entry::TileEntry;
use crate::store::format::extent::Extent;
use crate::store::format::flat_buffer::verified;
use crate::store::format::generated::tile as schema;
use crate::store::format::line_part::LinePart;
use crate::store::format::table_place::{ShortTable, TablePlace};
use crate::store::format::tile::*;

/// A square of two triangles, and a border triangle at its right edge that has a corner of another
/// tile.
///
/// ```text
/// 3────2
/// │ 1 ╱│╲       half-edges: 0–2 of triangle 0, 3–5 of triangle 1, 6–8 of triangle 2 in the border
/// │ ╱  │ 2 4    2 and 3 are on the diagonal, 1 and 8 on the right edge of the square
/// │╱ 0 │╱
/// 0────1
/// ```
fn drafts() -> (CoreDraft, BorderDraft) {
    let points = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    const NONE: PackedHalfEdge = PackedHalfEdge::NONE;
    let core = CoreDraft {
        points: points.map(|(x, y)| Point::new(x, y)).to_vec(),
        records: vec![0, 1, 2, 3],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        neighbours: vec![[NONE, NONE, HalfEdge(3).into()], [HalfEdge(2).into(), NONE, NONE]],
        ..CoreDraft::default()
    };
    let elsewhere = VertexId {
        tile: TileId(1),
        index: VertexIndex(0),
    };
    let border = BorderDraft {
        vertices: 4,
        core_triangles: 2,
        foreign: vec![(elsewhere, Point::new(2.0, 0.5))],
        triangles: vec![[1, 4, 2]],
        neighbours: vec![[Twin::Hull, Twin::Hull, Twin::HalfEdge(HalfEdge(1))]],
        core_links: vec![(1, 8)],
        ..BorderDraft::default()
    };
    (core, border)
}

/// The drafts of [`drafts`] with a break line, a wall and an obstacle, regions and sites.
fn full_drafts() -> (CoreDraft, BorderDraft) {
    let (mut core, mut border) = drafts();
    core.constraints = vec![0b110_110 & !(1 << 4), 0b101_101];
    core.components = vec![0, 1];
    core.edge_sources = vec![(2, source(LineKind::Wall, 3)), (2, source(LineKind::Obstacle, 5))];
    core.input_points = vec![true, false, true, true];
    core.sites = vec![(0, 4), (2, 0), (2, 900)];
    core.site_ids = ["", "pump", "é"].map(str::to_owned).to_vec();
    core.z = vec![1.5, -2.0, 0.0, 4.0];
    border.foreign_z = Some(vec![3.25]);
    border.constraints = vec![0b001_101];
    border.components = vec![2];
    border.edge_sources = vec![
        (1, source(LineKind::BreakLine, 0)),
        (5, source(LineKind::Obstacle, 5).reversed().cut(true, false)),
        (6, source(LineKind::Wall, 3)),
    ];
    (core, border)
}

/// A part of a line with both its ends.
fn source(kind: LineKind, number: u64) -> LinePart {
    LinePart::whole(EdgeSource::new(kind, number))
}

/// The components of the tile of [`full_drafts`].
fn full_table() -> Vec<u8> {
    table(
        &[(70_000, 1, true), (9, 0, false), (3, -2, false)].map(|(region, depth, is_hole)| Component {
            region,
            depth,
            is_hole,
        }),
    )
}

fn table(components: &[Component]) -> Vec<u8> {
    let records = components.iter().map(|&component| ComponentRecord {
        component,
        ..ComponentRecord::default()
    });
    encode(TileId(0), &records.collect::<Vec<_>>())
}

/// Opens a tile. If any of its triangles has a component, it has the table of [`full_drafts`].
fn open(drafts: &(CoreDraft, BorderDraft)) -> Result<Tile, Damage> {
    let has_components = drafts.0.components.iter().any(|&component| component > 0);
    open_with(drafts, &if has_components { full_table() } else { Vec::new() })
}

fn open_with((core, border): &(CoreDraft, BorderDraft), table: &[u8]) -> Result<Tile, Damage> {
    let buffers = Buffers::default();
    open_bytes(
        &core.encode(TileId(0), 1, &buffers),
        &border.encode(TileId(0), 1, &buffers),
        table,
    )
}

fn open_bytes(core: &Bytes, border: &Bytes, table: &[u8]) -> Result<Tile, Damage> {
    let extent = |bytes: &Bytes| Extent::raw(8192, bytes.len() as u32, crc32c::crc32c(bytes));
    let entry = TileEntry {
        core: extent(core),
        border: extent(border),
        generation: 1,
        vertices: 4,
        core_triangles: 2,
        border_triangles: 1,
        owned_triangles: 3,
        bounds: crate::geometry::Rect::PLANE,
        table: ShortTable::new(table).map_or(TablePlace::Nowhere, TablePlace::InPage),
    };
    Tile::open(TileId(0), &entry, [core, border], None)
}

#[test]
fn a_tile_has_the_constraints_regions_and_sites_of_its_drafts() {
    let tile = open(&full_drafts()).unwrap();
    let half_edges_with = |what: fn(&Tile, HalfEdge) -> bool| {
        (0..9)
            .filter(|&half_edge| what(&tile, HalfEdge(half_edge)))
            .collect::<Vec<_>>()
    };
    assert_eq!(
        half_edges_with(|tile, half_edge| tile.is_constraint(half_edge)),
        [1, 2, 3, 5, 6, 8]
    );
    assert_eq!(half_edges_with(|tile, half_edge| tile.is_wall(half_edge)), [2, 3, 5, 6]);
    let triangles = [0, 1, 2].map(TriangleId);
    assert_eq!(triangles.map(|t| tile.region(t)), [70_000, 9, 3]);
    assert_eq!(triangles.map(|t| tile.depth(t)), [1, 0, -2]);
    assert_eq!(triangles.map(|t| tile.is_hole(t)), [true, false, false]);
    let sites: Vec<_> = tile.sites().map(|site| (site.vertex.0, site.number, site.id)).collect();
    assert_eq!(sites, [(0, 4, None), (2, 0, Some("pump")), (2, 900, Some("é"))]);
    assert_eq!(
        [0, 1, 2, 3].map(|v| tile.is_site(VertexIndex(v))),
        [true, false, true, false]
    );
    assert_eq!(tile.site_count(), 3);
    assert_eq!(
        [0, 1, 2, 3].map(|v| tile.is_input_point(VertexIndex(v))),
        [true, false, true, true]
    );
}

/// Points of the input lie at all vertices of most files, and most segments are one edge.
#[test]
fn what_holds_all_vertices_and_all_segments_alike_takes_no_space() {
    let sizes = |change: fn(&mut CoreDraft, &mut BorderDraft)| {
        let (mut core, mut border) = full_drafts();
        change(&mut core, &mut border);
        let tile = open(&(core.clone(), border.clone())).unwrap();
        let points = tile.vertex_indices().filter(|&v| tile.is_input_point(v)).count();
        let parts = (0..9).flat_map(|half_edge| tile.edge_parts(HalfEdge(half_edge)));
        let whole = parts.filter(|part| part.begins() && part.ends()).count();
        let buffers = Buffers::default();
        let bytes = [
            core.encode(TileId(0), 1, &buffers).len(),
            border.encode(TileId(0), 1, &buffers).len(),
        ];
        (bytes, [points, whole])
    };
    let all_whole = |core: &mut CoreDraft, border: &mut BorderDraft| {
        core.input_points.clear();
        border.edge_sources[1].1 = source(LineKind::Obstacle, 5).reversed();
    };
    let (least, found) = sizes(all_whole);
    assert_eq!(found, [4, 8]);
    assert_eq!(
        sizes(|core, border| {
            core.input_points = vec![true; 4];
            border.edge_sources[1].1 = source(LineKind::Obstacle, 5).reversed();
        }),
        (least, found)
    );
    let (more, found) = sizes(|_, _| ());
    assert!(more[0] > least[0] && more[1] > least[1]);
    assert_eq!(found, [3, 7]);
    let (_, found) = sizes(|core, border| {
        core.input_points = vec![false; 4];
        for (_, part) in core.edge_sources.iter_mut().chain(&mut border.edge_sources) {
            *part = part.cut(false, false);
        }
    });
    assert_eq!(found, [0, 0]);
}

#[test]
fn the_half_edges_of_an_edge_see_its_sources_in_opposite_directions() {
    let tile = open(&full_drafts()).unwrap();
    let of = |half_edge: u32| {
        let parts: Vec<LinePart> = tile.edge_parts(HalfEdge(half_edge)).collect();
        let sources: Vec<EdgeSource> = tile.edge_sources(HalfEdge(half_edge)).collect();
        assert!(parts.iter().map(|part| part.source()).eq(sources));
        parts
    };
    let (wall, obstacle) = (source(LineKind::Wall, 3), source(LineKind::Obstacle, 5));
    assert_eq!(of(2), [wall, obstacle]);
    assert_eq!(of(3), [wall, obstacle.reversed()]);
    for half_edge in [1, 8] {
        assert_eq!(of(half_edge), [source(LineKind::BreakLine, 0)]);
    }
    let beginning = obstacle.reversed().cut(true, false);
    assert_eq!((of(5), of(6)), (vec![beginning], vec![wall]));
    assert_eq!((beginning.begins(), beginning.ends()), (true, false));
    for half_edge in [0, 4, 7] {
        assert_eq!(of(half_edge), []);
    }
    assert_eq!(tile.edges_with_sources(), 4);
}

/// A site's number is its id if no site of the tile has another id.
#[test]
fn without_ids_a_site_is_identified_by_its_number() {
    let (mut core, border) = full_drafts();
    core.site_ids.clear();
    let tile = open(&(core, border)).unwrap();
    assert!(tile.sites().all(|site| site.id.is_none()));
    assert_eq!(tile.sites().map(|site| site.number).collect::<Vec<_>>(), [4, 0, 900]);
}

#[test]
fn triangles_without_stored_regions_are_free_and_of_region_0() {
    let tile = open(&drafts()).unwrap();
    assert!(
        (0..9)
            .map(HalfEdge)
            .all(|half_edge| !tile.is_wall(half_edge) && tile.edge_sources(half_edge).count() == 0)
    );
    assert!(tile.triangle_ids().all(|t| tile.component(t) == Component::default()));
    assert!(tile.sites().next().is_none() && tile.vertex_indices().all(|v| !tile.is_site(v)));
    // Default values take no space.
    let (mut core, mut border) = drafts();
    core.components = vec![0; 2];
    core.constraints = vec![0; 2];
    border.components = vec![0];
    let encoded = |(core, border): &(CoreDraft, BorderDraft)| {
        let buffers = Buffers::default();
        [
            core.encode(TileId(0), 1, &buffers),
            border.encode(TileId(0), 1, &buffers),
        ]
    };
    assert_eq!(encoded(&(core, border)), encoded(&drafts()));
}

#[test]
fn depths_of_all_sizes_are_read_as_they_were_written() {
    for depth in [0, 1, -1, 63, -64, 64, 40_000, i32::MAX, i32::MIN] {
        let table = table(&[Component {
            depth,
            ..Component::default()
        }]);
        assert_eq!(open_with(&drafts(), &table).unwrap().depth(TriangleId(2)), depth);
    }
}

/// Corners of other tiles have a z if, and only if, the tile's own vertices have.
#[test]
fn all_corners_have_a_finite_z_or_none_has() {
    // z of the vertices, z of the foreign vertex, what is wrong.
    type Fault<'a> = (&'a [f64], Option<&'a [f64]>, &'a str);
    let with = |z: &[f64], foreign_z: Option<&[f64]>| {
        let (mut core, mut border) = drafts();
        core.z = z.to_vec();
        border.foreign_z = foreign_z.map(<[f64]>::to_vec);
        open(&(core, border)).map_err(|damage| damage.to_string())
    };
    let tile = with(&[5.0, -0.0, 7.0, 8.0], Some(&[9.5])).unwrap();
    let z = |tile: &Tile| {
        (0..5)
            .filter_map(|corner| tile.z(VertexIndex(corner)))
            .collect::<Vec<_>>()
    };
    assert_eq!((z(&tile), tile.has_z()), (vec![5.0, -0.0, 7.0, 8.0, 9.5], true));
    let without = with(&[], None).unwrap();
    assert_eq!((z(&without), without.has_z()), (vec![], false));
    assert!(tile.byte_size() > without.byte_size());
    let faults: [Fault<'_>; 9] = [
        (&[1.0; 4], None, "disagree on whether there is a z"),
        (&[], Some(&[1.0]), "disagree on whether there is a z"),
        (&[], Some(&[]), "disagree on whether there is a z"),
        (&[1.0; 4], Some(&[]), "there are 0 z of foreign vertices, not 1"),
        (&[1.0; 4], Some(&[1.0; 2]), "there are 2 z of foreign vertices, not 1"),
        (&[1.0; 3], Some(&[1.0]), "there are 3 z, not 4"),
        (&[1.0, 2.0, f64::NAN, 3.0], Some(&[1.0]), "vertex 2 has no finite z"),
        (
            &[1.0; 4],
            Some(&[f64::NAN]),
            "vertex 1:0 of another tile has no finite z",
        ),
        (
            &[1.0; 4],
            Some(&[f64::NEG_INFINITY]),
            "vertex 1:0 of another tile has no finite z",
        ),
    ];
    for (z, foreign_z, reason) in faults {
        let error = with(z, foreign_z).map(|_| ()).expect_err(reason);
        assert!(error.contains(reason), "{error:?} is not about {reason:?}");
    }
}

#[test]
fn drafts_that_contradict_themselves_are_rejected() {
    type Fault = fn(&mut CoreDraft, &mut BorderDraft);
    let faults: [(&str, Fault); 13] = [
        ("a wall is no constraint", |core, _| core.constraints[0] = 0b001_110),
        ("the border: a wall", |_, border| border.constraints[0] = 0b010_101),
        ("have 3 components", |core, _| core.components.push(1)),
        ("have 2 components", |_, border| border.components.push(0)),
        ("component 3 is not below 3", |core, _| core.components[1] = 3),
        ("an edge with a source", |core, _| core.edge_sources[0].0 = 6),
        ("an edge with a source", |core, _| core.edge_sources.swap(0, 1)),
        ("the border: an edge", |_, border| border.edge_sources[2].0 = 9),
        ("a site", |core, _| core.sites[2].0 = 4),
        ("a site", |core, _| core.sites.swap(1, 2)),
        ("the ids of the sites", |core, _| _ = core.site_ids.pop()),
        ("or ids their sites", |core, _| core.sites.clear()),
        ("2 bytes of input points, not 1", |core, _| {
            core.input_points.resize(9, true)
        }),
    ];
    for (reason, fault) in faults {
        let (mut core, mut border) = full_drafts();
        fault(&mut core, &mut border);
        let error = open(&(core, border)).map(|_| ()).expect_err(reason);
        assert!(error.to_string().contains(reason), "{error:?} is not about {reason:?}");
    }
}

/// Contradictions that no draft can express.
#[test]
fn a_border_with_only_one_of_two_matching_tables_is_rejected() {
    /// What a fault may put into the border.
    struct Offered<'b> {
        one: flatbuffers::WIPOffset<schema::Packed<'b>>,
        three: flatbuffers::WIPOffset<schema::Packed<'b>>,
        largest: flatbuffers::WIPOffset<schema::Packed<'b>>,
        /// This many bytes.
        bytes: [flatbuffers::WIPOffset<flatbuffers::Vector<'b, u8>>; 3],
    }
    type Fault = for<'b> fn(&mut schema::BorderArgs<'b>, Offered<'b>);
    let faults: [(&str, Fault); 7] = [
        ("", |_, _| ()),
        ("edges lack their sources", |args, it| args.edge_sides = Some(it.one)),
        ("1 edges have 3 sources", |args, it| {
            (args.edge_sides, args.edge_sources) = (Some(it.one), Some(it.three));
        }),
        ("ends of segments, but no sources", |args, it| {
            args.segment_ends = Some(it.bytes[1]);
        }),
        ("2 bytes of ends of segments, not 1", |args, it| {
            (args.edge_sides, args.edge_sources) = (Some(it.one), Some(it.one));
            args.segment_ends = Some(it.bytes[2]);
        }),
        ("0 bytes of ends of segments, not 1", |args, it| {
            (args.edge_sides, args.edge_sources) = (Some(it.one), Some(it.one));
            args.segment_ends = Some(it.bytes[0]);
        }),
        ("the number of a line is too large", |args, it| {
            (args.edge_sides, args.edge_sources) = (Some(it.one), Some(it.largest));
        }),
    ];
    let (core, border) = drafts();
    let buffers = Buffers::default();
    let core = core.encode(TileId(0), 1, &buffers);
    let right = border.encode(TileId(0), 1, &buffers);
    let right: schema::Border<'_> = verified(&right, "it").unwrap();
    for (reason, fault) in faults {
        let mut builder = flatbuffers::FlatBufferBuilder::new();
        let mut write = |values: &[u64]| {
            let largest = values.iter().copied().max().unwrap_or(0);
            crate::store::format::packed::write(&mut builder, values.iter().copied(), largest, 0)
        };
        let copy = |table: schema::Packed<'_>| {
            let bytes = table.data().unwrap_or_default();
            let values = bytes.bytes()[..bytes.len() - 7].iter().map(|&byte| u64::from(byte));
            values.collect::<Vec<u64>>()
        };
        let mut args = schema::BorderArgs {
            generation: 1,
            triangles: Some(write(&copy(right.triangles()))),
            core_links: Some(write(&copy(right.core_links()))),
            vertex_sides: Some(write(&copy(right.vertex_sides()))),
            neighbours: Some(write(&[7, 7, 1])),
            ..schema::BorderArgs::default()
        };
        let offered = [&[0][..], &[0, 1, 2], &[1 << 62]].map(&mut write);
        let [one, three, largest] = offered;
        let bytes = [&[][..], &[3], &[3, 3]].map(|bytes: &[u8]| builder.create_vector(bytes));
        args.foreign = Some(builder.create_vector(&right.foreign().iter().copied().collect::<Vec<_>>()));
        let offered = Offered {
            one,
            three,
            largest,
            bytes,
        };
        fault(&mut args, offered);
        let root = schema::Border::create(&mut builder, &args);
        builder.finish(root, None);
        let opened = open_bytes(&core, &builder.finished_data().to_vec().into(), &full_table());
        match opened {
            Ok(_) => assert_eq!(reason, ""),
            Err(error) => assert!(
                !reason.is_empty() && error.to_string().contains(reason),
                "{error:?} is not about {reason:?}"
            ),
        }
    }
}

/// Whatever the bytes are, opening fails, or all accessors of the tile work.
#[test]
fn random_bytes_are_rejected_or_give_a_tile_that_does_not_panic() {
    let mut seed = 11u64;
    let mut below = |n: usize| {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % n
    };
    let (core, border) = full_drafts();
    let buffers = Buffers::default();
    let right = [
        core.encode(TileId(0), 1, &buffers),
        border.encode(TileId(0), 1, &buffers),
    ];
    let mut outcomes = [0; 2];
    for _ in 0..30_000 {
        let mut parts = right.each_ref().map(|part| part.to_vec());
        let part = &mut parts[below(2)];
        for _ in 0..=below(2) {
            let at = below(part.len());
            part[at] = [0, 1, 2, 5, 0x7f, 0xff, part[at] ^ 1, part[at].wrapping_add(1)][below(8)];
        }
        let [core, border] = parts.map(Bytes::from);
        let Ok(tile) = open_bytes(&core, &border, &full_table()) else {
            outcomes[0] += 1;
            continue;
        };
        outcomes[1] += 1;
        for half_edge in (0..3 * tile.triangle_count()).map(HalfEdge) {
            let sources = tile
                .edge_parts(half_edge)
                .filter(|part| part.is_wall() || part.ends())
                .count();
            assert!(sources < 1000 && (tile.is_constraint(half_edge) || !tile.is_wall(half_edge)));
        }
        for triangle in tile.triangle_ids() {
            let told = (tile.region(triangle), tile.depth(triangle), tile.is_hole(triangle));
            let Component { region, depth, is_hole } = tile.component(triangle);
            assert_eq!(told, (region, depth, is_hole));
        }
        assert!(tile.sites().all(|site| tile.is_site(site.vertex)));
        assert!(
            tile.vertex_indices()
                .filter(|&vertex| tile.is_input_point(vertex))
                .count()
                <= 4
        );
        assert_eq!(tile.sites().count(), tile.site_count() as usize);
        assert!(tile.byte_size() < 100_000);
        let heights = tile
            .triangle_ids()
            .flat_map(|t| tile.corners(t))
            .map(|corner| tile.z(corner));
        assert!(
            heights
                .map(|z| z.is_some_and(f64::is_finite))
                .all(|finite| finite == tile.has_z())
        );
    }
    assert!(outcomes.iter().all(|&n| n > 1000), "{outcomes:?}");
}
