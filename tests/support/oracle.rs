//! Walking distances by brute force: the visibility graph of all vertices, by sectors, in O(n³). It
//! shares only the predicates with the library's search. From the file it takes triangles, hole
//! flags and walls.

use std::collections::HashMap;

use delaunay_tiles::geometry::{Orientation, Point, orient2d};
use delaunay_tiles::store::TileReader;
use futures::TryStreamExt;

use Orientation::{Clockwise, Collinear, CounterClockwise};

/// A scene, as a walker meets it.
pub struct Oracle {
    pub points: Vec<Point>,
    triangles: Vec<([usize; 3], bool)>,
    outside_is_free: bool,
    /// Edges that cannot be crossed.
    blocked: Vec<[usize; 2]>,
    spots: Vec<Spot>,
    /// For each vertex the sight lines to the vertices that it sees, with the sectors at both ends.
    graph: Vec<Vec<SightLine>>,
}

/// A straight line from a sector of a spot to a sector of another spot.
#[derive(Clone, Copy)]
struct SightLine {
    sector: usize,
    to: usize,
    to_sector: usize,
    length: f64,
}

/// A point with the blocked directions around it, counter-clockwise, and whether the sector on the
/// left of each is free. Without blocked directions there is one sector.
#[derive(Clone)]
struct Spot {
    point: Point,
    rays: Vec<Point>,
    is_free: Vec<bool>,
}

fn length(a: Point, b: Point) -> f64 {
    (a.x - b.x).hypot(a.y - b.y)
}

/// Returns whether `c` is on the line through `a` and `b`, strictly between them.
fn is_between(a: Point, c: Point, b: Point) -> bool {
    orient2d(a, b, c) == Collinear && a.lex_cmp(c) == c.lex_cmp(b) && a != c && c != b
}

fn same_direction(at: Point, a: Point, b: Point) -> bool {
    orient2d(at, a, b) == Collinear && at.lex_cmp(a) == at.lex_cmp(b)
}

impl Spot {
    /// Returns the sectors that contain a direction: one, or, along a blocked ray, the one on its
    /// left and the one on its right.
    fn sectors(&self, towards: Point) -> Vec<usize> {
        let n = self.rays.len();
        if n == 0 {
            return vec![0];
        }
        if let Some(ray) = self
            .rays
            .iter()
            .position(|&ray| same_direction(self.point, ray, towards))
        {
            return vec![ray, (ray + n - 1) % n];
        }
        let turn = |a, b| orient2d(self.point, a, b);
        let within = |a: Point, b: Point| match turn(a, b) {
            _ if n == 1 => true,
            CounterClockwise => turn(a, towards) == CounterClockwise && turn(towards, b) == CounterClockwise,
            Clockwise => !(turn(b, towards) == CounterClockwise && turn(towards, a) == CounterClockwise),
            Collinear => turn(a, towards) == CounterClockwise,
        };
        let found: Vec<usize> = (0..n)
            .filter(|&i| within(self.rays[i], self.rays[(i + 1) % n]))
            .collect();
        assert_eq!(found.len(), 1);
        found
    }

    fn free_sectors(&self) -> Vec<usize> {
        (0..self.is_free.len()).filter(|&sector| self.is_free[sector]).collect()
    }

    /// Creates a spot, with its rays sorted.
    fn new(point: Point, mut rays: Vec<(Point, bool)>) -> Self {
        let half = |p: Point| (p.y, p.x) < (point.y, point.x);
        rays.sort_by(|(a, _), (b, _)| {
            half(*a).cmp(&half(*b)).then_with(|| match orient2d(point, *a, *b) {
                CounterClockwise => std::cmp::Ordering::Less,
                Collinear => std::cmp::Ordering::Equal,
                Clockwise => std::cmp::Ordering::Greater,
            })
        });
        let (rays, is_free) = rays.into_iter().unzip();
        Self { point, rays, is_free }
    }
}

/// The outcome of a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Walk {
    Length(f64),
    Unreachable,
    /// An end is not free.
    Inside,
}

impl Oracle {
    pub async fn read(reader: &TileReader) -> Self {
        let (mut corners, mut walls) = (Vec::new(), Vec::new());
        let mut tiles = reader.tiles();
        let mut number: HashMap<[u64; 2], usize> = HashMap::new();
        let mut points = Vec::new();
        let mut index = |p: Point| {
            *number.entry([p.x.to_bits(), p.y.to_bits()]).or_insert_with(|| {
                points.push(p);
                points.len() - 1
            })
        };
        while let Some(tile) = tiles.try_next().await.unwrap() {
            for triangle in tile.owned_triangles() {
                let vertices = tile.triangle_points(triangle).map(&mut index);
                corners.push((vertices, !tile.is_hole(triangle)));
                walls.extend(
                    (0..3)
                        .filter(|&s| tile.is_wall(delaunay_tiles::geometry::HalfEdge::new(triangle, s)))
                        .map(|s| {
                            let s = s as usize;
                            [vertices[s], vertices[(s + 1) % 3]]
                        }),
                );
            }
        }
        Self::new(points, corners, &walls, !reader.metadata().exterior_is_hole)
    }

    fn new(
        points: Vec<Point>,
        triangles: Vec<([usize; 3], bool)>,
        walls: &[[usize; 2]],
        outside_is_free: bool,
    ) -> Self {
        let mut left: HashMap<[usize; 2], bool> = HashMap::new();
        for (corners, is_free) in &triangles {
            for s in 0..3 {
                left.insert([corners[s], corners[(s + 1) % 3]], *is_free);
            }
        }
        let is_free = |a: usize, b: usize| left.get(&[a, b]).copied().unwrap_or(outside_is_free);
        let mut blocked: Vec<[usize; 2]> = left
            .keys()
            .copied()
            .filter(|&[a, b]| is_free(a, b) != is_free(b, a))
            .collect();
        blocked.extend(walls);
        blocked.iter_mut().for_each(|edge| edge.sort_unstable());
        blocked.sort_unstable();
        blocked.dedup();
        let mut rays = vec![Vec::new(); points.len()];
        for &[a, b] in &blocked {
            rays[a].push((points[b], is_free(a, b)));
            rays[b].push((points[a], is_free(b, a)));
        }
        let spots = points.iter().zip(rays).enumerate().map(|(vertex, (&point, rays))| {
            if !rays.is_empty() {
                return Spot::new(point, rays);
            }
            let any = left.iter().find(|([a, _], _)| *a == vertex);
            Spot {
                point,
                rays: Vec::new(),
                is_free: vec![any.map_or(outside_is_free, |(_, &is_free)| is_free)],
            }
        });
        let mut this = Self {
            spots: spots.collect(),
            points,
            triangles,
            outside_is_free,
            blocked,
            graph: Vec::new(),
        };
        let n = this.points.len();
        this.graph = (0..n)
            .map(|a| {
                (0..n)
                    .filter(|&b| a != b)
                    .flat_map(|b| this.sight_lines(&this.spots[a], &this.spots[b], b))
                    .collect()
            })
            .collect();
        this
    }

    /// Returns the sight lines between two spots that pass no vertex.
    fn sight_lines(&self, from: &Spot, to: &Spot, number: usize) -> Vec<SightLine> {
        let (a, b) = (from.point, to.point);
        if a == b || self.points.iter().any(|&p| is_between(a, p, b)) {
            return Vec::new();
        }
        let crosses = self.blocked.iter().any(|&[p, q]| {
            let [p, q] = [p, q].map(|v| self.points[v]);
            let apart = |turns: [Orientation; 2]| {
                matches!(turns, [Clockwise, CounterClockwise] | [CounterClockwise, Clockwise])
            };
            apart([orient2d(a, b, p), orient2d(a, b, q)]) && apart([orient2d(p, q, a), orient2d(p, q, b)])
        });
        if crosses {
            return Vec::new();
        }
        // Along a blocked edge there are two sight lines: one on the left of the edge, which is the
        // right on the way back, and one on the other side.
        let there = from.sectors(b).into_iter();
        let mut back = to.sectors(a);
        back.reverse();
        let pairs: Vec<_> = there.zip(back).collect();
        let free = pairs.into_iter().filter(|&(s, t)| from.is_free[s] && to.is_free[t]);
        free.map(|(sector, to_sector)| SightLine {
            sector,
            to: number,
            to_sector,
            length: length(a, b),
        })
        .collect()
    }

    /// Returns the spot of any point; the vertex's own spot if the point is a vertex.
    fn spot(&self, point: Point) -> Spot {
        if let Some(vertex) = self.points.iter().position(|&p| p == point) {
            return self.spots[vertex].clone();
        }
        for (corners, is_free) in &self.triangles {
            let at = corners.map(|v| self.points[v]);
            let turns = [0, 1, 2].map(|s| orient2d(at[s], at[(s + 1) % 3], point));
            if turns.contains(&Clockwise) {
                continue;
            }
            let Some(on) = turns.iter().position(|&turn| turn == Collinear) else {
                return Spot {
                    point,
                    rays: Vec::new(),
                    is_free: vec![*is_free],
                };
            };
            let edge = [corners[on], corners[(on + 1) % 3]];
            let mut sorted = edge;
            sorted.sort_unstable();
            if !self.blocked.contains(&sorted) {
                return Spot {
                    point,
                    rays: Vec::new(),
                    is_free: vec![*is_free],
                };
            }
            // The sector on the left of the ray to an end is on the left of the edge directed to
            // that end.
            let twin_is_free = self
                .triangles
                .iter()
                .find(|(c, _)| (0..3).any(|s| [c[s], c[(s + 1) % 3]] == [edge[1], edge[0]]));
            let twin_is_free = twin_is_free.map_or(self.outside_is_free, |(_, is_free)| *is_free);
            return Spot::new(
                point,
                vec![(self.points[edge[1]], *is_free), (self.points[edge[0]], twin_is_free)],
            );
        }
        Spot {
            point,
            rays: Vec::new(),
            is_free: vec![self.outside_is_free],
        }
    }

    /// Returns whether a walker may be at a point.
    pub fn is_free(&self, point: Point) -> bool {
        self.spot(point).is_free.contains(&true)
    }

    /// Returns the lengths of the shortest paths from a point to all vertices, by sectors.
    fn ways(&self, source: &Spot) -> Vec<Vec<f64>> {
        let mut ways: Vec<Vec<f64>> = self
            .spots
            .iter()
            .map(|spot| vec![f64::INFINITY; spot.is_free.len()])
            .collect();
        if let Some(vertex) = self.points.iter().position(|&p| p == source.point) {
            for sector in source.free_sectors() {
                ways[vertex][sector] = 0.0;
            }
        } else {
            for (vertex, there) in ways.iter_mut().enumerate() {
                for line in self.sight_lines(source, &self.spots[vertex], vertex) {
                    there[line.to_sector] = there[line.to_sector].min(line.length);
                }
            }
        }
        let mut done: Vec<Vec<bool>> = ways.iter().map(|ways| vec![false; ways.len()]).collect();
        loop {
            let all = ways
                .iter()
                .enumerate()
                .flat_map(|(v, ways)| ways.iter().enumerate().map(move |(s, &way)| (way, v, s)));
            let open = all.filter(|&(way, v, s)| !done[v][s] && way.is_finite());
            let Some((way, vertex, sector)) = open.min_by(|a, b| a.0.total_cmp(&b.0)) else {
                return ways;
            };
            done[vertex][sector] = true;
            for line in self.graph[vertex].iter().filter(|line| line.sector == sector) {
                let there = &mut ways[line.to][line.to_sector];
                *there = there.min(way + line.length);
            }
        }
    }

    /// Returns the walks from a point to others.
    pub fn walks(&self, from: Point, to: &[Point]) -> Vec<Walk> {
        let source = self.spot(from);
        if source.free_sectors().is_empty() {
            return vec![Walk::Inside; to.len()];
        }
        let ways = self.ways(&source);
        let walk = |&to: &Point| {
            let spot = self.spot(to);
            if spot.free_sectors().is_empty() {
                return Walk::Inside;
            }
            let mut best = if from == to { 0.0 } else { f64::INFINITY };
            if let Some(vertex) = self.points.iter().position(|&p| p == to) {
                best = ways[vertex].iter().copied().fold(best, f64::min);
            } else {
                for line in self.sight_lines(&source, &spot, usize::MAX) {
                    best = best.min(line.length);
                }
                for (vertex, spot_of_vertex) in self.spots.iter().enumerate() {
                    for line in self.sight_lines(spot_of_vertex, &spot, usize::MAX) {
                        best = best.min(ways[vertex][line.sector] + line.length);
                    }
                }
            }
            if best.is_finite() {
                Walk::Length(best)
            } else {
                Walk::Unreachable
            }
        };
        to.iter().map(walk).collect()
    }
}
