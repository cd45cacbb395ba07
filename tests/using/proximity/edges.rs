//! The CDT distance is that of Dijkstra's search on the triangles in memory, by wedges. Points that
//! are inserted for a query have the distances that they have as vertices of a file.

use std::collections::HashMap;
use std::fs;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{PathOutcome, QueryError, QueryOptions};
use delaunay_tiles::store::{LineKind, TileReader};
use futures::TryStreamExt;
use proptest::prelude::*;

use crate::proximity::scene::{self, Scene, at, block, line, open, wall};
use crate::proximity::{TILES, is_near, length};
use crate::support::test_data::data;
use crate::support::{Random, runtime};

/// A vertex, and a triangle at it or the outside.
type Wedge = (usize, usize);
const OUTSIDE: usize = usize::MAX;

/// The edges of a file that one may walk along.
struct Mesh {
    points: Vec<Point>,
    /// The wedges of each vertex, each with the number of its sector.
    wedges: HashMap<Wedge, usize>,
    sectors: Vec<Vec<usize>>,
    edges: Vec<Vec<(usize, f64)>>,
}

impl Mesh {
    async fn read(reader: &TileReader) -> Self {
        let outside_is_free = !reader.metadata().exterior_is_hole;
        let mut numbers: HashMap<[u64; 2], usize> = HashMap::new();
        let (mut points, mut half_edges, mut walls) = (Vec::new(), HashMap::new(), Vec::new());
        let mut tiles = reader.tiles();
        let mut count = 0;
        while let Some(tile) = tiles.try_next().await.unwrap() {
            for triangle in tile.owned_triangles() {
                let corners = tile.triangle_points(triangle).map(|p| {
                    *numbers.entry([p.x.to_bits(), p.y.to_bits()]).or_insert_with(|| {
                        points.push(p);
                        points.len() - 1
                    })
                });
                for s in 0..3 {
                    let ends = [corners[s], corners[(s + 1) % 3]];
                    if tile.is_wall(delaunay_tiles::geometry::HalfEdge::new(triangle, s as u32)) {
                        walls.push(ends);
                    }
                    if !tile.is_hole(triangle) {
                        half_edges.insert(ends, count);
                    }
                }
                count += 1;
            }
            // All twins are known only after all tiles were read.
            walls.sort_unstable();
        }
        let all: Vec<_> = half_edges.iter().map(|(&ends, &face)| (ends, face)).collect();
        let hull = |ends: [usize; 2], half_edges: &HashMap<[usize; 2], usize>| {
            outside_is_free && !half_edges.contains_key(&ends)
        };
        let mut faces = half_edges.clone();
        let holes = holes(reader, &numbers).await;
        for ([a, b], _) in &all {
            if hull([*b, *a], &half_edges) && !holes.contains(&[*b, *a]) {
                faces.insert([*b, *a], OUTSIDE);
            }
        }
        // A hull edge of a hole has an outside too.
        for &[a, b] in &holes {
            if outside_is_free && !holes.contains(&[b, a]) && !half_edges.contains_key(&[b, a]) {
                faces.insert([b, a], OUTSIDE);
            }
        }
        let mut this = Self {
            points,
            wedges: HashMap::new(),
            sectors: Vec::new(),
            edges: Vec::new(),
        };
        let mut sorted: Vec<_> = faces.iter().collect();
        sorted.sort_unstable();
        for (&[a, b], &face) in sorted {
            for vertex in [a, b] {
                let next = this.wedges.len();
                this.wedges.entry((vertex, face)).or_insert(next);
            }
        }
        // Wedges on both sides of an edge that is not blocked are one sector.
        let mut parent: Vec<usize> = (0..this.wedges.len()).collect();
        fn root(parent: &[usize], mut i: usize) -> usize {
            while parent[i] != i {
                i = parent[i];
            }
            i
        }
        for (&[a, b], &face) in &faces {
            let is_blocked = walls.contains(&[a, b]) || walls.contains(&[b, a]);
            if let (Some(&other), false) = (faces.get(&[b, a]), is_blocked) {
                for vertex in [a, b] {
                    let [one, two] = [face, other].map(|face| root(&parent, this.wedges[&(vertex, face)]));
                    parent[one] = two;
                }
            }
        }
        let roots: Vec<usize> = (0..parent.len()).map(|i| root(&parent, i)).collect();
        this.wedges.values_mut().for_each(|sector| *sector = roots[*sector]);
        this.sectors = vec![Vec::new(); this.points.len()];
        for (&(vertex, _), &sector) in &this.wedges {
            if !this.sectors[vertex].contains(&sector) {
                this.sectors[vertex].push(sector);
            }
        }
        this.edges = vec![Vec::new(); roots.len()];
        for (&[a, b], &face) in &faces {
            let leg = length(&[a, b].map(|v| this.points[v]));
            let [one, two] = [a, b].map(|v| this.wedges[&(v, face)]);
            this.edges[one].push((two, leg));
            this.edges[two].push((one, leg));
        }
        this
    }

    fn vertex(&self, point: Point) -> usize {
        self.points.iter().position(|&p| p == point).unwrap()
    }

    /// Returns the distance of every sector from a vertex.
    fn distances(&self, from: usize) -> Vec<f64> {
        let mut far = vec![f64::INFINITY; self.edges.len()];
        let mut open: Vec<usize> = self.sectors[from].clone();
        open.iter().for_each(|&sector| far[sector] = 0.0);
        while let Some(sector) = open.pop() {
            for &(to, length) in &self.edges[sector] {
                let length = far[sector] + length;
                if length < far[to] * (1.0 - 1e-14) {
                    far[to] = length;
                    open.push(to);
                }
            }
        }
        far
    }

    fn distance(&self, far: &[f64], to: usize) -> f64 {
        self.sectors[to]
            .iter()
            .map(|&sector| far[sector])
            .fold(f64::INFINITY, f64::min)
    }
}

/// Returns the half-edges of triangles in holes, as pairs of vertices.
async fn holes(reader: &TileReader, numbers: &HashMap<[u64; 2], usize>) -> Vec<[usize; 2]> {
    let mut holes = Vec::new();
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.try_next().await.unwrap() {
        for triangle in tile.owned_triangles().filter(|&triangle| tile.is_hole(triangle)) {
            let corners = tile
                .triangle_points(triangle)
                .map(|p| numbers[&[p.x.to_bits(), p.y.to_bits()]]);
            holes.extend((0..3).map(|s| [corners[s], corners[(s + 1) % 3]]));
        }
    }
    holes
}

/// Compares all answers of a search from a vertex with the mesh.
async fn compare_tree(reader: &TileReader, mesh: &Mesh, from: Point) {
    let far = mesh.distances(mesh.vertex(from));
    let tree = reader.vertices_by_cdt_distance(from, QueryOptions::default());
    let tree: Vec<_> = tree.try_collect().await.unwrap();
    assert!(tree.is_sorted_by(|a, b| a.distance.value <= b.distance.value));
    let mut found: HashMap<usize, Vec<f64>> = HashMap::new();
    for (node, number) in tree.iter().zip(0u64..) {
        let of_vertex = found.entry(mesh.vertex(node.vertex.point)).or_default();
        of_vertex.push(node.distance.value);
        match node.parent {
            None => assert_eq!((node.vertex.point, node.distance.value), (from, 0.0)),
            Some(parent) => {
                assert!(parent < number);
                let before = &tree[parent as usize];
                let leg = length(&[before.vertex.point, node.vertex.point]);
                assert!(is_near(before.distance.value + leg, node.distance.value));
            }
        }
        assert!(node.distance.lower <= node.distance.value && node.distance.value <= node.distance.upper);
    }
    for (vertex, sectors) in mesh.sectors.iter().enumerate() {
        let mut expected: Vec<f64> = sectors
            .iter()
            .map(|&sector| far[sector])
            .filter(|far| far.is_finite())
            .collect();
        expected.sort_by(f64::total_cmp);
        let found = found.remove(&vertex).unwrap_or_default();
        assert_eq!(found.len(), expected.len(), "{from:?} to {:?}", mesh.points[vertex]);
        for (found, expected) in found.iter().zip(&expected) {
            assert!(
                is_near(*found, *expected) || found == expected,
                "{from:?} to {:?}: {found}, not {expected}",
                mesh.points[vertex]
            );
        }
    }
}

/// Returns the input of a file after its lines were split: each constraint edge is a wall, and each
/// triangle of a hole has a seed.
async fn as_split_scene(reader: &TileReader) -> Scene {
    let mut scene = Scene {
        exterior_is_hole: reader.metadata().exterior_is_hole,
        ..Scene::default()
    };
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.try_next().await.unwrap() {
        scene.points.extend(tile.points());
        for edge in tile.owned_constraints() {
            scene
                .lines
                .push((LineKind::Wall, tile.ends(edge).map(|end| end.point).to_vec()));
        }
        for triangle in tile.owned_triangles().filter(|&triangle| tile.is_hole(triangle)) {
            let [a, b, c] = tile.triangle_points(triangle);
            scene
                .seeds
                .push(Point::new((a.x + b.x + c.x) / 3.0, (a.y + b.y + c.y) / 3.0));
        }
    }
    scene
}

/// Compares distances between arbitrary points with those in a file that has both points among its
/// vertices.
async fn compare_inserted(reader: &TileReader, pairs: &[[Point; 2]]) {
    let scene = as_split_scene(reader).await;
    for &[from, to] in pairs {
        let found = match reader.cdt_distance(from, to, QueryOptions::default()).await {
            Ok(Some(path)) => {
                assert_eq!((path.points.first(), path.points.last()), (Some(&from), Some(&to)));
                assert!(is_near(length(&path.points), path.distance.value) || from == to);
                path.distance.value
            }
            Ok(None) => f64::INFINITY,
            Err(QueryError::InsideObstacle { .. }) => continue,
            Err(error) => panic!("{error}"),
        };
        let mut with_both = scene.clone();
        with_both.points.extend([from, to]);
        let (_scratch, anew) = with_both.build(1 << 16).await;
        let mesh = Mesh::read(&anew).await;
        let expected = mesh.distance(&mesh.distances(mesh.vertex(from)), mesh.vertex(to));
        assert!(
            is_near(found, expected) || found == expected,
            "{from:?} to {to:?}: {found}, not {expected}, in {scene:?}"
        );
        // The bound of Bose and Keil.
        let options = QueryOptions::default();
        match reader.shortest_path(from, to, options).await.unwrap() {
            PathOutcome::Found(path) => {
                let shortest = path.distance.value;
                assert!(
                    found >= shortest * (1.0 - 1e-12) && found <= shortest * 2.42 + 1e-300,
                    "{found} {shortest}"
                );
            }
            outcome => assert!(
                outcome == PathOutcome::Unreachable && found == f64::INFINITY,
                "{outcome:?}, {found}"
            ),
        }
    }
}

fn check(scene: &Scene, random: &mut Random, pairs: usize, tile_sizes: &[usize]) {
    runtime().block_on(async {
        let mut mesh = None;
        for (&size, round) in tile_sizes.iter().zip(0..) {
            let (scratch, reader) = scene.build(size).await;
            let reader = if round % 2 == 1 {
                open(&scratch, 0).await
            } else {
                reader
            };
            if mesh.is_none() {
                mesh = Some(Mesh::read(&reader).await);
            }
            let Some(mesh) = &mesh else { unreachable!() };
            for _ in 0..4 {
                let vertex = random.below(mesh.points.len());
                if !mesh.sectors[vertex].is_empty() {
                    compare_tree(&reader, mesh, mesh.points[vertex]).await;
                }
            }
            let targets = scene.targets(random, 2 * pairs);
            let pairs: Vec<[Point; 2]> = targets.chunks(2).map(|pair| [pair[0], pair[1]]).collect();
            compare_inserted(&reader, &pairs).await;
        }
    });
}

#[test]
fn cdt_distances_in_scenes_by_hand_equal_those_of_dijkstra_in_core() {
    let grid = ("a grid", Scene::on_grid(7, 7, vec![]));
    for (name, mut scene) in scene::by_hand().into_iter().chain([grid]) {
        println!("{name}");
        check(&scene, &mut Random(7), 8, &TILES);
        scene.exterior_is_hole = true;
        check(&scene, &mut Random(8), 6, &[9]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(3), ..ProptestConfig::default() })]

    #[test]
    fn cdt_distances_among_blocks_and_walls_on_grids_equal_those_of_dijkstra_in_core(scene in scene::blocks_and_walls(0..6, &scene::KINDS[1..]), seed in any::<u64>()) {
        check(&scene, &mut Random(seed), 8, &[[4, 9, 40][scene.lines.len() % 3], 1 << 16]);
    }

    #[test]
    fn cdt_distances_among_walls_anywhere_equal_those_of_dijkstra_in_core(seed in any::<u64>()) {
        let mut random = Random(seed);
        let scene = Scene::triangles_anywhere(&mut random);
        check(&scene, &mut random, 8, &[4, 1 << 16]);
    }
}

#[test]
fn cdt_distances_are_refused_for_files_with_break_lines() {
    let lines = vec![wall(&[(1, 1), (1, 5)]), line(LineKind::BreakLine, &[(3, 3), (3, 6)])];
    runtime().block_on(async {
        let (_scratch, reader) = Scene::on_grid(9, 9, lines).build(1 << 16).await;
        let error = reader
            .cdt_distance(at(0, 0), at(8, 8), QueryOptions::default())
            .await
            .unwrap_err();
        assert!(matches!(error, QueryError::BreakLines { .. }), "{error}");
        let vertices = reader.vertices_by_cdt_distance(at(0, 0), QueryOptions::default());
        let error = vertices.try_collect::<Vec<_>>().await.unwrap_err();
        assert!(matches!(error, QueryError::BreakLines { .. }), "{error}");
    });
}

#[test]
fn sites_are_ordered_by_cdt_distance_and_number() {
    let mut scene = Scene::on_grid(9, 9, vec![block([2, 2], [3, 3]), wall(&[(6, 1), (6, 7)])]);
    scene.sites = vec![at(8, 8), at(0, 1), at(1, 0), at(8, 8), at(7, 3), at(3, 3)];
    runtime().block_on(async {
        for tile_vertices in TILES {
            let (_scratch, reader) = scene.build(tile_vertices).await;
            let sites = reader.sites_by_cdt_distance(Point::new(0.25, 0.25), QueryOptions::default());
            let sites: Vec<_> = sites.try_collect().await.unwrap();
            assert!(sites.is_sorted_by(|a, b| (a.distance.value, a.number) < (b.distance.value, b.number)));
            // One site is in an obstacle.
            let numbers: Vec<u64> = sites.iter().map(|site| site.number).collect();
            assert_eq!(numbers, [1, 2, 4, 0, 3]);
            for site in sites {
                let path = reader.cdt_distance(Point::new(0.25, 0.25), site.vertex.point, QueryOptions::default());
                assert!(is_near(
                    path.await.unwrap().unwrap().distance.value,
                    site.distance.value
                ));
            }
        }
    });
}

/// 74 points that stretch a distance by more than π/2.
#[test]
fn the_stretch_of_a_cdt_distance_may_exceed_half_of_pi() {
    let text = fs::read_to_string(data("stretch/pi2_points_6dp.csv")).unwrap();
    let rows = text.lines().filter(|row| !row.starts_with('#'));
    let points = rows.map(|row| {
        let (x, y) = row.split_once(',').unwrap();
        Point::new(x.parse().unwrap(), y.parse().unwrap())
    });
    let scene = Scene {
        points: points.collect(),
        ..Scene::default()
    };
    assert_eq!(scene.points.len(), 74);
    runtime().block_on(async {
        let (from, to) = (scene.points[0], scene.points[37]);
        let straight = length(&[from, to]);
        for tile_vertices in TILES {
            let (_scratch, reader) = scene.build(tile_vertices).await;
            let path = reader
                .cdt_distance(from, to, QueryOptions::default())
                .await
                .unwrap()
                .unwrap();
            let ratio = path.distance.value / straight;
            assert!((ratio - 1.5754).abs() < 5e-5, "{ratio}");
        }
    });
}
