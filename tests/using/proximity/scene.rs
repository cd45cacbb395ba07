//! Scenes to walk in: by hand, and at random.

use std::ops::Range;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::store::{Cache, LineKind, LineSource, OpenOptions, TileReader};
use delaunay_tiles::{BuildOptions, Builder, Crossings, Description};
use proptest::prelude::*;

use crate::support::{Random, Scratch, batches};

/// A polyline, or the directed ring of an obstacle.
pub type SceneLine = (LineKind, Vec<Point>);

/// The input of a file.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub points: Vec<Point>,
    pub lines: Vec<SceneLine>,
    pub seeds: Vec<Point>,
    pub sites: Vec<Point>,
    pub exterior_is_hole: bool,
}

pub fn at(x: i32, y: i32) -> Point {
    Point::new(x.into(), y.into())
}

pub fn line(kind: LineKind, corners: &[(i32, i32)]) -> SceneLine {
    (kind, corners.iter().map(|&(x, y)| at(x, y)).collect())
}

pub fn wall(corners: &[(i32, i32)]) -> SceneLine {
    line(LineKind::Wall, corners)
}

/// Returns the ring of an obstacle, counter-clockwise.
pub fn block([x, y]: [i32; 2], [width, height]: [i32; 2]) -> SceneLine {
    let (right, top) = (x + width, y + height);
    line(
        LineKind::Obstacle,
        &[(x, y), (right, y), (right, top), (x, top), (x, y)],
    )
}

/// The kinds of lines that blocks may have; all but the first are obstacles to a walk.
pub const KINDS: [LineKind; 4] = [
    LineKind::BreakLine,
    LineKind::Wall,
    LineKind::Obstacle,
    LineKind::Obstacle,
];

/// Generates `count` blocks of these kinds, and walls, with corners on a grid. All points of the
/// grid are vertices, or only the corners of the room.
pub fn blocks_and_walls(count: Range<usize>, kinds: &'static [LineKind]) -> impl Strategy<Value = Scene> {
    let rectangle = (0i32..7, 0i32..7, 1i32..4, 1i32..4, 0usize..8);
    let rectangles = prop::collection::vec(rectangle, count);
    let walls = prop::collection::vec(prop::collection::vec((0i32..9, 0i32..9), 2..5), 0..4);
    let parts = (rectangles, walls, prop::bool::weighted(0.2), any::<bool>());
    parts.prop_map(|(rectangles, walls, exterior_is_hole, is_dense)| {
        let rectangles = rectangles.into_iter();
        let blocks = rectangles.map(|(x, y, width, height, how)| {
            let (_, corners) = block([x, y], [width, height]);
            (kinds[how * kinds.len() / 8], corners)
        });
        let walls = walls.iter().map(|corners| wall(corners));
        let walls = walls.filter(|(_, corners)| corners.windows(2).all(|pair| pair[0] != pair[1]));
        let lines = blocks.chain(walls).collect();
        let scene = match is_dense {
            true => Scene::on_grid(10, 10, lines),
            false => Scene::in_room(10, lines),
        };
        Scene {
            exterior_is_hole,
            ..scene
        }
    })
}

/// Returns hard scenes, with names.
pub fn by_hand() -> Vec<(&'static str, Scene)> {
    let spiral = wall(&[(1, 1), (9, 1), (9, 9), (2, 9), (2, 3), (7, 3), (7, 7), (4, 7), (4, 5)]);
    let comb = (0..5).map(|i| {
        wall(&[
            (1 + 2 * i, if i % 2 == 0 { 0 } else { 2 }),
            (1 + 2 * i, if i % 2 == 0 { 8 } else { 10 }),
        ])
    });
    vec![
        ("nothing in the way", Scene::in_room(10, vec![])),
        ("one wall", Scene::in_room(10, vec![wall(&[(5, 2), (5, 8)])])),
        ("a spiral", Scene::in_room(10, vec![spiral.clone()])),
        ("a spiral on a grid", Scene::on_grid(11, 11, vec![spiral])),
        ("a comb", Scene::in_room(10, comb.clone().collect())),
        ("a comb on a grid", Scene::on_grid(11, 11, comb.collect())),
        (
            "walls through from hull to hull",
            Scene::in_room(10, vec![wall(&[(5, 0), (5, 10)]), wall(&[(0, 5), (10, 5)])]),
        ),
        (
            "touching corners",
            Scene::on_grid(
                9,
                9,
                vec![block([1, 1], [3, 3]), block([4, 4], [3, 3]), block([1, 4], [3, 3])],
            ),
        ),
        (
            "shared walls",
            Scene::on_grid(
                9,
                9,
                vec![block([1, 2], [3, 3]), block([4, 2], [2, 5]), block([6, 3], [1, 2])],
            ),
        ),
        (
            "tees",
            Scene::on_grid(
                9,
                9,
                vec![
                    wall(&[(1, 4), (7, 4)]),
                    wall(&[(4, 4), (4, 8)]),
                    wall(&[(2, 4), (2, 1)]),
                ],
            ),
        ),
        (
            "the island is the hull",
            Scene {
                lines: vec![block([0, 0], [6, 4])],
                ..Scene::default()
            },
        ),
        (
            "the island is a hull of many points",
            Scene::on_grid(5, 5, vec![block([0, 0], [4, 4])]),
        ),
        (
            "walls on the hull",
            Scene::on_grid(5, 5, vec![wall(&[(0, 0), (4, 0), (4, 4), (1, 4)])]),
        ),
        (
            "a closed wall",
            Scene::on_grid(9, 9, vec![wall(&[(2, 2), (6, 2), (6, 6), (2, 6), (2, 2)])]),
        ),
        (
            "a lake with an island",
            Scene::on_grid(
                9,
                9,
                vec![
                    block([1, 1], [7, 7]),
                    line(LineKind::Obstacle, &[(2, 2), (2, 6), (6, 6), (6, 2), (2, 2)]),
                    block([3, 3], [1, 1]),
                ],
            ),
        ),
        (
            "a wall into a corner",
            Scene::on_grid(
                7,
                7,
                vec![block([2, 2], [2, 2]), wall(&[(4, 4), (6, 6)]), wall(&[(2, 2), (0, 0)])],
            ),
        ),
    ]
}

impl Scene {
    /// Creates a scene with all points of a grid, so that lines along it may cross there.
    pub fn on_grid(width: i32, height: i32, lines: Vec<SceneLine>) -> Self {
        let points = (0..width).flat_map(|x| (0..height).map(move |y| at(x, y)));
        Self {
            points: points.collect(),
            lines,
            ..Self::default()
        }
    }

    /// Creates a scene with the four corners of a room, and lines in it.
    pub fn in_room(size: i32, lines: Vec<SceneLine>) -> Self {
        Self {
            points: vec![at(0, 0), at(size, 0), at(size, size), at(0, size)],
            lines,
            ..Self::default()
        }
    }

    /// Creates a scene of square blocks in `across` rows and columns, with lanes between and around
    /// them.
    pub fn town(blocks_per_side: i32) -> Self {
        let blocks = (0..blocks_per_side * blocks_per_side)
            .map(|i| block([2 + 5 * (i % blocks_per_side), 2 + 5 * (i / blocks_per_side)], [3, 3]));
        let size = 5 * blocks_per_side + 3;
        Self::on_grid(size, size, blocks.collect())
    }

    /// Creates a town with `count` sites beside its lanes.
    pub fn town_with_sites(blocks_per_side: i32, count: usize, random: &mut Random) -> Self {
        let mut coordinate = |most: i32| random.below(most as usize) as i32;
        let sites = (0..count).map(|_| at(5 * coordinate(blocks_per_side + 1), coordinate(5 * blocks_per_side + 3)));
        Self {
            sites: sites.collect(),
            ..Self::town(blocks_per_side)
        }
    }

    /// Creates a scene of a few blocks and walls with corners on a grid, all points of which are
    /// vertices if `is_dense`.
    pub fn few_blocks(random: &mut Random, is_dense: bool) -> Self {
        let mut below = |most: usize| random.below(most) as i32;
        let blocks = (0..2 + below(4)).map(|_| block([below(7), below(7)], [1 + below(3), 1 + below(3)]));
        let mut lines: Vec<SceneLine> = blocks.collect();
        lines.extend((0..below(3)).map(|_| wall(&[(below(4), below(9)), (5 + below(5), below(9)), (4, 10)])));
        match is_dense {
            true => Self::on_grid(10, 10, lines),
            false => Self::in_room(11, lines),
        }
    }

    /// Creates walls and obstacles with up to four corners anywhere, and points.
    pub fn triangles_anywhere(random: &mut Random) -> Self {
        let point = |random: &mut Random| Point::new(random.unit() * 10.0, random.unit() * 10.0);
        let mut this = Self::default();
        for _ in 0..random.below(10) {
            let corners = (0..2 + random.below(3)).map(|_| point(random)).collect();
            this.lines.push((LineKind::Wall, corners));
        }
        for _ in 0..random.below(4) {
            let mut corners: Vec<Point> = (0..3).map(|_| point(random)).collect();
            corners.push(corners[0]);
            this.lines.push((LineKind::Obstacle, corners));
        }
        this.points = (0..20).map(|_| point(random)).collect();
        this
    }

    /// Creates obstacles with many corners anywhere, polylines of these kinds through them, and
    /// points.
    pub fn polygons_anywhere(random: &mut Random, kinds: &[LineKind]) -> Self {
        let mut this = Self::default();
        for _ in 0..2 + random.below(4) {
            let (x, y, size) = (random.unit() * 10.0, random.unit() * 10.0, 0.5 + 2.0 * random.unit());
            let corners = 3 + random.below(6);
            let corner = |i: usize, far: f64| {
                let turn = std::f64::consts::TAU * i as f64 / corners as f64;
                Point::new(x + far * turn.cos(), y + far * turn.sin())
            };
            let ring = (0..corners).map(|i| corner(i, size * (0.3 + random.unit())));
            let mut ring: Vec<Point> = ring.collect();
            ring.push(ring[0]);
            this.lines.push((LineKind::Obstacle, ring));
        }
        for _ in 0..random.below(8) {
            let corners = (0..2 + random.below(3)).map(|_| Point::new(random.unit() * 10.0, random.unit() * 10.0));
            let corners = corners.collect();
            this.lines.push((kinds[random.below(kinds.len())], corners));
        }
        let points = (0..20).map(|_| Point::new(random.unit() * 12.0 - 1.0, random.unit() * 12.0 - 1.0));
        this.points = points.collect();
        this
    }

    pub async fn build(&self, tile_vertices: usize) -> (Scratch, TileReader) {
        let scratch = Scratch::new();
        let options = BuildOptions::default()
            .tile_vertices(tile_vertices)
            .threads(2)
            .crossings(Crossings::Split)
            .exterior_is_hole(self.exterior_is_hole);
        let mut builder = Builder::new(&scratch.path, options).unwrap();
        let lines = self.lines.iter().zip(0..).map(|((kind, _), first)| LineSource {
            name: format!("line {first}"),
            kind: *kind,
            first,
            lines: 1,
            edit: 0,
        });
        builder.describe(Description {
            lines: lines.collect(),
            ..Description::default()
        });
        for ((kind, corners), number) in self.lines.iter().zip(0..) {
            let ends: Vec<[Point; 2]> = corners.windows(2).map(|pair| [pair[0], pair[1]]).collect();
            let batch = SegmentBatch {
                lines: vec![0; ends.len()],
                ends,
                ..SegmentBatch::default()
            };
            builder.push_lines(*kind, number, &batch).unwrap();
        }
        builder.push_seeds(&self.seeds).unwrap();
        builder
            .push_sites(&SiteBatch {
                points: self.sites.clone(),
                ids: (0..self.sites.len() as u64).map(SiteId::Number).collect(),
                ..SiteBatch::default()
            })
            .unwrap();
        for batch in batches(&self.points, &[]) {
            builder.push(&batch).await.unwrap();
        }
        builder.finish().await.unwrap();
        let reader = open(&scratch, usize::MAX).await;
        (scratch, reader)
    }

    /// Returns vertices, points between and beyond two vertices, and middles of lines' segments.
    pub fn targets(&self, random: &mut Random, count: usize) -> Vec<Point> {
        let all: Vec<Point> = self
            .points
            .iter()
            .chain(self.lines.iter().flat_map(|line| &line.1))
            .copied()
            .collect();
        let any = |random: &mut Random| all[random.below(all.len())];
        let mut targets = Vec::new();
        while targets.len() < count {
            let (a, b) = (any(random), any(random));
            let part = [0.0, 0.5, 0.25, random.unit(), -0.5, 1.75][random.below(6)];
            let between = Point::new(a.x + part * (b.x - a.x), a.y + part * (b.y - a.y));
            let (lines, index) = (&self.lines, random.below(self.lines.len().max(1)));
            targets.push(match (random.below(4), lines.get(index)) {
                (0, Some((_, corners))) => {
                    let first = random.below(corners.len() - 1);
                    let [a, b] = [corners[first], corners[first + 1]];
                    Point::new(a.x + 0.5 * (b.x - a.x), a.y + 0.5 * (b.y - a.y))
                }
                (1, _) => a,
                _ => between,
            });
        }
        targets
    }
}

/// Opens a file with a cache of `cache` bytes.
pub async fn open(scratch: &Scratch, cache: usize) -> TileReader {
    let cache = Cache::new(cache.min(1 << 30));
    TileReader::open(&scratch.path, OpenOptions::default().cache(&cache))
        .await
        .unwrap()
}
