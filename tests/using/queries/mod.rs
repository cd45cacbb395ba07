//! The promise: `locate` and `triangles_in` answer what an examination of every triangle would, for
//! any tiles, from any number of concurrent tasks, also when some callers cancel.

mod many;

use std::sync::Arc;
use std::time::Duration;

use crate::support::{Random, Scratch, batches, build_batches, built, points_of, runtime};
use delaunay_tiles::geometry::{Orientation, Point, Rect, orient2d};
use delaunay_tiles::query::{Location, TriangleRef};
use delaunay_tiles::store::{Cache, OpenOptions, TileId, TileReader, Vertex, VertexId};
use delaunay_tiles::{BuildOptions, Builder, EditOptions, Editor};
use distributions::Kind;
use futures::future::FutureExt;
use futures::stream::TryStreamExt;

fn options(tile_vertices: usize) -> BuildOptions {
    BuildOptions::default().tile_vertices(tile_vertices).threads(2)
}

/// Everything that a file contains.
struct Whole {
    vertices: Vec<Vertex>,
    triangles: Vec<[Vertex; 3]>,
    bounds: Rect,
}

impl Whole {
    async fn read(reader: &TileReader) -> Self {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        let mut tiles = reader.tiles();
        while let Some(tile) = tiles.try_next().await.unwrap() {
            vertices.extend(tile.vertex_indices().map(|v| tile.vertex(v)));
            triangles.extend(tile.owned_triangles().map(|t| tile.vertices(t)));
        }
        let bounds = Rect::around(vertices.iter().map(|v| v.point));
        Self {
            vertices,
            triangles,
            bounds,
        }
    }

    /// Compares an answer with an examination of every triangle.
    fn check(&self, p: Point, found: Location) {
        // A value nearer to 0 than the smallest coordinate counts as 0.
        let p = Point::new(flushed(p.x), flushed(p.y));
        if !self.bounds.contains(p) {
            assert_eq!(found, Location::Outside, "{p:?}");
            return;
        }
        let turns = |t: &[Vertex; 3]| [0, 1, 2].map(|i| orient2d(t[i].point, t[(i + 1) % 3].point, p));
        let holds = |t: &&[Vertex; 3]| !turns(t).contains(&Orientation::Clockwise);
        let on_vertex = self.vertices.iter().find(|v| v.point == p);
        let around: Vec<_> = self.triangles.iter().filter(holds).collect();
        match found {
            Location::OnVertex(vertex) => assert_eq!(Some(&vertex), on_vertex, "{p:?}"),
            Location::OnEdge { ends, triangle } => {
                assert!(on_vertex.is_none(), "{p:?}");
                self.check_triangle(&triangle);
                assert!(
                    (0..3).any(|i| [triangle.vertices[i], triangle.vertices[(i + 1) % 3]] == ends),
                    "{p:?}"
                );
                assert_eq!(orient2d(ends[0].point, ends[1].point, p), Orientation::Collinear);
                assert!(Rect::around(ends.map(|v| v.point)).contains(p));
                assert!((1..=2).contains(&around.len()), "{p:?}");
                assert!(around.iter().all(|t| ends.iter().all(|e| t.contains(e))), "{p:?}");
            }
            Location::InTriangle(triangle) => {
                self.check_triangle(&triangle);
                assert_eq!(around.len(), 1, "{p:?}");
                assert_eq!(named(around[0]), named(&triangle.vertices), "{p:?}");
                assert!(!turns(around[0]).contains(&Orientation::Collinear), "{p:?}");
            }
            Location::Outside => assert!(around.is_empty() && on_vertex.is_none(), "{p:?} is in {around:?}"),
        }
    }

    fn check_triangle(&self, triangle: &TriangleRef) {
        assert!(triangle.vertices.iter().any(|v| v.id.tile == triangle.tile));
    }

    /// Returns the triangles that meet a rectangle, found without the separating axes that the
    /// library uses.
    fn meeting(&self, rect: Rect) -> Vec<[VertexId; 3]> {
        if rect.is_empty() {
            return Vec::new();
        }
        let rect = Rect::new(
            flushed(rect.min_x),
            flushed(rect.min_y),
            flushed(rect.max_x),
            flushed(rect.max_y),
        );
        // The rectangle, shrunk towards all points so that it is finite.
        let b = self.bounds;
        let (min_x, min_y) = (rect.min_x.max(b.min_x - 1.0), rect.min_y.max(b.min_y - 1.0));
        let (max_x, max_y) = (rect.max_x.min(b.max_x + 1.0), rect.max_y.min(b.max_y + 1.0));
        if min_x > max_x || min_y > max_y {
            return Vec::new();
        }
        let corners = [(min_x, min_y), (max_x, min_y), (max_x, max_y), (min_x, max_y)].map(|(x, y)| Point::new(x, y));
        let meets = |t: &&[Vertex; 3]| {
            let t = t.map(|v| v.point);
            let edges = |q: &[Point]| (0..q.len()).map(|i| [q[i], q[(i + 1) % q.len()]]).collect::<Vec<_>>();
            let holds = |p: Point| {
                edges(&t)
                    .iter()
                    .all(|&[a, b]| orient2d(a, b, p) != Orientation::Clockwise)
            };
            t.iter().any(|&p| rect.contains(p))
                || corners.iter().any(|&p| holds(p))
                || edges(&t)
                    .iter()
                    .any(|&s| edges(&corners).iter().any(|&r| segments_meet(s, r)))
        };
        let mut found: Vec<_> = self.triangles.iter().filter(meets).map(named).collect();
        found.sort_unstable();
        found
    }

    /// Returns points to locate: vertices, middles of edges, and others.
    fn targets(&self, random: &mut Random, count: usize) -> Vec<Point> {
        let b = self.bounds;
        let mut targets = vec![
            Point::new(f64::NAN, 0.0),
            Point::new(b.min_x, f64::NAN),
            Point::new(f64::INFINITY, f64::NEG_INFINITY),
            Point::new(f64::NEG_INFINITY, b.max_y),
            Point::new(1e-300, -1e-300),
            Point::new(b.min_x, 1e-310),
            Point::new(-1e-50, b.max_y),
            Point::new(f64::MAX, f64::MAX),
            Point::new(b.max_x + 1.0, b.max_y),
            Point::new(b.min_x, b.min_y),
        ];
        let (width, height) = b.size();
        for _ in 0..count {
            let (x, y) = (1.2 * random.unit() - 0.1, 1.2 * random.unit() - 0.1);
            targets.push(Point::new(b.min_x + x * width, b.min_y + y * height));
            targets.extend(pick(random, &self.vertices).map(|v| v.point));
            if let Some(t) = pick(random, &self.triangles) {
                let [a, b] = [t[0].point, t[1].point];
                targets.push(Point::new(f64::midpoint(a.x, b.x), f64::midpoint(a.y, b.y)));
            }
        }
        targets
    }

    fn rects(&self, random: &mut Random, count: usize) -> Vec<Rect> {
        let b = self.bounds;
        let mut rects = vec![
            Rect::PLANE,
            Rect::EMPTY,
            Rect::new(b.max_x + 1.0, b.min_y, b.max_x + 2.0, b.max_y),
            Rect::new(-1e300, -1e300, -1e299, -1e299),
            Rect::new(f64::NAN, 0.0, 1.0, 1.0),
            Rect::new(1.0, 1.0, 0.0, 0.0),
            Rect::new(-1e-300, b.min_y, 1e-310, b.max_y),
            Rect::new(-1e-300, -1e-60, 1e-310, 1e-60),
            Rect::new(b.min_x, f64::NEG_INFINITY, f64::INFINITY, b.min_y),
            b,
        ];
        let targets = self.targets(random, count);
        let targets: Vec<_> = targets
            .into_iter()
            .filter(|p| p.x.abs() < 1e300 && p.y.is_finite())
            .collect();
        for pair in targets[1..].chunks(2) {
            rects.push(Rect::around(pair.iter().copied()));
            // Degenerate rectangles: a point, and a segment along each axis.
            let (p, q) = (pair[0], pair[pair.len() - 1]);
            rects.push(Rect::new(p.x, p.y, p.x, p.y));
            rects.push(Rect::around([p, Point::new(q.x, p.y)]));
            rects.push(Rect::around([p, Point::new(p.x, q.y)]));
        }
        rects
    }
}

fn flushed(v: f64) -> f64 {
    if v.abs() < Point::MIN_MAGNITUDE { 0.0 } else { v }
}

fn pick<'a, T>(random: &mut Random, items: &'a [T]) -> Option<&'a T> {
    if items.is_empty() {
        None
    } else {
        Some(&items[random.below(items.len())])
    }
}

fn segments_meet([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    if !Rect::around([a, b]).intersects(Rect::around([c, d])) {
        return false;
    }
    let parts = |a, b, c, d| {
        let (one, other) = (orient2d(a, b, c), orient2d(a, b, d));
        one == other && one != Orientation::Collinear
    };
    !parts(a, b, c, d) && !parts(c, d, a, b)
}

/// Returns the ids of a triangle's vertices, the smallest first.
fn named(t: &[Vertex; 3]) -> [VertexId; 3] {
    let mut ids = t.map(|v| v.id);
    let smallest = (0..3).min_by_key(|&i| ids[i]).unwrap();
    ids.rotate_left(smallest);
    ids
}

async fn found_in(reader: &TileReader, rect: Rect) -> Vec<[VertexId; 3]> {
    let found: Vec<TriangleRef> = reader.triangles_in(rect).try_collect().await.unwrap();
    assert!(
        found.is_sorted_by_key(|t| (t.tile, t.triangle)),
        "in the order of the tiles"
    );
    let mut found: Vec<_> = found.iter().map(|t| named(&t.vertices)).collect();
    found.sort_unstable();
    assert!(found.windows(2).all(|w| w[0] != w[1]), "each once");
    found
}

#[test]
fn locate_and_rectangles_agree_with_an_examination_of_every_triangle() {
    let runtime = runtime();
    let (mut located, mut rects) = (0, 0);
    for (kind, seed) in Kind::ALL.into_iter().zip(0u64..) {
        let points = points_of(kind, 300, seed);
        for tile_vertices in [8, 64, 65536] {
            println!("{kind}, tiles of {tile_vertices}");
            runtime.block_on(async {
                let (_scratch, reader) = built(&points, options(tile_vertices)).await;
                let whole = Whole::read(&reader).await;
                let mut random = Random(seed);
                for p in whole.targets(&mut random, 60) {
                    whole.check(p, reader.locate(p.x, p.y).await.unwrap());
                    located += 1;
                }
                for rect in whole.rects(&mut random, 12) {
                    assert_eq!(found_in(&reader, rect).await, whole.meeting(rect), "{rect:?}");
                    rects += 1;
                }
            });
        }
    }
    println!("{located} points, {rects} rectangles");
}

#[test]
fn every_vertex_and_every_half_step_of_a_grid_is_located() {
    let points: Vec<Point> = (0..144)
        .map(|i| Point::new(f64::from(i % 12), f64::from(i / 12)))
        .collect();
    for tile_vertices in [8, 64, 65536] {
        runtime().block_on(async {
            let (_scratch, reader) = built(&points, options(tile_vertices)).await;
            let whole = Whole::read(&reader).await;
            for i in -2..26 {
                for j in -2..26 {
                    let p = Point::new(f64::from(i) / 2.0, f64::from(j) / 2.0);
                    let found = reader.locate(p.x, p.y).await.unwrap();
                    whole.check(p, found);
                    let inside = (0..=22).contains(&i) && (0..=22).contains(&j);
                    // Whole steps are vertices; half steps are on cell edges, or on one of the
                    // diagonals.
                    match found {
                        Location::OnVertex(_) => assert!(inside && i % 2 == 0 && j % 2 == 0),
                        Location::OnEdge { .. } => assert!(inside && (i % 2 != 0 || j % 2 != 0)),
                        Location::InTriangle(_) => panic!("{p:?} lies on an edge"),
                        Location::Outside => assert!(!inside),
                    }
                }
            }
        });
    }
}

#[test]
fn files_without_triangles_locate_points_and_return_no_triangles() {
    let line: Vec<Point> = (0..40).map(|i| Point::new(f64::from(i), f64::from(-2 * i))).collect();
    for count in [0, 1, 2, 40] {
        runtime().block_on(async {
            let (_scratch, reader) = built(&line[..count], options(8)).await;
            let whole = Whole::read(&reader).await;
            for i in 0..90 {
                let p = Point::new(f64::from(i) / 2.0, f64::from(-i));
                whole.check(p, reader.locate(p.x, p.y).await.unwrap());
            }
            for p in whole.targets(&mut Random(1), 20) {
                whole.check(p, reader.locate(p.x, p.y).await.unwrap());
            }
            for rect in [Rect::PLANE, Rect::EMPTY, Rect::new(0.0, -9.0, 9.0, 0.0)] {
                assert!(found_in(&reader, rect).await.is_empty());
            }
        });
    }
}

#[test]
fn many_tasks_get_right_answers_from_a_reader_with_a_tiny_cache() {
    let points = points_of(Kind::Clusters, 1500, 3);
    runtime().block_on(async {
        let scratch = Scratch::new();
        build_batches(&scratch.path, &batches(&points, &[]), options(32))
            .await
            .unwrap();
        let cache = Cache::new(20_000);
        let reader = TileReader::open(&scratch.path, OpenOptions::default().cache(&cache))
            .await
            .unwrap();
        let whole = Arc::new(Whole::read(&reader).await);
        let tasks: Vec<_> = (0..32)
            .map(|seed| {
                let (reader, whole) = (reader.clone(), Arc::clone(&whole));
                tokio::spawn(async move {
                    let mut random = Random(seed);
                    for p in whole.targets(&mut random, 12) {
                        // Every other call times out at some moment.
                        let patience = Duration::from_micros(random.bits() % 300);
                        let _ = tokio::time::timeout(patience, reader.locate(p.x, p.y)).await;
                        drop(reader.locate(p.x, p.y).now_or_never());
                        drop(reader.triangles_in(Rect::PLANE).try_next().now_or_never());
                        whole.check(p, reader.locate(p.x, p.y).await.unwrap());
                    }
                    let rect = Rect::around([whole.vertices[random.below(1000)].point, whole.bounds_middle()]);
                    assert_eq!(found_in(&reader, rect).await, whole.meeting(rect));
                })
            })
            .collect();
        for task in tasks {
            tokio::time::timeout(Duration::from_secs(60), task)
                .await
                .unwrap()
                .unwrap();
        }
        let statistics = cache.statistics();
        assert!(
            statistics.bytes <= 20_000 && statistics.evictions > 100,
            "{statistics:?}"
        );
    });
}

/// A cache of the size that the directory names holds the whole file, with the notes of queries; and
/// a tile of some hundred vertices takes at most 1.3 times its bytes in the file.
#[test]
fn a_cache_of_the_named_size_holds_all_tiles() {
    for (kind, tile_vertices) in [(Kind::Uniform, 1000), (Kind::Clusters, 300), (Kind::Grid, 16)] {
        let points = points_of(kind, 4000, 7);
        runtime().block_on(async {
            let (scratch, reader) = built(&points, options(tile_vertices)).await;
            let directory = reader.directory().await.unwrap();
            let used = directory.tiles.iter().filter(|entry| !entry.is_unused());
            let (named, stored) = used.fold((0, 0), |(named, stored), entry| {
                (named + entry.cached_bytes(), stored + entry.stored_bytes())
            });
            let cache = Cache::new(named as usize);
            let reader = TileReader::open(&scratch.path, OpenOptions::default().cache(&cache))
                .await
                .unwrap();
            for _ in 0..3 {
                for p in &points {
                    reader.locate(p.x, p.y).await.unwrap();
                }
            }
            let statistics = cache.statistics();
            assert_eq!(statistics.evictions, 0, "{kind}: {statistics:?}");
            if tile_vertices >= 300 {
                let bytes = statistics.bytes as u64;
                assert!(10 * bytes <= 13 * stored, "{kind}: {bytes} for {stored}");
            }
        });
    }
}

impl Whole {
    fn bounds_middle(&self) -> Point {
        let b = self.bounds;
        Point::new(f64::midpoint(b.min_x, b.max_x), f64::midpoint(b.min_y, b.max_y))
    }
}

/// The task of a load may be dropped with its runtime before it ever ran. It used to stay in the
/// cache's list of loads, and every later reader of that tile got an error that its runtime was
/// shutting down.
#[test]
fn a_tile_whose_load_died_with_its_runtime_is_loaded_again() {
    let points = points_of(Kind::Uniform, 200, 1);
    let alive = runtime();
    let (_scratch, reader) = alive.block_on(built(&points, options(16)));
    let directory = alive.block_on(reader.directory()).unwrap();
    for id in (0..directory.tiles.len() as u32).map(TileId) {
        let dying = tokio::runtime::Builder::new_current_thread().build().unwrap();
        assert!(dying.block_on(async { reader.tile(id).now_or_never() }).is_none());
        drop(dying);
        let tile = alive.block_on(reader.tile(id)).unwrap();
        assert_eq!(tile.id(), id);
    }
}

/// A service runs builds, edits and compaction as tasks of its own. A span that was entered across
/// an await once kept builds on their thread.
#[test]
fn futures_of_builds_edits_and_compaction_are_send() {
    fn sent<T: Send>(future: T) -> T {
        future
    }
    runtime().block_on(async {
        let scratch = Scratch::new();
        let mut builder = Builder::new(&scratch.path, options(8)).unwrap();
        for batch in batches(&points_of(Kind::Uniform, 50, 1), &[]) {
            sent(builder.push(&batch)).await.unwrap();
        }
        sent(builder.finish()).await.unwrap();
        let editor = sent(Editor::open(&scratch.path, EditOptions::default().memory(1 << 30)))
            .await
            .unwrap();
        let transaction = sent(editor.begin()).await.unwrap();
        sent(transaction.commit()).await.unwrap();
        let reader = scratch.open().await;
        sent(reader.compact(&scratch.path)).await.unwrap();
        scratch.open().await.verify(true).await.unwrap();
    });
}

#[test]
fn streams_are_send_and_static_and_outlive_their_reader() {
    fn kept<T: Send + 'static>(_: &T) {}
    fn shared<T: Send + Sync + Clone + 'static>(_: &T) {}
    runtime().block_on(async {
        let (_scratch, reader) = built(&points_of(Kind::Uniform, 50, 1), options(8)).await;
        shared(&reader);
        shared(reader.cache());
        let (tiles, triangles) = (reader.tiles(), reader.triangles_in(Rect::PLANE));
        kept(&tiles);
        kept(&triangles);
        fn sent<T: Send>(future: T) -> T {
            future
        }
        let located = sent(reader.locate(0.5, 0.5)).await.unwrap();
        assert_ne!(located, Location::Outside);
        sent(reader.verify(true)).await.unwrap();
        sent(reader.recompute_digest()).await.unwrap();
        // The streams outlive their reader.
        drop(reader);
        let tiles: Vec<_> = tiles.try_collect().await.unwrap();
        let triangles: Vec<_> = triangles.try_collect().await.unwrap();
        assert_eq!(
            tiles.iter().map(|t| t.owned_triangles().count()).sum::<usize>(),
            triangles.len()
        );
    });
}
