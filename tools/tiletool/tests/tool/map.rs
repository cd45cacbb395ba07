//! The pixels of maps: heights, and what is drawn over them.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use crate::support::{json, run};
use resvg::tiny_skia::Pixmap;
use tempfile::TempDir;

/// More points than a map draws line by line: nearly a grid, in a rectangle of 2000 × 1000.
const COLUMNS: u32 = 260;
const ROWS: u32 = 130;

fn points(z: impl Fn(f64, f64) -> Option<f64>) -> String {
    let mut text = String::new();
    for i in 0..COLUMNS * ROWS {
        let (column, row) = (i % COLUMNS, i / COLUMNS);
        // The border is straight, so that the bounds are known.
        let moved = |at: u32, last: u32, by: u32| {
            if at == 0 || at == last {
                0.0
            } else {
                f64::from(by % 7) / 10.0
            }
        };
        let x = (f64::from(column) + moved(column, COLUMNS - 1, i * 5 + 1)) * 2000.0 / f64::from(COLUMNS - 1);
        let y = (f64::from(row) + moved(row, ROWS - 1, i * 3 + 2)) * 1000.0 / f64::from(ROWS - 1);
        let z = z(x, y).map_or(String::new(), |z| format!(" {z}"));
        writeln!(text, "{x} {y}{z}").unwrap();
    }
    text
}

/// A drawn map of a rectangle of 2000 × 1000.
struct Drawn {
    pixels: Pixmap,
    frame: [f64; 4],
}

impl Drawn {
    fn new(folder: &Path, file: &str) -> Self {
        run(folder, &format!("inspect {file} --plot map.svg"));
        run(folder, &format!("inspect {file} --plot map.png"));
        let svg = fs::read_to_string(folder.join("map.svg")).unwrap();
        let frame = svg.split("<clipPath id=\"frame\"><rect ").nth(1).unwrap();
        let frame = ["x=\"", " y=\"", "width=\"", "height=\""].map(|name| {
            let value = frame.split(name).nth(1).unwrap().split('"').next().unwrap();
            value.parse::<f64>().unwrap()
        });
        let pixels = Pixmap::decode_png(&fs::read(folder.join("map.png")).unwrap()).unwrap();
        Self { pixels, frame }
    }

    /// Returns the colour at a point of the plane.
    fn at(&self, x: f64, y: f64) -> [u8; 3] {
        let [left, top, width, height] = self.frame;
        // The bounds are 24 pixels inside of the frame, and wider than high.
        let scale = (width - 48.0) / 2000.0;
        let (x, y) = (
            left + width / 2.0 + (x - 1000.0) * scale,
            top + height / 2.0 - (y - 500.0) * scale,
        );
        let pixel = self.pixels.pixel(x as u32, y as u32).unwrap();
        [pixel.red(), pixel.green(), pixel.blue()]
    }

    /// Returns the mean luminance of the points with `x` in the middle of the map.
    fn luminance(&self, x: f64) -> f64 {
        let ys = (300..700).step_by(2);
        let count = ys.len() as f64;
        let of = |[r, g, b]: [u8; 3]| 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
        let sum = |x: f64| ys.clone().map(|y| of(self.at(x, f64::from(y)))).sum::<f64>();
        (0..20).map(|i| sum(x + f64::from(i))).sum::<f64>() / count / 20.0
    }
}

#[test]
fn a_plane_that_rises_gets_lighter() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    for (sign, file) in [(0.01, "east.tiles"), (-0.01, "west.tiles")] {
        fs::write(folder.join("points.txt"), points(|x, _| Some(100.0 + sign * x))).unwrap();
        // The border between two tiles would be drawn.
        let build = format!("build points.txt -o {file} --tile-vertices 65536 --quiet");
        run(folder, &build);
        let drawn = Drawn::new(folder, file);
        let luminances: Vec<_> = (1..19).map(|i| drawn.luminance(100.0 * f64::from(i))).collect();
        let rises = luminances.windows(2).all(|pair| sign * (pair[1] - pair[0]) > 0.0);
        assert!(rises, "{file}: {luminances:?}");
        let svg = fs::read_to_string(folder.join("map.svg")).unwrap();
        // The heights of the colours, the bar, and no sample.
        for text in [
            ">z<",
            "id=\"heights\"",
            ">200 coordinate units<",
            "The whole Delaunay triangulation of 33 800 vertices",
        ] {
            assert!(svg.contains(text), "{text}");
        }
        let [low, high] = if sign > 0.0 {
            [">100.0<", ">120.0<"]
        } else {
            [">80.0<", ">100.0<"]
        };
        assert!(svg.contains(low) && svg.contains(high), "{low} {high}");
    }
}

#[test]
fn a_large_map_shows_each_hole_and_each_line() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    for z in [None, Some(7.0)] {
        fs::write(folder.join("points.txt"), points(|_, _| z)).unwrap();
        fs::write(folder.join("wall.txt"), "300 200 1500 200").unwrap();
        fs::write(folder.join("break.txt"), "300 300 1500 300").unwrap();
        fs::write(
            folder.join("house.geojson"),
            r#"{"type":"Polygon","coordinates":[[[800,500],[1100,500],[1100,800],[800,800],[800,500]]]}"#,
        )
        .unwrap();
        run(
            folder,
            "build points.txt --walls wall.txt --segments break.txt --obstacles house.geojson --crs EPSG:25832 -o t.tiles \
             --tile-vertices 4000 --missing-z zero --quiet --force",
        );
        assert!(json(folder, "inspect t.tiles --json")["triangles"].as_u64().unwrap() > 60_000);
        let drawn = Drawn::new(folder, "t.tiles");
        // Some pixels are under the sides of cells.
        let share = |points: Vec<(f64, f64)>, colour: [u8; 3], most: u8| {
            let close = |found: [u8; 3]| found.iter().zip(colour).all(|(&a, b)| a.abs_diff(b) < most);
            points.iter().filter(|&&(x, y)| close(drawn.at(x, y))).count() as f64 / points.len() as f64
        };
        let along = |y: f64| (310..1490).step_by(10).map(|x| (f64::from(x), y)).collect::<Vec<_>>();
        assert!(share(along(200.0), [0x4a, 0x2c, 0x1d], 40) > 0.9, "wall");
        assert!(share(along(300.0), [0x2f, 0x7d, 0x4f], 40) > 0.9, "break line");
        let square = |x: f64| {
            let all = (0..400).map(|i| (x + f64::from(i % 20 * 14), 510.0 + f64::from(i / 20 * 14)));
            all.collect::<Vec<_>>()
        };
        let hole = [0xcf, 0xd3, 0xd6];
        assert!(share(square(810.0), hole, 16) > 0.9, "hole");
        assert!(share(square(1210.0), hole, 16) < 0.5, "no hole");
        let svg = fs::read_to_string(folder.join("map.svg")).unwrap();
        for text in [">holes<", ">walls<", ">break lines<", ">200 m<"] {
            assert!(svg.contains(text), "{text}");
        }
    }
}
