//! Invalid polygons: they are taken as they are meant if that is clear; otherwise an error says
//! which polygon is wrong, and where.

use std::error::Error;
use std::fs;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::{BuildError, BuildOptions, Crossings, Inverted, InvertedPolygons};

use super::{Built, Input, Way, without_sources};

const WAYS: [Way; 3] = [(4, 1), (9, 2), (1 << 16, 1)];

/// A valid polygon far from all others. It makes them not the first, and there are triangles in any
/// case.
const CHURCH: &str = "[[[90,90],[96,90],[94,97],[90,90]]]";
const CHURCH_AREA: f64 = 21.0;

/// Builds from the coordinates of `polygons`, after the valid one.
fn build(polygons: &[&str], crossings: Crossings) -> Result<Built, Box<dyn Error>> {
    let features = [CHURCH].iter().chain(polygons).map(|coordinates| {
        // A MultiPolygon has one more array level.
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
    let options = BuildOptions::default().crossings(crossings);
    Input::obstacles(path).build(&options, &WAYS)
}

/// Builds from polygons that must be accepted.
#[track_caller]
fn accepted(polygons: &[&str]) -> Built {
    match build(polygons, Crossings::Error) {
        Ok(built) => built,
        Err(error) => panic!("{polygons:?}: {error}"),
    }
}

impl Built {
    /// Returns the area of the holes and the number of hole regions, without the valid polygon.
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

/// Checks that exactly the `expected` lines cross, at the expected points; that is an error, and
/// the lines can be split. Returns the build with the lines split.
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
fn unclosed_reversed_and_repeated_positions_do_not_change_the_holes() {
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
fn rings_that_cross_are_refused_or_split() {
    // A bow-tie; its larger lobe decides on which side its interior is.
    let built = crosses(
        &["[[[0,0],[8,8],[8,0],[0,4],[0,0]]]"],
        &[(1, 1, [8.0 / 3.0, 8.0 / 3.0])],
    );
    assert!(
        (built.covered().0 - 64.0 / 3.0 - 16.0 / 3.0).abs() < 1e-9,
        "both lobes are covered"
    );
    assert_eq!(built.summary.inverted_parts, 1);
    let first = built.summary.first_inverted.map(|first| (first.obstacle, first.point));
    assert_eq!(first, Some((1, Point::new(0.0, 0.0))));
    // The error names the polygon by its index in the file.
    let bow_tie = "[[[20,0],[28,4],[28,0],[20,12],[20,0]]]";
    crosses(&[SQUARE, bow_tie], &[(2, 2, [26.0, 3.0])]);
    // Lobes that cancel out are a wall from both sides, whose segments cross several times at one
    // point. The error reports that point once.
    let error = build(&["[[[0,0],[8,4],[8,0],[0,4],[0,0]]]"], Crossings::Error).unwrap_err();
    let text = error.to_string();
    assert!(text.contains(": obstacle 1 and obstacle 1 at (4, 2);"), "{text}");
    assert!(!text.contains("more"), "{text}");
    // Two polygons that overlap.
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
    assert_eq!(built.depths(), [0, 1]);
}

#[test]
fn a_polygon_covers_each_point_once_however_often_its_rings_go_round() {
    let square = accepted(&[SQUARE]);
    let twice = "[[[0,0],[8,0],[8,8],[0,8],[0,0],[8,0],[8,8],[0,8],[0,0]]]";
    // The parts of a MultiPolygon are one obstacle.
    let (again, ring) = (format!("[{SQUARE},{SQUARE},{SQUARE}]"), &SQUARE[1..SQUARE.len() - 1]);
    let turned = format!("[[{ring},[[0,0],[0,8],[8,8],[8,0]]],{SQUARE},{SQUARE}]");
    for same in [twice, &again, &turned] {
        let built = accepted(&[same]);
        assert_eq!((built.covered(), built.depths()), ((64.0, 1), vec![0, 1]), "{same}");
        assert_eq!(built.digest, square.digest, "{same}");
    }
    // Within and beside each other, with a wall between them.
    let court = "[[[0,0],[8,0],[8,8],[0,8]],[[2,2],[6,2],[6,6],[2,6]]]";
    for (other, area, holes) in [
        ("[[[2,2],[6,2],[6,6],[2,6]]]", 64.0, 2),
        ("[[[0,0],[8,0],[8,4],[0,4],[0,0]]]", 56.0, 3),
        ("[[[8,2],[12,2],[12,5],[8,5],[8,2]]]", 60.0, 2),
    ] {
        let parts = format!("[{court},{other}]");
        if other.contains("[8,4],[0,4]") {
            // The ring of the second part crosses the court.
            let built = build(&[&parts], Crossings::Split).unwrap();
            assert_eq!(
                (built.covered(), built.depths()),
                ((area, holes), vec![0, 1]),
                "{parts}"
            );
            continue;
        }
        let built = accepted(&[&parts]);
        assert_eq!(
            (built.covered(), built.depths()),
            ((area, holes), vec![0, 1]),
            "{parts}"
        );
    }
    // Two features stay two obstacles.
    assert_eq!(accepted(&[twice, SQUARE]).depths(), [0, 1, 2]);
}

#[test]
fn overlapping_polygons_cover_the_union_of_their_areas() {
    let twice = accepted(&[SQUARE, SQUARE]);
    assert_eq!(twice.covered(), (64.0, 1));
    assert_eq!(twice.depths(), [0, 1, 2]);
    let once = accepted(&[SQUARE]);
    assert_eq!(without_sources(twice.digest), without_sources(once.digest));
    let [twice, once] = [twice, once].map(|built| built.digest.edge_sources.count);
    assert_eq!(twice, once + 4, "each edge of the square has a source for each square");
    let within = accepted(&[SQUARE, "[[[2,2],[6,2],[6,6],[2,6],[2,2]]]"]);
    assert_eq!(within.covered(), (64.0, 2));
    assert_eq!(within.depths(), [0, 1, 2]);
    // A polygon in the court of another one overlaps nothing.
    let in_court = accepted(&[
        "[[[0,0],[8,0],[8,8],[0,8],[0,0]],[[2,2],[2,6],[6,6],[6,2],[2,2]]]",
        "[[[2,2],[6,2],[6,6],[2,6],[2,2]]]",
    ]);
    assert_eq!(in_court.covered(), (64.0, 2));
    assert_eq!(in_court.depths(), [0, 1]);
}

#[test]
fn polygons_that_touch_stay_two_regions() {
    // They touch along a part of a wall, in a corner, and with a corner on a wall.
    for (other, edges, area) in [
        ("[[[8,2],[12,2],[12,5],[8,5],[8,2]]]", 9, 12.0),
        ("[[[8,8],[10,8],[10,10],[8,10],[8,8]]]", 8, 4.0),
        ("[[[8,4],[10,2],[10,6],[8,4]]]", 8, 4.0),
        ("[[[8,0],[16,0],[16,8],[8,8],[8,0]]]", 7, 64.0),
    ] {
        let built = accepted(&[SQUARE, other]);
        assert_eq!(built.covered(), (64.0 + area, 2), "{other}");
        assert_eq!(built.summary.constraint_edges, edges + 3, "{other}");
        // One polygon of two parts gives the same result, though it is invalid.
        let (one, other) = (&SQUARE, &other);
        let parts = accepted(&[&format!("[{one},{other}]")]);
        assert_eq!(parts.digest, built.digest, "{other}");
        assert_eq!(parts.covered(), built.covered());
    }
}

#[test]
fn polygons_without_area_cover_nothing() {
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

/// Checks that `count` polygons are inside out, in `parts` parts. That is an error that names the
/// first polygon and a point; if crossing lines are split instead, such parts are covered. Returns
/// the build with the lines split.
#[track_caller]
fn is_inside_out(polygons: &[&str], count: u64, parts: u64, obstacle: u64, [x, y]: [f64; 2]) -> Built {
    let expected = Inverted {
        obstacle,
        point: Point::new(x, y),
    };
    let error = build(polygons, Crossings::Error).unwrap_err();
    match error.downcast_ref() {
        Some(BuildError::Inverted(InvertedPolygons { first, polygons })) => {
            assert_eq!((*first, *polygons), (expected, count));
        }
        _ => panic!("{error}"),
    }
    let text = format!("obstacle {obstacle} is inside out at ({x}, {y})");
    assert!(error.to_string().contains(&text), "{error}");
    let built = build(polygons, Crossings::Split).unwrap();
    assert_eq!(
        (built.summary.inverted_parts, built.summary.first_inverted),
        (parts, Some(expected))
    );
    assert!(built.depths().iter().all(|&depth| depth >= 0));
    built
}

#[test]
fn wrongly_nested_rings_are_refused_as_inside_out() {
    let hole_outside = "[[[0,0],[8,0],[8,8],[0,8],[0,0]],[[10,2],[14,2],[14,6],[10,6],[10,2]]]";
    let built = is_inside_out(&[hole_outside], 1, 1, 1, [10.0, 2.0]);
    assert_eq!(built.covered(), (64.0 + 16.0, 2));
    assert_eq!(built.depths(), [0, 1]);
    let hole_in_hole =
        "[[[0,0],[8,0],[8,8],[0,8],[0,0]],[[1,1],[7,1],[7,7],[1,7],[1,1]],[[3,3],[5,3],[5,5],[3,5],[3,3]]]";
    let built = is_inside_out(&[SQUARE, hole_outside, hole_in_hole], 2, 2, 2, [10.0, 2.0]);
    // The hole in a hole is covered by another polygon, but it is inside out nevertheless.
    assert_eq!(built.covered(), (64.0 + 16.0, 4));
    let built = is_inside_out(&[hole_in_hole], 1, 1, 1, [3.0, 3.0]);
    assert_eq!(built.covered(), (64.0 - 36.0 + 4.0, 2));
    // A part two levels too deep, and the wall of a polygon that may have the hole there.
    let twice = "[[[10,0],[18,0],[18,8],[10,8]],[[2,2],[6,2],[6,6],[2,6]],[[3,3],[5,3],[5,5],[3,5]]]";
    let built = is_inside_out(&[twice, "[[[2,2],[2,0],[3,0],[2,2]]]"], 1, 2, 1, [2.0, 2.0]);
    assert_eq!(built.depths(), [0, 1]);
    // A bow-tie with a vertex where it crosses itself; its lobes are covered if both have the same
    // direction.
    is_inside_out(
        &["[[[0,0],[4,4],[8,12],[0,12],[4,4],[8,0],[0,0]]]"],
        1,
        1,
        1,
        [0.0, 0.0],
    );
    let eight = accepted(&["[[[0,0],[8,0],[4,4],[8,12],[0,12],[4,4],[0,0]]]"]);
    assert_eq!(eight.covered(), (16.0 + 32.0, 2));
    assert_eq!((eight.summary.inverted_parts, eight.summary.first_inverted), (0, None));
}

/// Depths were sums over all polygons. So a part that was inside out silently freed what another
/// polygon covers.
#[test]
fn a_part_that_is_inside_out_frees_nothing_that_another_polygon_covers() {
    // The lobe to the right of (3, 3) has the wrong direction, under a valid polygon.
    let bow = "[[[0,0],[0,6],[3,3],[5,1],[5,5],[3,3],[0,0]]]";
    let valid = "[[[3,3],[3,0],[6,0],[6,6],[3,6],[3,3]]]";
    let built = is_inside_out(&[bow, valid], 1, 1, 1, [3.0, 3.0]);
    assert_eq!(built.covered(), (9.0 + 18.0, 3));
    assert_eq!(built.depths(), [0, 1, 2]);
    is_inside_out(&[valid, bow], 1, 1, 2, [3.0, 3.0]);
    is_inside_out(&[bow], 1, 1, 1, [3.0, 3.0]);
    // The same in one feature.
    let parts = format!("[{bow},{valid}]");
    assert_eq!(is_inside_out(&[&parts], 1, 1, 1, [3.0, 3.0]).covered(), built.covered());
    // Two polygons that are inside out at the same place: -1 - 1 + 2.
    let built = is_inside_out(&[bow, bow, valid, valid], 2, 2, 1, [3.0, 3.0]);
    assert_eq!(built.depths(), [0, 1, 2, 4]);
    // A hole beside its polygon, within another polygon, and one as large as another polygon.
    let beside = "[[[0,0],[8,0],[8,8],[0,8]],[[10,2],[14,2],[14,6],[10,6]]]";
    let around = "[[[9,1],[15,1],[15,7],[9,7]]]";
    let same = "[[[10,2],[14,2],[14,6],[10,6]]]";
    assert_eq!(
        is_inside_out(&[beside, around], 1, 1, 1, [10.0, 2.0]).covered().0,
        64.0 + 36.0
    );
    assert_eq!(
        is_inside_out(&[same, beside], 1, 1, 2, [10.0, 2.0]).covered().0,
        64.0 + 16.0
    );
    // A hole in a hole, under another polygon.
    let nested = "[[[0,0],[9,0],[9,9],[0,9]],[[1,1],[8,1],[8,8],[1,8]],[[2,2],[4,2],[4,4],[2,4]]]";
    assert_eq!(
        is_inside_out(&[nested, "[[[2,2],[4,2],[4,4],[2,4]]]"], 1, 1, 1, [2.0, 2.0])
            .covered()
            .0,
        81.0 - 49.0 + 4.0
    );
}

/// A ring whose lobes cancel out was once treated as one that encloses nothing.
#[test]
fn two_lobes_of_equal_size_are_both_covered() {
    let bow = "[[[0,0],[0,4],[2,2],[4,0],[4,4],[2,2]]]";
    let turned = "[[[2,2],[4,4],[4,0],[2,2],[0,4],[0,0]]]";
    for bow in [bow, turned] {
        let error = build(&[bow], Crossings::Error).unwrap_err();
        assert!(error.to_string().contains("obstacle 1 is inside out at ("), "{error}");
        let built = build(&[bow], Crossings::Split).unwrap();
        assert_eq!((built.covered(), built.depths()), ((8.0, 2), vec![0, 1]));
    }
    let crossing = build(&["[[[0,0],[4,4],[4,0],[0,4]]]"], Crossings::Split).unwrap();
    assert_eq!((crossing.covered(), crossing.summary.inverted_parts), ((8.0, 2), 1));
}

/// If a ring crosses itself in a vertex of another polygon, no segments cross, so that check did
/// not detect that the ring is inside out.
#[test]
fn a_ring_that_crosses_itself_in_the_corner_of_another_polygon_is_refused_as_inside_out() {
    let bow = "[[[0,0],[8,8],[8,0],[2,6],[0,0]]]";
    let error = build(&[bow], Crossings::Error).unwrap_err();
    assert!(
        matches!(error.downcast_ref(), Some(BuildError::Crossings { count: 1, .. })),
        "{error}"
    );
    let built = is_inside_out(&[bow, "[[[4,4],[6,20],[2,20],[4,4]]]"], 1, 1, 1, [0.0, 0.0]);
    assert_eq!(built.covered(), (16.0 + 8.0 + 32.0, 3));
}

/// An error of a single polygon is reported first, since it is known before all other polygons were
/// read.
#[test]
fn a_polygon_that_is_inside_out_is_reported_before_crossings() {
    let crossing = ["[[[0,0],[8,0],[8,8],[0,8]]]", "[[[4,4],[12,4],[12,12],[4,12]]]"];
    let beside = "[[[20,0],[28,0],[28,8],[20,8]],[[30,2],[34,2],[34,6],[30,6]]]";
    let error = build(&[crossing[0], crossing[1], beside], Crossings::Error).unwrap_err();
    assert!(
        error.to_string().starts_with("obstacle 3 is inside out at (30, 2): "),
        "{error}"
    );
}
