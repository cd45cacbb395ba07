//! Polygons of maps: islands, houses, lake shores, the map of a game.

use delaunay_tiles::{BuildOptions, MissingZ};

use super::rings::{Polygon, area, polygons_of};
use super::{Input, TriangleTotals, WAYS, assert_same_area, without_sources};
use crate::support::test_data::{data, shared};

fn whole_area(polygons: &[Polygon]) -> f64 {
    polygons.iter().map(Polygon::area).sum()
}

#[test]
fn each_island_becomes_a_hole_of_its_area() {
    let path = data("indonesia/indonesia_ne10m.geojson");
    let polygons = polygons_of(&path);
    let built = Input::obstacles(path).build(&BuildOptions::default(), &WAYS).unwrap();
    assert_eq!(built.summary.constraint_edges, 23_541);
    assert_eq!(built.summary.hole_regions, 339);
    // A simple polygon of n vertices has n - 2 triangles.
    assert_eq!(built.holes().triangles, 23_541 - 2 * 339);
    assert_same_area(built.holes().area, whole_area(&polygons));
    assert!(built.check_depths(&polygons, 40) > 1000);
}

/// The same islands as polygons, and as segments with a point in each.
#[test]
fn hole_points_and_polygons_of_islands_give_the_same_file() {
    let (Some(poly), Some(geojson)) = (
        shared("indonesia/group1_dense_small.poly"),
        shared("indonesia/group1_dense_small.geojson"),
    ) else {
        return;
    };
    let polygons = polygons_of(&geojson);
    let input = Input {
        poly: Some(poly),
        ..Input::default()
    };
    let seeded = input.build(&BuildOptions::default(), &WAYS).unwrap();
    let covered = Input::obstacles(geojson)
        .build(&BuildOptions::default(), &WAYS)
        .unwrap();
    for built in [&seeded, &covered] {
        assert_eq!((built.summary.vertices, built.summary.constraint_edges), (2477, 2477));
        assert_eq!(built.summary.hole_regions, 77);
        assert_eq!(built.holes().triangles, 2477 - 2 * 77);
        assert_same_area(built.holes().area, whole_area(&polygons));
    }
    // Walls around holes, and obstacles.
    assert_ne!(seeded.digest, covered.digest);
    assert_eq!(without_sources(seeded.digest), without_sources(covered.digest));
    assert!(seeded.triangles.iter().all(|triangle| triangle.depth == 0));
    assert!(covered.check_depths(&polygons, 1) > 2000);
}

#[test]
fn the_free_space_of_a_game_has_the_area_within_its_rings() {
    let input = Input {
        poly: Some(data("arena/arena.poly")),
        ..Input::default()
    };
    let options = BuildOptions::default().exterior_is_hole(true);
    let inside = input.build(&options, &WAYS).unwrap();
    assert_eq!((inside.summary.vertices, inside.summary.constraint_edges), (112, 112));
    let rings = inside.rings();
    let areas: Vec<f64> = rings.iter().map(|ring| area(ring).abs()).collect();
    let outer = areas.iter().copied().fold(0.0, f64::max);
    let expected = 2.0 * outer - areas.iter().sum::<f64>();
    assert_eq!(inside.free().triangles, 112 - 2 + 2 * 5);
    assert_same_area(inside.free().area, expected);
    // Without `exterior_is_hole` the exterior is free too.
    let all = input.build(&BuildOptions::default(), &WAYS).unwrap();
    assert_eq!(all.summary.hole_regions, 5);
    assert_same_area(all.holes().area, areas.iter().sum::<f64>() - outer);
    assert!(all.free().area > expected);
}

/// Houses that share walls and corners.
#[test]
fn houses_that_share_walls_give_holes_of_their_area() {
    let Some(path) = shared("obstacles/bubenec_buildings.geojson") else {
        return;
    };
    let polygons = polygons_of(&path);
    let built = Input::obstacles(path).build(&BuildOptions::default(), &WAYS).unwrap();
    assert_eq!(built.check_depths(&polygons, 1), built.triangles.len());
    // No house overlaps another, so their union has the sum of their areas.
    assert!(built.triangles.iter().all(|triangle| [0, 1].contains(&triangle.depth)));
    assert_same_area(built.holes().area, whole_area(&polygons));
    assert_eq!(built.summary.hole_regions, 144);
    let corners: usize = polygons.iter().map(Polygon::vertices).sum();
    assert!((built.summary.vertices as usize) < corners, "corners are shared");
    assert!((built.summary.constraint_edges as usize) < corners, "walls are shared");
}

/// Lake shores in a survey: edges that keep the heights of the points, and no holes.
#[test]
fn lake_shores_as_break_lines_keep_heights_and_make_no_holes() {
    use std::collections::HashMap;

    use delaunay_tiles::geometry::Point;
    use delaunay_tiles::input::{InputOptions, PointBatch, PointSource};
    use delaunay_tiles::store::LineKind;

    let (Some(survey), Some(lakes)) = (
        shared("lidar/lidR_Topography.laz"),
        shared("lidar/lidR_Topography_lake_polygons_UTM17.geojson"),
    ) else {
        return;
    };
    let polygons = polygons_of(&lakes);
    let input = Input {
        points: vec![survey.clone()],
        segments: vec![lakes],
        ..Input::default()
    };
    let options = BuildOptions::default().missing_z(MissingZ::Zero);
    let built = input.build(&options, &WAYS[1..]).unwrap();
    assert_eq!(built.holes(), TriangleTotals::default());
    assert_eq!(built.summary.regions, 2);
    for (_, sources) in &built.edges {
        assert_eq!(sources.len(), 1);
        assert_eq!((sources[0].kind(), sources[0].number()), (LineKind::BreakLine, 0));
    }
    // The edges are the whole shore, and nothing else.
    let length = |[a, b]: &[Point; 2]| (b.x - a.x).hypot(b.y - a.y);
    let shore: f64 = polygons[0].segments().map(|segment| length(&segment)).sum();
    assert_same_area(built.edges.iter().map(|(ends, _)| length(ends)).sum(), shore);
    // Each point has its first record, with that record's z. Other vertices are corners of the
    // shore, which have no z.
    let mut points = PointSource::open(&[survey], &InputOptions::default()).unwrap();
    let (mut batch, mut heights) = (PointBatch::default(), HashMap::new());
    while points.next_batch(&mut batch).unwrap() {
        for ((point, z), record) in batch.points.iter().zip(&batch.z).zip(&batch.records) {
            let key = [point.x, point.y].map(f64::to_bits);
            heights.entry(key).or_insert((Some(*z), *record));
        }
    }
    let mut ends = 0;
    for vertex in &built.vertices {
        match heights.get(&[vertex.point.x, vertex.point.y].map(f64::to_bits)) {
            Some(expected) => assert_eq!((vertex.z, vertex.record), *expected),
            None => {
                assert_eq!(vertex.z, Some(0.0));
                ends += 1;
            }
        }
    }
    assert_eq!(ends, built.summary.added_vertices);
    assert!(ends > 0);
}
