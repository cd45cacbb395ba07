//! Polygons that are not as they should be: taken as they are meant where that is clear, else an error that says which and where.

use std::error::Error;
use std::fs;

use delaunay_tiles::build::{BuildError, BuildOptions, Crossings, Inverted};
use delaunay_tiles::geometry::Point;

use super::{Built, Input, Way};

const WAYS: [Way; 3] = [(4, 1), (9, 2), (1 << 16, 1)];

/// A good polygon far from all others, so that these are not the first, and there are triangles in any case.
const CHURCH: &str = "[[[90,90],[96,90],[94,97],[90,90]]]";
const CHURCH_AREA: f64 = 21.0;

/// Builds from the coordinates of polygons behind those of a good one.
fn build(polygons: &[&str], crossings: Crossings) -> Result<Built, Box<dyn Error>> {
    let features = [CHURCH].iter().chain(polygons).map(|coordinates| {
        // A MultiPolygon has an array more.
        let kind = if coordinates.starts_with("[[[[") {
            "MultiPolygon"
        } else {
            "Polygon"
        };
        format!(r#"{{"type":"Feature","geometry":{{"type":"{kind}","coordinates":{coordinates}}}}}"#)
    });
    let features = features.collect::<Vec<_>>().join(",");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("town.geojson");
    fs::write(
        &path,
        format!(r#"{{"type":"FeatureCollection","features":[{features}]}}"#),
    )
    .unwrap();
    let options = BuildOptions {
        crossings,
        ..BuildOptions::default()
    };
    Input::obstacles(path).build(&options, &WAYS)
}

/// Builds from polygons that are no mistake.
#[track_caller]
fn accepted(polygons: &[&str]) -> Built {
    match build(polygons, Crossings::Error) {
        Ok(built) => built,
        Err(error) => panic!("{polygons:?}: {error}"),
    }
}

impl Built {
    /// The area of holes, and how many regions they are, without the good polygon.
    fn covered(&self) -> (f64, u64) {
        (self.holes().area - CHURCH_AREA, self.summary.hole_regions - 1)
    }

    fn depths(&self) -> Vec<i32> {
        let mut depths: Vec<i32> = self.triangles.iter().map(|triangle| triangle.depth).collect();
        depths.sort_unstable();
        depths.dedup();
        depths
    }
}

/// Lines of these numbers cross at this place, and no others; that is an error, and can be split.
#[track_caller]
fn crosses(polygons: &[&str], expected: &[(u64, u64, [f64; 2])]) -> Built {
    let error = build(polygons, Crossings::Error).unwrap_err();
    let Some(BuildError::Crossings { first, count }) = error.downcast_ref() else {
        panic!("{error}");
    };
    let found: Vec<_> = first
        .iter()
        .map(|crossing| {
            let [one, other] = crossing.lines.map(|line| line.number());
            (one, other, [crossing.point.x, crossing.point.y])
        })
        .collect();
    assert_eq!((&*found, *count), (expected, expected.len() as u64));
    for (one, other, [x, y]) in expected {
        let text = format!("obstacle {one} and obstacle {other} at ({x}, {y})");
        assert!(error.to_string().contains(&text), "{error}");
    }
    let built = build(polygons, Crossings::Split).unwrap();
    assert_eq!(built.summary.crossings, expected.len() as u64);
    for (_, _, [x, y]) in expected {
        assert!(built.vertices.iter().any(|vertex| vertex.point == Point::new(*x, *y)));
    }
    built
}

const SQUARE: &str = "[[[0,0],[8,0],[8,8],[0,8],[0,0]]]";

#[test]
fn rings_that_are_written_carelessly() {
    let square = accepted(&[SQUARE]);
    assert_eq!(square.covered(), (64.0, 1));
    for same in [
        "[[[0,0],[8,0],[8,8],[0,8]]]",
        "[[[0,0],[0,8],[8,8],[8,0],[0,0]]]",
        "[[[0,0],[0,0],[8,0],[8,0],[8,0],[8,8],[0,8],[0,0],[0,0]]]",
        "[[[0,0],[-0.0,8],[8,8],[8,-0.0]]]",
        "[[[8,8],[8,0],[0,0],[0,8]],[],[[3,3],[3,3]]]",
    ] {
        assert_eq!(accepted(&[same]).digest, square.digest, "{same}");
    }
    let court = accepted(&["[[[0,0],[8,0],[8,8],[0,8],[0,0]],[[2,2],[2,6],[6,6],[6,2],[2,2]]]"]);
    assert_eq!(court.covered(), (48.0, 1));
    for same in [
        "[[[0,0],[8,0],[8,8],[0,8]],[[2,2],[6,2],[6,6],[2,6]]]",
        "[[[0,0],[0,8],[8,8],[8,0]],[[2,2],[2,6],[6,6],[6,2]]]",
    ] {
        assert_eq!(accepted(&[same]).digest, court.digest, "{same}");
    }
}

#[test]
fn rings_that_cross() {
    // A bow-tie; its larger lobe tells on which side its interior is.
    let built = crosses(
        &["[[[0,0],[8,8],[8,0],[0,4],[0,0]]]"],
        &[(1, 1, [8.0 / 3.0, 8.0 / 3.0])],
    );
    assert!(
        (built.covered().0 - 64.0 / 3.0 - 16.0 / 3.0).abs() < 1e-9,
        "both lobes are covered"
    );
    assert_eq!(built.summary.inverted_regions, 1);
    let first = built.summary.first_inverted.map(|first| (first.obstacle, first.point));
    assert_eq!(first, Some((1, Point::new(0.0, 0.0))));
    // The polygon is named by its place in the file.
    let bow_tie = "[[[20,0],[28,4],[28,0],[20,12],[20,0]]]";
    crosses(&[SQUARE, bow_tie], &[(2, 2, [26.0, 3.0])]);
    // Lobes that cancel out are a wall from both sides, whose segments cross several times at one place: told of once.
    let error = build(&["[[[0,0],[8,4],[8,0],[0,4],[0,0]]]"], Crossings::Error).unwrap_err();
    let text = error.to_string();
    assert!(text.contains(": obstacle 1 and obstacle 1 at (4, 2);"), "{text}");
    assert!(!text.contains("more"), "{text}");
    // Two that overlap.
    let built = crosses(
        &[SQUARE, "[[[4,4],[12,4],[12,12],[4,12],[4,4]]]"],
        &[(1, 2, [4.0, 8.0]), (1, 2, [8.0, 4.0])],
    );
    assert_eq!(built.covered(), (64.0 + 64.0 - 16.0, 3));
    assert_eq!(built.depths(), [0, 1, 2]);
    // A ring that goes round twice.
    let built = crosses(
        &["[[[0,0],[8,0],[8,8],[2,8],[2,2],[6,2],[6,10],[0,10],[0,0]]]"],
        &[(1, 1, [6.0, 8.0])],
    );
    assert_eq!(built.covered(), (8.0 * 8.0 + 2.0 * 6.0, 2));
    assert_eq!(built.depths(), [0, 1, 2]);
}

#[test]
fn polygons_that_lie_on_each_other() {
    let twice = accepted(&[SQUARE, SQUARE]);
    assert_eq!(twice.covered(), (64.0, 1));
    assert_eq!(twice.depths(), [0, 1, 2]);
    assert_eq!(twice.digest, accepted(&[SQUARE]).digest);
    let within = accepted(&[SQUARE, "[[[2,2],[6,2],[6,6],[2,6],[2,2]]]"]);
    assert_eq!(within.covered(), (64.0, 2));
    assert_eq!(within.depths(), [0, 1, 2]);
    // In the court of another there is room.
    let in_court = accepted(&[
        "[[[0,0],[8,0],[8,8],[0,8],[0,0]],[[2,2],[2,6],[6,6],[6,2],[2,2]]]",
        "[[[2,2],[6,2],[6,6],[2,6],[2,2]]]",
    ]);
    assert_eq!(in_court.covered(), (64.0, 2));
    assert_eq!(in_court.depths(), [0, 1]);
}

#[test]
fn polygons_that_touch() {
    // Along a part of a wall, in a corner, with a corner on a wall.
    for (other, edges, area) in [
        ("[[[8,2],[12,2],[12,5],[8,5],[8,2]]]", 9, 12.0),
        ("[[[8,8],[10,8],[10,10],[8,10],[8,8]]]", 8, 4.0),
        ("[[[8,4],[10,2],[10,6],[8,4]]]", 8, 4.0),
        ("[[[8,0],[16,0],[16,8],[8,8],[8,0]]]", 7, 64.0),
    ] {
        let built = accepted(&[SQUARE, other]);
        assert_eq!(built.covered(), (64.0 + area, 2), "{other}");
        assert_eq!(built.summary.constraint_edges, edges + 3, "{other}");
        // As one polygon of two parts it is the same, though no valid one.
        let (one, other) = (&SQUARE, &other);
        let parts = accepted(&[&format!("[{one},{other}]")]);
        assert_eq!(parts.digest, built.digest, "{other}");
        assert_eq!(parts.covered(), built.covered());
    }
}

#[test]
fn polygons_that_enclose_nothing() {
    for (nothing, edges, note) in [
        ("[[[0,0],[8,0],[4,0],[0,0]]]", 2, Some("1 rings enclose nothing")),
        ("[[[0,0],[8,8],[0,0]]]", 1, Some("1 rings enclose nothing")),
        ("[[[0,0],[0,0],[0,0],[0,0]]]", 0, Some("1 rings have one position only")),
        ("[[]]", 0, None),
        ("[]", 0, None),
        // A court as large as its house.
        (
            "[[[0,0],[8,0],[8,8],[0,8],[0,0]],[[0,0],[0,8],[8,8],[8,0],[0,0]]]",
            4,
            None,
        ),
    ] {
        let built = accepted(&[nothing]);
        assert_eq!(built.covered(), (0.0, 0), "{nothing}");
        assert_eq!(built.depths().last(), Some(&1));
        assert_eq!(built.summary.constraint_edges, edges + 3, "{nothing}");
        match note {
            None => assert_eq!(built.notes, [""; 0]),
            Some(note) => assert!(built.notes[0].starts_with(note), "{:?}", built.notes),
        }
    }
}

/// A region of these polygons is inside out; that is an error which says of which line it is and where, and such regions are
/// covered where lines that cross are split.
#[track_caller]
fn is_inside_out(polygons: &[&str], regions: u64, obstacle: u64, [x, y]: [f64; 2]) -> Built {
    let expected = Inverted {
        obstacle,
        point: Point::new(x, y),
    };
    let error = build(polygons, Crossings::Error).unwrap_err();
    match error.downcast_ref() {
        Some(BuildError::Inverted { first, regions: found }) => assert_eq!((*first, *found), (expected, regions)),
        _ => panic!("{error}"),
    }
    let text = format!("obstacle {obstacle} is inside out at ({x}, {y})");
    assert!(error.to_string().contains(&text), "{error}");
    let built = build(polygons, Crossings::Split).unwrap();
    assert_eq!(
        (built.summary.inverted_regions, built.summary.first_inverted),
        (regions, Some(expected))
    );
    built
}

#[test]
fn rings_that_are_nested_wrongly() {
    let hole_outside = "[[[0,0],[8,0],[8,8],[0,8],[0,0]],[[10,2],[14,2],[14,6],[10,6],[10,2]]]";
    let built = is_inside_out(&[hole_outside], 1, 1, [10.0, 2.0]);
    assert_eq!(built.covered(), (64.0 + 16.0, 2));
    assert_eq!(built.depths(), [-1, 0, 1]);
    let hole_in_hole =
        "[[[0,0],[8,0],[8,8],[0,8],[0,0]],[[1,1],[7,1],[7,7],[1,7],[1,1]],[[3,3],[5,3],[5,5],[3,5],[3,3]]]";
    let built = is_inside_out(&[SQUARE, hole_outside, hole_in_hole], 1, 2, [10.0, 2.0]);
    assert_eq!(built.covered(), (64.0 + 16.0, 4));
    let built = is_inside_out(&[hole_in_hole], 1, 1, [3.0, 3.0]);
    assert_eq!(built.covered(), (64.0 - 36.0 + 4.0, 2));
    // Twice as deep, and the wall of one that may have the hole there.
    let twice = "[[[10,0],[18,0],[18,8],[10,8]],[[2,2],[6,2],[6,6],[2,6]],[[3,3],[5,3],[5,5],[3,5]]]";
    let built = is_inside_out(&[twice, "[[[2,2],[2,0],[3,0],[2,2]]]"], 2, 1, [2.0, 2.0]);
    assert_eq!(built.depths(), [-2, -1, 0, 1]);
    // A bow-tie that has a corner where it crosses itself; its lobes are covered if both run the same way.
    is_inside_out(&["[[[0,0],[4,4],[8,12],[0,12],[4,4],[8,0],[0,0]]]"], 1, 1, [0.0, 0.0]);
    let eight = accepted(&["[[[0,0],[8,0],[4,4],[8,12],[0,12],[4,4],[0,0]]]"]);
    assert_eq!(eight.covered(), (16.0 + 32.0, 2));
    assert_eq!(
        (eight.summary.inverted_regions, eight.summary.first_inverted),
        (0, None)
    );
}
