//! Scenes to walk in.

use delaunay_tiles::build::{BuildOptions, Builder, Crossings, Description};
use delaunay_tiles::geometry::Point;
use delaunay_tiles::input::{SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::store::{Cache, LineKind, LineSource, OpenOptions, TileReader};

use crate::support::{Random, Scratch, batches};

/// A polyline, or the directed ring of an obstacle.
pub type Line = (LineKind, Vec<Point>);

/// What a file is built of.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub points: Vec<Point>,
    pub lines: Vec<Line>,
    pub seeds: Vec<Point>,
    pub sites: Vec<Point>,
    pub exterior_is_hole: bool,
}

pub fn at(x: i32, y: i32) -> Point {
    Point::new(x.into(), y.into())
}

pub fn line(kind: LineKind, corners: &[(i32, i32)]) -> Line {
    (kind, corners.iter().map(|&(x, y)| at(x, y)).collect())
}

pub fn wall(corners: &[(i32, i32)]) -> Line {
    line(LineKind::Wall, corners)
}

/// The ring of an obstacle, counter-clockwise.
pub fn block([x, y]: [i32; 2], [width, height]: [i32; 2]) -> Line {
    let (right, top) = (x + width, y + height);
    line(
        LineKind::Obstacle,
        &[(x, y), (right, y), (right, top), (x, top), (x, y)],
    )
}

/// Scenes with names, of what is hard.
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
    /// All points of a grid, so that lines along it may cross there.
    pub fn on_grid(width: i32, height: i32, lines: Vec<Line>) -> Self {
        let points = (0..width).flat_map(|x| (0..height).map(move |y| at(x, y)));
        Self {
            points: points.collect(),
            lines,
            ..Self::default()
        }
    }

    /// The four corners of a room, and lines in it.
    pub fn in_room(size: i32, lines: Vec<Line>) -> Self {
        Self {
            points: vec![at(0, 0), at(size, 0), at(size, size), at(0, size)],
            lines,
            ..Self::default()
        }
    }

    pub async fn build(&self, tile_vertices: usize) -> (Scratch, TileReader) {
        let scratch = Scratch::new();
        let options = BuildOptions {
            tile_vertices,
            threads: 2,
            crossings: Crossings::Split,
            exterior_is_hole: self.exterior_is_hole,
            ..BuildOptions::default()
        };
        let mut builder = Builder::new(&scratch.path, options).unwrap();
        let lines = self.lines.iter().zip(0..).map(|((kind, _), first)| LineSource {
            name: format!("line {first}"),
            kind: *kind,
            first,
            lines: 1,
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

    /// Vertices, middles between them, others, and places outside.
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
            let (corners, place) = (&self.lines, random.below(self.lines.len().max(1)));
            targets.push(match (random.below(4), corners.get(place)) {
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

/// Opens a file with a cache of so many bytes.
pub async fn open(scratch: &Scratch, cache: usize) -> TileReader {
    let cache = Cache::new(cache.min(1 << 30));
    TileReader::open(&scratch.path, OpenOptions::default().cache(&cache))
        .await
        .unwrap()
}
