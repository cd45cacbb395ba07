//! Obstacles whose rings overlap or touch: a file stores each of them so that it covers each point
//! 0 or 1 times, whatever the tiles, the order of the rings, and whether a build or an edit added
//! them.

use std::collections::{BTreeMap, HashMap};

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::SegmentBatch;
use delaunay_tiles::store::{
    EdgeSource, LineBatch, LineKind, LinePart, LineSource, OpenOptions, TileReader, VerifyError,
};
use delaunay_tiles::{BuildError, BuildOptions, Builder, Crossings, Description, EditOptions, Editor, PolygonCheck};
use futures::TryStreamExt;

use super::rings::winding;
use crate::support::{Random, Scratch, batches, built, runtime};

/// The obstacles lie in the square from 0 to this coordinate.
const SIZE: usize = 7;

/// A ring as its segments.
type Ring = Vec<[Point; 2]>;

/// An obstacle: polygons, each as its rings.
#[derive(Clone, Debug)]
struct Obstacle {
    polygons: Vec<Vec<Ring>>,
    /// Whether each ring is a line of its own. Then there is one polygon.
    ring_lines: bool,
}

impl Obstacle {
    fn segments(&self) -> Ring {
        self.polygons.iter().flatten().flatten().copied().collect()
    }

    fn lines(&self) -> u64 {
        match self.ring_lines {
            true => self.polygons[0].len() as u64,
            false => 1,
        }
    }

    /// Returns how often it covers a point: 0 or 1.
    fn covers(&self, point: Point) -> i32 {
        i32::from(winding(&self.segments(), point) != 0)
    }

    /// Returns its segments. Its lines are numbered from 0 on, and its polygons from 100 times
    /// `first_line` on.
    fn batch(&self, first_line: u64) -> SegmentBatch {
        let mut batch = SegmentBatch::default();
        for (polygon, number) in self.polygons.iter().zip(100 * first_line..) {
            for (ring, line) in polygon.iter().zip(0..) {
                batch.ends.extend_from_slice(ring);
                batch.polygons.resize(batch.ends.len(), number);
                batch
                    .lines
                    .resize(batch.ends.len(), if self.ring_lines { line } else { 0 });
            }
        }
        batch
    }
}

fn at(x: usize, y: usize) -> Point {
    Point::new(x as f64, y as f64)
}

/// Returns the ring of a rectangle, counter-clockwise, in steps of at most `step`.
fn rectangle([x, y]: [usize; 2], [right, top]: [usize; 2], step: usize) -> Ring {
    let corners = [at(x, y), at(right, y), at(right, top), at(x, top)];
    let mut ring = Vec::new();
    for (number, &from) in corners.iter().enumerate() {
        let to = corners[(number + 1) % 4];
        let [dx, dy] = [to.x - from.x, to.y - from.y];
        let steps = (dx.abs().max(dy.abs()) / step as f64).ceil();
        let on = |step: f64| Point::new(from.x + dx / steps * step, from.y + dy / steps * step);
        ring.extend((0..steps as usize).map(|step| [on(step as f64), on(step as f64 + 1.0)]));
    }
    ring
}

fn reversed(ring: &Ring) -> Ring {
    ring.iter().rev().map(|&[a, b]| [b, a]).collect()
}

/// Returns obstacles of rectangles that overlap, touch and repeat, with holes and spikes. If their
/// segments have length 1, none cross.
fn random_obstacles(random: &mut Random, step: usize) -> Vec<Obstacle> {
    let mut corners = || {
        let (mut x, mut y) = ([0; 2], [0; 2]);
        while x[0] == x[1] || y[0] == y[1] {
            [x, y] = [(); 2].map(|()| [random.below(SIZE + 1), random.below(SIZE + 1)]);
        }
        ([x[0].min(x[1]), y[0].min(y[1])], [x[0].max(x[1]), y[0].max(y[1])])
    };
    let mut obstacle = |shape: usize| {
        let ring_lines = shape.is_multiple_of(2);
        let polygons = if ring_lines { 1 } else { 1 + shape / 2 % 3 };
        let polygon = |number: usize| {
            let (low, high) = corners();
            let mut rings = vec![rectangle(low, high, step)];
            if shape.is_multiple_of(3) {
                // The hole may touch the ring around it, and be as large.
                rings.push(reversed(&rectangle(low, [high[0], low[1] + 1], step)));
            }
            if shape / 3 % 2 == number % 2 {
                let (low, high) = corners();
                rings.push(rectangle(low, high, step));
            }
            if shape.is_multiple_of(5) {
                // Twice the same ring, and a spike.
                rings.push(rings[0].clone());
                let spike = rings[0][0];
                rings.push(vec![spike, [spike[1], spike[0]]]);
            }
            rings
        };
        Obstacle {
            polygons: (0..polygons).map(polygon).collect(),
            ring_lines,
        }
    };
    [0, 1, 3, 5, 10, 15, 7, 12].into_iter().map(&mut obstacle).collect()
}

/// What a file stores of obstacles.
#[derive(Debug, PartialEq)]
struct Stored {
    /// Each constraint edge from its smaller end to its larger one, with its sources.
    edges: BTreeMap<[[u64; 2]; 2], Vec<LinePart>>,
    /// The polygon of each line.
    polygons: Vec<u64>,
}

fn line_sources(obstacles: &[Obstacle]) -> Vec<LineSource> {
    vec![LineSource {
        name: "obstacles".to_owned(),
        kind: LineKind::Obstacle,
        first: 0,
        lines: obstacles.iter().map(Obstacle::lines).sum(),
        edit: 0,
    }]
}

/// All points at which segments of length 1 begin and end.
fn grid() -> Vec<Point> {
    let side = 0..=SIZE;
    side.clone().flat_map(|x| side.clone().map(move |y| at(x, y))).collect()
}

async fn build(obstacles: &[Obstacle], options: BuildOptions) -> Result<Scratch, BuildError> {
    let scratch = Scratch::new();
    let mut builder = Builder::new(&scratch.path, options)?;
    builder.describe(Description {
        lines: line_sources(obstacles),
        ..Description::default()
    });
    let mut first = 0;
    for obstacle in obstacles {
        builder.push_lines(LineKind::Obstacle, first, &obstacle.batch(first))?;
        first += obstacle.lines();
    }
    for batch in batches(&grid(), &[]) {
        builder.push(&batch).await?;
    }
    builder.finish().await?;
    Ok(scratch)
}

async fn edit(obstacles: &[Obstacle]) -> Scratch {
    let (scratch, _) = built(&grid(), BuildOptions::default().tile_vertices(9)).await;
    let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(64 << 20))
        .await
        .unwrap()
        .begin()
        .await
        .unwrap();
    let mut first = 0;
    for obstacle in obstacles {
        transaction
            .constrain(LineKind::Obstacle, first, &obstacle.batch(first))
            .unwrap();
        first += obstacle.lines();
    }
    transaction.add_sources(line_sources(obstacles));
    transaction.commit().await.unwrap();
    scratch
}

/// Verifies a file, and compares the coverage by each obstacle with the windings of its rings, at a
/// point of each triangle that is not tiny.
async fn check(scratch: &Scratch, obstacles: &[Obstacle]) -> Stored {
    let reader = scratch.open().await;
    let lists = reader.lists().await.unwrap();
    reader.verify(true).await.unwrap();
    let (mut edges, mut triangles) = (BTreeMap::new(), Vec::new());
    let mut of_polygon: HashMap<u64, Ring> = HashMap::new();
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.try_next().await.unwrap() {
        triangles.extend(tile.owned_triangles().map(|t| (tile.triangle_points(t), tile.depth(t))));
        for edge in tile.owned_constraints() {
            let [a, b] = tile.ends(edge).map(|end| end.point);
            let mut sources: Vec<LinePart> = tile.edge_parts(edge).collect();
            for source in &sources {
                let polygon = of_polygon.entry(lists.polygon(source.number())).or_default();
                polygon.push(if source.depth_change() > 0 { [a, b] } else { [b, a] });
            }
            let mut key = [a, b];
            if b.lex_cmp(a).is_lt() {
                key.reverse();
                sources.iter_mut().for_each(|source| *source = source.reversed());
            }
            sources.sort_unstable();
            edges.insert(key.map(|p| [p.x, p.y].map(f64::to_bits)), sources);
        }
    }
    let mut checked = 0;
    for ([a, b, c], depth) in triangles {
        if (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) < 1e-6 {
            continue;
        }
        let middle = Point::new((a.x + b.x + c.x) / 3.0, (a.y + b.y + c.y) / 3.0);
        let (mut expected, mut first) = (0, 0);
        for obstacle in obstacles {
            let covers = obstacle.covers(middle);
            let stored = of_polygon.get(&first).map_or(0, |polygon| winding(polygon, middle));
            assert_eq!(stored, covers, "obstacle {first} at {middle:?}");
            expected += covers;
            first += obstacle.lines();
        }
        assert_eq!(depth, expected, "at {middle:?}");
        checked += 1;
    }
    assert!(checked > SIZE * SIZE, "{checked}");
    let lines: u64 = obstacles.iter().map(Obstacle::lines).sum();
    Stored {
        edges,
        polygons: (0..lines).map(|line| lists.polygon(line)).collect(),
    }
}

#[test]
fn obstacles_that_overlap_themselves_cover_each_point_once() {
    runtime().block_on(async {
        for seed in 0..12 {
            let mut random = Random(seed);
            let obstacles = random_obstacles(&mut random, 1);
            let options =
                |tile_vertices, threads| BuildOptions::default().tile_vertices(tile_vertices).threads(threads);
            let expected = check(&build(&obstacles, options(9, 2)).await.unwrap(), &obstacles).await;
            let mut line = 0;
            for obstacle in &obstacles {
                let lines = line..line + obstacle.lines();
                assert!(lines.clone().all(|its| expected.polygons[its as usize] == line));
                line = lines.end;
            }
            let split = options(1 << 16, 1).crossings(Crossings::Split);
            for options in [options(4, 1), options(1 << 16, 1), split] {
                let same = build(&obstacles, options).await.unwrap();
                assert_eq!(check(&same, &obstacles).await, expected, "{seed}");
            }
            assert_eq!(check(&edit(&obstacles).await, &obstacles).await, expected, "{seed}");
            let mut turned = obstacles.clone();
            for obstacle in &mut turned {
                for polygon in &mut obstacle.polygons {
                    polygon.iter_mut().for_each(|ring| random.shuffle(ring));
                    if !obstacle.ring_lines {
                        random.shuffle(polygon);
                    }
                }
                random.shuffle(&mut obstacle.polygons);
            }
            let same = build(&turned, options(9, 2)).await.unwrap();
            assert_eq!(check(&same, &turned).await, expected, "{seed}");
        }
    });
}

#[test]
fn obstacles_whose_rings_cross_cover_each_point_once_if_they_are_split() {
    runtime().block_on(async {
        for seed in 0..20 {
            let mut random = Random(100 + seed);
            let mut obstacles = random_obstacles(&mut random, SIZE);
            // A random ring crosses itself in points that are rounded. It may be inside out.
            let corners: Vec<Point> = (0..7)
                .map(|_| at(random.below(SIZE + 1), random.below(SIZE + 1)))
                .collect();
            let ring = (0..7).map(|i| [corners[i], corners[(i + 1) % 7]]);
            obstacles.push(Obstacle {
                polygons: vec![vec![ring.collect()]],
                ring_lines: false,
            });
            let mut all = Vec::new();
            for tile_vertices in [8, 1 << 16] {
                let options = BuildOptions::default()
                    .tile_vertices(tile_vertices)
                    .crossings(Crossings::Split);
                all.push(check(&build(&obstacles, options).await.unwrap(), &obstacles).await);
            }
            assert_eq!(all[0], all[1], "{seed}");
        }
    });
}

/// Compares a file with its obstacles as they were given, or normalised.
async fn has_lines(reader: &TileReader, obstacles: &[Obstacle], is_normalised: bool) -> Result<(), VerifyError> {
    let mut check = PolygonCheck::new(&std::env::temp_dir(), 1 << 20);
    let (mut all, mut first) = (Vec::new(), 0);
    for obstacle in obstacles {
        let batch = obstacle.batch(first);
        check.push(first, &batch).unwrap();
        let sources = batch
            .lines
            .iter()
            .map(|line| LinePart::whole(EdgeSource::new(LineKind::Obstacle, first + line)));
        all.push(LineBatch {
            sources: sources.collect(),
            ends: batch.ends,
        });
        first += obstacle.lines();
    }
    check.finish().unwrap();
    let mut normalizer = check.normalizer().filter(|_| is_normalised);
    let mut all = all.into_iter();
    let next = |batch: &mut LineBatch| {
        let Some(next) = all.next() else { return Ok(false) };
        *batch = next;
        if let Some(normalizer) = &mut normalizer {
            normalizer.normalize(batch);
        }
        Ok::<_, String>(true)
    };
    reader.verify_lines(next).await.map(|_| ())
}

#[test]
fn a_file_has_the_normalised_segments_of_its_obstacles_and_no_others() {
    runtime().block_on(async {
        let obstacles = random_obstacles(&mut Random(77), 1);
        let scratch = build(&obstacles, BuildOptions::default().tile_vertices(9))
            .await
            .unwrap();
        let reader = scratch.open().await;
        has_lines(&reader, &obstacles, true).await.unwrap();
        assert!(has_lines(&reader, &obstacles, false).await.is_err());
        assert!(has_lines(&reader, &obstacles[1..], true).await.is_err());
    });
}

/// If lines are not split, a ring that crosses itself in a vertex is refused if it covers something
/// twice there: it would have to be cut where other inputs decide.
#[test]
fn an_obstacle_that_crosses_itself_in_a_vertex_and_covers_a_point_twice_is_refused() {
    runtime().block_on(async {
        let cross = Obstacle {
            polygons: vec![vec![rectangle([0, 2], [6, 4], SIZE), rectangle([2, 0], [4, 6], SIZE)]],
            ring_lines: false,
        };
        let obstacles = [cross];
        let options = BuildOptions::default();
        match build(&obstacles, options.clone()).await.map(|_| ()) {
            Err(BuildError::Overlapping(found)) => assert_eq!((found.obstacle, found.point), (0, at(2, 2))),
            other => panic!("{other:?}"),
        }
        let split = build(&obstacles, options.crossings(Crossings::Split)).await.unwrap();
        check(&split, &obstacles).await;
    });
}

/// Builds from squares in rows and a comb of `teeth` teeth, all of them obstacles. `twice` repeats
/// an obstacle, so that the file has it twice under one number.
async fn square_and_comb(teeth: u32, twice: Option<u64>) -> Scratch {
    let ring = |corners: &[Point]| -> Ring {
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).map(|(&a, &b)| [a, b]).collect()
    };
    let mut all: Vec<Ring> = Vec::new();
    for i in 0..3000u32 {
        let [x, y] = [i % 60, i / 60].map(|place| 3.0 * f64::from(place));
        let corners = [[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]];
        all.push(ring(&corners.map(|[x, y]| Point::new(x, y))));
    }
    let mut corners = vec![Point::new(-10.0, -20.0), Point::new(200.0, -20.0)];
    for tooth in (0..teeth).rev() {
        let x = 200.0 * f64::from(tooth) / f64::from(teeth);
        corners.extend([Point::new(x + 0.015, -12.0), Point::new(x, -18.0)]);
    }
    all.push(ring(&corners));
    let scratch = Scratch::new();
    let options = BuildOptions::default().tile_vertices(200).threads(2);
    let mut builder = Builder::new(&scratch.path, options).unwrap();
    let source = |name: &str, first, lines| LineSource {
        name: name.to_owned(),
        kind: LineKind::Obstacle,
        first,
        lines,
        edit: 0,
    };
    builder.describe(Description {
        lines: vec![source("squares", 0, 3000), source("comb", 3000, 1)],
        ..Description::default()
    });
    // Not beside each other, where they would be one obstacle.
    let (before, after) = (
        twice.filter(|&number| number >= 1500),
        twice.filter(|&number| number < 1500),
    );
    let numbers = before.into_iter().chain(0..all.len() as u64).chain(after);
    for number in numbers {
        let ends = all[number as usize].clone();
        let batch = SegmentBatch {
            lines: vec![0; ends.len()],
            ends,
            ..SegmentBatch::default()
        };
        builder.push_lines(LineKind::Obstacle, number, &batch).unwrap();
    }
    builder.finish().await.unwrap();
    scratch
}

/// A number that two obstacles have stands for an obstacle that overlaps itself.
#[test]
fn verify_names_the_polygon_that_covers_a_part_twice_in_little_memory_too() {
    runtime().block_on(async {
        for twice in [None, Some(0), Some(1717), Some(2999), Some(3000)] {
            let scratch = square_and_comb(6000, twice).await;
            for memory in [Some(2 << 20), None] {
                let options = OpenOptions::default();
                let options = memory.map_or(options.clone(), |memory| options.memory(memory));
                let reader = TileReader::open(&scratch.path, options).await.unwrap();
                reader.verify(false).await.unwrap();
                let found = match reader.verify(true).await {
                    Ok(_) => None,
                    Err(VerifyError::Polygon {
                        polygon,
                        file,
                        line,
                        reason,
                    }) => {
                        assert!(reason.starts_with("covers a part more than once at ("), "{reason}");
                        let expected = if polygon < 3000 {
                            ("squares", polygon)
                        } else {
                            ("comb", 0)
                        };
                        assert_eq!((&*file, line), expected);
                        Some(polygon)
                    }
                    Err(error) => panic!("{error}"),
                };
                assert_eq!(found, twice, "{memory:?}");
            }
        }
    });
}
