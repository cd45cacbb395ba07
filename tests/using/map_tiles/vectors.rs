//! Vector tiles, read by a crate that has nothing to do with the one that writes them.

use std::collections::{BTreeMap, BTreeSet};

use delaunay_tiles::map_tiles::{GridKind, Layer, MapSource, TileCoord};
use delaunay_tiles::{Point, Rect};
use futures::TryStreamExt;
use geo_types::Geometry;
use mvt_reader::Reader;
use mvt_reader::feature::{Feature, Value};

use super::{Plan, draw, hills, tile, tiles_of};
use crate::support::runtime;

type Unit = [i64; 2];

/// The features of each layer.
fn layers(bytes: &[u8]) -> BTreeMap<String, Vec<Feature<i32>>> {
    let reader = Reader::new(bytes.to_vec()).unwrap();
    let all = reader.get_layer_metadata().unwrap();
    assert!(all.iter().all(|layer| layer.extent == 4096 && layer.version == 2));
    all.iter()
        .map(|layer| (layer.name.clone(), reader.get_features_as(layer.layer_index).unwrap()))
        .collect()
}

async fn decoded(source: &MapSource, at: TileCoord) -> BTreeMap<String, Vec<Feature<i32>>> {
    layers(&draw(source, GridKind::Native, Layer::Mesh, at).await.bytes)
}

/// The exterior rings of a feature, without the corner that closes them.
fn rings(feature: &Feature<i32>) -> Vec<Vec<Unit>> {
    let open = |ring: &geo_types::LineString<i32>| -> Vec<Unit> {
        let corners: Vec<Unit> = ring.0.iter().map(|c| [c.x.into(), c.y.into()]).collect();
        assert!(corners.len() >= 4 && corners.first() == corners.last());
        corners[1..].to_vec()
    };
    match feature.get_geometry() {
        Geometry::MultiPolygon(all) => all
            .0
            .iter()
            .map(|one| {
                assert!(one.interiors().is_empty());
                open(one.exterior())
            })
            .collect(),
        Geometry::Polygon(one) => vec![open(one.exterior())],
        other => panic!("{other:?}"),
    }
}

/// Twice the area of a ring, positive if it is clockwise on a screen.
fn doubled_area(ring: &[Unit]) -> i64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum()
}

/// A ring from its smallest corner on.
fn from_smallest(mut ring: Vec<Unit>) -> Vec<Unit> {
    let first = (0..ring.len()).min_by_key(|&i| ring[i]).unwrap();
    ring.rotate_left(first);
    ring
}

fn number(feature: &Feature<i32>, name: &str) -> f64 {
    match feature.properties.as_ref().unwrap().get(name).unwrap() {
        Value::UInt(v) => *v as f64,
        Value::Float(v) => f64::from(*v),
        Value::Double(v) => *v,
        other => panic!("{name}: {other:?}"),
    }
}

/// The position of a point in a tile, rounded as a whole zoom is.
fn unit(source: &MapSource, at: TileCoord, p: Point) -> Unit {
    let square = source.grid(GridKind::Native).unwrap().square();
    let all = 4096.0 * f64::from(1u32 << at.z());
    let side = square.size().0;
    let [x, y] = [(p.x - square.min_x) / side, (square.max_y - p.y) / side].map(|share| (share * all).round() as i64);
    [x - 4096 * i64::from(at.x()), y - 4096 * i64::from(at.y())]
}

#[test]
fn the_triangles_of_a_tile_are_those_of_the_file() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(1200, 41).with_z(hills).tile_vertices(150).build().await;
        let grid = source.grid(GridKind::Native).unwrap();
        let mut compared = 0;
        for at in tiles_of(grid, 3) {
            let found = decoded(&source, at).await;
            let Some(triangles) = found.get("triangles") else {
                continue;
            };
            // The triangles of the file that are wholly inside the tile.
            let inside = |ring: &Vec<Unit>| ring.iter().flatten().all(|v| (0..=4096).contains(v));
            let mut expected = BTreeMap::new();
            let all: Vec<_> = source.reader().triangles_in(Rect::PLANE).try_collect().await.unwrap();
            for triangle in all {
                let [a, b, c] = triangle.vertices.map(|vertex| unit(&source, at, vertex.point));
                let ring = from_smallest(vec![a, c, b]);
                if inside(&ring) && doubled_area(&ring) > 0 {
                    let z = triangle.vertices.map(|vertex| hills(vertex.point));
                    expected.insert(ring, z.iter().copied().fold(f64::MIN, f64::max));
                }
            }
            let mut seen = BTreeSet::new();
            for feature in triangles {
                let [ring] = &rings(feature)[..] else {
                    panic!("a triangle has one ring")
                };
                assert!(doubled_area(ring) > 0);
                let ring = from_smallest(ring.clone());
                if let Some(z) = expected.get(&ring) {
                    assert!((number(feature, "zmax") - z).abs() < 1e-4);
                    assert!(number(feature, "zmin") <= number(feature, "zmax"));
                    assert!(seen.insert(ring));
                }
            }
            assert_eq!(seen.len(), expected.len(), "{at}");
            compared += seen.len();
        }
        assert!(compared > 500, "{compared}");
    });
}

#[test]
fn triangles_cover_a_tile_once_and_neighbours_agree_in_the_margin() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(1500, 42).with_z(hills).tile_vertices(200).build().await;
        // A tile inside the hull, with its margin.
        let (west, east) = (tile(3, 2, 5), tile(3, 3, 5));
        let all = |layers: &BTreeMap<String, Vec<Feature<i32>>>| -> Vec<Vec<Unit>> {
            layers["triangles"].iter().flat_map(rings).map(from_smallest).collect()
        };
        let [west, east] = [decoded(&source, west).await, decoded(&source, east).await].map(|layers| all(&layers));
        let side = 4096 + 2 * 64;
        assert_eq!(west.iter().map(|ring| doubled_area(ring)).sum::<i64>(), 2 * side * side);
        // Triangles that neither tile has cut.
        let common = |rings: Vec<Vec<Unit>>, moved: i64| -> BTreeSet<Vec<Unit>> {
            let rings = rings
                .into_iter()
                .map(|ring| ring.into_iter().map(|[x, y]| [x + moved, y]).collect::<Vec<_>>());
            let inner = |ring: &Vec<Unit>| {
                ring.iter()
                    .all(|[x, y]| (4033..=4159).contains(x) && (-63..=4159).contains(y))
            };
            rings.filter(inner).collect()
        };
        let (a, b) = (common(west, 0), common(east, 4096));
        assert!(a == b, "{a:?} {b:?}");
    });
}

#[test]
fn lines_holes_sites_and_cells_are_those_of_the_file() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(1500, 43)
            .with_z(hills)
            .with_town()
            .tile_vertices(300)
            .build()
            .await;
        let at = tile(0, 0, 0);
        let found = decoded(&source, at).await;
        let grid = source.grid(GridKind::Native).unwrap();
        let scale = 4096.0 / grid.square().size().0;
        // Sixteen obstacles, each a region of its own.
        assert_eq!(found["holes"].len(), 16);
        let corners = [(0.0, 0.0), (9.7, 1.3), (8.1, 9.9), (-1.9, 8.2)];
        let next = corners.iter().cycle().skip(1);
        let area: f64 = corners
            .iter()
            .zip(next)
            .map(|(a, b)| (a.0 * b.1 - b.0 * a.1) / 2.0)
            .sum();
        for hole in &found["holes"] {
            let units: i64 = rings(hole).iter().map(|ring| doubled_area(ring)).sum();
            assert!(
                (units as f64 / 2.0 / scale / scale - area).abs() < 0.02 * area,
                "{units}"
            );
        }
        let kinds = found["lines"]
            .iter()
            .map(|line| line.properties.as_ref().unwrap()["kind"].clone());
        let count = |kind: &str| {
            kinds
                .clone()
                .filter(|found| *found == Value::String(kind.to_owned()))
                .count()
        };
        // Rings are joined, and so are the parts of the break line and of the wall.
        assert_eq!([count("obstacle"), count("break"), count("wall")], [16, 1, 1]);
        let sites: Vec<f64> = found["sites"].iter().map(|site| number(site, "number")).collect();
        assert_eq!(sites, [0.0, 1.0]);
        let vertices: f64 = found["cells"].iter().map(|cell| number(cell, "vertices")).sum();
        assert_eq!(vertices, source.reader().metadata().vertices as f64);
        let cells: i64 = found["cells"]
            .iter()
            .flat_map(rings)
            .map(|ring| doubled_area(&ring))
            .sum();
        assert!((cells as f64 / 2.0 / scale / scale - 1e4).abs() < 20.0, "{cells}");
        assert_eq!(number(&found["info"][0], "level"), 0.0);
    });
}

#[test]
fn the_same_vectors_come_of_all_tile_sizes() {
    let bytes = |tile_vertices: usize| {
        runtime().block_on(async {
            let (_scratch, source) = Plan::square(1500, 44)
                .with_z(hills)
                .tile_vertices(tile_vertices)
                .build()
                .await;
            let mut all = Vec::new();
            for at in tiles_of(source.grid(GridKind::Native).unwrap(), 2) {
                let layers = decoded(&source, at).await;
                all.push(
                    layers
                        .get("triangles")
                        .map(|layer| layer.iter().flat_map(rings).collect::<Vec<_>>()),
                );
            }
            all
        })
    };
    assert!(bytes(150) == bytes(4000));
}
