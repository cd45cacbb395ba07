//! `tiletool inspect` from the command line.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::{command, complaint, errors, names, printed};
use resvg::tiny_skia::Pixmap;
use resvg::usvg::{Options, Tree};
use serde_json::Value;
use tempfile::TempDir;

/// A folder with a tile file.
struct Case {
    folder: TempDir,
    file: PathBuf,
}

fn text_of(path: &Path) -> &str {
    path.to_str().unwrap()
}

impl Case {
    /// Builds a tile file from these lines of text, with at most `tile_vertices` vertices per tile.
    fn build(lines: &[String], tile_vertices: usize) -> Self {
        let folder = TempDir::new().unwrap();
        let (input, file) = (folder.path().join("points.txt"), folder.path().join("map.tiles"));
        fs::write(&input, lines.join("\n")).unwrap();
        let limit = tile_vertices.to_string();
        let build = [
            "build",
            "points.txt",
            "-o",
            "map.tiles",
            "--tile-vertices",
            &limit,
            "--quiet",
        ];
        printed(command(folder.path(), &build));
        Self { folder, file }
    }

    /// Builds 30 × 20 points of a slightly bent grid, with z. One point occurs twice.
    fn grid() -> Self {
        let points = (0..600).map(|i| (f64::from(i % 30), f64::from(i / 30)));
        let points = points.map(|(x, y)| format!("{} {} {}", 100.0 + x + y * y / 50.0, y, x * y));
        let mut lines: Vec<_> = points.collect();
        lines.push(lines[17].clone());
        Self::build(&lines, 64)
    }

    fn in_folder(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, options: &[&str]) -> Command {
        command(
            self.folder.path(),
            &[&["inspect", text_of(&self.file)], options].concat(),
        )
    }

    fn text(&self, options: &[&str]) -> String {
        printed(self.command(options))
    }

    fn json(&self, options: &[&str]) -> Value {
        serde_json::from_str(&self.text(&[&["--json"], options].concat())).unwrap()
    }

    /// Draws maps in both formats and checks that they are valid. Returns the SVG and the number of
    /// colours of the PNG.
    fn maps(&self) -> (String, usize) {
        let [svg, png] = ["map.svg", "map.png"].map(|name| self.in_folder(name));
        let drawn = self.json(&["--plot", text_of(&svg)])["plot"].clone();
        assert!(self.text(&["--plot", text_of(&png)]).contains("map.png: 1600 x "));
        let svg = fs::read_to_string(svg).unwrap();
        let tree = Tree::from_str(&svg, &Options::default()).unwrap();
        // Encoded images have any letters.
        let mut parts = svg.split(";base64,");
        let first = parts.next().unwrap_or_default();
        let text: Vec<_> = parts
            .filter_map(|part| Some(part.split_once('"')?.1))
            .chain([first])
            .collect();
        assert!(!text.iter().any(|text| text.contains("NaN") || text.contains("inf")));
        assert_eq!(drawn["bytes"], svg.len());
        let png = fs::read(png).unwrap();
        assert_eq!(png[..8], *b"\x89PNG\r\n\x1a\n");
        let pixels = Pixmap::decode_png(&png).unwrap();
        for (key, of_svg, of_png) in [
            ("width", tree.size().width(), pixels.width()),
            ("height", tree.size().height(), pixels.height()),
        ] {
            assert_eq!(drawn[key], of_png);
            assert_eq!(of_svg, of_png as f32);
        }
        let colours: HashSet<_> = pixels.data().chunks(4).collect();
        let names = names(self.folder.path());
        assert!(!names.iter().any(|name| name.contains("partial")), "{names:?}");
        (svg, colours.len())
    }
}

#[test]
fn the_json_summary_describes_the_file() {
    let case = Case::grid();
    let json = case.json(&[]);
    for (key, value) in [
        ("points", 601),
        ("duplicates", 1),
        ("vertices", 600),
        ("generation", 1),
        ("tile_vertices", 64),
        ("file_bytes", fs::metadata(&case.file).unwrap().len()),
    ] {
        assert_eq!(json[key], value, "{key}");
    }
    assert_eq!(json["has_z"], true);
    assert_eq!(json["crs"], Value::Null);
    assert_eq!(json["sources"][0]["name"], "points.txt");
    assert_eq!(json["sources"][0]["records"], 601);
    assert_eq!(json["bounds"]["min_x"], 100.0);
    assert_eq!(json["bounds"]["max_y"], 19.0);
    assert_eq!(json["file_id"].as_str().unwrap().len(), 32);
    assert!(json["producer"].as_str().unwrap().starts_with("delaunay-tiles"));
    let number = |key: &str| json[key].as_u64().unwrap();
    // Euler's formula.
    assert_eq!(number("triangles"), 2 * 600 - 2 - number("hull_edges"));
    assert_eq!(
        number("core_triangles") + number("border_triangles"),
        number("triangles")
    );
    assert!(number("border_triangles") > 0 && number("tiles") >= 10);
    let quartiles = ["min", "lower_quartile", "median", "upper_quartile", "max"];
    let quartiles = quartiles.map(|key| json["vertices_per_tile"][key].as_u64().unwrap());
    assert!(quartiles.is_sorted() && quartiles[0] > 0 && quartiles[4] <= 64);
    let parts = ["core", "border", "directory", "other"];
    let bytes: u64 = parts.iter().map(|part| number(&format!("{part}_bytes"))).sum();
    assert_eq!(bytes, number("file_bytes"));
    let shares = parts
        .iter()
        .map(|part| json[format!("{part}_bytes_share")].as_f64().unwrap());
    assert!((shares.sum::<f64>() - 1.0).abs() < 1e-9);
    for key in [
        "format_version",
        "backend",
        "border_triangles_share",
        "bytes_per_vertex",
    ] {
        assert!(!json[key].is_null(), "{key}");
    }
    for key in ["tile_list", "tile", "region_list", "plot"] {
        assert!(json.get(key).is_none(), "{key}");
    }
}

#[test]
fn the_text_summary_describes_the_file() {
    let text = Case::grid().text(&[]);
    for part in [
        "points.txt  601 records",
        "601, 1 duplicate merged",
        "600, with z",
        "at most 64 vertices each",
        "x  100.0000 to 136.2200",
        "version 2, generation 1",
    ] {
        assert!(text.contains(part), "{part} is missing:\n{text}");
    }
}

#[test]
fn tiles_prints_one_row_per_tile() {
    let case = Case::grid();
    let json = case.json(&["--tiles"]);
    let tiles = json["tile_list"].as_array().unwrap();
    assert_eq!(tiles.len() as u64, json["tiles"]);
    let sum = |key: &str| tiles.iter().map(|tile| tile[key].as_u64().unwrap()).sum::<u64>();
    assert_eq!(sum("vertices"), 600);
    assert_eq!(sum("owned_triangles"), json["triangles"]);
    assert_eq!(sum("core_bytes"), json["core_bytes"]);
    let text = case.text(&["--tiles"]);
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines.len(), tiles.len() + 1);
    assert!(lines[0].trim_start().starts_with("tile  vertices"));
    assert!(lines.iter().all(|line| line.len() == lines[0].len()), "{text}");
    for (id, line) in lines[1..].iter().enumerate() {
        let numbers = line.split_whitespace().map(|n| n.parse::<u64>().unwrap());
        let first: Vec<_> = numbers.take(2).collect();
        assert_eq!(first, [id as u64, tiles[id]["vertices"].as_u64().unwrap()]);
    }
}

#[test]
fn tile_prints_all_vertices_and_triangles_of_a_tile() {
    let case = Case::grid();
    let json = case.json(&["--tile", "3"]);
    assert_eq!(json["vertices"], 600, "the summary is missing");
    let tile = &json["tile"];
    assert_eq!(tile["id"], 3);
    let vertices = tile["vertex_list"].as_array().unwrap();
    let triangles = tile["triangle_list"].as_array().unwrap();
    assert_eq!(vertices.len() as u64, tile["vertices"]);
    for (index, vertex) in vertices.iter().enumerate() {
        assert_eq!(vertex["index"], index);
        // The record number determines the point of the grid.
        let record = vertex["record"].as_u64().unwrap();
        let (x, y) = ((record % 30) as f64, (record / 30) as f64);
        assert_eq!(vertex["y"], y);
        assert_eq!(vertex["z"], x * y);
        let bound = |key: &str| tile["cell"][key].as_f64();
        assert!(bound("min_y").is_none_or(|bound| bound < y) && bound("max_y").is_none_or(|bound| y <= bound));
    }
    let count = |key: &str, value: Value| triangles.iter().filter(|t| t[key] == value).count() as u64;
    assert_eq!(count("part", "core".into()), tile["core_triangles"]);
    assert_eq!(count("part", "border".into()), tile["border_triangles"]);
    assert_eq!(count("owned", true.into()), tile["owned_triangles"]);
    for triangle in triangles {
        let corners = triangle["corners"].as_array().unwrap();
        assert!(
            corners.iter().any(|corner| corner[0] == 3),
            "no corner belongs to the tile"
        );
        for neighbour in triangle["neighbours"].as_array().unwrap() {
            let Some(number) = neighbour.as_u64() else {
                assert!(neighbour == "hull" || neighbour == "elsewhere");
                continue;
            };
            let back = triangles[number as usize]["neighbours"].as_array().unwrap();
            assert!(back.contains(&triangle["number"]));
        }
    }
    let text = case.text(&["--tile", "3"]);
    let blocks: Vec<Vec<_>> = text.split("\n\n").map(|block| block.lines().collect()).collect();
    assert_eq!(blocks.len(), 3);
    assert_eq!(blocks[0][0], "tile 3");
    assert!(blocks[1][0].starts_with("vertex") && blocks[2][0].starts_with("triangle"));
    assert_eq!(blocks[1].len(), 1 + vertices.len());
    assert_eq!(blocks[2].len(), 1 + triangles.len());
}

#[test]
fn a_small_file_is_drawn_whole() {
    let case = Case::grid();
    let (svg, colours) = case.maps();
    assert!(colours > 10);
    assert!(svg.contains("The whole Delaunay triangulation of 600 vertices"));
    assert!(svg.contains(">map.tiles</text>"));
    for id in 0..case.json(&[])["tiles"].as_u64().unwrap() {
        assert!(svg.contains(&format!(">{id}</text>")), "tile {id} has no label");
    }
    assert!(svg.matches("<path").count() < 20, "an element for each edge");
}

#[test]
fn the_map_of_a_large_file_shows_all_of_it() {
    // The points are evenly distributed: multiples of powers of the plastic number's inverse,
    // modulo 1.
    let points = (1..=32_000u32).map(|i| [0.754_877_666, 0.569_840_291].map(|step| (f64::from(i) * step).fract()));
    let lines: Vec<_> = points.map(|[x, y]| format!("{x} {y}")).collect();
    let case = Case::build(&lines, 64);
    let (svg, colours) = case.maps();
    assert!(colours > 10);
    assert!(svg.contains("The whole Delaunay triangulation of 32 000 vertices"));
    assert!(svg.contains("<image ") && svg.contains(">edges<"));
    assert!(svg.len() < 8_000_000, "{} bytes", svg.len());
    assert!(!svg.contains(">17</text>"), "labels for too many tiles");
    let again = case.in_folder("again.svg");
    let json = case.json(&["--plot", text_of(&again), "--memory", "16MiB"]);
    for key in ["vertices", "triangles"] {
        assert_eq!(json["plot"][key], json[key]);
    }
    assert!(fs::read_to_string(again).unwrap() == svg);
}

#[test]
fn every_option_works_with_degenerate_files() {
    let line = |f: fn(f64) -> (f64, f64)| (0..200).map(|i| f(f64::from(i))).collect::<Vec<_>>();
    for (name, points) in [
        ("none", Vec::new()),
        ("one", vec![(3.0, 4.0)]),
        ("one at the origin", vec![(0.0, 0.0)]),
        ("two", vec![(1e30, 4.0), (-1e30, 4.0)]),
        ("a slanted line", line(|i| (i, 3.0 * i))),
        ("a vertical line", line(|i| (5e5, i))),
        ("far", line(|i| (1e15 + i % 3.0, 1e15 + i))),
        ("huge", line(|i| (1e30 * (i % 7.0), 1e30 * i))),
        ("tiny", line(|i| (1e-30 * i, 1e-30 * (i % 7.0)))),
    ] {
        println!("{name}");
        let lines: Vec<_> = points.iter().map(|(x, y)| format!("{x:e} {y:e}")).collect();
        let case = Case::build(&lines, 64);
        let json = case.json(&["--tiles"]);
        assert_eq!(json["vertices"], points.len());
        assert_eq!(json["bounds"].is_null(), points.is_empty());
        assert_eq!(json["tile_list"].as_array().unwrap().len() as u64, json["tiles"]);
        let regions = case.json(&["--regions", "--all"]);
        assert_eq!(regions["region_totals"]["regions"], json["regions"]);
        let listed = regions["region_list"].as_array().unwrap();
        assert_eq!(listed.len() as u64, json["regions"]);
        let triangles: u64 = listed.iter().map(|region| region["triangles"].as_u64().unwrap()).sum();
        assert_eq!(regions["region_totals"]["triangles"], triangles);
        for options in [&[][..], &["--tiles"], &["--tile", "0"], &["--regions"]] {
            let inspect = case.command(options);
            if points.is_empty() && options.contains(&"0") {
                complaint(inspect, 1);
                continue;
            }
            let text = printed(inspect);
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        }
        let (svg, colours) = case.maps();
        assert!(colours > 1 && svg.contains("map.tiles"));
    }
}

#[test]
fn an_error_names_its_cause() {
    let case = Case::grid();
    let map = case.in_folder("map.svg");
    let failed = |command: Command, code: i32, parts: &[&str]| {
        let error = complaint(command, code);
        for part in parts {
            assert!(error.contains(part), "{part} is missing: {error}");
        }
    };
    let count = case.json(&[])["tiles"].to_string();
    failed(
        case.command(&["--tile", "99999"]),
        1,
        &["map.tiles", "no tile 99999", &count],
    );
    failed(
        case.command(&["--tile", "99999", "--plot", text_of(&map)]),
        1,
        &["no tile 99999"],
    );
    assert!(!map.exists());
    failed(case.command(&["--tils"]), 2, &["--tils"]);
    failed(case.command(&["--tile", "seven"]), 2, &["seven"]);
    failed(case.command(&["--all"]), 2, &["--regions"]);
    failed(case.command(&["--plot", "map.pdf"]), 2, &["map.pdf", ".svg", ".png"]);
    failed(case.command(&["--plot", "map"]), 2, &[".svg", ".png"]);
    let nowhere = case.in_folder("no").join("map.svg");
    failed(
        case.command(&["--plot", text_of(&nowhere)]),
        1,
        &["map.svg", "cannot write"],
    );
    for (name, what) in [("missing.tiles", "cannot read"), ("points.txt", "points.txt")] {
        let file = case.in_folder(name);
        failed(
            command(case.folder.path(), &["inspect", text_of(&file)]),
            1,
            &[name, what],
        );
    }
}

#[test]
fn a_damaged_file_is_an_error_and_gives_no_map() {
    let case = Case::grid();
    let sound = fs::read(&case.file).unwrap();
    let map = case.in_folder("map.svg");
    let mut refused = 0;
    for at in (0..sound.len()).step_by(sound.len() / 40) {
        let mut damaged = sound.clone();
        damaged[at] ^= 0x41;
        fs::write(&case.file, damaged).unwrap();
        let _ = fs::remove_file(&map);
        let output = case
            .command(&["--tile", "1", "--plot", text_of(&map)])
            .output()
            .unwrap();
        // Damage of padding or of one of the two superblocks has no effect.
        if output.status.success() {
            assert!(map.exists());
            continue;
        }
        assert_eq!(output.status.code(), Some(1), "byte {at}");
        assert!(errors(&output).contains("map.tiles"), "byte {at}");
        assert!(!map.exists());
        refused += 1;
    }
    assert!(refused > 5, "{refused}");
    for length in [0, 100, 5000, 8192, sound.len() - 1] {
        fs::write(&case.file, &sound[..length]).unwrap();
        println!("{length} bytes");
        complaint(case.command(&["--plot", text_of(&map)]), 1);
    }
}

/// A wall passes vertices of a grid, and begins and ends between them.
#[test]
fn tile_prints_what_holds_vertices_and_edges() {
    let folder = TempDir::new().unwrap();
    let grid = (0..25).map(|i| format!("{} {}\n", i % 5, i / 5));
    fs::write(folder.path().join("a.txt"), grid.clone().take(10).collect::<String>()).unwrap();
    fs::write(folder.path().join("b.txt"), grid.skip(10).collect::<String>()).unwrap();
    fs::write(folder.path().join("walls.txt"), "0.5 2 3.5 2\n").unwrap();
    crate::support::run(
        folder.path(),
        "build a.txt b.txt --walls walls.txt -o map.tiles --quiet",
    );
    let json = crate::support::json(folder.path(), "inspect map.tiles --tile 0 --json");
    let firsts: Vec<_> = [0, 1].map(|at| json["sources"][at]["first_record"].clone()).to_vec();
    assert_eq!(firsts, [0, 10]);
    assert_eq!(json["added_vertices"], 2);
    let vertices = json["tile"]["vertex_list"].as_array().unwrap();
    let others = vertices.iter().filter(|vertex| vertex["input_point"] == false);
    let mut others: Vec<_> = others.map(|vertex| vertex["x"].as_f64().unwrap()).collect();
    others.sort_by(f64::total_cmp);
    assert_eq!(others, [0.5, 3.5]);
    let lines = json["tile"]["line_list"].as_array().unwrap();
    assert_eq!(lines.len(), 4);
    for line in lines {
        assert_eq!((&line["line"], &line["kind"]), (&0.into(), &"wall".into()));
        let x = |end: usize| {
            vertices[line["edge"][end][1].as_u64().unwrap() as usize]["x"]
                .as_f64()
                .unwrap()
        };
        for (key, x) in [("begins", x(0)), ("ends", x(1))] {
            assert_eq!(line[key].as_bool().unwrap(), x == 0.5 || x == 3.5, "{line}");
        }
    }
    let text = crate::support::run(folder.path(), "inspect map.tiles --tile 0");
    let blocks: Vec<Vec<_>> = text.split("\n\n").map(|block| block.lines().collect()).collect();
    assert!(blocks[1][0].ends_with("input point"));
    assert!(blocks[3][0].contains("begins") && blocks[3].len() == 5);
    let yes = blocks[3]
        .iter()
        .flat_map(|line| line.split_whitespace())
        .filter(|word| *word == "yes");
    assert_eq!(yes.count(), 2);
}
