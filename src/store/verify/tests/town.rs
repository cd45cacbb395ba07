//! Models of files with lines, regions and holes.

use std::collections::{HashMap, HashSet};

use crate::geometry::Point;
use crate::store::format::component_table::Component;
use crate::store::format::edge_source::{EdgeSource, LineKind};
use crate::store::format::ids::VertexId;
use crate::store::format::line_part::LinePart;
use crate::store::format::line_source::LineSource;
use crate::store::verify::tests::model::{Model, Named, pair};
use crate::store::verify::tests::{grid, scattered};

pub(super) type Edge = [VertexId; 2];

/// A valid model with its regions and holes, which were found by brute force.
#[derive(Clone)]
pub(super) struct Town {
    pub(super) model: Model,
    /// The component of each triangle.
    pub(super) labels: HashMap<Named, Component>,
    pub(super) sources: HashMap<Edge, Vec<LinePart>>,
}

/// A pseudorandom number generator.
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
    /// Generates overlapping obstacles, walls and break lines from the edges of a triangulation.
    pub(super) fn generate(points: &[Point], tile_vertices: usize, seed: u64, exterior_is_hole: bool) -> Self {
        let mut model = Model::of(points, tile_vertices);
        let mut dice = Dice(seed);
        let triangles = model.triangles();
        let triangle_at: HashMap<Edge, Named> = triangles
            .iter()
            .flat_map(|&t| half_edges(t).map(|half_edge| (half_edge, t)))
            .collect();
        let neighbour = |[a, b]: Edge| triangle_at.get(&[b, a]).copied();

        let mut edges: Vec<Edge> = triangle_at.keys().map(|&[a, b]| pair(a, b)).collect();
        edges.sort_unstable();
        edges.dedup();
        let (break_lines, walls) = (BREAK_LINES, edges.len() / 3);
        let mut sources: HashMap<Edge, Vec<LinePart>> = HashMap::new();
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
                .push(EdgeSource::new(kind, number as u64).into());
        }
        let mut depths: HashMap<Named, i32> = HashMap::new();
        for obstacle in 0..OBSTACLES {
            let number = (break_lines + walls) as u64 + obstacle;
            let mut inside = vec![triangles[dice.below(triangles.len())]];
            let mut next = 0;
            while inside.len() < triangles.len() / 8 && next < inside.len() {
                let neighbours = half_edges(inside[next]).into_iter().filter_map(neighbour);
                let fresh: Vec<Named> = neighbours.filter(|t| !inside.contains(t)).collect();
                inside.extend(fresh);
                next += 1;
            }
            for &t in &inside {
                *depths.entry(t).or_default() += 1;
                for half_edge in half_edges(t)
                    .into_iter()
                    .filter(|&half_edge| neighbour(half_edge).is_none_or(|t| !inside.contains(&t)))
                {
                    let source = LinePart::whole(EdgeSource::new(LineKind::Obstacle, number));
                    let edge = pair(half_edge[0], half_edge[1]);
                    let seen = if edge == half_edge { source } else { source.reversed() };
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
                let open = half_edges(region[next])
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
        let mut lists = model.directory.lists.clone();
        let mut labels = HashMap::new();
        for (region, number) in regions.iter().zip(0u64..) {
            let depth = depths.get(&region[0]).copied().unwrap_or(0);
            let is_open = region
                .iter()
                .flat_map(|&t| half_edges(t))
                .any(|edge| neighbour(edge).is_none() && !sources.contains_key(&pair(edge[0], edge[1])));
            let is_seeded = dice.below(5) == 0;
            if is_seeded {
                lists
                    .hole_points
                    .push(centroid(&model, region[dice.below(region.len())]));
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
            let first = lists
                .lines
                .last()
                .map_or(0, |last: &LineSource| last.first + last.lines);
            let name = kind.to_string();
            lists.lines.push(LineSource {
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
        model.directory.lists = lists;
        Self { model, labels, sources }
    }

    /// Returns a copy of the model with `change` applied.
    pub(super) fn but(&self, change: impl FnOnce(&mut Model)) -> Model {
        let mut wrong = self.model.clone();
        change(&mut wrong);
        wrong
    }

    /// Returns the edges with sources, in order.
    pub(super) fn edges(&self) -> Vec<Edge> {
        let mut edges: Vec<Edge> = self.sources.keys().copied().collect();
        edges.sort_unstable();
        edges
    }

    /// Returns a triangle of each region, and its component.
    pub(super) fn regions(&self) -> Vec<(Named, Component)> {
        let mut regions: Vec<_> = self.labels.iter().map(|(&t, &label)| (t, label)).collect();
        regions.sort_unstable_by_key(|&(t, label)| (label.region, t));
        regions.dedup_by_key(|(_, label)| label.region);
        regions
    }
}

pub(super) fn half_edges(t: Named) -> [Edge; 3] {
    [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]
}

pub(super) fn centroid(model: &Model, t: Named) -> Point {
    let [a, b, c] = t.map(|v| model.point(v));
    Point::new((a.x + b.x + c.x) / 3.0, (a.y + b.y + c.y) / 3.0)
}

/// Returns the tile that an edge belongs to.
pub(super) fn owner(model: &Model, edge: Edge) -> usize {
    let [a, b] = edge;
    let smaller = if model.point(a).lex_cmp(model.point(b)).is_lt() {
        a
    } else {
        b
    };
    smaller.tile.0 as usize
}

pub(super) fn towns() -> Vec<Town> {
    [
        (grid(), 16, false),
        (scattered(), 16, true),
        (scattered(), 40, false),
        (grid(), 1000, true),
    ]
    .iter()
    .zip(1..)
    .map(|((points, tile_vertices, exterior), seed)| Town::generate(points, *tile_vertices, seed, *exterior))
    .collect()
}
