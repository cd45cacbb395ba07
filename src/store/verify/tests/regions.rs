//! Regions, holes and sources that are wrong in one thing each.

use std::collections::{HashMap, HashSet};

use super::model::{Model, Named, pair};
use super::{grid, scattered};
use crate::geometry::Point;
use crate::store::{Component, EdgeSource, LineKind, LineSource, TileId, VertexId};

type Edge = [VertexId; 2];

/// A model whose lines, regions and holes were found by brute force, and what is right of it.
#[derive(Clone)]
struct Town {
    model: Model,
    /// Of all triangles.
    labels: HashMap<Named, Component>,
    sources: HashMap<Edge, Vec<EdgeSource>>,
}

/// Numbers that look random, from one that does not.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n
    }
}

const BREAK_LINES: usize = 7;
const OBSTACLES: u64 = 4;

impl Town {
    /// Obstacles that overlap, and walls and break lines here and there, among the edges of a triangulation.
    fn found(points: &[Point], tile_vertices: usize, seed: u64, exterior_is_hole: bool) -> Self {
        let mut model = Model::of(points, tile_vertices);
        let mut dice = Dice(seed);
        let triangles = model.triangles();
        let across: HashMap<Edge, Named> = triangles.iter().flat_map(|&t| sides(t).map(|side| (side, t))).collect();
        let neighbour = |[a, b]: Edge| across.get(&[b, a]).copied();

        let mut edges: Vec<Edge> = across.keys().map(|&[a, b]| pair(a, b)).collect();
        edges.sort_unstable();
        edges.dedup();
        let (break_lines, walls) = (BREAK_LINES, edges.len() / 3);
        let mut sources: HashMap<Edge, Vec<EdgeSource>> = HashMap::new();
        for number in 0..break_lines + walls {
            let kind = if number < break_lines {
                LineKind::BreakLine
            } else {
                LineKind::Wall
            };
            let edge = edges[dice.below(edges.len())];
            sources
                .entry(edge)
                .or_default()
                .push(EdgeSource::new(kind, number as u64));
        }
        let mut depths: HashMap<Named, i32> = HashMap::new();
        for obstacle in 0..OBSTACLES {
            let number = (break_lines + walls) as u64 + obstacle;
            let mut inside = vec![triangles[dice.below(triangles.len())]];
            let mut next = 0;
            while inside.len() < triangles.len() / 8 && next < inside.len() {
                let beside = sides(inside[next]).into_iter().filter_map(neighbour);
                let fresh: Vec<Named> = beside.filter(|t| !inside.contains(t)).collect();
                inside.extend(fresh);
                next += 1;
            }
            for &t in &inside {
                *depths.entry(t).or_default() += 1;
                for side in sides(t)
                    .into_iter()
                    .filter(|&side| neighbour(side).is_none_or(|t| !inside.contains(&t)))
                {
                    let source = EdgeSource::new(LineKind::Obstacle, number);
                    let edge = pair(side[0], side[1]);
                    let seen = if edge == side { source } else { source.reversed() };
                    sources.entry(edge).or_default().push(seen);
                }
            }
        }

        let mut regions: Vec<Vec<Named>> = Vec::new();
        let mut seen = HashSet::new();
        for &t in &triangles {
            if !seen.insert(t) {
                continue;
            }
            let mut region = vec![t];
            let mut next = 0;
            while next < region.len() {
                let open = sides(region[next])
                    .into_iter()
                    .filter(|&[a, b]| !sources.contains_key(&pair(a, b)));
                let fresh: Vec<Named> = open.filter_map(neighbour).filter(|&t| seen.insert(t)).collect();
                region.extend(fresh);
                next += 1;
            }
            regions.push(region);
        }
        let tiles = |region: &Vec<Named>| {
            let tiles = region.iter().flatten().map(|v| v.tile).collect::<HashSet<_>>();
            tiles.len()
        };
        regions.sort_by_key(|region| tiles(region) == 1);
        let mut metadata = model.directory.metadata.clone();
        let mut labels = HashMap::new();
        for (region, number) in regions.iter().zip(0u64..) {
            let depth = depths.get(&region[0]).copied().unwrap_or(0);
            let is_open = region
                .iter()
                .flat_map(|&t| sides(t))
                .any(|side| neighbour(side).is_none() && !sources.contains_key(&pair(side[0], side[1])));
            let is_seeded = dice.below(5) == 0;
            if is_seeded {
                metadata.seeds.push(middle(&model, region[dice.below(region.len())]));
            }
            let is_hole = depth != 0 || is_seeded || exterior_is_hole && is_open;
            let label = Component {
                region: number,
                depth,
                is_hole,
            };
            labels.extend(region.iter().map(|&t| (t, label)));
            if is_hole {
                metadata.hole_regions += 1;
                metadata.hole_triangles += region.len() as u64;
            }
        }
        metadata.regions = regions.len() as u64;
        metadata.spanning_regions = regions.iter().filter(|region| tiles(region) > 1).count() as u64;
        metadata.exterior_is_hole = exterior_is_hole;
        metadata.sites = 2 * model.tiles.len() as u64;
        let counts = [
            (LineKind::BreakLine, break_lines as u64),
            (LineKind::Wall, walls as u64),
            (LineKind::Obstacle, OBSTACLES),
        ];
        for (kind, lines) in counts {
            let first = metadata
                .lines
                .last()
                .map_or(0, |last: &LineSource| last.first + last.lines);
            let name = kind.to_string();
            metadata.lines.push(LineSource {
                name,
                kind,
                first,
                lines,
                edit: 0,
            });
        }
        for (tile, number) in model.tiles.iter_mut().zip(0..) {
            tile.constraints = sources.keys().copied().collect();
            let is_wall = |edge: &&Edge| sources[*edge].iter().any(|source| source.is_wall());
            tile.walls = sources.keys().filter(is_wall).copied().collect();
            tile.labels = labels.clone();
            tile.sites = vec![(0, 2 * number), (2, 2 * number + 1)];
        }
        for (edge, sources) in &sources {
            let owner = owner(&model, *edge);
            model.tiles[owner].sources.insert(*edge, sources.clone());
        }
        model.directory.metadata = metadata;
        Self { model, labels, sources }
    }

    /// A copy of the model that is wrong in one thing.
    fn but(&self, change: impl FnOnce(&mut Model)) -> Model {
        let mut wrong = self.model.clone();
        change(&mut wrong);
        wrong
    }

    /// The edges with sources, in order.
    fn edges(&self) -> Vec<Edge> {
        let mut edges: Vec<Edge> = self.sources.keys().copied().collect();
        edges.sort_unstable();
        edges
    }

    /// A triangle of each region, and what it is.
    fn regions(&self) -> Vec<(Named, Component)> {
        let mut regions: Vec<_> = self.labels.iter().map(|(&t, &label)| (t, label)).collect();
        regions.sort_unstable_by_key(|&(t, label)| (label.region, t));
        regions.dedup_by_key(|(_, label)| label.region);
        regions
    }
}

fn sides(t: Named) -> [Edge; 3] {
    [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]
}

fn middle(model: &Model, t: Named) -> Point {
    let [a, b, c] = t.map(|v| model.point(v));
    Point::new((a.x + b.x + c.x) / 3.0, (a.y + b.y + c.y) / 3.0)
}

/// The tile that an edge belongs to.
fn owner(model: &Model, edge: Edge) -> usize {
    let [a, b] = edge;
    let smaller = if model.point(a).lex_cmp(model.point(b)).is_lt() {
        a
    } else {
        b
    };
    smaller.tile.0 as usize
}

fn towns() -> Vec<Town> {
    [
        (grid(), 16, false),
        (scattered(), 16, true),
        (scattered(), 40, false),
        (grid(), 1000, true),
    ]
    .iter()
    .zip(1..)
    .map(|((points, tile_vertices, exterior), seed)| Town::found(points, *tile_vertices, seed, *exterior))
    .collect()
}

/// The model is found to be wrong, in these words.
#[track_caller]
fn found(wrong: &Model, words: &str) {
    let text = match wrong.verify() {
        Ok(()) => panic!("it is not found: {words}"),
        Err(error) => error.to_string(),
    };
    assert!(text.contains(words), "{text:?} is not about {words:?}");
}

#[test]
fn towns_are_right_before_they_are_made_wrong() {
    for town in towns() {
        town.model.verify().unwrap();
        let m = &town.model.directory.metadata;
        let local = m.regions - m.spanning_regions;
        assert!(local > 5 && m.hole_regions > 3 && m.hole_regions < m.regions && !m.seeds.is_empty());
        assert_eq!(
            m.spanning_regions > 5,
            town.model.tiles.len() > 1,
            "{}",
            m.spanning_regions
        );
    }
}

#[test]
fn constraints_without_sources_and_sources_without_constraints() {
    for town in towns() {
        for edge in town.edges().into_iter().step_by(5) {
            let owner = owner(&town.model, edge);
            found(
                &town.but(|m| _ = m.tiles[owner].sources.remove(&edge)),
                "is a constraint without a source",
            );
            let no_constraint = |m: &mut Model| {
                m.tiles.iter_mut().for_each(|tile| {
                    tile.constraints.remove(&edge);
                    tile.walls.remove(&edge);
                })
            };
            assert!(town.but(no_constraint).verify().is_err());
        }
        // A source for an edge that is none, and so parts nothing.
        let all = town
            .model
            .triangles()
            .into_iter()
            .flat_map(sides)
            .map(|[a, b]| pair(a, b));
        for edge in all.filter(|edge| !town.sources.contains_key(edge)).step_by(7) {
            let owner = owner(&town.model, edge);
            let source = vec![EdgeSource::new(LineKind::BreakLine, 0)];
            found(
                &town.but(|m| _ = m.tiles[owner].sources.insert(edge, source)),
                "it has sources for edges that are no constraints of its own",
            );
        }
    }
}

#[test]
fn sources_in_a_tile_that_does_not_own_the_edge() {
    let mut tried = 0;
    for town in towns() {
        for edge in town.edges() {
            let owner = owner(&town.model, edge);
            for other in edge
                .map(|v| v.tile.0 as usize)
                .into_iter()
                .filter(|&tile| tile != owner)
            {
                let sources = town.sources[&edge].clone();
                found(
                    &town.but(|m| _ = m.tiles[other].sources.insert(edge, sources)),
                    "it has sources for edges that are no constraints of its own",
                );
                tried += 1;
            }
        }
    }
    assert!(tried > 20, "{tried}");
}

#[test]
fn walls_that_no_source_says_and_sources_that_no_wall_follows() {
    for town in towns() {
        for edge in town.edges().into_iter().step_by(4) {
            let flip = |m: &mut Model| {
                for tile in &mut m.tiles {
                    if !tile.walls.remove(&edge) {
                        tile.walls.insert(edge);
                    }
                }
            };
            found(&town.but(flip), "disagree on whether it is a wall");
            // In one tile only, where it is an edge of several.
            for tile in edge.map(|v| v.tile.0 as usize) {
                let flip = |m: &mut Model| {
                    let walls = &mut m.tiles[tile].walls;
                    if !walls.remove(&edge) {
                        walls.insert(edge);
                    }
                };
                assert!(town.but(flip).verify().is_err());
            }
        }
    }
}

#[test]
fn depths_that_do_not_follow_from_the_sources() {
    for town in towns() {
        for edge in town.edges() {
            let owner = owner(&town.model, edge);
            let Some(place) = town.sources[&edge]
                .iter()
                .position(|source| source.kind() == LineKind::Obstacle)
            else {
                continue;
            };
            found(
                &town.but(|m| {
                    let source = &mut m.tiles[owner].sources.get_mut(&edge).unwrap()[place];
                    *source = source.reversed();
                }),
                "changes the depth by",
            );
        }
        for (_, label) in town.regions().into_iter().step_by(3) {
            for step in [-1, 1, i32::MAX] {
                let deeper = |m: &mut Model| {
                    let labels = m.tiles.iter_mut().flat_map(|tile| tile.labels.values_mut());
                    labels
                        .filter(|other| other.region == label.region)
                        .for_each(|other| other.depth = other.depth.wrapping_add(step));
                };
                assert!(town.but(deeper).verify().is_err());
            }
        }
    }
}

#[test]
fn lines_that_the_directory_does_not_know() {
    for town in towns() {
        for source in 0..3 {
            found(
                &town.but(|m| {
                    let lines = &mut m.directory.metadata.lines;
                    lines[source].kind = match lines[source].kind {
                        LineKind::BreakLine => LineKind::Wall,
                        _ => LineKind::BreakLine,
                    };
                }),
                "which the directory does not know",
            );
        }
        found(
            &town.but(|m| m.directory.metadata.lines[2].lines -= 1),
            "which the directory does not know",
        );
        // Who gives lines no names has none in the directory.
        town.but(|m| m.directory.metadata.lines.clear()).verify().unwrap();
    }
}

#[test]
fn a_triangle_of_another_region_depth_or_kind() {
    for town in towns() {
        let regions = town.regions();
        let mut triangles: Vec<_> = town.labels.keys().copied().collect();
        triangles.sort_unstable();
        for (t, number) in triangles.into_iter().step_by(9).zip(0usize..) {
            let right = town.labels[&t];
            let other = regions[(right.region as usize + 1) % regions.len()].1.region;
            let wrong = [
                Component { region: other, ..right },
                Component {
                    depth: right.depth + 1,
                    ..right
                },
                Component {
                    is_hole: !right.is_hole,
                    ..right
                },
            ];
            for wrong in wrong {
                // In all tiles, and in one.
                let everywhere = |m: &mut Model| m.tiles.iter_mut().for_each(|tile| _ = tile.labels.insert(t, wrong));
                assert!(town.but(everywhere).verify().is_err(), "{t:?} {wrong:?}");
                let tile = t[number % 3].tile;
                let once = |m: &mut Model| _ = m.tiles[tile.0 as usize].labels.insert(t, wrong);
                assert!(town.but(once).verify().is_err(), "{t:?} {wrong:?} in {tile}");
            }
        }
    }
}

#[test]
fn holes_without_a_reason_and_reasons_without_a_hole() {
    for town in towns() {
        for (_, label) in town.regions() {
            let filled = |m: &mut Model| {
                let labels = m.tiles.iter_mut().flat_map(|tile| tile.labels.values_mut());
                labels
                    .filter(|other| other.region == label.region)
                    .for_each(|other| other.is_hole = !other.is_hole);
                let triangles = town
                    .labels
                    .values()
                    .filter(|other| other.region == label.region)
                    .count() as u64;
                let metadata = &mut m.directory.metadata;
                let sign = if label.is_hole { 1u64.wrapping_neg() } else { 1 };
                metadata.hole_regions = metadata.hole_regions.wrapping_add(sign);
                metadata.hole_triangles = metadata.hole_triangles.wrapping_add(sign.wrapping_mul(triangles));
            };
            let words = if label.is_hole {
                "is no hole, but should be"
            } else {
                "nothing makes it one"
            };
            found(&town.but(filled), words);
        }
        let metadata = &town.model.directory.metadata;
        for seed in 0..metadata.seeds.len() {
            let removed = town.but(|m| _ = m.directory.metadata.seeds.remove(seed));
            // Its region may be covered by an obstacle, or lie outside, so one is enough.
            if let Err(error) = removed.verify() {
                assert!(error.to_string().contains("nothing makes it one"), "{error}");
            }
        }
        found(
            &town.but(|m| m.directory.metadata.seeds.clear()),
            "nothing makes it one",
        );
        let free = town.regions().into_iter().find(|(_, label)| !label.is_hole).unwrap().0;
        found(
            &town.but(|m| m.directory.metadata.seeds.push(middle(&town.model, free))),
            "is no hole, but should be",
        );
        assert!(
            town.but(|m| m.directory.metadata.exterior_is_hole ^= true)
                .verify()
                .is_err()
        );
    }
}

/// A seed in the middle of an edge means the region around it; at a vertex and on a constraint it may mean anything.
#[test]
fn seeds_on_edges_and_vertices() {
    let town = &towns()[3];
    let with = |seed: Point| town.but(|m| m.directory.metadata.seeds.push(seed)).verify();
    let mut wrong = 0;
    for t in town.model.triangles() {
        for side in sides(t) {
            let [a, b] = side.map(|v| town.model.point(v));
            let between = Point::new((a.x + b.x) / 2.0, (a.y + b.y) / 2.0);
            let is_free = !town.labels[&t].is_hole && !town.sources.contains_key(&pair(side[0], side[1]));
            assert_eq!(with(between).is_err(), is_free, "{between:?}");
            wrong += u32::from(is_free);
            with(a).unwrap();
        }
    }
    with(Point::new(-1.0, 3.0)).unwrap();
    assert!(wrong > 10, "{wrong}");
}

#[test]
fn numbers_of_regions_that_are_skipped_used_twice_or_moved() {
    for town in towns() {
        let m = &town.model.directory.metadata;
        let renumber = |from: u64, to: u64, in_tile: Option<TileId>| {
            town.but(|m| {
                let tiles = m.tiles.iter_mut().zip(0..);
                let tiles = tiles.filter(|(_, number)| in_tile.is_none_or(|tile| tile.0 == *number));
                let labels = tiles.flat_map(|(tile, _)| tile.labels.values_mut());
                labels
                    .filter(|label| label.region == from)
                    .for_each(|label| label.region = to);
            })
        };
        for region in [
            0,
            m.spanning_regions.saturating_sub(1),
            m.spanning_regions,
            m.regions - 1,
        ] {
            found(&renumber(region, m.regions, None), "it is of region");
            let other = (region + 1) % m.regions;
            assert!(renumber(region, other, None).verify().is_err(), "{region}");
        }
        // A region that lies in one tile has the number of one that lies in another, so that all counts stay.
        let of_tile = |region: u64| {
            let t = town.labels.iter().find(|(_, label)| label.region == region).unwrap().0;
            t[0].tile
        };
        let (last, before) = (m.regions - 1, m.regions - 2);
        if of_tile(last) != of_tile(before) {
            found(&renumber(last, before, None), "should lie in one tile each");
        }
        let one_more = |m: &mut Model| m.directory.metadata.regions += 1;
        found(&town.but(one_more), "should lie in one tile each");
        let spanning = |m: &mut Model| m.directory.metadata.spanning_regions = m.directory.metadata.regions;
        // They may lie in several tiles, but need not.
        town.but(spanning).verify().unwrap();
        if m.spanning_regions > 0 {
            let fewer = |m: &mut Model| m.directory.metadata.spanning_regions -= 1;
            found(&town.but(fewer), "lies in one by its number");
        }
        found(
            &town.but(|m| {
                let metadata = &mut m.directory.metadata;
                (metadata.regions, metadata.spanning_regions, metadata.hole_regions) = (0, 0, 0);
            }),
            "the directory says that there are no regions",
        );
    }
}

#[test]
fn counts_that_are_off() {
    for town in towns() {
        found(
            &town.but(|m| m.directory.metadata.hole_regions -= 1),
            "regions are holes",
        );
        found(
            &town.but(|m| m.directory.metadata.hole_triangles -= 1),
            "triangles in holes",
        );
        found(&town.but(|m| m.directory.metadata.sites += 1), "sites");
        found(&town.but(|m| m.tiles[0].sites.clear()), "sites");
    }
}
