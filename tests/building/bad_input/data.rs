//! Point sets from other projects. Each is built in small and large tiles by all engines, verified,
//! and compared with the in-core reference.

use std::fs;

use delaunay_tiles::BuildOptions;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::mesh::EngineKind;

use crate::support::test_data::{data, shared};
use crate::support::{built, reference, runtime};

/// Returns all numbers in a text, with any separators.
fn numbers(text: &str) -> Vec<f64> {
    let separators = |c: char| !(c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '+'));
    text.split(separators)
        .filter(|word| !word.is_empty())
        .map(|word| word.parse().unwrap())
        .collect()
}

fn check(name: &str, points: &[Point], tile_sizes: &[usize]) {
    let expected = reference(EngineKind::Native, points);
    for &engine in EngineKind::ALL {
        assert_eq!(reference(engine, points), expected, "{name}, {engine}");
        for &tile_vertices in tile_sizes {
            let options = BuildOptions::default()
                .tile_vertices(tile_vertices)
                .engine(engine)
                .threads(2);
            runtime().block_on(async {
                let (_scratch, reader) = built(points, options).await;
                if let Err(error) = reader.verify(true).await {
                    panic!("{name}, {engine}, tiles of {tile_vertices}: {error}");
                }
                assert_eq!(
                    reader.recompute_digest().await.unwrap(),
                    expected,
                    "{name}, {engine}, tiles of {tile_vertices}"
                );
            });
        }
    }
}

#[test]
fn delaunator_test_sets_give_one_triangulation_in_every_engine() {
    let mut files: Vec<_> = fs::read_dir(data("delaunator"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "json"));
    files.sort();
    assert_eq!(files.len(), 16);
    for path in files {
        let numbers = numbers(&fs::read_to_string(&path).unwrap());
        assert_eq!(numbers.len() % 2, 0, "{}", path.display());
        let points: Vec<Point> = numbers.chunks(2).map(|xy| Point::new(xy[0], xy[1])).collect();
        let valid: Vec<Point> = points.iter().copied().filter(|p| p.is_valid()).collect();
        let name = path.file_name().unwrap().to_string_lossy();
        println!("{name}: {} points, {} of them valid", points.len(), valid.len());
        check(&name, &valid, &[8, 65536]);
    }
}

/// The coordinates' magnitudes range from 1e-6 to 1e35. All points of a file form one set here.
///
/// On these sets the bulk load of crate spade leaves a hull that is not convex (17 edges instead of
/// 7, which a computation in fractions confirms). The engine that wraps spade detects this.
#[test]
fn robust_predicates_test_sets_give_one_triangulation_in_every_engine() {
    for name in ["orient2d.txt", "incircle.txt"] {
        let text = fs::read_to_string(data("robust-predicates").join(name)).unwrap();
        let mut points = Vec::new();
        for line in text.lines() {
            let numbers = numbers(line);
            let coordinates = &numbers[1..numbers.len() - 1];
            points.extend(
                coordinates
                    .chunks(2)
                    .map(|xy| Point::new(xy[0], xy[1]))
                    .filter(|p| p.is_valid()),
            );
        }
        println!("{name}: {} points", points.len());
        check(name, &points, &[8, 65536]);
    }
}

/// Elevation grids beside the project, if they are there.
#[test]
fn elevation_grids_give_one_triangulation_in_every_engine() {
    let Some(grids) = shared("dem") else {
        return;
    };
    for path in fs::read_dir(grids)
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "f32le"))
    {
        let about = fs::read_to_string(path.with_extension("json")).unwrap();
        println!("{}", path.display());
        let values: Vec<f32> = fs::read(&path)
            .unwrap()
            .chunks(4)
            .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
            .collect();
        let field = |name: &str| -> f64 {
            let at = about.find(&format!("\"{name}\":")).unwrap();
            numbers(about[at + name.len() + 3..].split([',', '}']).next().unwrap())[0]
        };
        let [x0, y0, dx, dy] = ["x0_cell_centre", "y0_cell_centre_top", "dx", "dy"].map(field);
        let width = field("cols") as usize;
        assert_eq!(values.len(), width * field("rows") as usize);
        let points: Vec<Point> = values
            .iter()
            .enumerate()
            .filter(|(_, z)| z.is_finite())
            .map(|(i, _)| Point::new(x0 + (i % width) as f64 * dx, y0 - (i / width) as f64 * dy))
            .collect();
        check("elevations", &points, &[4096]);
    }
}
