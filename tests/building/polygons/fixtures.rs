//! Polygons from the tests of other projects, many of them degenerate, as obstacles.

use std::fs;
use std::path::Path;
use std::slice;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::{BuildError, BuildOptions, Crossings};

use super::rings::{self, Flaw, Polygon};
use super::{Input, WAYS, assert_same_area};
use crate::support::test_data::{data, shared};

use Flaw::{Crosses, Flat, Misnested, Touches};

/// The polygons of earcutr, each with the flaws that keep its numbers of vertices and rings from
/// telling its number of triangles.
const EARCUTR: [(&str, &[Flaw]); 35] = [
    ("bad-diagonals", &[Touches]),
    ("bad-hole", &[Crosses, Touches, Misnested]),
    ("building", &[]),
    ("degenerate", &[Flat, Touches]),
    ("dude", &[]),
    ("eberly-3", &[Touches]),
    ("eberly-6", &[]),
    ("empty-square", &[Touches]),
    ("filtered-bridge-jhl", &[]),
    ("hilbert", &[]),
    ("hole-touching-outer", &[Touches]),
    ("infinite-loop-jhl", &[Touches]),
    ("issue142", &[Crosses, Touches, Misnested]),
    ("issue149", &[Touches]),
    ("issue16", &[]),
    ("issue17", &[]),
    ("issue29", &[]),
    ("issue34", &[]),
    ("issue35", &[]),
    ("issue45", &[Touches]),
    ("issue52", &[]),
    ("issue83", &[Touches]),
    ("outside-ring", &[Touches]),
    ("self-touching", &[Touches]),
    ("shared-points", &[Touches]),
    ("simplified-us-border", &[Crosses, Touches]),
    ("steiner", &[]),
    ("touching-holes", &[Touches]),
    ("water", &[Crosses, Touches]),
    ("water-huge", &[Flat, Crosses, Touches, Misnested]),
    ("water-huge2", &[Flat, Crosses, Touches, Misnested]),
    ("water2", &[Touches]),
    ("water3", &[Touches]),
    ("water3b", &[Touches]),
    ("water4", &[Touches]),
];

/// The polygons of poly2tri. The last two are random points, which cross everywhere as a ring.
const POLY2TRI: [(&str, &[Flaw]); 4] = [
    ("bird.dat", &[]),
    ("nazca_heron.dat", &[]),
    ("draw_sample", &[Crosses]),
    ("random_100", &[Crosses]),
];

type Ring = Vec<[f64; 2]>;

/// Builds from the rings of a polygon, and checks that it has these flaws.
fn check(name: &str, rings: &[Ring], flaws: &[Flaw]) {
    println!("{name}");
    let polygon = Polygon::new(rings);
    assert_eq!(polygon.flaws(), flaws, "{name}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fixture.geojson");
    fs::write(&path, format!(r#"{{"type":"Polygon","coordinates":{rings:?}}}"#)).unwrap();
    let input = Input::obstacles(path);

    let mut options = BuildOptions::default();
    if flaws.contains(&Crosses) {
        let error = input.build(&options, &WAYS).unwrap_err();
        let Some(BuildError::Crossings { first, count }) = error.downcast_ref() else {
            panic!("{name}: {error}");
        };
        let segments: Vec<[Point; 2]> = polygon.segments().collect();
        let expected = rings::crossings(&segments);
        // The segments of a ring without area come in both directions.
        let has_more = flaws.contains(&Flat) && *count > expected;
        assert!(*count == expected || has_more, "{name}: {count}, not {expected}");
        assert!(first.len() as u64 == (*count).min(10), "{name}: {first:?}");
        options.crossings = Crossings::Split;
    }
    let built = match input.build(&options, &WAYS) {
        Ok(built) => built,
        Err(error) => panic!("{name}: {error}"),
    };
    // Everything that the rings wind around counts once, however often they do.
    let covered = built.triangles.iter().map(|triangle| {
        let area = rings::area(&triangle.corners);
        f64::from(triangle.depth) * area
    });
    let segments: Vec<[Point; 2]> = polygon.segments().collect();
    let gone_round = built.triangles.iter().filter(|triangle| {
        let [a, b, c] = triangle.corners;
        let centroid = Point::new((a.x + b.x + c.x) / 3.0, (a.y + b.y + c.y) / 3.0);
        rings::winding(&segments, centroid) != 0
    });
    let expected = match flaws.contains(&Crosses) || built.summary.inverted_parts > 0 {
        false => polygon.area(),
        true => gone_round.map(|triangle| rings::area(&triangle.corners)).sum(),
    };
    assert_same_area(covered.sum(), expected);
    assert_eq!(built.summary.crossings > 0, flaws.contains(&Crosses));
    if flaws.contains(&Crosses) {
        return;
    }
    assert!(built.check_depths(slice::from_ref(&polygon), 1) > 0, "{name}");
    assert_same_area(built.holes().area, polygon.area());
    if flaws.is_empty() {
        let (vertices, holes) = (polygon.vertices() as u64, polygon.rings.len() as u64 - 1);
        assert_eq!(built.summary.vertices, vertices, "{name}");
        assert_eq!(built.holes().triangles, vertices - 2 + 2 * holes, "{name}");
        assert_eq!(built.summary.hole_regions, 1, "{name}");
    }
}

#[test]
fn polygons_of_earcutr_give_holes_of_their_area_and_depth() {
    let mut checked = 0;
    for (name, flaws) in EARCUTR {
        let shipped = data(&format!("earcutr/{name}.json"));
        let path = Some(shipped).filter(|path| path.exists());
        let Some(path) = path.or_else(|| shared(&format!("fixtures/earcutr-0.5.0/{name}.json"))) else {
            continue;
        };
        let rings: Vec<Ring> = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
        check(name, &rings, flaws);
        checked += 1;
    }
    assert!(checked >= 30);
}

#[test]
fn polygons_of_poly2tri_give_holes_of_their_area_and_depth() {
    let row = |line: &str| -> [f64; 2] {
        let numbers = line.split_whitespace().map(|number| number.parse().unwrap());
        numbers.collect::<Vec<_>>().try_into().unwrap()
    };
    let ring = |path: &Path| -> Ring { fs::read_to_string(path).unwrap().lines().map(row).collect() };
    for (name, flaws) in POLY2TRI {
        check(name, &[ring(&data(&format!("poly2tri/{name}")))], flaws);
    }
}
