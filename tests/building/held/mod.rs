//! The promise: a file says what holds each vertex and each edge: at which vertices points of the
//! input lie, which lines run along an edge, and where their segments begin and end. A brute-force
//! oracle derives the same from the input alone.

use std::collections::{BTreeMap, BTreeSet};

use delaunay_tiles::geometry::{Orientation, Point, orient2d, segments_cross};
use delaunay_tiles::input::{PointBatch, SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::store::{LineKind, LinePart, PointOrigin, TileReader};
use delaunay_tiles::{BuildOptions, Builder, Crossings, EditOptions, Editor};
use futures::TryStreamExt;

use crate::support::cases::cases;
use crate::support::{Random, Scratch, distinct, runtime_for, verify_lines};

type Segment = [Point; 2];

/// Points, lines by their numbers, and sites.
#[derive(Clone, Debug, Default)]
struct Scene {
    points: Vec<Point>,
    lines: Vec<(LineKind, Vec<Segment>)>,
    sites: Vec<Point>,
}

/// The coordinates of a point, which are integers unless lines are split.
type Key = [u64; 2];

fn key(p: Point) -> Key {
    [p.x, p.y].map(f64::to_bits)
}

/// What a file says: the sources of each constraint edge, from its smaller end to its larger one,
/// as text; and the vertices at which points of the input lie.
#[derive(Debug, Default, PartialEq)]
struct Held {
    edges: BTreeMap<[Key; 2], Vec<String>>,
    input_points: BTreeSet<Key>,
    vertices: BTreeSet<Key>,
}

fn forward([a, b]: Segment) -> Segment {
    if a.lex_cmp(b).is_lt() { [a, b] } else { [b, a] }
}

fn is_on([a, b]: Segment, p: Point) -> bool {
    let [low, high] = forward([a, b]);
    orient2d(a, b, p) == Orientation::Collinear && p.lex_cmp(low).is_ge() && p.lex_cmp(high).is_le()
}

fn text(number: u64, code: &str, begins: bool, ends: bool) -> String {
    format!("{number}{code} {begins} {ends}")
}

impl Scene {
    /// Makes a scene on a small lattice, where points lie on lines, lines overlap, touch and meet
    /// in vertices, but do not cross.
    fn random(random: &mut Random, size: usize, kinds: &[LineKind]) -> Self {
        let at = |random: &mut Random| Point::new(random.below(size) as f64, random.below(size) as f64);
        let mut scene = Self {
            points: (0..random.below(40)).map(|_| at(random)).collect(),
            ..Self::default()
        };
        let mut all: Vec<Segment> = Vec::new();
        for _ in 0..1 + random.below(12) {
            let kind = kinds[random.below(kinds.len())];
            let segments: Vec<Segment> = match kind {
                LineKind::Obstacle => ring(random, size),
                _ => {
                    let mut corners: Vec<Point> = (0..2 + random.below(4)).map(|_| at(random)).collect();
                    if random.below(4) == 0 {
                        // Back on the same way, and a segment of no length.
                        corners.extend(corners.clone().into_iter().rev());
                    }
                    corners.windows(2).map(|pair| [pair[0], pair[1]]).collect()
                }
            };
            let crosses = |new: &Segment| {
                let mut others = all.iter().chain(&segments);
                others.any(|old| segments_cross(old[0], old[1], new[0], new[1]))
            };
            if !segments.iter().any(crosses) {
                all.extend_from_slice(&segments);
                scene.lines.push((kind, segments));
            }
        }
        scene.sites = (0..random.below(5)).map(|_| at(random)).collect();
        scene
    }

    fn segments(&self) -> impl Iterator<Item = (u64, LineKind, Segment)> {
        let numbered = self.lines.iter().zip(0..);
        let all = numbered.flat_map(|((kind, segments), number)| segments.iter().map(move |&s| (number, *kind, s)));
        all.filter(|(.., ends)| ends[0] != ends[1])
    }

    /// Returns what a file must say, unless lines are split.
    fn held(&self) -> Held {
        let ends = self.segments().flat_map(|(.., ends)| ends);
        let all: Vec<Point> = self.points.iter().chain(&self.sites).copied().chain(ends).collect();
        let vertices = distinct(&all);
        // The edges along each segment, with the sources in the direction of the edge.
        let mut along: BTreeMap<([Key; 2], u64, &str), Vec<Segment>> = BTreeMap::new();
        for (number, kind, ends) in self.segments() {
            let on_it: Vec<Point> = vertices.iter().copied().filter(|&p| is_on(ends, p)).collect();
            let code = match (kind, forward(ends) == ends) {
                (LineKind::BreakLine, _) => "b",
                (LineKind::Wall, _) => "w",
                (LineKind::Obstacle, true) => "l",
                (LineKind::Obstacle, false) => "r",
            };
            for pair in on_it.windows(2) {
                along
                    .entry(([pair[0], pair[1]].map(key), number, code))
                    .or_default()
                    .push(ends);
            }
        }
        let mut edges: BTreeMap<[Key; 2], Vec<String>> = BTreeMap::new();
        for ((edge, number, code), segments) in along {
            let [begins, ends] = edge.map(|at| segments.iter().flatten().any(|&end| key(end) == at));
            let copies = if "lr".contains(code) { segments.len() } else { 1 };
            let source = text(number, code, begins, ends);
            edges
                .entry(edge)
                .or_default()
                .extend(std::iter::repeat_n(source, copies));
        }
        edges.values_mut().for_each(|sources| sources.sort());
        Held {
            edges,
            input_points: self.points.iter().map(|&p| key(p)).collect(),
            vertices: vertices.into_iter().map(key).collect(),
        }
    }

    /// Builds the lines before `built`, and inserts the others in an edit, if there are any.
    /// Returns `None` if the edit is impossible.
    async fn build(&self, options: BuildOptions, built: usize) -> Option<Scratch> {
        let scratch = Scratch::new();
        let mut builder = Builder::new(&scratch.path, options).unwrap();
        for ((kind, segments), number) in self.lines[..built].iter().zip(0..) {
            builder.push_lines(*kind, number, &batch(segments)).unwrap();
        }
        let sites = SiteBatch {
            points: self.sites.clone(),
            ids: (0..self.sites.len() as u64).map(SiteId::Number).collect(),
            ..SiteBatch::default()
        };
        builder.push_sites(&sites).unwrap();
        builder.push(&self.point_batch()).await.unwrap();
        let summary = builder.finish().await.unwrap();
        if built == self.lines.len() {
            return Some(scratch);
        }
        if summary.triangles == 0 {
            return None;
        }
        let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(1 << 20))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        for ((kind, segments), number) in self.lines.iter().zip(0..).skip(built) {
            transaction.constrain(*kind, number, &batch(segments)).unwrap();
        }
        transaction.commit().await.unwrap();
        Some(scratch)
    }

    fn point_batch(&self) -> PointBatch {
        PointBatch {
            points: self.points.clone(),
            z: Vec::new(),
            records: (0..self.points.len() as u64).collect(),
        }
    }

    /// Checks the file's own consistency and compares it with the points and lines by `verify`.
    async fn verify(&self, reader: &TileReader, first_end: u64) {
        reader.verify(true).await.unwrap();
        let lines = self.segments().map(|(number, kind, ends)| {
            let source = delaunay_tiles::store::EdgeSource::new(kind, number);
            (ends, LinePart::whole(source))
        });
        verify_lines(reader, lines.collect()).await.unwrap();
        let all = self.lines.iter().flat_map(|(_, segments)| segments.as_flattened());
        let mut ends = PointBatch {
            points: all.copied().collect(),
            ..PointBatch::default()
        };
        ends.records = (first_end..).take(ends.points.len()).collect();
        let first_site = first_end + ends.points.len() as u64;
        ends.remove_pairs_at_one_point();
        let sites = PointBatch {
            points: self.sites.clone(),
            z: Vec::new(),
            records: (first_site..).take(self.sites.len()).collect(),
        };
        let batches = |origin: PointOrigin| {
            let all = [
                (self.point_batch(), PointOrigin::Input),
                (ends.clone(), origin),
                (sites.clone(), PointOrigin::Other),
            ];
            let mut all = all.into_iter();
            move |batch: &mut PointBatch| {
                let next = all.next();
                Ok::<_, String>(next.map(|(next, origin)| {
                    *batch = next;
                    origin
                }))
            }
        };
        reader.verify_points(batches(PointOrigin::Other)).await.unwrap();
        // If the ends were points of the input, the file would be wrong.
        let points: BTreeSet<Key> = self.points.iter().map(|&p| key(p)).collect();
        if ends.points.iter().any(|&end| !points.contains(&key(end))) {
            reader.verify_points(batches(PointOrigin::Input)).await.unwrap_err();
        }
    }

    /// Returns the scene with its points in another order, and its break lines and walls in the
    /// other direction.
    fn turned(&self, random: &mut Random) -> Self {
        let mut turned = self.clone();
        random.shuffle(&mut turned.points);
        for (kind, segments) in &mut turned.lines {
            random.shuffle(segments);
            if *kind != LineKind::Obstacle {
                segments.iter_mut().for_each(|ends| ends.reverse());
            }
        }
        turned
    }
}

/// A rectangle, with a spike sometimes.
fn ring(random: &mut Random, size: usize) -> Vec<Segment> {
    let [x, y] = [0; 2].map(|_| random.below(size - 2));
    let [width, height] = [x, y].map(|from| 1 + random.below(size - 1 - from));
    let at = |x: usize, y: usize| Point::new(x as f64, y as f64);
    let mut corners = vec![at(x, y), at(x + width, y), at(x + width, y + height)];
    if random.below(3) == 0 {
        corners.extend([at(x + width, y + height + 1), at(x + width, y + height)]);
    }
    corners.extend([at(x, y + height), at(x, y)]);
    corners.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

fn batch(segments: &[Segment]) -> SegmentBatch {
    SegmentBatch {
        ends: segments.to_vec(),
        lines: vec![0; segments.len()],
        ..SegmentBatch::default()
    }
}

/// Returns what a file says.
async fn read(reader: &TileReader) -> Held {
    let mut held = Held::default();
    let mut without_point = 0;
    let tiles: Vec<_> = reader.tiles().try_collect().await.unwrap();
    for tile in &tiles {
        for vertex in tile.vertex_indices() {
            held.vertices.insert(key(tile.point(vertex)));
            match tile.is_input_point(vertex) {
                true => _ = held.input_points.insert(key(tile.point(vertex))),
                false => without_point += 1,
            }
        }
        for edge in tile.owned_constraints() {
            let ends = tile.ends(edge).map(|end| end.point);
            let is_forward = forward(ends) == ends;
            let seen = |part: LinePart| if is_forward { part } else { part.reversed() };
            let sources = tile.edge_parts(edge).map(seen).map(|part| {
                let code = match (part.kind(), part.depth_change()) {
                    (LineKind::BreakLine, _) => "b",
                    (LineKind::Wall, _) => "w",
                    (LineKind::Obstacle, 1) => "l",
                    (LineKind::Obstacle, _) => "r",
                };
                text(part.number(), code, part.begins(), part.ends())
            });
            let mut sources: Vec<String> = sources.collect();
            sources.sort();
            assert!(held.edges.insert(forward(ends).map(key), sources).is_none());
        }
    }
    assert_eq!(reader.metadata().ends, without_point);
    held
}

const ALL: [LineKind; 3] = [LineKind::BreakLine, LineKind::Wall, LineKind::Obstacle];

/// Tile vertices, merge vertices, threads, memory.
const WAYS: [(usize, usize, usize, u64); 4] = [
    (4, 16, 1, 1 << 30),
    (8, 1 << 16, 3, 1 << 30),
    // Some segments are deferred.
    (16, 200, 2, 1 << 20),
    (1 << 16, 1 << 16, 1, 1 << 30),
];

fn options((tile_vertices, merge_vertices, threads, memory): (usize, usize, usize, u64)) -> BuildOptions {
    let options = BuildOptions::default().tile_vertices(tile_vertices);
    options.merge_vertices(merge_vertices).threads(threads).memory(memory)
}

#[test]
fn files_say_what_holds_their_vertices_and_edges_however_they_are_built() {
    let (mut edges, mut passed, mut edited, mut on_line) = (0, 0, 0, 0);
    for seed in 0..cases(60) as u64 {
        let mut random = Random(1000 + seed);
        let mut scene = Scene::random(&mut random, 5 + seed as usize % 12, &ALL);
        if seed % 10 == 0 {
            // Everything on one line.
            for (kind, segments) in &mut scene.lines {
                *kind = LineKind::Wall;
                segments.iter_mut().flatten().for_each(|p| p.y = 2.0 * p.x);
            }
            scene.points.iter_mut().for_each(|p| p.y = 2.0 * p.x);
            scene.sites.iter_mut().for_each(|p| p.y = 2.0 * p.x);
            on_line += usize::from(!scene.held().edges.is_empty());
        }
        let expected = scene.held();
        let turned = scene.turned(&mut random);
        edges += expected.edges.len();
        let sources = expected.edges.values().flatten();
        passed += sources.filter(|source| source.contains("false")).count();
        for way in WAYS {
            runtime_for(way.2).block_on(async {
                for scene in [&scene, &turned] {
                    let all = scene.lines.len();
                    let scratch = scene.build(options(way), all).await.unwrap();
                    let reader = scratch.open().await;
                    assert_eq!(read(&reader).await, expected, "seed {seed}, {way:?}");
                    scene.verify(&reader, scene.points.len() as u64).await;
                    for built in [0, all / 2] {
                        let Some(scratch) = scene.build(options(way), built).await else {
                            continue;
                        };
                        let reader = scratch.open().await;
                        assert_eq!(
                            read(&reader).await,
                            expected,
                            "seed {seed}, {way:?}, edited from {built}"
                        );
                        reader.verify(true).await.unwrap();
                        edited += 1;
                    }
                }
            });
        }
    }
    assert!(
        edges > cases(500) && passed > cases(100) && edited > cases(50) && on_line > 0,
        "{edges} {passed} {edited} {on_line}"
    );
}

/// The points at which lines are split are no ends of segments, and no points of the input.
#[test]
fn split_lines_begin_and_end_at_the_ends_of_their_segments_only() {
    let mut crossings = 0;
    for seed in 0..cases(48) as u64 {
        let mut random = Random(seed);
        let at = |random: &mut Random| Point::new(random.below(64) as f64 / 4.0, random.below(64) as f64 / 4.0);
        let segments = |random: &mut Random| -> Vec<Segment> {
            let corners: Vec<Point> = (0..3).map(|_| at(random)).collect();
            corners.windows(2).map(|pair| [pair[0], pair[1]]).collect()
        };
        let scene = Scene {
            points: (0..60).map(|_| at(&mut random)).collect(),
            lines: (0..8).map(|line| (ALL[line % 2], segments(&mut random))).collect(),
            sites: vec![at(&mut random)],
        };
        let mut ends: BTreeMap<u64, BTreeSet<Key>> = BTreeMap::new();
        for (number, _, segment) in scene.segments() {
            ends.entry(number).or_default().extend(segment.map(key));
        }
        let mut same: Option<Held> = None;
        for way in WAYS {
            runtime_for(way.2).block_on(async {
                let options = options(way).crossings(Crossings::Split);
                let scratch = scene.build(options, scene.lines.len()).await.unwrap();
                let reader = scratch.open().await;
                reader.verify(true).await.unwrap();
                let held = read(&reader).await;
                crossings += reader.metadata().crossings;
                let points: BTreeSet<Key> = scene.points.iter().map(|&p| key(p)).collect();
                assert_eq!(held.input_points, points);
                let mut found: BTreeMap<u64, BTreeSet<Key>> = BTreeMap::new();
                for (edge, sources) in &held.edges {
                    for source in sources {
                        let words: Vec<&str> = source.split(' ').collect();
                        let number = words[0].trim_end_matches(char::is_alphabetic).parse().unwrap();
                        let is_end = [words[1], words[2]].map(|word| word == "true");
                        let here = edge.iter().zip(is_end).filter(|(_, is_end)| *is_end);
                        found.entry(number).or_default().extend(here.map(|(end, _)| *end));
                    }
                }
                assert_eq!(found, ends, "seed {seed}, {way:?}");
                assert!(same.as_ref().is_none_or(|same| *same == held));
                same = Some(held);
            });
        }
    }
    assert!(crossings > cases(200) as u64, "{crossings}");
}

/// Makes obstacles of several rings that touch and overlap, but do not cross.
fn overlapping(random: &mut Random, size: usize) -> Scene {
    let mut all: Vec<Segment> = Vec::new();
    let mut obstacle = || {
        let mut rings: Vec<Segment> = Vec::new();
        for _ in 0..30 {
            let ring = ring(random, size);
            let crosses = |new: &Segment| all.iter().any(|old| segments_cross(old[0], old[1], new[0], new[1]));
            if !ring.iter().any(crosses) && rings.len() < 20 {
                all.extend_from_slice(&ring);
                rings.extend(ring);
            }
        }
        (LineKind::Obstacle, rings)
    };
    let lines = [obstacle(), obstacle()];
    Scene {
        points: vec![Point::new(-1.0, -1.0), Point::new(40.0, 0.0), Point::new(0.0, 40.0)],
        lines: lines.into_iter().filter(|(_, rings)| !rings.is_empty()).collect(),
        sites: Vec::new(),
    }
}

/// An obstacle that covers a place more than once is normalised: overlapping segments become one
/// edge, whose source has the ends of all of them.
#[test]
fn where_rings_of_an_obstacle_overlap_each_of_their_segments_holds_its_ends() {
    let (mut replaced, mut passed) = (0, 0);
    for seed in 0..cases(40) as u64 {
        let mut random = Random(500 + seed);
        let scene = overlapping(&mut random, 4 + seed as usize % 4);
        let turned = scene.turned(&mut random);
        let mut same: Option<Held> = None;
        for way in WAYS {
            runtime_for(way.2).block_on(async {
                let (all, split) = (scene.lines.len(), options(way).crossings(Crossings::Split));
                let ways = [
                    (&scene, options(way), all),
                    (&turned, options(way), all),
                    (&scene, split, all),
                    (&scene, options(way), 0),
                    (&turned, options(way), 1),
                ];
                for (scene, options, built) in ways {
                    let reader = scene.build(options, built).await.unwrap().open().await;
                    reader.verify(true).await.unwrap();
                    let held = read(&reader).await;
                    assert!(same.as_ref().is_none_or(|same| *same == held), "seed {seed}, {way:?}");
                    same = Some(held);
                }
            });
        }
        let same = same.unwrap();
        let mut edges: BTreeSet<([Key; 2], u64)> = BTreeSet::new();
        for (edge, sources) in &same.edges {
            let mut of_lines: BTreeMap<u64, [bool; 2]> = BTreeMap::new();
            for source in sources {
                let words: Vec<&str> = source.split(' ').collect();
                let number = words[0].trim_end_matches(['l', 'r']).parse().unwrap();
                let found = of_lines.entry(number).or_default();
                *found = [found[0] || words[1] == "true", found[1] || words[2] == "true"];
            }
            for (number, found) in of_lines {
                let ends = edge.map(|end| Point::new(f64::from_bits(end[0]), f64::from_bits(end[1])));
                let along = scene.lines[number as usize].1.iter().copied();
                let along: Vec<Segment> = along.filter(|&its| ends.iter().all(|&end| is_on(its, end))).collect();
                let is_end = ends.map(|end| along.iter().flatten().any(|&other| other == end));
                assert_eq!(found, is_end, "seed {seed}");
                replaced += usize::from(along.len() > 1);
                passed += is_end.iter().filter(|is_end| !**is_end).count();
                edges.insert((*edge, number));
            }
        }
        for (number, _, ends) in scene.segments() {
            let on_it = same
                .vertices
                .iter()
                .map(|p| Point::new(f64::from_bits(p[0]), f64::from_bits(p[1])));
            let mut on_it: Vec<Point> = on_it.filter(|&p| is_on(ends, p)).collect();
            on_it.sort_by(|a, b| a.lex_cmp(*b));
            assert!(
                on_it
                    .windows(2)
                    .all(|pair| edges.contains(&([pair[0], pair[1]].map(key), number)))
            );
        }
    }
    assert!(replaced > cases(100) && passed > cases(50), "{replaced} {passed}");
}
