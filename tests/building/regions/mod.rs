//! The promise: regions, their depths under obstacles, holes, walls, the sources of edges, and
//! sites are those of an in-core search. They do not depend on the tile size, the memory, the
//! threads, or the order and direction of the lines. `verify` proves them.

mod reference;

use std::collections::HashMap;

use self::reference::{Expected, key};
use crate::support::cases::{by_turns, cases};
use crate::support::{Random, Scratch, batches, runtime, runtime_for, verify_lines};
use delaunay_tiles::geometry::{Orientation, Point, area_sign, orient2d};
use delaunay_tiles::input::{SegmentBatch, SiteBatch, SiteId};
use delaunay_tiles::store::{EdgeSource, LineKind, LinePart, TileReader, VerifyError};
use delaunay_tiles::{
    BuildError, BuildOptions, BuildSummary, Builder, Crossings, EditError, EditOptions, EditSummary, Editor,
};
use futures::TryStreamExt;
use proptest::prelude::*;

/// Polylines, or the directed rings of an obstacle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct InputLine {
    kind: LineKind,
    rings: Vec<Vec<Point>>,
}

impl InputLine {
    fn new(kind: LineKind, corners: &[(i32, i32)]) -> Self {
        let corners = corners.iter().map(|&(x, y)| Point::new(x.into(), y.into()));
        Self {
            kind,
            rings: vec![corners.collect()],
        }
    }

    /// Creates the outline of a rectangle, counter-clockwise: the ring of an obstacle, or,
    /// reversed, of a hole in one.
    fn rectangle(kind: LineKind, [x, y]: [i32; 2], [width, height]: [i32; 2]) -> Self {
        let (right, top) = (x + width, y + height);
        Self::new(kind, &[(x, y), (right, y), (right, top), (x, top), (x, y)])
    }

    fn turned(mut self) -> Self {
        self.rings.iter_mut().for_each(|ring| ring.reverse());
        self
    }

    /// Adds a hole with the outline of another line.
    fn without(mut self, hole: Self) -> Self {
        self.rings.extend(hole.turned().rings);
        self
    }

    fn corners(&self) -> impl Iterator<Item = &Point> {
        self.rings.iter().flatten()
    }

    fn segments(&self) -> impl Iterator<Item = [Point; 2]> {
        let rings = self.rings.iter().flat_map(|ring| ring.windows(2));
        rings.map(|pair| [pair[0], pair[1]])
    }

    /// Returns whether it is the ring of an obstacle with the wrong direction.
    fn is_inverted(&self) -> bool {
        let [ring] = &*self.rings else { return false };
        self.kind == LineKind::Obstacle && area_sign(ring.iter().copied()).is_lt()
    }
}

/// The input of a build.
#[derive(Clone, Debug, Default)]
pub(crate) struct Input {
    points: Vec<Point>,
    lines: Vec<InputLine>,
    seeds: Vec<Point>,
    exterior_is_hole: bool,
    /// Whether rings may be nested wrongly.
    may_be_inverted: bool,
    sites: Vec<(Point, SiteId)>,
    /// What a file stores instead of the lines, if an obstacle overlaps itself.
    stored: Option<Vec<InputLine>>,
}

impl Input {
    /// Creates an input with all points of a grid, so that lines along it may cross there.
    fn on_grid(size: i32, lines: Vec<InputLine>) -> Self {
        let points = (0..size).flat_map(|x| (0..size).map(move |y| Point::new(x.into(), y.into())));
        Self {
            points: points.collect(),
            lines,
            ..Self::default()
        }
    }

    async fn build(&self, scratch: &Scratch, options: BuildOptions) -> Result<BuildSummary, BuildError> {
        let options = options
            .exterior_is_hole(self.exterior_is_hole)
            .crossings(match self.may_be_inverted {
                true => Crossings::Split,
                false => Crossings::Error,
            });
        let mut builder = Builder::new(&scratch.path, options)?;
        let mut numbered: Vec<(u64, &InputLine)> = (0..).zip(&self.lines).collect();
        // The order does not matter.
        Random(self.points.len() as u64).shuffle(&mut numbered);
        for (number, line) in numbered {
            let ends: Vec<[Point; 2]> = line.segments().collect();
            let batch = SegmentBatch {
                lines: vec![0; ends.len()],
                ends,
                ..SegmentBatch::default()
            };
            builder.push_lines(line.kind, number, &batch)?;
        }
        builder.push_seeds(&self.seeds)?;
        builder.push_sites(&SiteBatch {
            points: self.sites.iter().map(|(point, _)| *point).collect(),
            ids: self.sites.iter().map(|(_, id)| id.clone()).collect(),
            ..SiteBatch::default()
        })?;
        for batch in batches(&self.points, &[]) {
            builder.push(&batch).await?;
        }
        builder.finish().await
    }

    /// Returns the input with all obstacles in the right direction, as a build that splits lines
    /// covers them, and each of them covering each point once.
    fn put_right(&self) -> Self {
        let turn = |line: &InputLine| match line.is_inverted() {
            true => line.clone().turned(),
            false => line.clone(),
        };
        Self {
            lines: self.stored.as_ref().unwrap_or(&self.lines).iter().map(turn).collect(),
            ..self.clone()
        }
    }

    /// Builds a file with the first `built` lines, and with the corners of the others if
    /// `has_corners`, and inserts the others in an edit. Returns `None` if the file has no
    /// triangles, if there are no other lines, or if the first lines cross without their corners.
    async fn build_and_edit(
        &self,
        (built, has_corners): (usize, bool),
        tile_vertices: usize,
    ) -> Option<(Scratch, EditSummary)> {
        let corners = self.lines.iter().flat_map(InputLine::corners);
        let corners = corners.filter(|_| has_corners);
        let first = Self {
            points: self.points.iter().chain(corners).copied().collect(),
            lines: self.lines[..built].to_vec(),
            may_be_inverted: true,
            ..self.clone()
        };
        let options = BuildOptions::default().tile_vertices(tile_vertices).memory(ENOUGH);
        let scratch = Scratch::new();
        let summary = match first.build(&scratch, options).await {
            Err(BuildError::Crossings { .. }) if !has_corners => return None,
            built => built.unwrap(),
        };
        if summary.triangles == 0 || built == self.lines.len() {
            return None;
        }
        let segments: usize = self.lines.iter().map(|line| line.segments().count()).sum();
        // So little memory that tiles must leave the cache and come back.
        let memory = (256 << 10) + 400 * segments as u64;
        let mut transaction = Editor::open(&scratch.path, EditOptions::default().memory(memory))
            .await
            .unwrap()
            .begin()
            .await
            .unwrap();
        for (line, number) in self.lines.iter().zip(0..).skip(built) {
            let ends: Vec<[Point; 2]> = line.segments().collect();
            let batch = SegmentBatch {
                lines: vec![0; ends.len()],
                ends,
                ..SegmentBatch::default()
            };
            transaction.constrain(line.kind, number, &batch).unwrap();
        }
        let edited = transaction.commit().await;
        if self.lines[built..].iter().any(InputLine::is_inverted) {
            assert!(matches!(edited, Err(EditError::Inverted { .. })), "{edited:?}");
            return None;
        }
        Some((scratch, edited.unwrap()))
    }

    /// Compares a file with lines and sites. An end counts if one of the segments of `given`, which
    /// these lines replace, ends there and runs along.
    async fn compare(&self, reader: &TileReader, given: &Self) -> Result<(), VerifyError> {
        let numbered = self.lines.iter().zip(&given.lines).zip(0..);
        let lines = numbered.flat_map(|((line, given), number)| {
            let source = EdgeSource::new(line.kind, number);
            line.segments().map(move |ends| {
                let along = given.segments().filter(|its| ends.iter().all(|&end| is_on(*its, end)));
                let at: Vec<Point> = along.flatten().collect();
                let [begins, is_end] = ends.map(|end| at.contains(&end));
                (ends, LinePart::of(source, begins, is_end))
            })
        });
        verify_lines(reader, lines.collect()).await?;
        let mut sites = self.sites.chunks(2);
        let next = |batch: &mut SiteBatch| -> Result<bool, String> {
            let Some(chunk) = sites.next() else { return Ok(false) };
            (batch.points, batch.ids) = chunk.iter().cloned().unzip();
            Ok(true)
        };
        reader.verify_sites(next).await.map(|_| ())
    }
}

fn is_on([a, b]: [Point; 2], p: Point) -> bool {
    let is_between = |a: f64, b: f64, c: f64| a.min(b) <= c && c <= a.max(b);
    orient2d(a, b, p) == Orientation::Collinear && is_between(a.x, b.x, p.x) && is_between(a.y, b.y, p.y)
}

/// (tile vertices, merge vertices, threads, memory)
type Way = (usize, usize, usize, u64);

const ENOUGH: u64 = 1 << 30;
const WAYS: [Way; 5] = [
    (4, 8, 1, ENOUGH),
    // The lines need more than the share of a leaf, so some are deferred.
    (40, 1 << 16, 2, 1 << 20),
    (9, 1 << 16, 2, ENOUGH),
    (40, 100, 3, ENOUGH),
    (1 << 16, 1 << 16, 1, ENOUGH),
];

/// Builds in all `ways`, and compares with what an in-core search finds. Returns the number of
/// deferred segments in all.
fn check(input: &Input, ways: &[Way]) -> u64 {
    let mut deferred = 0;
    let right = input.put_right();
    let expected = Expected::of(&right);
    let input = &Input {
        may_be_inverted: input.lines.iter().any(InputLine::is_inverted),
        ..input.clone()
    };
    let mut digests = Vec::new();
    let ways = ways.iter().filter(|way| !input.may_be_inverted || way.3 == ENOUGH);
    for (round, &(tile_vertices, merge_vertices, threads, memory)) in ways.enumerate() {
        runtime_for(threads).block_on(async {
            let scratch = Scratch::new();
            let options = BuildOptions::default()
                .tile_vertices(tile_vertices)
                .merge_vertices(merge_vertices)
                .threads(threads)
                .memory(memory);
            if input.may_be_inverted {
                let strict = Input {
                    may_be_inverted: false,
                    ..input.clone()
                };
                let refused = strict.build(&scratch, options.clone()).await;
                assert!(matches!(refused, Err(BuildError::Inverted { .. })), "{refused:?}");
            }
            let summary = input.build(&scratch, options).await.unwrap();
            deferred += summary.deferred_segments;
            assert_eq!(
                summary.sites_in_holes, expected.sites_in_holes,
                "tiles of {tile_vertices}"
            );
            let reader = scratch.open().await;
            let counts = [summary.regions, summary.hole_regions, summary.hole_triangles];
            compare(&expected, &reader, counts).await;
            if let Err(error) = reader.verify(true).await {
                panic!("tiles of {tile_vertices}: {error}");
            }
            if let Err(error) = right.compare(&reader, input).await {
                panic!("tiles of {tile_vertices}: {error}");
            }
            digests.push(reader.recompute_digest().await.unwrap());
            let half = input.lines.len() / 2;
            for built in by_turns(&[(0, true), (half, true), (half, false), (0, false)], round) {
                let edited = input.build_and_edit(built, tile_vertices).await;
                let Some((scratch, summary)) = edited else { continue };
                let reader = scratch.open().await;
                let way = format!("tiles of {tile_vertices}, {built:?} lines and corners from the start");
                compare(
                    &expected,
                    &reader,
                    [summary.regions, summary.hole_regions, summary.hole_triangles],
                )
                .await;
                if let Err(error) = reader.verify(true).await {
                    panic!("{way}: {error}");
                }
                if let Err(error) = right.compare(&reader, input).await {
                    panic!("{way}: {error}");
                }
                digests.push(reader.recompute_digest().await.unwrap());
            }
        });
    }
    assert!(digests.windows(2).all(|pair| pair[0] == pair[1]), "{digests:?}");
    deferred
}

fn site_at_each_point(input: &Input) -> Vec<(Point, SiteId)> {
    let numbered = input.points.iter().zip(0..);
    numbered
        .map(|(&point, number)| (point, SiteId::Number(number)))
        .collect()
}

/// Compares a file with what is expected; `counts` are its regions, hole regions and hole
/// triangles.
async fn compare(expected: &Expected, reader: &TileReader, counts: [u64; 3]) {
    let mut region_of: HashMap<u64, usize> = HashMap::new();
    let (mut holes, mut triangles, mut sites) = (0, 0, Vec::new());
    let mut sources = Vec::new();
    let mut tiles = reader.tiles();
    while let Some(tile) = tiles.try_next().await.unwrap() {
        for triangle in tile.owned_triangles() {
            let corners = tile.triangle_points(triangle);
            let of = expected.triangles[&key(corners)];
            assert_eq!(tile.depth(triangle), of.depth, "{corners:?}");
            assert_eq!(tile.is_hole(triangle), of.is_hole, "{corners:?}");
            let component = *region_of.entry(tile.region(triangle)).or_insert(of.component);
            assert_eq!(component, of.component, "{corners:?}");
            holes += u64::from(of.is_hole);
            triangles += 1;
        }
        for edge in tile.owned_constraints() {
            let ends = tile.ends(edge).map(|end| end.point);
            let mut edge_sources: Vec<EdgeSource> = tile.edge_sources(edge).collect();
            edge_sources.sort_unstable();
            assert_eq!(tile.is_wall(edge), edge_sources.iter().any(|source| source.is_wall()));
            sources.extend(
                edge_sources
                    .into_iter()
                    .map(|source| match ends[0].lex_cmp(ends[1]).is_lt() {
                        true => (ends, source),
                        false => ([ends[1], ends[0]], source.reversed()),
                    }),
            );
        }
        for site in tile.sites() {
            let id = site.id.map_or_else(|| site.number.to_string(), str::to_owned);
            sites.push((tile.point(site.vertex), id));
        }
    }
    assert_eq!(triangles, expected.triangles.len());
    assert_eq!(region_of.len(), expected.regions);
    assert_eq!(
        counts[0] as usize,
        if expected.has_regions { expected.regions } else { 0 }
    );
    assert_eq!(counts[1] as usize, expected.hole_regions);
    assert_eq!(counts[2], holes);
    let order = |a: &([Point; 2], EdgeSource), b: &([Point; 2], EdgeSource)| {
        let ends = a.0[0].lex_cmp(b.0[0]).then(a.0[1].lex_cmp(b.0[1]));
        ends.then(a.1.cmp(&b.1))
    };
    sources.sort_by(order);
    assert_eq!(sources, expected.sources);
    sites.sort_by(|a, b| a.0.lex_cmp(b.0).then(a.1.cmp(&b.1)));
    assert_eq!(sites, expected.sites);
}

#[test]
fn regions_of_nested_overlapping_and_touching_obstacles_equal_those_in_core() {
    use LineKind::{BreakLine, Obstacle, Wall};
    let block = |at, size| InputLine::rectangle(Obstacle, at, size);
    for (name, lines) in [
        (
            "island in a lake on an island",
            vec![
                block([2, 2], [16, 16]).without(block([4, 4], [10, 10])),
                block([6, 6], [5, 5]).without(block([7, 7], [2, 2])),
            ],
        ),
        (
            "overlaps",
            vec![block([2, 2], [9, 9]), block([5, 5], [9, 9]), block([8, 1], [3, 17])],
        ),
        (
            "shared walls",
            vec![block([2, 2], [5, 5]), block([7, 2], [5, 5]), block([2, 7], [10, 5])],
        ),
        ("the same twice", vec![block([3, 3], [7, 7]), block([3, 3], [7, 7])]),
        (
            "touching corners",
            vec![
                block([2, 2], [4, 4]),
                block([6, 6], [4, 4]),
                block([2, 6], [4, 4]).without(block([2, 6], [4, 4])),
                block([2, 6], [4, 4]),
            ],
        ),
        (
            // The sum of depths is 0 there, and the area was once free.
            "one that runs round the wrong way, under another",
            vec![
                block([2, 2], [9, 9]),
                block([2, 2], [9, 9]).turned(),
                block([6, 6], [9, 9]).turned(),
            ],
        ),
        (
            "holes that others cover",
            vec![
                block([2, 2], [14, 14]).without(block([4, 4], [6, 6])),
                block([3, 3], [14, 14]).without(block([5, 5], [6, 6])),
            ],
        ),
        (
            "walls and break lines about",
            vec![
                block([4, 4], [9, 9]),
                InputLine::new(Wall, &[(0, 8), (19, 8)]),
                InputLine::new(BreakLine, &[(8, 0), (8, 19)]),
                InputLine::rectangle(Wall, [1, 1], [2, 17]),
                InputLine::rectangle(BreakLine, [10, 10], [9, 9]),
            ],
        ),
        (
            "spikes and bridges",
            vec![
                InputLine::new(
                    Obstacle,
                    &[
                        (2, 2),
                        (12, 2),
                        (12, 8),
                        (17, 8),
                        (12, 8),
                        (12, 12),
                        (7, 12),
                        (7, 7),
                        (7, 12),
                        (2, 12),
                        (2, 2),
                    ],
                ),
                InputLine::new(
                    Obstacle,
                    &[
                        (14, 14),
                        (18, 14),
                        (18, 18),
                        (14, 18),
                        (14, 14),
                        (1, 14),
                        (1, 17),
                        (1, 14),
                        (14, 14),
                    ],
                ),
            ],
        ),
        (
            "all of the hull",
            vec![block([0, 0], [19, 19]).without(block([5, 5], [3, 3]))],
        ),
        (
            "a ring that goes round twice",
            vec![InputLine::new(
                Obstacle,
                &[(2, 2), (9, 2), (9, 9), (2, 9), (2, 2), (9, 2), (9, 6), (2, 6), (2, 2)],
            )],
        ),
    ] {
        println!("{name}");
        let mut input = Input::on_grid(20, lines);
        input.sites = site_at_each_point(&input);
        if name == "a ring that goes round twice" {
            // A ring around both rounds, and a wall where one of them ends.
            let mut stored = InputLine::new(Obstacle, &[(2, 2), (9, 2), (9, 6), (9, 9), (2, 9), (2, 6), (2, 2)]);
            stored
                .rings
                .extend(InputLine::new(Obstacle, &[(2, 6), (9, 6), (2, 6)]).rings);
            input.stored = Some(vec![stored]);
        }
        check(&input, &WAYS);
        input.exterior_is_hole = true;
        input.seeds = vec![Point::new(1.5, 0.5), Point::new(8.0, 8.0), Point::new(100.0, 0.0)];
        check(&input, &[WAYS[0], WAYS[2]]);
    }
}

/// The file does not depend on which thread does what, or on what that thread did before.
#[test]
fn files_do_not_depend_on_the_number_of_threads() {
    let mut random = Random(3);
    let rectangles = (0..40).map(|i| {
        let [at, size] = [[40, 40], [20, 20]].map(|most| most.map(|most| random.below(most) as i32));
        let kinds = [LineKind::BreakLine, LineKind::Wall, LineKind::Obstacle];
        InputLine::rectangle(kinds[i % 3], at, size)
    });
    let input = Input::on_grid(61, rectangles.collect());
    let bytes = |threads: usize| {
        let scratch = Scratch::new();
        let options = BuildOptions::default().tile_vertices(60).threads(threads);
        runtime().block_on(input.build(&scratch, options)).unwrap();
        std::fs::read(&scratch.path).unwrap()
    };
    let one = bytes(1);
    for threads in [2, 3, 5] {
        assert!(bytes(threads) == one, "{threads} threads");
    }
}

/// Lines only; their ends are all the vertices.
#[test]
fn regions_of_polygons_without_points_equal_those_in_core() {
    let mut random = Random(7);
    for round in 0..20 {
        let lines = (0..12).map(|i| {
            let [x, y] = [4 * (i % 4), 4 * (i / 4)];
            let size = [1, 2].map(|least| least + random.below(2) as i32);
            let line = InputLine::rectangle(LineKind::Obstacle, [x, y], size);
            if random.below(4) == 0 {
                InputLine {
                    kind: LineKind::Wall,
                    ..line
                }
            } else {
                line
            }
        });
        let input = Input {
            lines: lines.collect(),
            exterior_is_hole: round % 2 == 0,
            ..Input::default()
        };
        check(&input, &[(4, 8, 1, ENOUGH), (7, 1 << 16, 2, ENOUGH), WAYS[3]]);
    }
}

#[test]
fn sites_may_coincide_with_vertices_and_with_each_other() {
    let at = |x: f64, y: f64| Point::new(x, y);
    let mut input = Input::on_grid(12, vec![InputLine::rectangle(LineKind::Obstacle, [2, 2], [5, 5])]);
    let number = SiteId::Number;
    input.sites = vec![
        (at(3.0, 3.0), number(7)),
        (at(3.0, 3.0), number(7)),
        (at(3.0, 3.0), number(2)),
        (at(2.0, 2.0), number(3)),
        (at(4.25, 3.5), number(u64::MAX)),
        (at(4.25, 3.5), number(0)),
    ];
    check(&input, &WAYS);
    input.sites.push((at(9.5, 9.5), SiteId::Text("café".to_owned())));
    input.sites.push((at(9.5, 9.5), SiteId::Text("12a".to_owned())));
    check(&input, &WAYS);
}

/// Blocks on disk, and segments that do not fit in memory.
#[test]
fn regions_of_builds_larger_than_memory_equal_those_in_core() {
    let mut lines = Vec::new();
    for i in 0..400 {
        let at = [(i % 20) * 8, (i / 20) * 8];
        let court = InputLine::rectangle(LineKind::Obstacle, [at[0] + 1, at[1] + 1], [4, 4]);
        lines.push(InputLine::rectangle(LineKind::Obstacle, at, [6, 6]).without(court));
        lines.push(InputLine::rectangle(LineKind::Wall, [at[0] + 2, at[1] + 2], [1, 2]));
    }
    let input = Input::on_grid(160, lines);
    check(&input, &[(300, 1 << 16, 2, 2 << 20), (300, 1 << 16, 1, ENOUGH)]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(120) as u32, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn regions_of_random_rectangles_equal_those_in_core(
        rectangles in prop::collection::vec((0i32..8, 0i32..8, 0i32..6, 0i32..6, 0u8..8), 1..9),
        seeds in prop::collection::vec((-2i32..20, -2i32..20), 0..3),
        exterior_is_hole in any::<bool>(),
    ) {
        let kinds = [LineKind::BreakLine, LineKind::Wall, LineKind::Obstacle, LineKind::Obstacle];
        let lines = rectangles.into_iter().map(|(x, y, width, height, how)| {
            let line = InputLine::rectangle(kinds[usize::from(how) / 2], [x, y], [width, height]);
            if how % 2 == 1 && how < 7 { line.turned() } else { line }
        });
        let mut input = Input::on_grid(13, lines.collect());
        input.exterior_is_hole = exterior_is_hole;
        input.sites = site_at_each_point(&input);
        input.seeds = seeds.into_iter().map(|(x, y)| Point::new(f64::from(x) * 0.75, f64::from(y) * 0.75)).collect();
        check(&input, &[(4, 8, 1, ENOUGH), (11, 1 << 16, 2, ENOUGH)]);
    }
}

#[test]
fn regions_of_deferred_rings_equal_those_in_core() {
    use LineKind::{BreakLine, Obstacle, Wall};
    let mut random = Random(11);
    let mut point = || Point::new(random.below(1000) as f64, random.below(1000) as f64);
    let triangle = |kind, r: i32| {
        let corners = [
            (500 + r, 500),
            (500 - r / 2, 500 + r),
            (500 - r / 3, 500 - r),
            (500 + r, 500),
        ];
        InputLine::new(kind, &corners)
    };
    let mut input = Input {
        points: (0..900).map(|_| point()).collect(),
        lines: vec![
            triangle(Obstacle, 497),
            triangle(Obstacle, 440),
            triangle(Obstacle, 440).without(triangle(Obstacle, 390)),
            triangle(BreakLine, 300),
            triangle(Wall, 250),
            triangle(Obstacle, 200),
            InputLine::new(Wall, &[(0, 2), (999, 3)]),
        ],
        ..Input::default()
    };
    assert!(check(&input, &WAYS) > 0, "nothing was deferred");
    input.sites = site_at_each_point(&input);
    check(&input, &WAYS);
    // With few sites, some segments are deferred as before.
    input.sites.truncate(20);
    assert!(check(&input, &WAYS) > 0, "nothing was deferred beside sites");
}
