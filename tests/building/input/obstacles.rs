//! Polygons of GeoJSON: the segments that they give, and what is refused.

use crate::input::segments::{Segments, open};
use delaunay_tiles::input::{InputError, RecordKind, SegmentSource};

fn read(text: &str) -> Result<Segments, InputError> {
    open(&[("town.geojson", text.as_bytes())], SegmentSource::open_obstacles)
}

/// Returns the GeoJSON polygon with these rings.
pub fn polygon(rings: &[&[[f64; 2]]]) -> String {
    format!(r#"{{"type":"Polygon","coordinates":{rings:?}}}"#)
}

/// Returns the segments of the polygon with these rings.
#[track_caller]
fn ends(rings: &[&[[f64; 2]]]) -> Vec<[f64; 4]> {
    read(&polygon(rings)).unwrap().ends
}

/// Returns the expected segments of a ring.
fn ring(vertices: &[[f64; 2]]) -> Vec<[f64; 4]> {
    let next = vertices.iter().cycle().skip(1);
    vertices
        .iter()
        .zip(next)
        .map(|(a, b)| [a[0], a[1], b[0], b[1]])
        .collect()
}

#[track_caller]
fn assert_same(mut found: Vec<[f64; 4]>, mut expected: Vec<[f64; 4]>) {
    found.sort_by(|a, b| a.partial_cmp(b).unwrap());
    expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(found, expected);
}

const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]];
const COURT: [[f64; 2]; 3] = [[2.0, 2.0], [3.0, 7.0], [7.0, 2.0]];

/// Outer rings become counter-clockwise and inner rings clockwise, whatever their winding, and
/// whether they are closed or not.
#[test]
fn rings_of_either_winding_give_the_same_segments() {
    let expected = [ring(&SQUARE), ring(&COURT)].concat();
    for turned in 0..4 {
        for closed in [false, true] {
            let [mut outer, mut inner] = [SQUARE.to_vec(), COURT.to_vec()];
            if turned & 1 > 0 {
                outer.reverse();
            }
            if turned & 2 > 0 {
                inner.reverse();
            }
            if closed {
                outer.push(outer[0]);
                inner.push(inner[0]);
            }
            let all = read(&polygon(&[&outer, &inner])).unwrap();
            assert_same(all.ends, expected.clone());
            let notes = all.source.notes();
            assert_eq!(notes.len(), usize::from(!closed));
            let note = "town.geojson: 2 rings do not end where they begin; they were closed";
            assert!(notes.iter().all(|found| found.ends_with(note)), "{notes:?}");
        }
    }
}

#[test]
fn repeated_positions_give_no_segment() {
    let [a, b, c, d] = SQUARE;
    let all = read(&polygon(&[&[a, a, d, d, d, c, b, a, a]])).unwrap();
    assert_same(all.ends, ring(&SQUARE));
    assert!(all.source.notes().is_empty());
    // 0 and -0 are the same coordinate.
    let signed = r#"{"type":"Polygon","coordinates":[[[0,0],[9,-0.0],[9,0],[9,9],[0,9],[-0.0,0.0]]]}"#;
    assert_same(read(signed).unwrap().ends, ring(&SQUARE));
}

/// Segments that run out and back are returned unchanged; they cancel out.
#[test]
fn spikes_and_bridges_keep_their_segments() {
    let spike = [[0.0, 0.0], [9.0, 0.0], [20.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]];
    let mut turned = spike;
    turned.reverse();
    assert_same(ends(&[&spike]), ring(&spike));
    assert_same(ends(&[&turned]), ring(&spike));
    // An extreme vertex at the tip of a spike has no turn, but the area has a sign.
    let tip = [[-5.0, -5.0], [0.0, 0.0], [0.0, 9.0], [9.0, 9.0], [9.0, 0.0], [0.0, 0.0]];
    let mut counter_clockwise = tip;
    counter_clockwise.reverse();
    assert_same(ends(&[&tip]), ring(&counter_clockwise));
    // A court connected to the outer ring by a bridge.
    let keyhole = [&SQUARE[..], &SQUARE[..1], &COURT[..], &COURT[..1]].concat();
    assert_same(ends(&[&keyhole]), ring(&keyhole));
}

/// The sign of the whole area decides the direction, not the turn at a corner.
#[test]
fn the_whole_area_decides_the_direction_of_touching_lobes() {
    let small_lobe_turned = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0], [-9.0, 0.0], [0.0, -9.0]];
    assert_same(ends(&[&small_lobe_turned]), ring(&small_lobe_turned));
    let mut turned = small_lobe_turned;
    turned.reverse();
    assert_same(ends(&[&turned]), ring(&small_lobe_turned));
}

/// Rings that enclose nothing block the way from both sides.
#[test]
fn rings_without_area_give_segments_in_both_directions() {
    let both_ways = |vertices: &[[f64; 2]]| {
        let there = ring(vertices);
        let back = there.iter().map(|[a, b, c, d]| [*c, *d, *a, *b]);
        [back.collect(), there].concat()
    };
    let collinear = [[0.0, 0.0], [3.0, 3.0], [9.0, 9.0], [6.0, 6.0]];
    let wall = [[0.0, 0.0], [9.0, 1.0]];
    let cancelling = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0], [-1.0, 0.0], [-1.0, 1.0]];
    // No three of the sums of this ring in floating point agree on the sign.
    let tenths = [[0.1, 0.1], [0.2, 0.2], [0.7, 0.7]];
    for flat in [&collinear[..], &wall, &tenths] {
        let closed = [flat, &flat[..1]].concat();
        let all = read(&polygon(&[&closed])).unwrap();
        assert_same(all.ends, both_ways(flat));
        assert_eq!(all.source.notes().len(), 1);
        let note = &all.source.notes()[0];
        assert!(note.contains("town.geojson: 1 rings enclose nothing"), "{note}");
        // A court in a ring that encloses nothing is not a court.
        let all = read(&polygon(&[&closed, &[COURT[0], COURT[1], COURT[2], COURT[0]]])).unwrap();
        assert_same(all.ends, [both_ways(flat), both_ways(&COURT)].concat());
        assert!(all.source.notes()[0].contains("2 rings enclose nothing"));
        // A ring without area within a polygon takes no area away.
        assert_same(ends(&[&SQUARE, flat]), [ring(&SQUARE), both_ways(flat)].concat());
    }
    // Two lobes that cancel out do enclose area, one of them inside out: they are returned
    // unchanged.
    let closed = [&cancelling[..], &cancelling[..1]].concat();
    let court = [COURT[0], COURT[1], COURT[2], COURT[0]];
    let all = read(&polygon(&[&closed, &court])).unwrap();
    assert_same(all.ends, [ring(&cancelling), ring(&COURT)].concat());
    assert!(all.source.notes().is_empty());
    assert_same(
        ends(&[&SQUARE, &closed]),
        [ring(&SQUARE), both_ways(&cancelling)].concat(),
    );
    for none in [&[][..], &[[1.0, 1.0]], &[[1.0, 1.0], [1.0, 1.0]]] {
        let all = read(&polygon(&[none])).unwrap();
        assert_same(all.ends, Vec::new());
        // There are no segments that could block the way.
        let note = all.source.notes().first();
        let left_out = note.is_some_and(|note| note.ends_with("1 rings have one position only; they were left out"));
        assert_eq!(
            (all.source.notes().len() == 1, left_out),
            (!none.is_empty(), !none.is_empty())
        );
        assert_same(ends(&[none, &COURT]), both_ways(&COURT));
        assert_same(ends(&[&SQUARE, none, &COURT]), [ring(&SQUARE), ring(&COURT)].concat());
    }
}

/// The largest and the smallest valid coordinates, and slivers that are collinear in floating
/// point.
#[test]
fn huge_and_tiny_rings_get_the_right_direction() {
    let (most, least) = (2f64.powi(200), 2f64.powi(-142));
    let far = 2f64.powi(52);
    for counter_clockwise in [
        [[-most, -most], [most, -most], [most, most]],
        [[0.0, 0.0], [least, 0.0], [0.0, least]],
        [[0.0, 0.0], [most, least], [-most, least]],
        [[far, far], [far + 2.0, far + 2.0], [far + 4.0, far + 5.0]],
        [
            [-20_037_508.34, -20_037_508.34],
            [0.1, 0.1],
            [20_037_508.34, 20_037_508.34 + 4e-9],
        ],
    ] {
        let mut turned = counter_clockwise;
        turned.reverse();
        for rings in [counter_clockwise, turned] {
            assert_same(ends(&[&rings]), ring(&counter_clockwise));
        }
    }
}

/// All rings of a feature form one line; each polygon of a MultiPolygon has its own outer ring.
#[test]
fn each_feature_is_one_line() {
    let text = r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","geometry":null},
        {"type":"Feature","geometry":{"coordinates":[[[[0,0],[0,9],[9,9],[0,0]],[[2,4],[2,5],[3,5],[2,4]]],[],[[[20,0],[29,0],[29,9],[20,0]]]],
            "type":"MultiPolygon"}},
        {"type":"Feature","geometry":{"type":"GeometryCollection","geometries":[
            {"type":"Polygon","coordinates":[[[40,0],[49,0],[49,9],[40,0]]]},{"type":"Polygon","coordinates":[]}]}}]}"#;
    let all = read(text).unwrap();
    assert_eq!(all.lines, [vec![1; 9], vec![2; 3]].concat());
    let expected = [
        ring(&[[0.0, 0.0], [9.0, 9.0], [0.0, 9.0]]),
        ring(&[[2.0, 4.0], [2.0, 5.0], [3.0, 5.0]]),
        ring(&[[20.0, 0.0], [29.0, 0.0], [29.0, 9.0]]),
        ring(&[[40.0, 0.0], [49.0, 0.0], [49.0, 9.0]]),
    ];
    assert_same(all.ends, expected.concat());
    assert_eq!(all.source.sources(), [("town.geojson".to_owned(), 3)]);
    assert!(
        all.source
            .origin(2)
            .unwrap()
            .to_string()
            .ends_with("town.geojson: feature 2 (counted from 0)")
    );
}

/// An empty ring first in its polygon hides which ring is the outer one, if no position came
/// before. Empty rings do not shift the others.
#[test]
fn empty_rings_keep_their_index_among_the_rings() {
    let text = r#"{"type":"MultiPolygon","coordinates":[[[]],[[],[[0,0],[9,0],[0,9],[0,0]]]]}"#;
    let all = read(text).unwrap();
    assert_eq!(all.ends.len(), 6);
    assert!(
        all.source.notes()[0].contains("1 rings enclose nothing"),
        "{:?}",
        all.source.notes()
    );
    let text = r#"{"type":"MultiPolygon","coordinates":[[],[[[0,9],[9,0],[0,0],[0,9]]]]}"#;
    assert_same(read(text).unwrap().ends, ring(&[[0.0, 0.0], [9.0, 0.0], [0.0, 9.0]]));
}

#[test]
fn a_reversed_ring_keeps_the_z_of_its_vertices() {
    let text = r#"{"type":"Polygon","coordinates":[[[0,0,1],[0,9,2],[9,9,3],[0,0,1]]]}"#;
    let all = read(text).unwrap();
    assert_eq!(all.ends, ring(&[[0.0, 0.0], [9.0, 9.0], [0.0, 9.0]]));
    assert_eq!(all.z, [[1.0, 3.0], [3.0, 2.0], [2.0, 1.0]]);
}

#[test]
fn a_ring_larger_than_a_batch_is_reversed_as_a_whole() {
    let circle: Vec<[f64; 2]> = (0..20_000)
        .map(|n| f64::from(n) * (std::f64::consts::TAU / 20_000.0))
        .map(|angle| [angle.cos(), angle.sin()])
        .collect();
    let mut turned = circle.clone();
    turned.reverse();
    assert_same(ends(&[&turned]), ring(&circle));
}

#[test]
fn geometries_that_are_no_polygons_are_refused() {
    let good = r#"{"type":"Polygon","coordinates":[[[0,0],[9,0],[0,9],[0,0]]]}"#;
    for (geometry, kind) in [
        (r#"{"type":"LineString","coordinates":[[0,0],[1,0]]}"#, "LineString"),
        (r#"{"coordinates":[[0,0],[1,0]],"type":"LineString"}"#, "LineString"),
        (
            r#"{"coordinates":[[[0,0],[1,0]]],"type":"MultiLineString"}"#,
            "MultiLineString",
        ),
        (r#"{"type":"Point","coordinates":[0,0]}"#, "Point"),
        (r#"{"type":"MultiPoint","coordinates":[]}"#, "MultiPoint"),
        (r#"{"coordinates":[],"type":"LineString"}"#, "LineString"),
    ] {
        for (text, number) in [
            (geometry.to_owned(), 0),
            (format!("{good}\n{geometry}"), 1),
            (
                format!(r#"{good}{good}{{"type":"GeometryCollection","geometries":[{good},{geometry}]}}"#),
                2,
            ),
        ] {
            let error = read(&text).map(|all| all.ends).unwrap_err().to_string();
            let parts = [
                format!("town.geojson: obstacle {number} (byte "),
                format!("): this is a {kind}; obstacles are Polygons and MultiPolygons"),
            ];
            assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        }
    }
    for (text, parts) in [
        (
            r#"{"type":"Polygon","coordinates":[[[0,0],[1e201,0],[0,9],[0,0]]]}"#,
            &["obstacle 0 (byte 40): x is 1e201", "2^200"][..],
        ),
        (
            r#"{"type":"Polygon","coordinates":[[[0,0],[1],[0,9],[0,0]]]}"#,
            &["obstacle 0 (byte 40): the position has 1 of at least 2 elements"],
        ),
        (
            r#"{"type":"Polygon","coordinates":[[0,0],[1,0]]}"#,
            &["an object of type Polygon has wrong members"],
        ),
        ("", &["the file is empty"]),
    ] {
        let error = read(text).map(|all| all.ends).unwrap_err().to_string();
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
    for name in ["rows.csv", "pairs.u32", "town.poly", "town"] {
        let error = open(&[(name, b"")], SegmentSource::open_obstacles)
            .map(|_| ())
            .unwrap_err();
        assert!(
            matches!(
                error,
                InputError::UnknownFormat {
                    kind: RecordKind::Obstacle,
                    ..
                }
            ),
            "{error}"
        );
        assert!(
            error.to_string().contains(name) && error.to_string().contains(".geojson"),
            "{error}"
        );
    }
}

/// An error ends the stream, and counts obstacles over all files.
#[test]
fn an_error_in_the_second_file_counts_obstacles_over_both_files() {
    let good = polygon(&[&SQUARE]);
    let bad = format!("{good}{}", r#"{"type":"Point","coordinates":[0,0]}"#);
    let files: [(&str, &[u8]); 2] = [("good.json", good.as_bytes()), ("bad.json", bad.as_bytes())];
    let error = open(&files, SegmentSource::open_obstacles).map(|_| ()).unwrap_err();
    assert!(
        matches!(
            error,
            InputError::Record {
                kind: RecordKind::Obstacle,
                number: 2,
                ..
            }
        ),
        "{error}"
    );
}
