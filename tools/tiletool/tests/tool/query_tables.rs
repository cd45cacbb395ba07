//! `tiletool query matrix`, `along` and `range --area`, and what all queries print.

use std::f64::consts::PI;
use std::fs;

use crate::support::errors;
use crate::town::Town;
use serde_json::{Value, json};

#[test]
fn a_matrix_has_the_distance_of_each_pair() {
    let town = Town::new();
    town.write("a.csv", "x,y\n-4,-4\n0,0\n4,4\n");
    town.write("b.csv", "-4,4\n-2.5,2.5\n");
    let table = town.query("matrix", &["--from-file", "a.csv", "--to-file", "b.csv", "--csv"]);
    let mut lines = table.lines();
    assert_eq!(
        lines.next(),
        Some("from_index,to_index,from_x,from_y,to_x,to_y,status,distance,lower,upper")
    );
    // The second list is the shorter one.
    let rows: Vec<String> = lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            assert_eq!(cells.len(), 10, "{line}");
            cells[..8].join(",")
        })
        .collect();
    assert_eq!(
        rows,
        [
            "0,0,-4,-4,-4,4,ok,8",
            "1,0,0,0,-4,4,inside_obstacle,",
            "2,0,4,4,-4,4,ok,8",
            "0,1,-4,-4,-2.5,2.5,unreachable,",
            "1,1,0,0,-2.5,2.5,inside_obstacle,",
            "2,1,4,4,-2.5,2.5,unreachable,",
        ]
    );
    let all = town.query("matrix", &["--batch", "a.csv", "--json"]);
    let all: Vec<Value> = all.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(all.len(), 9);
    assert_eq!(
        (&all[0]["distance"], &all[2]["distance"]),
        (&json!(0.0), &all[6]["distance"])
    );
    assert_eq!(all[1]["nearest_free"].as_array().map(Vec::len), Some(2));
    assert_eq!(
        [
            &all[1]["from_index"],
            &all[1]["to_index"],
            &all[1]["from"],
            &all[1]["to"]
        ],
        [&json!(0), &json!(1), &json!([-4.0, -4.0]), &json!([0.0, 0.0])]
    );
    let sites = town.query("matrix", &["--from-file", "a.csv", "--sites"]);
    assert_eq!(sites.lines().count(), 12);
    assert!(
        sites.starts_with("0 (-4, -4) to baker (0, 3): ")
            && sites.contains("2 (4, 4) to inner (-2.5, 2.5): no path exists"),
        "{sites}"
    );
    let shapes = town.query(
        "matrix",
        &[
            "--from-file",
            "a.csv",
            "--to-file",
            "b.csv",
            "--geojson",
            "--plot",
            "m.svg",
        ],
    );
    let shapes: Value = serde_json::from_str(&shapes).unwrap();
    let [first, .., last] = &shapes["features"].as_array().unwrap()[..] else {
        panic!("{shapes}")
    };
    let ends = [&first["geometry"]["coordinates"][0], &last["properties"]["from"]];
    assert_eq!(ends, [&json!([-4.0, -4.0]), &json!([4.0, 4.0])]);
    assert_eq!(
        (&first["properties"]["distance"], &last["geometry"]),
        (&json!(8.0), &Value::Null)
    );
    let itself: Value = serde_json::from_str(&town.query("matrix", &["--batch", "b.csv", "--geojson"])).unwrap();
    let itself = &itself["features"][0]["geometry"];
    assert_eq!(*itself, json!({"type": "Point", "coordinates": [-4.0, 4.0]}));
    let picture = fs::read_to_string(town.path("m.svg")).unwrap();
    assert!(
        picture.contains("Shortest paths from 3 to 2 points") && picture.contains("2 found"),
        "{picture}"
    );
    town.write("many.csv", "1,1\n".repeat(101));
    let complaint = town.run(
        1,
        &[
            "query",
            "matrix",
            "town.tiles",
            "--batch",
            "many.csv",
            "--plot",
            "m.svg",
        ],
    );
    assert!(complaint.contains("10 201"), "{complaint}");
    for args in [&[][..], &["--from-file", "a.csv"], &["--batch", "gone.csv"]] {
        town.run(1, &[&["query", "matrix", "town.tiles"], args].concat());
    }
    town.run(
        2,
        &[
            "query",
            "matrix",
            "town.tiles",
            "--batch",
            "a.csv",
            "--from-file",
            "a.csv",
        ],
    );
}

#[test]
fn along_gives_the_nearest_sites_of_each_interval() {
    let town = Town::new();
    let line = ["--from", "-4,0", "--to", "4,0", "-k", "1"];
    let table = town.query("along", &[&line[..], &["--csv"]].concat());
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(
        rows[0].join(","),
        "line_from_x,line_from_y,line_to_x,line_to_y,from_t,to_t,from_x,from_y,to_x,to_y,status,rank,site,from_distance,to_distance"
    );
    let (first, last) = (&rows[1], &rows[rows.len() - 1]);
    assert_eq!((first[4], last[5]), ("0", "1"));
    // There are obstacles between -1 and 1, and between 2 and 3.
    let inside: Vec<_> = rows.iter().filter(|row| row[10] == "inside_obstacle").collect();
    assert_eq!(inside.len(), 2);
    assert_eq!(
        (&inside[0][4..10], &inside[0][11..]),
        (&["0.375", "0.625", "-1", "0", "1", "0"][..], &["", "", "", ""][..])
    );
    assert!(last[11] == "1" && last[12].starts_with("\"far"), "{last:?}");

    let found = town.json("along", &line);
    let intervals = found["intervals"].as_array().unwrap();
    assert_eq!(intervals.len(), rows.len() - 1);
    assert_eq!(intervals[0]["sites"].as_array().map(Vec::len), Some(1));
    let drawn: Value = serde_json::from_str(&town.query("along", &[&line[..], &["--geojson"]].concat())).unwrap();
    assert_eq!(drawn["features"][0]["geometry"]["coordinates"][0], json!([-4.0, 0.0]));
    assert!(town.query("along", &line).contains("inside an obstacle"));
    town.run(1, &["query", "along", "town.tiles"]);
}

/// Returns twice the area of a ring, positive if it is counter-clockwise.
fn doubled_area(ring: &Value) -> f64 {
    let at = |point: &Value, axis: usize| point[axis].as_f64().unwrap();
    let points = ring.as_array().unwrap();
    assert!(points.len() > 3 && points.first() == points.last());
    points
        .windows(2)
        .map(|pair| at(&pair[0], 0) * at(&pair[1], 1) - at(&pair[1], 0) * at(&pair[0], 1))
        .sum()
}

#[test]
fn areas_are_polygons_inside_the_true_area() {
    let town = Town::new();
    // The area goes round the obstacle in the middle and meets itself: a ring with a hole.
    let args = ["--at", "0,2", "--radius", "4.5", "--area", "--geojson"];
    let drawn: Value = serde_json::from_str(&town.query("range", &args)).unwrap();
    let area = &drawn["features"][0];
    assert_eq!(
        (&area["geometry"]["type"], &area["properties"]["tolerance"]),
        (&json!("MultiPolygon"), &json!(1e-4))
    );
    let polygons = area["geometry"]["coordinates"].as_array().unwrap();
    let rings = polygons[0].as_array().unwrap();
    assert!(doubled_area(&rings[0]) > 0.0 && rings[1..].iter().all(|ring| doubled_area(ring) < 0.0));
    assert!(drawn["features"].as_array().unwrap().len() > 1);
    // Without obstacles, the area is a polygon inside the true disc.
    let args = ["--at", "3.5,0", "--radius", "0.25", "--area", "--geojson"];
    let disc: Value = serde_json::from_str(&town.query("range", &args)).unwrap();
    let ring = &disc["features"][0]["geometry"]["coordinates"][0][0];
    let part = doubled_area(ring) / (2.0 * std::f64::consts::PI * 0.25 * 0.25);
    assert!((1.0 - 2e-4..=1.0 + 1e-6).contains(&part), "{part}");
}

/// Returns the area that `range --area` prints as JSON.
fn area(town: &Town, at: &str, radius: &str) -> f64 {
    let found = town.json("range", &["--at", at, "--radius", radius, "--area"]);
    found["area"].as_f64().unwrap()
}

/// Checks an area, which may be too small by 0.014 %.
#[track_caller]
fn assert_area(found: f64, expected: f64) {
    assert!(
        (expected * (1.0 - 1.4e-4)..=expected * (1.0 + 1e-8)).contains(&found),
        "{found}, not {expected}"
    );
}

#[test]
fn the_size_of_an_area_is_that_of_its_disc_without_what_is_hidden() {
    let town = Town::new();
    // Free discs, one over a wall; half a disc at the edge of an obstacle; three quarters at its corner.
    assert_area(area(&town, "3.5,0", "0.25"), PI / 16.0);
    assert_area(area(&town, "-2.5,3", "0.25"), PI / 16.0);
    assert_area(area(&town, "0,1", "0.5"), PI / 8.0);
    assert_area(area(&town, "1,1", "0.5"), 0.75 * PI / 4.0);
    // Beside an edge, a disc loses the segment beyond it; outside the hull, nothing.
    let segment = 0.5f64.acos() - 0.5 * 0.75f64.sqrt();
    assert_area(area(&town, "0,-1.5", "1"), PI - segment);
    assert_area(area(&town, "100,100", "3"), 9.0 * PI);
    // In a closed room, nothing else is reached.
    let room = area(&town, "-2.5,2.5", "9");
    assert!((room - 1.0).abs() < 1e-8, "{room}");
    assert_eq!(area(&town, "-2.5,2.5", "0"), 0.0);
}

#[test]
fn all_formats_of_a_range_have_its_area() {
    let town = Town::new();
    let ask = ["--at", "0,3", "--radius", "0.5", "--area"];
    let text = town.query("range", &ask);
    assert!(
        text.starts_with("(0, 3): 1 site within a walking distance of 0.5 coordinate units; area 0.785")
            && text.contains(" square coordinate units\n   1  0 "),
        "{text}"
    );
    let table = town.query(
        "range",
        &[&ask[..], &["--at", "3.5,-2", "--at", "0,0", "--csv"]].concat(),
    );
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][10], "area");
    // A row without a site says the area if there are no sites, and an obstacle has none.
    assert_eq!(
        (rows[1][2], rows[1][4], rows[2][2], rows[2][4]),
        ("ok", "baker", "ok", "")
    );
    for row in &rows[1..3] {
        assert_area(row[10].parse().unwrap(), PI / 4.0);
    }
    assert_eq!((rows[3][2], rows[3][10], rows.len()), ("inside_obstacle", "", 4));
    let drawn: Value = serde_json::from_str(&town.query("range", &[&ask[..], &["--geojson"]].concat())).unwrap();
    assert_area(drawn["features"][0]["properties"]["area"].as_f64().unwrap(), PI / 4.0);
    assert_eq!(town.json("range", &ask[..4])["area"], Value::Null);
}

#[test]
fn an_empty_answer_says_why() {
    let town = Town::new();
    town.run(0, &["build", "points.csv", "--walls", "fences.csv", "-o", "bare.tiles"]);
    let no_sites = "the file has no sites; build it with --sites FILE";
    let far = "no site is within a walking distance of 0.5 coordinate units";
    let at = ["--at", "-4,-4"];
    for (file, ask, note) in [
        ("bare.tiles", &["knn"][..], no_sites),
        ("bare.tiles", &["range", "--radius", "2"], no_sites),
        ("town.tiles", &["range", "--radius", "0.5"], far),
    ] {
        let ask = [&["query", ask[0], file], &at[..], &ask[1..]].concat();
        assert_eq!(town.run(0, &ask), format!("(-4, -4): {note}\n"));
        let json: Value = serde_json::from_str(&town.run(0, &[&ask[..], &["--json"]].concat())).unwrap();
        assert_eq!((&json["note"], &json["sites"]), (&json!(note), &json!([])));
        assert_eq!(town.run(0, &[&ask[..], &["--csv"]].concat()).lines().count(), 1);
    }
    assert_eq!(town.json("knn", &at)["note"], Value::Null);
    let enclosed = ["--at", "-2.5,2.25"];
    assert_eq!(town.json("knn", &enclosed)["note"], Value::Null);
    let along = [
        "query",
        "along",
        "bare.tiles",
        "--from",
        "-4,0",
        "--to",
        "4,0",
        "--json",
    ];
    assert_eq!(
        serde_json::from_str::<Value>(&town.run(0, &along)).unwrap()["note"],
        no_sites
    );
    town.write("from.csv", "1,1\n");
    let matrix = ["query", "matrix", "bare.tiles", "--from-file", "from.csv", "--sites"];
    assert!(town.run(1, &matrix).contains(no_sites));
    town.write("lonely.csv", "-2.5,2.5,inner\n");
    let build = ["build", "points.csv", "--walls", "fences.csv", "--sites", "lonely.csv"];
    town.run(0, &[&build[..], &["-o", "lonely.tiles"]].concat());
    assert_eq!(
        town.run(0, &["query", "knn", "lonely.tiles", "--at", "-4,-4"]),
        "(-4, -4): no site can be reached\n"
    );
    town.write("nothing.csv", "x,y\n");
    let empty = crate::support::command(
        &town.path(""),
        &["query", "knn", "town.tiles", "--batch", "nothing.csv"],
    )
    .output()
    .unwrap();
    assert!(empty.stdout.is_empty() && errors(&empty).contains("note: nothing.csv has no rows of x,y"));
}

#[test]
fn degrees_are_named_with_a_warning_once() {
    let town = Town::new();
    town.run(
        0,
        &[
            "build",
            "--obstacles",
            "houses.geojson",
            "--sites",
            "shops.csv",
            "-o",
            "globe.tiles",
        ],
    );
    let run = |args: &[&str]| {
        let output = crate::support::command(&town.path(""), &[&["query"], args].concat())
            .output()
            .unwrap();
        (String::from_utf8(output.stdout.clone()).unwrap(), errors(&output))
    };
    let (text, warning) = run(&["knn", "globe.tiles", "--at", "0,2", "--at", "0,4", "-k", "1"]);
    assert!(
        text.starts_with("(0, 2): 1 site by walking distance, in degrees\n   1  1 "),
        "{text}"
    );
    assert_eq!(warning.matches("degrees, not metres").count(), 1, "{warning}");
    let (text, _) = run(&["path", "globe.tiles", "--from", "0,2", "--to", "0,4"]);
    assert_eq!(text, "(0, 2) to (0, 4): 2 degrees\n");
    assert_eq!(run(&["locate", "globe.tiles", "--at", "0,2"]).1, "");
    // Points without a reference system may have any unit.
    let (text, warning) = run(&["nearest", "town.tiles", "--at", "0,2"]);
    assert!(
        text.starts_with("(0, 2): 1 site by Euclidean distance, in coordinate units\n") && warning.is_empty(),
        "{text}{warning}"
    );
    let named = r#"{"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}, "features": [{"type": "Feature", "properties": {}, "geometry": {"type": "MultiPoint", "coordinates": [[4500123.25, 5400000], [4500126.25, 5400000], [4500123.25, 5400004]]}}]}"#;
    town.write("named.geojson", named);
    town.run(0, &["build", "named.geojson", "-o", "named.tiles"]);
    let (text, warning) = run(&[
        "path",
        "named.tiles",
        "--from",
        "4500126.25,5400000",
        "--to",
        "4500123.25,5400004",
    ]);
    assert_eq!(
        (&*text, &*warning),
        ("(4500126.25, 5400000) to (4500123.25, 5400004): 5 m\n", "")
    );
}

#[test]
fn a_limit_is_reported_in_every_format() {
    let town = Town::new();
    let limited = |what, format| town.query(what, &["--at", "-4,-3", "--max-tiles", "0", format]);
    for what in ["knn", "nearest"] {
        let table = limited(what, "--csv");
        let lines: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!(
            (lines[1][2], lines[1].len(), lines.len()),
            ("out_of_budget", lines[0].len(), 2)
        );
        let json: Value = serde_json::from_str(&limited(what, "--json")).unwrap();
        assert!(json["lower_bound"].is_number() && json["note"].is_null(), "{json}");
    }
    let inside = town.json("knn", &["--at", "0.5,0.75"]);
    assert_eq!(
        (&inside["inside_point"], &inside["nearest_free"]),
        (&json!([0.5, 0.75]), &json!([0.5, 1.0]))
    );
}
