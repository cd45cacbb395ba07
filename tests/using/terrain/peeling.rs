//! Surfaces from which long triangles are peeled off from the hull inwards, against a flood over all
//! triangles in memory.

use std::collections::BTreeSet;

use super::contours::{self, contours};
use super::rasters::{Triangle, build, triangles, whole};
use crate::export::features::features;
use crate::support::peeling::peeled;
use crate::support::{Random, Scratch, batches, build_batches, runtime};
use delaunay_tiles::BuildOptions;
use delaunay_tiles::export::{ExportError, ExportOptions, Format, What, export};
use delaunay_tiles::geometry::{Point, Rect};
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::{OpenOptions, ReadError, TileReader};
use delaunay_tiles::terrain::{Grid, Measure, Profile, RasterOptions, Surface};

/// Points in a ring round a lake, in a crescent round a bay, and a few far away from all others, with
/// random heights.
fn shore(seed: u64) -> (Vec<Point>, Vec<f64>) {
    let mut random = Random(seed);
    let mut points: Vec<Point> = [(9.0, 6.5), (-7.5, 3.0), (4.0, -8.0), (9.5, 6.5), (11.0, -0.1)]
        .map(|(x, y)| Point::new(x, y))
        .to_vec();
    let mut around = |x: f64, first: f64, last: f64, count: usize| {
        for _ in 0..count {
            let (angle, radius) = (first + (last - first) * random.unit(), 0.5 + 0.5 * random.unit());
            points.push(Point::new(x + radius * angle.cos(), radius * angle.sin()));
        }
    };
    around(0.0, 0.0, std::f64::consts::TAU, 700);
    around(3.0, 1.0, 5.3, 500);
    let z = points.iter().map(|_| 10.0 * random.unit() - 5.0).collect();
    (points, z)
}

const LAKE: Point = Point { x: 0.01, y: 0.02 };
const BAY: Point = Point { x: 3.02, y: 0.01 };

/// A gate across the bay: the outside reaches the bay only through the triangles of this obstacle.
fn gate() -> SegmentBatch {
    let corners = [(3.3, -1.2), (3.45, -1.2), (3.45, 1.2), (3.3, 1.2)].map(|(x, y)| Point::new(x, y));
    SegmentBatch {
        z: vec![[1.0, 3.0]; 4],
        ends: (0..4).map(|i| [corners[i], corners[(i + 1) % 4]]).collect(),
        lines: vec![0; 4],
        ..SegmentBatch::default()
    }
}

fn grid() -> Grid {
    Grid::covering(Rect::new(-8.0, -8.5, 11.5, 7.0), 0.25, Point::new(0.11, 0.07)).unwrap()
}

fn surface(holes: bool, most: f64) -> Surface {
    Surface::default().holes(holes).max_edge(Some(most)).from_hull(true)
}

/// Returns the triangles that count, by the flood.
async fn counting(reader: &TileReader, holes: bool, most: f64) -> Vec<Triangle> {
    let all = triangles(reader, true, f64::INFINITY).await;
    let corners: Vec<[Point; 3]> = all.iter().map(|triangle| triangle.corners).collect();
    let left = all
        .into_iter()
        .zip(peeled(&corners, most))
        .filter(|(_, is_peeled)| !is_peeled);
    let in_no_hole = triangles(reader, holes, f64::INFINITY).await;
    let in_no_hole: BTreeSet<_> = in_no_hole.iter().map(|triangle| name(triangle.corners)).collect();
    let left = left.map(|(triangle, _)| triangle);
    left.filter(|triangle| in_no_hole.contains(&name(triangle.corners)))
        .collect()
}

/// The bits of the corners, sorted.
fn name(corners: [Point; 3]) -> [[u64; 2]; 3] {
    let mut name = corners.map(|p| [p.x, p.y].map(f64::to_bits));
    name.sort_unstable();
    name
}

/// Returns the triangles that an export writes.
async fn exported(reader: &TileReader, holes: bool, most: f64) -> BTreeSet<[[u64; 2]; 3]> {
    let options = ExportOptions::default()
        .holes(holes)
        .max_edge(Some(most))
        .from_hull(true);
    let options = options.what(Some(What::Triangles));
    let outputs = vec![Vec::new()];
    let exported = export(reader, Format::GeoJson, options, outputs, |_, _| ())
        .await
        .unwrap();
    let (features, _) = features(Format::GeoJson, &exported.outputs[0]);
    let corners = features
        .iter()
        .map(|feature| name([0, 1, 2].map(|i| Point::new(feature.corners[i][0], feature.corners[i][1]))));
    let found: BTreeSet<_> = corners.collect();
    assert_eq!(found.len() as u64, exported.triangles);
    found
}

/// All that is asked of a surface; heights and the like by their bits.
#[derive(PartialEq)]
struct Answers {
    triangles: BTreeSet<[[u64; 2]; 3]>,
    heights: Vec<u64>,
    slopes: Vec<u64>,
    volume: [u64; 2],
    profile: Profile,
    contours: BTreeSet<contours::Contour>,
}

fn bits(values: &[f64]) -> Vec<u64> {
    values
        .iter()
        .map(|value| if value.is_nan() { u64::MAX } else { value.to_bits() })
        .collect()
}

async fn answers(reader: &TileReader, holes: bool, most: f64) -> Answers {
    let surface = surface(holes, most);
    let options = RasterOptions::new(grid()).surface(surface);
    let volume = reader.volume(0.5, surface, None).await.unwrap();
    let line = [(-8.0, 3.1), (0.0, -0.1), (3.1, 0.05), (11.0, 0.0)].map(|(x, y)| Point::new(x, y));
    Answers {
        triangles: exported(reader, holes, most).await,
        heights: bits(&whole(reader, &options).await),
        slopes: bits(&whole(reader, &options.measure(Measure::Slope)).await),
        volume: [volume.cut, volume.area].map(f64::to_bits),
        profile: reader.profile(&line, surface).await.unwrap(),
        contours: contours(reader, contours::options(2.0, 0.5).surface(surface)).await,
    }
}

/// Checks the answers against the triangles that count.
async fn check(reader: &TileReader, holes: bool, most: f64, answers: &Answers) {
    let counting = counting(reader, holes, most).await;
    let names: BTreeSet<_> = counting.iter().map(|triangle| name(triangle.corners)).collect();
    assert!(answers.triangles == names, "{holes} {most}");
    let at = |p: Point| counting.iter().find(|triangle| triangle.contains(p)).map(|t| t.z_at(p));
    let grid = grid();
    for (cell, height) in (0..).zip(&answers.heights) {
        let centre = grid.centre(cell % grid.columns(), cell / grid.columns());
        let expected = at(centre);
        assert_eq!(*height == u64::MAX, expected.is_none(), "{centre:?} {holes} {most}");
        if let Some(expected) = expected {
            assert!((f64::from_bits(*height) - expected).abs() < 1e-6, "{centre:?}");
        }
        assert_eq!(
            answers.slopes[cell as usize] == u64::MAX,
            expected.is_none(),
            "{centre:?}"
        );
        if cell % 397 == 0 {
            let z = reader
                .surface_z(centre.x, centre.y, surface(holes, most))
                .await
                .unwrap();
            assert_eq!(z.map_or(u64::MAX, f64::to_bits), *height, "{centre:?}");
        }
    }
    let area: f64 = counting
        .iter()
        .map(|t| Triangle::area(t.corners[0], t.corners[1], t.corners[2]) / 2.0)
        .sum();
    assert!((f64::from_bits(answers.volume[1]) - area).abs() < 1e-9, "{area}");
    let corners: Vec<_> = counting
        .iter()
        .map(|t| [0, 1, 2].map(|i| (t.corners[i], t.z[i])))
        .collect();
    assert!(
        answers.contours == contours::expected(&corners, 2.0, 0.5),
        "{holes} {most}"
    );
    // The line has a vertex at the lake and one at the bay.
    for (p, number) in [(Point::new(0.0, -0.1), 1), (Point::new(3.1, 0.05), 2)] {
        let points = answers.profile.parts.iter().flat_map(|part| &part.points);
        let is_there = points.into_iter().any(|found| found.point == p);
        assert_eq!(is_there, at(p).is_some(), "corner {number} of the line, {holes} {most}");
    }
}

#[test]
fn what_is_left_is_what_a_flood_from_the_hull_leaves_whatever_the_tiles() {
    let (points, z) = shore(1);
    let cases = [
        (false, 0.0),
        (false, 0.07),
        (true, 0.3),
        (false, 0.3),
        (false, 1.5),
        (true, 100.0),
    ];
    runtime().block_on(async {
        let mut of_tiles = Vec::new();
        for (tile_vertices, threads) in [(5000, 1), (50, 2), (4, 1)] {
            let scratch = build(&points, &z, &gate(), tile_vertices, threads).await;
            let reader = scratch.open().await;
            assert!(reader.metadata().hole_triangles > 0);
            let mut found = Vec::new();
            for (holes, most) in cases {
                let answers = answers(&reader, holes, most).await;
                if tile_vertices == 50 {
                    check(&reader, holes, most, &answers).await;
                }
                found.push(answers);
            }
            of_tiles.push(found);
        }
        for found in &of_tiles {
            assert!(*found == of_tiles[0]);
        }
        let sizes: Vec<usize> = of_tiles[0].iter().map(|answers| answers.triangles.len()).collect();
        assert!(
            sizes[0] == 0 && sizes[1] < sizes[3] && sizes[3] < sizes[2] && sizes[3] < sizes[4],
            "{sizes:?}"
        );
    });
}

#[test]
fn a_lake_stays_and_a_bay_does_not() {
    let (points, z) = shore(2);
    runtime().block_on(async {
        for tile_vertices in [5000, 8] {
            let scratch = build(&points, &z, &gate(), tile_vertices, 2).await;
            let reader = scratch.open().await;
            for (surface, lake, bay) in [
                (Surface::default().from_hull(true), true, true),
                (Surface::default().max_edge(Some(0.3)), false, false),
                (surface(false, 0.3), true, false),
                (surface(false, 1000.0), true, true),
            ] {
                for (p, is_on_surface) in [(LAKE, lake), (BAY, bay)] {
                    let z = reader.surface_z(p.x, p.y, surface).await.unwrap();
                    assert_eq!(z.is_some(), is_on_surface, "{p:?} on {surface:?}");
                }
            }
        }
    });
}

#[test]
fn files_of_few_triangles_are_peeled_too() {
    runtime().block_on(async {
        let square = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.25)].map(|(x, y)| Point::new(x, y));
        let line = [0.0, 1.0, 2.0].map(|x| Point::new(x, x));
        for (points, most, left) in [
            (&square[..0], 1.0, 0),
            (&square[..1], 1.0, 0),
            (&line[..], 1.0, 0),
            (&square[..3], 1.0, 0),
            (&square[..3], 1.5, 1),
            (&square[..], 1.0, 0),
            (&square[..], 1.5, 2),
        ] {
            let scratch = Scratch::new();
            let z: Vec<f64> = points.iter().map(|p| p.x).collect();
            let options = BuildOptions::default().tile_vertices(4);
            build_batches(&scratch.path, &batches(points, &z), options)
                .await
                .unwrap();
            let reader = scratch.open().await;
            assert_eq!(exported(&reader, false, most).await.len(), left, "{points:?}");
            let z = reader.surface_z(0.0, 0.0, surface(false, most)).await.unwrap();
            let is_vertex_alone = reader.metadata().triangles == 0 && !points.is_empty();
            assert_eq!(z.is_some(), left > 0 || is_vertex_alone, "{points:?}");
        }
    });
}

#[test]
fn an_export_has_the_same_bytes_in_every_memory() {
    let (points, z) = shore(3);
    runtime().block_on(async {
        let scratch = build(&points, &z, &gate(), 20, 2).await;
        let options = ExportOptions::default().max_edge(Some(0.1)).from_hull(true);
        let exported = async |reader: &TileReader| {
            let exported = export(reader, Format::Obj, options.clone(), vec![Vec::new()], |_, _| ()).await?;
            Ok::<_, ExportError>(exported.outputs)
        };
        let whole = exported(&scratch.open().await).await.unwrap();
        let (mut works, mut refused) = (0, 0);
        for memory in (14..30).flat_map(|bits| [1u64 << bits, 3 << (bits - 1)]) {
            let small = OpenOptions::default().memory(memory);
            let Ok(small) = TileReader::open(&scratch.path, small).await else {
                continue;
            };
            match exported(&small).await {
                Ok(again) => {
                    assert!(again == whole, "{memory} bytes");
                    works += 1;
                }
                Err(ExportError::Read(ReadError::Memory { needed, .. })) => {
                    assert!(needed > memory && works == 0, "{memory} bytes");
                    refused += 1;
                }
                Err(error) => panic!("{error}"),
            }
            // A volume needs less than the texts of an export.
            match small.volume(0.0, surface(false, 0.0), None).await {
                Ok(volume) => assert_eq!(volume.area, 0.0),
                Err(error) => assert!(error.to_string().contains("memory"), "{error}"),
            }
        }
        assert!(works > 2 && refused > 0, "{works} {refused}");
    });
}
