//! Methods of queries, and the experiment that compares them, as users run them.

use std::fs;

use crate::support::{errors, fails, run, tiletool};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Creates a folder with houses, a fence and shops.
fn town() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let house =
        |[x, y, u, v]: [i32; 4]| json!({"type": "Polygon", "coordinates": [[[x, y], [u, y], [u, v], [x, v], [x, y]]]});
    let houses = [
        [1, 1, 3, 3],
        [4, 1, 6, 8],
        [7, 2, 9, 4],
        [-1, -1, 0, 0],
        [10, 10, 11, 11],
    ]
    .map(house);
    let houses = json!({"type": "GeometryCollection", "geometries": houses}).to_string();
    fs::write(folder.path().join("houses.geojson"), houses).unwrap();
    fs::write(folder.path().join("fences.csv"), "0,5,3.5,5\n").unwrap();
    fs::write(folder.path().join("shops.csv"), "2,6,a\n8,1,b\n8,7,c\n0.5,2,d\n").unwrap();
    run(
        folder.path(),
        "tool build --quiet --obstacles houses.geojson --walls fences.csv --sites shops.csv -o town.tiles",
    );
    folder
}

const METHODS: [&str; 3] = ["visibility --stretch 3", "euclid-zhang", "euclid-xia"];

#[test]
fn all_methods_give_the_same_answers() {
    let town = town();
    for ask in [
        "knn town.tiles --at 2,4 -k 3",
        "range town.tiles --at 2,4 --at 9,9 --radius 7",
        "path town.tiles --from 2,4 --to 2,5.5",
        "path town.tiles --from 2,2 --to 2,5.5",
    ] {
        // Text has the bends, but few digits. Rows have all digits; the bounds of methods differ.
        let answers = |method: &str| {
            let ask = format!("query {ask}{method}");
            let rows = run(town.path(), &format!("{ask} --csv"));
            let without_bounds = rows.lines().map(|row| row.rsplitn(3, ',').last().unwrap().to_owned());
            (run(town.path(), &ask), without_bounds.collect::<Vec<_>>())
        };
        let expected = answers("");
        assert!(expected.1[0].ends_with(",distance"));
        for method in METHODS {
            assert_eq!(answers(&format!(" --method {method}")), expected);
        }
    }
}

#[test]
fn answers_report_their_cost() {
    let town = town();
    for method in METHODS.into_iter().chain(["wavefront"]) {
        let ask = format!("query knn town.tiles --at 2,4 -k 2 --json --method {method}");
        assert_eq!(crate::support::json(town.path(), &ask)["statistics"], Value::Null);
        let answer = crate::support::json(town.path(), &format!("{ask} --stats"));
        assert_eq!(answer["sites"].as_array().unwrap().len(), 2);
        let cost = &answer["statistics"];
        for count in ["candidates", "edges_considered", "nodes_swept", "rounds", "tiles"] {
            assert!(cost[count].as_u64().unwrap() > 0, "{count}: {cost}");
        }
        assert!(cost["milliseconds"]["locate"].as_f64().unwrap() >= 0.0);
        let output = tiletool(town.path(), &ask.replace("--json", "--stats"))
            .output()
            .unwrap();
        assert!(errors(&output).contains("constraint edges: "), "{}", errors(&output));
    }
}

#[test]
fn a_stretch_factor_that_is_too_small_is_refused() {
    let town = town();
    for stretch in ["1.57", "NaN", "inf", "-3", "x"] {
        let ask = format!("query knn town.tiles --at 2,4 --method visibility --stretch={stretch}");
        let error = fails(town.path(), 2, &ask);
        assert!(error.contains("stretch factor"), "{error}");
    }
}

#[test]
fn all_methods_but_the_wavefront_refuse_break_lines() {
    let town = town();
    let lines = "tool build --quiet --obstacles houses.geojson --segments fences.csv --sites shops.csv -o lines.tiles";
    run(town.path(), lines);
    let ask = "query knn lines.tiles --at 2,4 --method";
    run(town.path(), &format!("{ask} wavefront"));
    for method in METHODS {
        let error = fails(town.path(), 1, &format!("{ask} {method}"));
        assert!(error.contains("break lines"), "{error}");
    }
}

#[test]
fn an_experiment_compares_the_methods() {
    let town = town();
    let ask = "queries houses.geojson --sites 30 --queries 3 --k 1,4 --stretches 2.42 -o results";
    run(town.path(), ask);
    let read = |name: &str| fs::read_to_string(town.path().join("results").join(name)).unwrap();
    // Two kinds of two numbers of sites, by four methods, from three points.
    assert_eq!(read("queries.csv").lines().count(), 1 + 2 * 2 * 4 * 3);
    assert_eq!(read("summary.csv").lines().count(), 1 + 2 * 2 * 4);
    for name in ["README.md", "time.svg", "edges.svg", "swept.svg", "tiles.svg"] {
        assert!(read(name).contains("Zhang et al."), "{name}");
    }
    let error = fails(town.path(), 1, "queries town.tiles --queries 1 --stretches 1.5 -o more");
    assert!(error.contains("stretch factor"), "{error}");
}
