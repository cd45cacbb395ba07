//! Heights at points, along lines, and volumes.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::support::{errors, fails, json as report, run, tiletool};

/// Builds `t.tiles`: a square of 20 by 20 whose z is x + 2 y, with a square hole of 2 by 2 at (4, 4), and
/// `flat.tiles`, which has no z.
fn build(folder: &Path) {
    let (mut points, mut flat) = ("x,y,z\n".to_owned(), String::new());
    for (x, y) in (0..21).flat_map(|x| (0..21).map(move |y| (x, y))) {
        writeln!(points, "{x},{y},{}", x + 2 * y).unwrap();
        writeln!(flat, "{x},{y}").unwrap();
    }
    fs::write(folder.join("p.csv"), points).unwrap();
    fs::write(folder.join("flat.csv"), flat).unwrap();
    let ring = json!([[4, 4], [6, 4], [6, 6], [4, 6], [4, 4]]);
    fs::write(
        folder.join("pond.geojson"),
        json!({"type": "Polygon", "coordinates": [ring]}).to_string(),
    )
    .unwrap();
    run(
        folder,
        "build p.csv --obstacles pond.geojson --tile-vertices 40 -o t.tiles --quiet",
    );
    run(folder, "build flat.csv -o flat.tiles --quiet");
}

fn shapes(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn z_prints_the_number_alone_and_says_why_there_is_none() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    build(folder);
    assert_eq!(run(folder, "query z t.tiles --at 3.5,4.25 --at 20,20"), "12\n60\n");
    assert_eq!(run(folder, "query z t.tiles --at -1,4"), "outside the triangulation\n");
    assert_eq!(run(folder, "query z t.tiles --at 5.25,5.5"), "in a hole\n");
    assert_eq!(run(folder, "query z t.tiles --at 5.25,5.5 --all"), "16.25\n");
    assert_eq!(run(folder, "query z t.tiles --at 4,5"), "14\n");
    let limited = run(folder, "query z t.tiles --at 0.25,0.5 --max-edge 1");
    assert!(limited.contains("--max-edge"), "{limited}");
    fs::write(folder.join("b.csv"), "x,y\n1.5,1.5\n5.5,5.5\n-3,0\n").unwrap();
    assert_eq!(
        run(folder, "query z t.tiles --batch b.csv --csv"),
        "x,y,z\n1.5,1.5,4.5\n5.5,5.5,\n-3,0,\n"
    );
    let lines = run(folder, "query z t.tiles --batch b.csv --json");
    let lines: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines[0], json!({"at": [1.5, 1.5], "z": 4.5}));
    assert_eq!(
        lines[2],
        json!({"at": [-3.0, 0.0], "z": null, "note": "outside the triangulation"})
    );
    let features = shapes(&run(folder, "query z t.tiles --batch b.csv --geojson"));
    assert_eq!(
        features["features"][0]["geometry"]["coordinates"],
        json!([1.5, 1.5, 4.5])
    );
    assert_eq!(features["features"][1]["geometry"]["coordinates"], json!([5.5, 5.5]));
    assert!(fails(folder, 1, "query z flat.tiles --at 1,1").contains("flat.tiles has no z"));
    assert!(fails(folder, 1, "query z t.tiles").contains("--batch FILE"));
}

#[test]
fn locate_has_the_heights_of_the_point_and_its_vertices() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    build(folder);
    let text = run(folder, "query locate t.tiles --at 7,9");
    assert!(
        text.contains("on vertex") && text.contains("; z 25\n") && text.contains("at (7, 9), z 25\n"),
        "{text}"
    );
    let found = report(folder, "query locate t.tiles --at 7.25,9.5 --json");
    assert_eq!(found["z"], 26.25);
    assert_eq!(found["vertex_z"].as_array().unwrap().len(), 3);
    let table = run(folder, "query locate t.tiles --at 7.5,9 --csv");
    let (header, row) = table.trim_end().split_once('\n').unwrap();
    assert!(header.ends_with("vertex_2,z,z_0,z_1,z_2"), "{header}");
    assert!(row.ends_with(",25.5,25,26,") || row.ends_with(",25.5,26,25,"), "{row}");
    let flat = report(folder, "query locate flat.tiles --at 7,9 --json");
    assert_eq!((&flat["z"], &flat["vertex_z"]), (&Value::Null, &json!([null])));
    let text = run(folder, "query locate flat.tiles --at 7,9");
    assert!(text.lines().count() == 1 && !text.contains('z'), "{text}");
}

#[test]
fn a_profile_has_both_ends_all_edges_and_gaps() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    build(folder);
    let line = "query profile t.tiles --from -2,5 --to 8,5";
    let expected: String = [(0, 2), (0, 3), (0, 4), (0, 5), (0, 6), (1, 8), (1, 9), (1, 10)]
        .map(|(part, distance)| format!("{part},{distance},{},5,{}\n", distance - 2, distance + 8))
        .concat();
    assert_eq!(
        run(folder, &format!("{line} --csv")),
        format!("part,distance,x,y,z\n,0,-2,5,\n{expected}")
    );
    let found = report(folder, &format!("{line} --json"));
    assert_eq!(found["length"], 10.0);
    assert_eq!(found["gaps"], json!([[0.0, 2.0], [6.0, 8.0]]));
    assert_eq!(
        found["parts"][0][1],
        json!({"distance": 3.0, "at": [1.0, 5.0], "z": 11.0})
    );
    let text = run(folder, line);
    assert!(text.starts_with("10 coordinate units: 8 points in 2 parts\n"), "{text}");
    assert!(
        text.contains("6  to 8: not on the surface\n") && text.contains("0  to 2: not on the surface\n"),
        "{text}"
    );
    let features = shapes(&run(folder, &format!("{line} --geojson")));
    let parts = features["features"].as_array().unwrap();
    assert_eq!((parts.len(), &parts[1]["geometry"]["type"]), (2, &json!("LineString")));
    assert_eq!(parts[1]["geometry"]["coordinates"][0], json!([6.0, 5.0, 16.0]));
    assert_eq!(
        report(folder, &format!("{line} --all --json"))["gaps"],
        json!([[0.0, 2.0]])
    );
}

#[test]
fn a_profile_follows_the_first_line_of_a_file() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    build(folder);
    let lines = [json!([[1, 1], [3, 1], [3, 2]]), json!([[9, 9], [10, 9]])];
    let lines = lines.map(|line| json!({"type": "LineString", "coordinates": line}));
    let collection = json!({"type": "GeometryCollection", "geometries": lines});
    fs::write(folder.join("l.geojson"), collection.to_string()).unwrap();
    let found = report(folder, "query profile t.tiles --line l.geojson --json");
    let z: Vec<f64> = found["parts"][0]
        .as_array()
        .unwrap()
        .iter()
        .map(|p| p["z"].as_f64().unwrap())
        .collect();
    assert_eq!((found["length"].as_f64(), z), (Some(3.0), vec![3.0, 4.0, 5.0, 7.0]));
    fs::write(
        folder.join("none.geojson"),
        r#"{"type":"FeatureCollection","features":[]}"#,
    )
    .unwrap();
    for (args, complaint) in [
        ("t.tiles --line none.geojson", "has no lines"),
        ("t.tiles --line missing.geojson", "missing.geojson"),
        ("t.tiles --line p.csv", "p.csv"),
        ("t.tiles --from 1,1 --to 1,1", "no two different points"),
        ("t.tiles --from 1,1 --to 1e300,1", "1e300"),
        ("t.tiles", "--line FILE"),
        ("flat.tiles --from 1,1 --to 2,1", "flat.tiles has no z"),
    ] {
        let error = fails(folder, 1, &format!("query profile {args}"));
        assert!(error.contains(complaint) && !error.contains("panic"), "{args}: {error}");
    }
    let stats = tiletool(folder, "query profile t.tiles --from 1,1 --to 2,1 --stats")
        .output()
        .unwrap();
    assert!(errors(&stats).contains("tiles: "), "{}", errors(&stats));
}

#[test]
fn volumes_are_cut_and_fill_also_in_polygons() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    build(folder);
    let close = |found: &Value, key: &str, expected: f64| {
        let number = found[key].as_f64().unwrap();
        assert!(
            (number - expected).abs() < 1e-9 * expected.max(1.0),
            "{key}: {number}, not {expected}"
        );
    };
    // The mean height is 30; in the hole 15.
    let whole = report(folder, "query volume t.tiles --level -1 --json");
    close(&whole, "cut", 400.0 * 31.0 - 4.0 * 16.0);
    close(&whole, "area", 396.0);
    assert_eq!((&whole["fill"], &whole["area_below"]), (&json!(0.0), &json!(0.0)));
    let all = report(folder, "query volume t.tiles --level 0 --all --json");
    close(&all, "cut", 400.0 * 30.0);
    // A polygon with a hole, whose sides run along edges, and one that is larger than the hull.
    let pit = json!([
        [[8, 8], [14, 8], [14, 12], [8, 12], [8, 8]],
        [[9.5, 9.5], [10.5, 9.5], [10.5, 10.5], [9.5, 10.5], [9.5, 9.5]]
    ]);
    fs::write(
        folder.join("pit.geojson"),
        json!({"type": "Polygon", "coordinates": pit}).to_string(),
    )
    .unwrap();
    let found = report(folder, "query volume t.tiles --level 0 --polygon pit.geojson --json");
    close(&found, "area", 23.0);
    close(&found, "cut", 24.0 * 31.0 - 30.0);
    let large = json!([[[-90, -90], [90, -90], [90, 90], [-90, 90], [-90, -90]]]);
    fs::write(
        folder.join("large.geojson"),
        json!({"type": "Polygon", "coordinates": large}).to_string(),
    )
    .unwrap();
    let small = run(
        folder,
        "query volume t.tiles --level 20 --polygon large.geojson --csv --memory 4MiB",
    );
    assert_eq!(small, run(folder, "query volume t.tiles --level 20 --csv"));
    assert!(
        small.starts_with("level,cut,fill,area,area_above,area_below\n20,"),
        "{small}"
    );
    let text = run(folder, "query volume t.tiles --level 0 --all");
    assert!(
        text.starts_with("cut above 0: 12000, on 400 square coordinate units\nfill below 0: 0, on 0 "),
        "{text}"
    );
    assert!(fails(folder, 1, "query volume flat.tiles --level 0").contains("flat.tiles has no z"));
    assert!(fails(folder, 1, "query volume t.tiles --level 0 --polygon missing.geojson").contains("missing.geojson"));
    fails(folder, 2, "query volume t.tiles --level NaN");
    fails(folder, 2, "query volume t.tiles");
}

/// Builds `t.tiles`: a square of 20 by 20 whose z is x + 2 y, without points in a lake of 5 by 5 and in a bay of
/// that size at the upper side.
fn build_shore(folder: &Path) {
    let mut points = "x,y,z\n".to_owned();
    for (x, y) in (0..21).flat_map(|x| (0..21).map(move |y| (x, y))) {
        let is_water = |low: i32, high: i32| (9..=12).contains(&x) && (low..=high).contains(&y);
        if !is_water(6, 9) && !is_water(16, 20) {
            writeln!(points, "{x},{y},{}", x + 2 * y).unwrap();
        }
    }
    fs::write(folder.join("p.csv"), points).unwrap();
    run(folder, "build p.csv --tile-vertices 20 -o t.tiles --quiet");
}

#[test]
fn from_the_hull_long_triangles_are_left_out_in_the_bay_and_not_in_the_lake() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    build_shore(folder);
    let (short, peeled) = ("--max-edge 1.5", "--max-edge 1.5 --from-hull");
    // At the corners of the lake, and at the lower ones of the bay, triangles are short.
    for (options, area) in [("", 400.0), (short, 400.0 - 23.0 - 24.0), (peeled, 400.0 - 24.0)] {
        let found = report(
            folder,
            format!("query volume t.tiles --level -1 --json {options}").trim_end(),
        );
        assert!(
            (found["area"].as_f64().unwrap() - area).abs() < 1e-9,
            "{options}: {found}"
        );
    }
    let through_both = "query profile t.tiles --from 10.5,0 --to 10.5,20 --json";
    for (options, gaps) in [
        (short, json!([[5.0, 10.0], [15.0, 20.0]])),
        (peeled, json!([[15.0, 20.0]])),
    ] {
        assert_eq!(
            report(folder, &format!("{through_both} {options}"))["gaps"],
            gaps,
            "{options}"
        );
    }
    let cells = |options: &str| {
        let export = "export t.tiles -o t.asc --resolution 1 --bounds 10,0,11,20";
        run(folder, &format!("{export} {options}"));
        let text = fs::read_to_string(folder.join("t.asc")).unwrap();
        let cells = text.lines().skip(6).map(|line| line.trim() != "-9999");
        cells.collect::<Vec<bool>>()
    };
    let rows = |is_there: &dyn Fn(usize) -> bool| (0..20).map(is_there).collect::<Vec<bool>>();
    assert_eq!(cells(short), rows(&|row| row >= 5 && !(10..15).contains(&row)));
    assert_eq!(cells(peeled), rows(&|row| row >= 5));
    let count = |command: &str, key: &str| {
        let counted = |options: &str| {
            report(folder, format!("{command} --json {options}").trim_end())[key]
                .as_u64()
                .unwrap()
        };
        [short, peeled, ""].map(counted)
    };
    for format in ["ply", "fgb"] {
        let [short, peeled, all] = count(&format!("export t.tiles -o t.{format}"), "triangles");
        assert!(short < peeled && peeled < all, "{format}: {short} {peeled} {all}");
    }
    let [of_short, of_peeled, of_all] = count("export t.tiles -o c.geojson --contours 1000 --base 25.5", "contours");
    assert_eq!([of_short, of_peeled, of_all], [2, 1, 1]);
    for command in [
        "export t.tiles -o u.ply --from-hull",
        "query volume t.tiles --level 0 --from-hull",
        "query profile t.tiles --from 0,0 --to 1,1 --from-hull",
    ] {
        assert!(fails(folder, 2, command).contains("--max-edge"), "{command}");
    }
}
