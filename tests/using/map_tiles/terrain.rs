//! Terrain meshes, read by a decoder that follows the specification of quantized-mesh-1.0.

use std::collections::{BTreeMap, BTreeSet};

use delaunay_tiles::map_tiles::{DrawLimits, GridKind, MapSource, NoGrid, TerrainCoord};
use delaunay_tiles::terrain::Surface;
use delaunay_tiles::{Point, Rect};

use super::{Plan, hills};
use crate::support::runtime;

/// A terrain tile.
struct Mesh {
    centre: [f64; 3],
    range: [f64; 2],
    sphere: ([f64; 3], f64),
    occlusion: [f64; 3],
    /// u, v and height of each vertex, up to 32767.
    vertices: Vec<[u16; 3]>,
    triangles: Vec<[usize; 3]>,
    /// West, south, east, north.
    edges: [Vec<usize>; 4],
}

/// Bytes that are read one after the other.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (first, rest) = self.0.split_first_chunk().unwrap();
        self.0 = rest;
        *first
    }

    fn f64(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }

    fn three(&mut self) -> [f64; 3] {
        [self.f64(), self.f64(), self.f64()]
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.take())
    }

    fn deltas(&mut self, count: usize) -> Vec<u16> {
        let mut value = 0i32;
        let next = |_| {
            let coded = i32::from(self.u16());
            value += (coded >> 1) ^ -(coded & 1);
            u16::try_from(value).unwrap()
        };
        (0..count).map(next).collect()
    }
}

fn decode(bytes: &[u8]) -> Mesh {
    let mut bytes = Bytes(bytes);
    let centre = bytes.three();
    let range = [f32::from_le_bytes(bytes.take()), f32::from_le_bytes(bytes.take())].map(f64::from);
    let sphere = (bytes.three(), bytes.f64());
    let occlusion = bytes.three();
    let count = bytes.u32() as usize;
    assert!(count < 65_536, "indices of 16 bits");
    let [u, v, height] = [(); 3].map(|()| bytes.deltas(count));
    let mut highest = 0u16;
    let indices = bytes.u32() as usize * 3;
    let mut index = |_| {
        let code = bytes.u16();
        let index = highest - code;
        highest += u16::from(code == 0);
        usize::from(index)
    };
    let indices: Vec<usize> = (0..indices).map(&mut index).collect();
    let edges = [(); 4].map(|()| {
        let count = bytes.u32();
        (0..count).map(|_| usize::from(bytes.u16())).collect()
    });
    assert!(bytes.0.is_empty());
    Mesh {
        centre,
        range,
        sphere,
        occlusion,
        vertices: (0..count).map(|i| [u[i], v[i], height[i]]).collect(),
        triangles: indices.chunks(3).map(|c| [c[0], c[1], c[2]]).collect(),
        edges,
    }
}

impl Mesh {
    fn height(&self, vertex: usize) -> f64 {
        self.range[0] + (self.range[1] - self.range[0]) * f64::from(self.vertices[vertex][2]) / 32767.0
    }

    /// The heights by place along a side.
    fn side(&self, side: usize) -> BTreeMap<u16, u16> {
        let along = 1 - side % 2;
        self.edges[side]
            .iter()
            .map(|&i| (self.vertices[i][along], self.vertices[i][2]))
            .collect()
    }
}

async fn terrain(source: &MapSource, z: u8, x: u32, y: u32) -> Mesh {
    let at = TerrainCoord::new(z, x, y).unwrap();
    decode(&source.terrain(at, DrawLimits::default()).await.unwrap().bytes)
}

/// Hills of a degree by a degree.
fn plan() -> Plan {
    let mut plan = Plan::square(6000, 51).with_z(hills).tile_vertices(500).crs("EPSG:4326");
    plan.points
        .iter_mut()
        .for_each(|p| *p = Point::new(10.0 + p.x / 100.0, 46.0 + p.y / 100.0));
    plan
}

fn ecef(lon: f64, lat: f64, height: f64) -> [f64; 3] {
    let (a, f) = (6_378_137.0, 1.0 / 298.257_223_563);
    let e2 = f * (2.0 - f);
    let (lon, lat) = (lon.to_radians(), lat.to_radians());
    let n = a / (1.0 - e2 * lat.sin() * lat.sin()).sqrt();
    [
        (n + height) * lat.cos() * lon.cos(),
        (n + height) * lat.cos() * lon.sin(),
        (n * (1.0 - e2) + height) * lat.sin(),
    ]
}

#[test]
fn a_terrain_tile_is_a_whole_mesh() {
    runtime().block_on(async {
        let (_scratch, source) = plan().build().await;
        let facts = source.terrain_facts().unwrap();
        for z in [0, 3, 7, 9, facts.max_zoom + 3] {
            let at = |degrees: f64, start: f64| ((degrees + start) / (180.0 / f64::from(1u32 << z))) as u32;
            let (x, y) = (at(10.4, 180.0), at(46.6, 90.0));
            let mesh = terrain(&source, z, x, y).await;
            let place = |i: usize| [0, 1].map(|axis| i64::from(mesh.vertices[i][axis]));
            let area = |[a, b, c]: [usize; 3]| {
                let [a, b, c] = [a, b, c].map(place);
                (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            };
            assert!(mesh.triangles.iter().all(|&triangle| area(triangle) > 0));
            assert_eq!(
                mesh.triangles.iter().map(|&triangle| area(triangle)).sum::<i64>(),
                2 * 32767 * 32767
            );
            // All vertices on a side are in its list, and each side has its corners.
            for (side, (axis, step)) in [(0, 0), (1, 0), (0, 32767), (1, 32767)].into_iter().enumerate() {
                let expected: BTreeSet<usize> = (0..mesh.vertices.len())
                    .filter(|&i| mesh.vertices[i][axis] == step)
                    .collect();
                assert_eq!(expected, mesh.edges[side].iter().copied().collect());
                assert!(mesh.side(side).contains_key(&0) && mesh.side(side).contains_key(&32767));
            }
            // The sphere has all vertices.
            let bounds = TerrainCoord::new(z, x, y).unwrap().bounds();
            let side = bounds.size().0;
            for i in 0..mesh.vertices.len() {
                let [u, v] = place(i).map(|step| step as f64 / 32767.0 * side);
                let p = ecef(bounds.min_x + u, bounds.min_y + v, mesh.height(i));
                let far = (0..3).map(|k| (p[k] - mesh.sphere.0[k]).powi(2)).sum::<f64>().sqrt();
                assert!(far <= mesh.sphere.1 * 1.000_001, "{z} {far} {}", mesh.sphere.1);
            }
            let middle = ecef(bounds.min_x + side / 2.0, bounds.min_y + side / 2.0, 0.0);
            assert!((0..3).all(|k| (middle[k] - mesh.centre[k]).abs() < 1000.0));
            let far = mesh.occlusion.iter().map(|v| v * v).sum::<f64>().sqrt();
            assert!(far >= 1.0 - 1e-9, "{far}");
        }
    });
}

#[test]
fn neighbours_have_the_same_vertices_where_they_meet() {
    runtime().block_on(async {
        let (_scratch, source) = plan().build().await;
        let mut heights = BTreeSet::new();
        for z in [8, 10, 12] {
            let at = |degrees: f64, start: f64| ((degrees + start) / (180.0 / f64::from(1u32 << z))) as u32;
            let (x, y) = (at(10.5, 180.0), at(46.3, 90.0));
            let here = terrain(&source, z, x, y).await;
            let east = terrain(&source, z, x + 1, y).await;
            let north = terrain(&source, z, x, y + 1).await;
            assert_eq!(here.side(2), east.side(0));
            assert_eq!(here.side(3), north.side(1));
            assert_eq!((here.range, here.range), (east.range, north.range));
            heights.extend(here.side(2).into_values());
        }
        assert!(heights.len() > 20, "{}", heights.len());
    });
}

#[test]
fn the_heights_of_a_terrain_tile_are_those_of_the_surface_in_metres() {
    runtime().block_on(async {
        // Feet: EPSG:2992 with z in the same unit.
        let foot = 0.3048;
        let mut feet = Plan::square(3000, 52).with_z(hills).crs("EPSG:2992");
        feet.points
            .iter_mut()
            .for_each(|p| *p = Point::new(636_000.0 + 20.0 * p.x, 848_000.0 + 20.0 * p.y));
        let (_scratch, source) = feet.build().await;
        let facts = source.terrain_facts().unwrap();
        let grid = source.grid(GridKind::WebMercatorQuad).unwrap();
        let z = facts.max_zoom;
        let side = 180.0 / f64::from(1u32 << z);
        let (lon, lat) = (
            (facts.bounds.min_x + facts.bounds.max_x) / 2.0,
            (facts.bounds.min_y + facts.bounds.max_y) / 2.0,
        );
        let at = TerrainCoord::new(z, ((lon + 180.0) / side) as u32, ((lat + 90.0) / side) as u32).unwrap();
        let mesh = decode(&source.terrain(at, DrawLimits::default()).await.unwrap().bytes);
        let bounds = at.bounds();
        let (mut compared, mut outside) = (0, 0);
        for (i, &[u, v, _]) in mesh.vertices.iter().enumerate() {
            let lon = bounds.min_x + side * f64::from(u) / 32767.0;
            let lat = bounds.min_y + side * f64::from(v) / 32767.0;
            let mercator = [
                0.5 + lon / 360.0,
                0.5 - lat.to_radians().sin().atanh() / std::f64::consts::TAU,
            ];
            let p = grid.point_at(mercator).unwrap();
            match source.reader().surface_z(p.x, p.y, Surface::default()).await.unwrap() {
                Some(expected) => {
                    // A place is rounded by half a step, on slopes of less than one in ten.
                    let most = (mesh.range[1] - mesh.range[0]) / 32767.0 + 0.05;
                    assert!(
                        (mesh.height(i) - expected * foot).abs() <= most,
                        "{u} {v} {} {expected}",
                        mesh.height(i)
                    );
                    compared += 1;
                }
                None => {
                    outside += 1;
                    assert_eq!(mesh.height(i), mesh.range[0]);
                }
            }
        }
        assert!(compared > 200, "{compared} {outside}");
    });
}

#[test]
fn the_tiles_that_are_available_are_those_that_have_something() {
    runtime().block_on(async {
        let (_scratch, source) = plan().build().await;
        let facts = source.terrain_facts().unwrap();
        assert!(facts.bounds.contains(Point::new(10.5, 46.5)) && facts.bounds.size().0 < 1.2);
        assert_eq!(facts.available.len(), usize::from(facts.max_zoom) + 1);
        for (z, range) in (0u8..).zip(&facts.available) {
            let corner = TerrainCoord::new(z, range.start_x, range.start_y).unwrap();
            let last = TerrainCoord::new(z, range.end_x, range.end_y).unwrap();
            let all = Rect::new(
                corner.bounds().min_x,
                corner.bounds().min_y,
                last.bounds().max_x,
                last.bounds().max_y,
            );
            assert!(all.min_x <= facts.bounds.min_x && all.max_x >= facts.bounds.max_x);
            let drawn = source.terrain(corner, DrawLimits::default()).await.unwrap();
            assert!(!drawn.is_empty());
            if let Some(beside) = TerrainCoord::new(z, range.end_x + 1, range.end_y) {
                assert!(
                    source.terrain(beside, DrawLimits::default()).await.unwrap().is_empty(),
                    "{z}"
                );
            }
        }
        // Cesium starts with both tiles of zoom 0.
        assert_eq!((facts.available[0].start_x, facts.available[0].end_x), (0, 1));
    });
}

#[test]
fn a_file_that_is_not_known_to_be_on_earth_has_no_terrain() {
    runtime().block_on(async {
        let (_scratch, source) = Plan::square(60, 53).with_z(hills).build().await;
        assert_eq!(source.terrain_facts().unwrap_err(), NoGrid::NoCrs);
    });
}
