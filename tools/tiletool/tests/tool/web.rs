//! Queries of a file on a web server: how many requests they send.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use crate::server::{Fault, Server};
use crate::support::{errors, json, run, tiletool};

/// Asks for the triangle at 20 places, each in a process of its own. Opening the file, finding a tile
/// and reading it must take four requests, and each further tile two.
fn takes_four_requests(folder: &Path, file: &str) {
    let server = Server::start(fs::read(folder.join(file)).unwrap(), Fault::None);
    let mut single = 0;
    for place in 0..20 {
        let before = server.requests();
        let [x, y] = [place * 37 % 97, place * 61 % 89].map(|at| f64::from(at) / 100.0 + 0.013);
        let args = format!("query locate {} --at {x},{y} --stats", server.url);
        let output = tiletool(folder, &args).output().unwrap();
        let stats = errors(&output);
        assert!(output.status.success(), "{stats}");
        let tiles = stats.split("tiles: ").nth(1).and_then(|rest| rest.split(' ').next());
        let tiles: usize = tiles.and_then(|tiles| tiles.parse().ok()).expect(&stats);
        let requests = server.requests() - before;
        assert!(
            requests <= 2 + 2 * tiles,
            "{file} at {x},{y}: {requests} requests, {stats}"
        );
        single += usize::from(tiles == 1);
    }
    assert!(single >= 10, "{single}");
}

#[test]
fn one_place_of_thousands_of_tiles_takes_at_most_four_requests() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    run(folder, "generate uniform -n 100000 --seed 7 -o p.f64");
    run(folder, "build p.f64 -o p.tiles --tile-vertices 8");
    takes_four_requests(folder, "p.tiles");
    // A copy in a new order, with all lists in new places.
    run(folder, "compact p.tiles -o c.tiles");
    takes_four_requests(folder, "c.tiles");
    // The heights of a triangle are in its tile.
    run(folder, "generate uniform -n 100000 --seed 7 --dims 3 -o z.f64");
    run(folder, "build z.f64 --dims 3 -o z.tiles --tile-vertices 8");
    takes_four_requests(folder, "z.tiles");
}

#[test]
fn a_reference_system_and_many_hole_points_add_no_requests() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let places: Vec<[f64; 2]> = (0..5000)
        .map(|i| [i % 71, i / 71].map(|at| f64::from(at) / 70.0))
        .collect();
    let points: Vec<String> = places.iter().map(|[x, y]| format!("[{x},{y}]")).collect();
    let crs = r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::25832"}}"#;
    let points = format!(r#"{{"type":"MultiPoint",{crs},"coordinates":[{}]}}"#, points.join(","));
    fs::write(folder.join("p.geojson"), points).unwrap();
    run(folder, "build p.geojson -o p.tiles --tile-vertices 100");
    assert!(run(folder, "inspect p.tiles").contains("25832"));
    takes_four_requests(folder, "p.tiles");

    // The hole points lie outside, and make nothing a hole.
    let mut poly = "5000 2 0 0\n".to_owned();
    for ([x, y], number) in places.iter().zip(1..) {
        writeln!(poly, "{number} {x} {y}").unwrap();
    }
    poly.push_str("0 0\n30000\n");
    for hole in 1..=30_000 {
        writeln!(poly, "{hole} {} 5", 5 + hole).unwrap();
    }
    fs::write(folder.join("h.poly"), poly).unwrap();
    run(folder, "build h.poly -o h.tiles --tile-vertices 100");
    assert_eq!(json(folder, "inspect h.tiles --json")["hole_points"], 30_000);
    takes_four_requests(folder, "h.tiles");
}
