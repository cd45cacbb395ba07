//! What pictures of answers and maps say: signs, names, distances, titles and scales.

use std::fs;

use crate::support::{json, run};
use crate::town::Town;
use tempfile::TempDir;

/// Draws the answer to a query. Returns the SVG.
#[track_caller]
fn drawn(town: &Town, what: &str, args: &[&str]) -> String {
    town.query(what, &[args, &["--plot", "drawn.svg"]].concat());
    fs::read_to_string(town.path("drawn.svg")).unwrap()
}

/// Checks that texts are in a picture, one after the other.
#[track_caller]
fn in_order(svg: &str, texts: &[&str]) {
    let mut rest = svg;
    for text in texts {
        let element = format!(">{text}</text>");
        let Some((_, after)) = rest.split_once(&element) else {
            panic!("{text} is missing, or not after the texts before it: {svg}");
        };
        rest = after;
    }
}

/// Returns the value of an attribute of the last element before a text of the legend.
#[track_caller]
fn of_sign<'a>(svg: &'a str, text: &str, attribute: &str) -> &'a str {
    let before = svg.split(&format!(">{text}</text>")).next().unwrap();
    let sign = before.lines().rev().nth(1).unwrap();
    let value = sign.split(&format!(" {attribute}=\"")).nth(1);
    value.unwrap_or_else(|| panic!("{sign}")).split('"').next().unwrap()
}

const DASHES: &str = "stroke-dasharray=\"70 50\"";
const RING: &str = "fill=\"#fcfbf8\" stroke=\"#a8327a\"";

#[test]
fn a_matrix_tells_starts_from_ends_and_writes_distances_on_paths() {
    let town = Town::new();
    town.write("from.csv", "x,y\n-4,-4\n4,4\n");
    town.write("to.csv", "-4,4\n-2.5,2.5\n");
    let svg = drawn(&town, "matrix", &["--from-file", "from.csv", "--to-file", "to.csv"]);
    // Both known distances are 8; nothing leads into the fence.
    in_order(&svg, &["8", "8", "from", "to", "paths", "not found", "walls"]);
    assert_ne!(of_sign(&svg, "from", "fill"), of_sign(&svg, "to", "fill"));
    assert!(of_sign(&svg, "from", "r") == "3.5" && of_sign(&svg, "to", "height") == "8");
    assert_eq!(svg.matches(DASHES).count(), 1);

    town.write("all.csv", "-4,-4\n4,-4\n4,4\n");
    let svg = drawn(&town, "matrix", &["--batch", "all.csv"]);
    in_order(&svg, &["8", "from and to", "paths"]);
    assert!(!svg.contains(">to<") && !svg.contains(">not found<") && !svg.contains(DASHES));
    // The way there and back is the same.
    assert_eq!(svg.matches(">8</text>").count(), 2);

    let svg = drawn(&town, "matrix", &["--from-file", "from.csv", "--sites"]);
    for name in ["baker", "inner", "far, far", "pump"] {
        assert!(svg.contains(&format!(">{name}</text>")), "{name}");
    }
}

#[test]
fn a_path_that_was_not_found_is_a_dashed_line() {
    let town = Town::new();
    for (to, is_found) in [("1.5,0", true), ("-2.5,2.5", false), ("0,0", false)] {
        let svg = drawn(&town, "path", &["--from", "-2,0", "--to", to]);
        let way = if is_found { "path" } else { "not found" };
        in_order(&svg, &["from", "to", way, "obstacles"]);
        assert_eq!(
            (svg.contains(DASHES), svg.contains(">not found<")),
            (!is_found, !is_found)
        );
    }
    town.write("ways.csv", "-4,-4,-4,4\n-2,0,-2.5,2.5\n-4,-4,4,-4\n");
    let svg = drawn(&town, "path", &["--batch", "ways.csv"]);
    in_order(&svg, &["8", "8", "from", "to", "paths", "not found"]);
}

#[test]
fn sites_have_their_names_and_those_not_found_are_rings() {
    let town = Town::new();
    let svg = drawn(&town, "knn", &["--at", "-4,-3", "-k", "3"]);
    in_order(&svg, &["pump: 4", "from", "sites found", "paths", "other sites"]);
    assert!(!svg.contains(">not found<") && svg.contains(RING));
    // No path leads to `inner`, which is far from the others.
    let svg = drawn(&town, "knn", &["--at", "0,2", "-k", "4"]);
    in_order(&svg, &["baker: 1", "sites found", "paths", "not found"]);
    assert!(svg.contains(">pump: ") && svg.contains(">far, far: ") && !svg.contains(">inner"));
    assert!(svg.contains(RING) && !svg.contains(">other sites<"));
    let svg = drawn(&town, "range", &["--at", "-4,-3", "--radius", "20"]);
    in_order(&svg, &["pump: 4", "sites found", "not found"]);
    // In a batch, a site has no single distance.
    town.write("places.csv", "0,2\n0,2.5\n");
    let svg = drawn(&town, "knn", &["--batch", "places.csv", "-k", "1"]);
    assert_eq!(svg.matches(">baker</text>").count(), 1);
    let svg = drawn(&town, "nearest", &["--at", "0,2", "--vertices"]);
    assert!(svg.contains(">0:") && !svg.contains(RING));
}

#[test]
fn colours_of_pieces_are_those_of_their_nearest_sites() {
    let town = Town::new();
    let line = ["--from", "-4,-3.5", "--to", "4,3.5"];
    let svg = drawn(&town, "along", &line);
    in_order(&svg, &["from", "to", "inside an obstacle", "nearest site", "pump"]);
    let legend = svg.split(">nearest site<").nth(1).unwrap();
    let mut colours = Vec::new();
    for name in ["pump", "baker", "far, far"] {
        let colour = of_sign(legend, name, "stroke");
        assert!(svg.contains(&format!("fill=\"{colour}\" stroke=\"#fff\"")), "{name}");
        assert!(
            svg.contains(&format!("stroke=\"{colour}\" stroke-width=\"50.0\"")),
            "{name}"
        );
        colours.push(colour);
    }
    colours.sort_unstable();
    colours.dedup();
    assert_eq!(colours.len(), 3);
    let svg = drawn(&town, "along", &[&line[..], &["-k", "2"]].concat());
    in_order(&svg, &["nearest sites, nearest first"]);
    // Nothing is reached from inside the fence.
    let svg = drawn(&town, "along", &["--from", "-2.9,2.9", "--to", "-2.1,2.9", "-k", "9"]);
    assert!(!svg.contains(">not found<") && svg.contains(">inner</text>"));
}

#[test]
fn names_do_not_overlap_however_many_there_are() {
    let town = Town::new();
    let points: String = (0..40).map(|i| format!("{},{}\n", i % 8 - 4, i / 8 - 4)).collect();
    town.write("many.csv", points);
    let svg = drawn(&town, "matrix", &["--batch", "many.csv"]);
    let inside = svg
        .split("<g clip-path")
        .nth(1)
        .unwrap()
        .split("from and to")
        .next()
        .unwrap();
    let mut boxes = Vec::new();
    for text in inside.lines().filter(|line| line.contains("paint-order")) {
        let value = |name: &str| -> f64 {
            text.split(name)
                .nth(1)
                .unwrap()
                .split('"')
                .next()
                .unwrap()
                .parse()
                .unwrap()
        };
        let characters = text.split('>').nth(1).unwrap().split('<').next().unwrap().len();
        boxes.push((
            value("x=\""),
            value(" y=\""),
            3.5 * characters as f64,
            value("font-size=\""),
        ));
    }
    assert!((10..780).contains(&boxes.len()), "{}", boxes.len());
    for (i, a) in boxes.iter().enumerate() {
        for b in &boxes[..i] {
            let apart = (a.0 - b.0).abs() >= a.2 + b.2 || (a.1 - b.1).abs() >= 0.9 * a.3;
            assert!(apart, "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_title_is_above_every_picture() {
    let town = Town::new();
    let path = ["query", "path", "town.tiles", "--from", "-4,-4", "--to", "4,4"];
    town.write("a.csv", "-4,-4\n4,4\n");
    for command in [
        &["build", "points.csv", "-o", "again.tiles", "--force"][..],
        &["inspect", "town.tiles"],
        &path,
        &["query", "matrix", "town.tiles", "--batch", "a.csv"],
        &["query", "knn", "town.tiles", "--at", "0,2"],
    ] {
        town.run(0, &[command, &["--plot", "plain.svg"]].concat());
        town.run(
            0,
            &[command, &["--plot", "t.svg", "--title", "Shops & <paths>"]].concat(),
        );
        let [plain, titled] = ["plain.svg", "t.svg"].map(|name| fs::read_to_string(town.path(name)).unwrap());
        let name = if command[0] == "build" {
            "again.tiles"
        } else {
            "town.tiles"
        };
        assert!(plain.contains(&format!(">{name}</text>")), "{command:?}");
        let title = "Shops &amp; &lt;paths&gt;";
        assert!(titled.contains(&format!("<title>{title}</title>")) && titled.contains(&format!(">{title}</text>")));
        assert!(titled.contains(&format!(">{name}  ·  ")), "{command:?}");
        let complaint = town.run(2, &[command, &["--title", "Shops"]].concat());
        assert!(complaint.contains("--plot"), "{complaint}");
        town.run(2, &[command, &["--plot", "t.svg", "--title", ""]].concat());
    }
}

#[test]
fn every_picture_has_a_scale_with_the_unit() {
    let town = Town::new();
    town.write("a.csv", "-4,-4\n4,4\n");
    for (crs, unit) in [
        (None, "coordinate units"),
        (Some("EPSG:25832"), "m"),
        (Some("EPSG:4326"), "degrees"),
    ] {
        let crs = crs.map_or(Vec::new(), |crs| vec!["--crs", crs]);
        let build = [
            "build",
            "points.csv",
            "--obstacles",
            "houses.geojson",
            "--sites",
            "shops.csv",
            "-o",
            "town.tiles",
        ];
        town.run(0, &[&build[..], &["--force", "--plot", "drawn.svg"], &crs].concat());
        let mut all = vec![fs::read_to_string(town.path("drawn.svg")).unwrap()];
        town.run(0, &["inspect", "town.tiles", "--plot", "drawn.svg"]);
        all.push(fs::read_to_string(town.path("drawn.svg")).unwrap());
        for (what, args) in [
            ("locate", &["--at", "0,0"][..]),
            ("nearest", &["--at", "0,3"]),
            ("knn", &["--at", "-4,-3"]),
            ("range", &["--at", "0,2", "--radius", "3"]),
            ("path", &["--from", "-2,0", "--to", "0,0"]),
            ("along", &["--from", "-4,-3.5", "--to", "4,3.5"]),
            ("matrix", &["--batch", "a.csv"]),
        ] {
            all.push(drawn(&town, what, args));
        }
        for svg in all {
            // One is singular.
            let unit = unit.trim_end_matches('s');
            let ends = [format!(" {unit}</text>"), format!(" {unit}s</text>")];
            let is_scale = |line: &&str| ends.iter().any(|end| line.ends_with(end)) && !line.contains('·');
            assert!(svg.lines().any(|line| is_scale(&line)), "{unit}: {svg}");
        }
    }
}

/// Squares of a side of 1 in rows, and a square of a side of 100 beside them.
fn islands(count: u32) -> String {
    let square = |x: u32, y: u32, side: u32| {
        let (u, v) = (x + side, y + side);
        format!("[[[{x},{y}],[{u},{y}],[{u},{v}],[{x},{v}],[{x},{y}]]]")
    };
    let small = (0..count).map(|i| square(200 + i % 100 * 3, i / 100 * 3, 1));
    let all: Vec<_> = small.chain([square(0, 0, 100)]).collect();
    format!("{{\"type\":\"MultiPolygon\",\"coordinates\":[{}]}}", all.join(","))
}

/// Returns the widths of lines of a colour, in units of a tenth of a pixel, the widest first.
fn widths(svg: &str, colour: &str) -> Vec<f64> {
    let group = svg.split("<g transform").nth(1).unwrap().split("</g>").next().unwrap();
    let start = format!("stroke=\"{colour}\" stroke-width=\"");
    let parts = group.split(&start).skip(1);
    parts
        .map(|part| part.split('"').next().unwrap().parse().unwrap())
        .collect()
}

#[test]
fn lines_are_thin_where_there_are_many_and_around_what_is_small() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let wall = "#4a2c1d";
    let mut widest = Vec::new();
    for count in [1, 1000] {
        fs::write(folder.join("islands.geojson"), islands(count)).unwrap();
        run(
            folder,
            "build --obstacles islands.geojson -o i.tiles --quiet --force --plot map.svg",
        );
        let map = fs::read_to_string(folder.join("map.svg")).unwrap();
        run(folder, "query path i.tiles --from=-10,-10 --to 510,110 --plot path.svg");
        let path = fs::read_to_string(folder.join("path.svg")).unwrap();
        for svg in [&map, &path] {
            let widths = widths(svg, wall);
            assert!(
                widths.len() >= 2 && widths.windows(2).all(|pair| pair[0] > pair[1]),
                "{widths:?}"
            );
            widest.push(widths[0]);
        }
    }
    assert!(widest[2] < widest[0] && widest[3] <= widest[1], "{widest:?}");
    assert!(json(folder, "inspect i.tiles --json")["triangles"].as_u64().unwrap() < 60_000);
}
