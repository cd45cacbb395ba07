//! `tiletool query` from the command line.

use std::fs;

use crate::town::Town;
use serde_json::{Value, json};

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
        (&inside["element"], &inside["status"]),
        (&json!("triangle"), &json!("inside_obstacle"))
    );
    assert_eq!(inside["nearest_free"], json!([0.5, 1.0]));
    let outside = town.json("locate", &["--at", "-400,0.75"]);
    assert_eq!(
        (&outside["element"], &outside["status"]),
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
