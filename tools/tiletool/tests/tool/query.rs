//! `tiletool query` from the command line.

use std::fs;
use std::path::PathBuf;

use crate::support::{command, complaint, printed};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A folder with a town: a square of 8 by 8 with an obstacle in the middle, a closed wall, and
/// sites.
struct Town(TempDir);

impl Town {
    fn new() -> Self {
        let this = Self(tempfile::tempdir().unwrap());
        let ring = |[x, y, u, v]: [i32; 4]| json!([[x, y], [u, y], [u, v], [x, v], [x, y]]);
        let features = [ring([-1, -1, 1, 1]), ring([2, -4, 3, 2])];
        let features = features.map(|ring| json!({"type": "Polygon", "coordinates": [ring]}));
        this.write(
            "houses.geojson",
            json!({"type": "GeometryCollection", "geometries": features}).to_string(),
        );
        this.write("fences.csv", "-3,2,-2,2\n-2,2,-2,3\n-2,3,-3,3\n-3,3,-3,2\n");
        this.write("points.csv", "-4,-4\n4,-4\n4,4\n-4,4\n");
        this.write(
            "shops.csv",
            "0,3,baker\n\"-2.5\",2.5,inner\n3.5,0,\"far, far\"\n0,-3,pump\n",
        );
        let build = [
            "build",
            "points.csv",
            "--obstacles",
            "houses.geojson",
            "--walls",
            "fences.csv",
        ];
        this.run(0, &[&build[..], &["--sites", "shops.csv", "-o", "town.tiles"]].concat());
        this
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs a command that must end with this exit code. Returns its standard output, or its
    /// standard error if the code is not 0.
    #[track_caller]
    fn run(&self, code: i32, args: &[&str]) -> String {
        let command = command(self.0.path(), args);
        match code {
            0 => printed(command),
            _ => complaint(command, code),
        }
    }

    fn query(&self, what: &str, args: &[&str]) -> String {
        self.run(0, &[&["query", what, "town.tiles"], args].concat())
    }

    fn json(&self, what: &str, args: &[&str]) -> Value {
        serde_json::from_str(&self.query(what, &[args, &["--json"]].concat())).unwrap()
    }
}

#[test]
fn a_path_is_shortest_and_names_its_bends() {
    let town = Town::new();
    let path = town.json("path", &["--from", "-2,0", "--to", "1.5,0", "--certify"]);
    let length = 2f64.sqrt() + 2.0 + 1.25f64.sqrt();
    assert!((path["distance"].as_f64().unwrap() - length).abs() < 1e-12, "{path}");
    assert!(path["lower"].as_f64() <= path["distance"].as_f64() && path["distance"].as_f64() <= path["upper"].as_f64());
    assert_eq!(
        (&path["status"], &path["path"]["certified"]),
        (&json!("ok"), &json!(true))
    );
    let bends = path["path"]["bends"].as_array().unwrap();
    assert_eq!(bends.len(), 2);
    assert!(
        bends.iter().all(|bend| bend["lines"][0]["kind"] == "obstacle"),
        "{path}"
    );

    let text = town.query("path", &["--from", "-2,0", "--to", "1.5,0"]);
    assert!(
        text.starts_with("(-2, 0) to (1.5, 0): 4.53") && text.contains("around obstacle"),
        "{text}"
    );
    let drawn = town.query("path", &["--from", "-4,-4", "--to", "-4,4", "--geojson"]);
    let drawn: Value = serde_json::from_str(&drawn).unwrap();
    let feature = &drawn["features"][0];
    assert_eq!(
        feature["geometry"],
        json!({"type": "LineString", "coordinates": [[-4.0, -4.0], [-4.0, 4.0]]})
    );
    assert_eq!(feature["properties"]["distance"], 8.0);
}

#[test]
fn answers_of_a_batch_are_in_the_order_of_its_rows() {
    let town = Town::new();
    let mut rows = String::from("from_x,from_y,to_x,to_y\n");
    for i in 0..50 {
        rows.push_str(&format!("-4,-4,-4,{}\n", f64::from(i) / 8.0));
    }
    rows.push_str("0,0,-4,-4\n-2.5,2.5,-4,-4\n\n");
    town.write("ways.csv", rows);
    let table = town.query("path", &["--batch", "ways.csv", "--csv", "--cache", "0"]);
    let mut lines = table.lines();
    assert_eq!(
        lines.next(),
        Some("from_x,from_y,to_x,to_y,status,distance,lower,upper")
    );
    for i in 0..50 {
        let cells: Vec<&str> = lines.next().unwrap().split(',').collect();
        let y = f64::from(i) / 8.0;
        assert_eq!((cells[3], cells[4], cells.len()), (&*y.to_string(), "ok", 8));
        let [distance, lower, upper] = [5, 6, 7].map(|cell| cells[cell].parse::<f64>().unwrap());
        assert!(
            lower <= distance && distance <= upper && distance == y + 4.0,
            "{cells:?}"
        );
    }
    assert_eq!(lines.next(), Some("0,0,-4,-4,inside_obstacle,,,"));
    assert_eq!(lines.next(), Some("-2.5,2.5,-4,-4,unreachable,,,"));
    assert_eq!(lines.next(), None);
    assert_eq!(
        town.query("path", &["--batch", "ways.csv", "--csv", "--threads", "1"]),
        table
    );
}

#[test]
fn sites_are_ordered_by_walking_distance() {
    let town = Town::new();
    let found = town.json("knn", &["--at", "-4,-3"]);
    let names: Vec<&str> = found["sites"]
        .as_array()
        .unwrap()
        .iter()
        .map(|site| site["site"].as_str().unwrap())
        .collect();
    assert_eq!(
        (names, &found["status"]),
        (vec!["pump", "baker", "far, far"], &json!("ok"))
    );
    let within = town.json("range", &["--at", "-4,-3", "--radius", "4"]);
    assert_eq!(within["sites"], json!([found["sites"][0]]));
    assert_eq!(found["sites"][0]["distance"], 4.0);
    let table = town.query("knn", &["--at", "-4,-3", "--at", "0.5,0.5", "-k", "3", "--csv"]);
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows[0], "x,y,status,rank,site,to_x,to_y,distance,lower,upper");
    assert!(
        rows[1].starts_with("-4,-3,ok,1,pump,0,-3,4,") && rows[3].contains(r#","far, far","#),
        "{table}"
    );
    assert_eq!(rows[4..], ["0.5,0.5,inside_obstacle,,,,,,,"]);
    let one = town.query("knn", &["--at", "-4,-3", "-k", "1"]);
    assert!(
        one.contains("   1  4 ") && one.contains("site pump at (0, -3)"),
        "{one}"
    );
    let stopped = town.json("knn", &["--at", "-4,-3", "--max-tiles", "0"]);
    assert_eq!(
        (&stopped["status"], &stopped["sites"]),
        (&json!("out_of_budget"), &json!([]))
    );
}

#[test]
fn locate_and_nearest_find_elements_and_sites() {
    let town = Town::new();
    assert_eq!(
        town.query("locate", &["--at", "-4,4"])
            .split(": ")
            .last()
            .unwrap()
            .split(' ')
            .next(),
        Some("on")
    );
    let inside = town.json("locate", &["--at", "0.5,0.75"]);
    assert_eq!(
        (&inside["where"], &inside["status"]),
        (&json!("triangle"), &json!("inside_obstacle"))
    );
    assert_eq!(inside["nearest_free"], json!([0.5, 1.0]));
    let outside = town.json("locate", &["--at", "-400,0.75"]);
    assert_eq!(
        (&outside["where"], &outside["status"]),
        (&json!("outside"), &json!("ok"))
    );
    let near = town.json("nearest", &["--at", "0,0"]);
    assert_eq!(
        (&near["nearest"][0]["site"], &near["nearest"][0]["distance"]),
        (&json!("baker"), &json!(3.0))
    );
    let near = town.json("nearest", &["--at", "0,0", "--vertices", "-k", "4"]);
    let near = near["nearest"].as_array().unwrap();
    assert!(
        near.len() == 4 && near.iter().all(|near| near["distance"] == 2f64.sqrt()),
        "{near:?}"
    );
}

#[test]
fn mistakes_in_queries_are_errors_that_name_them() {
    let town = Town::new();
    town.write("bad.csv", "x,y\n1,2\n3;4\n");
    town.write("text.tiles", "no tiles");
    for (code, args, complaint) in [
        (1, &["path", "town.tiles"][..], "give --from X,Y --to X,Y"),
        (1, &["knn", "town.tiles"], "give --at X,Y"),
        (
            1,
            &["knn", "town.tiles", "--batch", "bad.csv"],
            "bad.csv: line 3: `3;4` is not x,y",
        ),
        (
            1,
            &["knn", "town.tiles", "--batch", "none.csv"],
            "none.csv: cannot be opened",
        ),
        (
            1,
            &["path", "town.tiles", "--batch", "bad.csv"],
            "bad.csv: line 2: `1,2` is not from_x,from_y,to_x,to_y",
        ),
        (1, &["knn", "none.tiles", "--at", "0,3"], "none.tiles"),
        (1, &["knn", "text.tiles", "--at", "0,3"], "text.tiles"),
        (1, &["knn", "town.tiles", "--at", "1e300,3"], "is not a valid point"),
        (
            2,
            &["knn", "town.tiles", "--at", "1,2,3"],
            "two numbers separated by a comma",
        ),
        (2, &["knn", "town.tiles", "--at", "1,2", "-k", "0"], "0"),
        (2, &["range", "town.tiles", "--at", "1,2"], "--radius"),
        (2, &["range", "town.tiles", "--at", "1,2", "--radius", "-1"], "--radius"),
        (2, &["path", "town.tiles", "--from", "1,2"], "--to"),
        (
            2,
            &["knn", "town.tiles", "--at", "1,2", "--csv", "--json"],
            "cannot be used with",
        ),
    ] {
        let errors = town.run(code, &[&["query"], args].concat());
        assert!(errors.contains(complaint), "{args:?}: {errors}");
    }
}

#[test]
fn a_matrix_has_the_distance_of_each_pair() {
    let town = Town::new();
    town.write("a.csv", "x,y\n-4,-4\n0,0\n4,4\n");
    town.write("b.csv", "-4,4\n-2.5,2.5\n");
    let table = town.query("matrix", &["--from-file", "a.csv", "--to-file", "b.csv", "--csv"]);
    let mut lines = table.lines();
    assert_eq!(
        lines.next(),
        Some("from,to,from_x,from_y,to_x,to_y,status,distance,lower,upper")
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
    let ends = [&first["geometry"]["coordinates"][0], &last["properties"]["from_at"]];
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
        "line_from_x,line_from_y,line_to_x,line_to_y,from_t,to_t,from_x,from_y,to_x,to_y,status,sites"
    );
    let (first, last) = (&rows[1], &rows[rows.len() - 1]);
    assert_eq!((first[4], last[5]), ("0", "1"));
    // There are obstacles between -1 and 1, and between 2 and 3.
    let inside: Vec<_> = rows.iter().filter(|row| row[10] == "inside_obstacle").collect();
    assert_eq!(inside.len(), 2);
    assert_eq!(
        (&inside[0][4..10], inside[0][11]),
        (&["0.375", "0.625", "-1", "0", "1", "0"][..], "")
    );
    assert!(last[11].starts_with("\"far"), "{last:?}");

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
    town.run(
        1,
        &["query", "range", "town.tiles", "--at", "0,2", "--radius", "1", "--area"],
    );
}

#[test]
fn plots_show_what_was_found() {
    let town = Town::new();
    town.write("places.csv", "-4,0\n4,0\n");
    for (what, args) in [
        ("locate", &["--at", "0,0"][..]),
        ("nearest", &["--at", "0,3", "-k", "2"]),
        ("knn", &["--at", "-4,-3", "-k", "2"]),
        ("knn", &["--batch", "places.csv"]),
        ("range", &["--at", "0,2", "--radius", "3", "--area"]),
        ("path", &["--from", "-2,0", "--to", "1.5,0"]),
        ("path", &["--from", "-2,0", "--to", "-2.5,2.5"]),
        ("along", &["--from", "-6,0", "--to", "4,1"]),
    ] {
        let text = town.query(what, &[args, &["--plot", "drawn.svg"]].concat());
        assert!(!text.is_empty());
        let drawn = fs::read_to_string(town.path("drawn.svg")).unwrap();
        assert!(
            drawn.starts_with("<svg") && drawn.ends_with("</svg>\n") && drawn.contains(">from<"),
            "{what}"
        );
        let paths = drawn.matches(">paths<").count() + drawn.matches(">path<").count();
        let expects_paths = matches!(what, "knn" | "range") || text.contains("turn") || text.contains("around");
        assert_eq!(paths == 1, expects_paths, "{what} {args:?}");
        assert_eq!(
            drawn.contains("triangles searched"),
            !matches!(what, "locate" | "nearest") && !args.contains(&"--batch")
        );
    }
    town.query("path", &["--from", "-2,0", "--to", "1.5,0", "--plot", "drawn.png"]);
    assert!(fs::read(town.path("drawn.png")).unwrap().starts_with(b"\x89PNG"));
    town.run(
        2,
        &[
            "query",
            "path",
            "town.tiles",
            "--from",
            "0,3",
            "--to",
            "1,3",
            "--plot",
            "drawn.gif",
        ],
    );
}

#[test]
fn modes_bound_the_distance_and_progressive_answers_have_two_stages() {
    let town = Town::new();
    let ends = ["--from", "-2,0", "--to", "1.5,0"];
    let length = 2f64.sqrt() + 2.0 + 1.25f64.sqrt();
    for mode in ["exact", "within:0", "within:0.05", "fast"] {
        let path = town.json("path", &[&ends[..], &["--mode", mode, "--certify"]].concat());
        let [lower, value, upper] = ["lower", "distance", "upper"].map(|key| path[key].as_f64().unwrap());
        assert!(lower <= value && value <= upper, "{path}");
        assert!(lower <= length && length <= upper * (1.0 + 1e-15), "{path}");
        assert_eq!(path["path"]["certified"], true);
        for what in ["knn", "range"] {
            let limit = if what == "knn" { ["-k", "3"] } else { ["--radius", "20"] };
            let sites = town.json(what, &[&["--at", "-2,0", "--mode", mode], &limit[..]].concat());
            assert!(sites["sites"].as_array().unwrap().len() >= 2, "{sites}");
        }
    }
    for mode in ["within:-1", "within:nan", "within:x", "within", "quick", ""] {
        let complaint = town.run(
            2,
            &[&["query", "path", "town.tiles", "--mode", mode], &ends[..]].concat(),
        );
        assert!(complaint.contains("within:0.05"), "{complaint}");
    }
    town.run(
        2,
        &[
            &["query", "path", "town.tiles", "--progressive", "--mode", "fast"],
            &ends[..],
        ]
        .concat(),
    );

    let both = town.query("path", &[&ends[..], &["--progressive", "--json"]].concat());
    let both: Vec<Value> = both.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!([&both[0]["stage"], &both[1]["stage"]], ["fast", "exact"]);
    assert!(
        both.len() == 2 && both[0]["exact_cost"]["tiles"].as_u64() >= Some(1),
        "{both:?}"
    );
    assert!(both[0]["lower"].as_f64().unwrap() <= length && both[1]["upper"].as_f64().unwrap() >= length);
    let table = town.query("path", &[&ends[..], &["--progressive", "--csv"]].concat());
    let rows: Vec<Vec<&str>> = table.lines().map(|row| row.split(',').collect()).collect();
    assert!(rows.len() == 3 && rows.iter().all(|row| row.len() == 11), "{table}");
    assert_eq!([rows[0][8], rows[1][8], rows[2][8]], ["stage", "fast", "exact"]);
    let text = town.query("path", &[&ends[..], &["--progressive"]].concat());
    assert!(
        text.starts_with("fast (the exact answer may take 1 tile and ") && text.contains("\nexact: "),
        "{text}"
    );
    let drawn = town.query("knn", &["--at", "-2,0", "-k", "2", "--progressive", "--geojson"]);
    let drawn: Value = serde_json::from_str(&drawn).unwrap();
    let stages = drawn["features"].as_array().unwrap().iter();
    let stages: Vec<&Value> = stages.map(|feature| &feature["properties"]["stage"]).collect();
    assert_eq!(stages, ["fast", "fast", "exact", "exact"]);
    let limited = town.query(
        "path",
        &[&ends[..], &["--progressive", "--max-time", "0", "--csv"]].concat(),
    );
    assert!(
        limited.contains(",out_of_budget,") && limited.lines().nth(1).unwrap().ends_with(",,,"),
        "{limited}"
    );
    let inside = town.query("knn", &["--at", "0,0", "--progressive"]);
    assert!(inside.contains("is inside an obstacle"), "{inside}");
}
