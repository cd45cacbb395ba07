//! Tests visibility and walking distances against brute force by sectors.

use proptest::prelude::*;

use crate::geometry::{Orientation, Point, orient2d, segments_cross};
use crate::query::baselines::graph::edges::LocalGraph;
use crate::query::baselines::graph::search::VisibilitySearch;
use crate::query::baselines::graph::sweep::{Range, Side, Sweep};

use Orientation::Clockwise;
use Orientation::Collinear;
use Orientation::CounterClockwise;

/// Walls between points, and points without walls.
struct Scene {
    points: Vec<Point>,
    walls: Vec<[usize; 2]>,
}

fn is_between(a: Point, c: Point, b: Point) -> bool {
    orient2d(a, b, c) == Collinear && a.lex_cmp(c) == c.lex_cmp(b) && a != c && c != b
}

fn crosses([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    segments_cross(a, b, c, d)
}

impl Scene {
    /// Creates a scene from the walls and points that do not cross, touch or lie on earlier ones.
    fn new(walls: &[[(i32, i32); 2]], open: &[(i32, i32)]) -> Self {
        let mut this = Self {
            points: Vec::new(),
            walls: Vec::new(),
        };
        let at = |(x, y): (i32, i32)| Point::new(f64::from(x), f64::from(y));
        for ends in walls {
            let ends = ends.map(at);
            let is_clear = ends[0] != ends[1]
                && !this.points.iter().any(|&p| is_between(ends[0], p, ends[1]))
                && this.walls.iter().all(|wall| {
                    let wall = wall.map(|end| this.points[end]);
                    let ends_on_it = ends.iter().any(|&end| is_between(wall[0], end, wall[1]));
                    let is_the_same = ends.contains(&wall[0]) && ends.contains(&wall[1]);
                    !(ends_on_it || is_the_same || crosses(wall, ends))
                });
            if is_clear {
                let ends = ends.map(|end| this.number(end));
                this.walls.push(ends);
            }
        }
        for &coordinates in open {
            let point = at(coordinates);
            let is_on_wall = |wall: &[usize; 2]| is_between(this.points[wall[0]], point, this.points[wall[1]]);
            if !this.walls.iter().any(is_on_wall) {
                this.number(point);
            }
        }
        this
    }

    fn number(&mut self, point: Point) -> usize {
        let known = self.points.iter().position(|&p| p == point);
        known.unwrap_or_else(|| {
            self.points.push(point);
            self.points.len() - 1
        })
    }

    fn graph(&self) -> LocalGraph {
        let mut graph = LocalGraph::default();
        for &point in &self.points {
            graph.node((point, None));
        }
        for &[a, b] in &self.walls {
            graph.add_edge([(self.points[a], None), (self.points[b], None)], [true; 2]);
        }
        graph
    }

    /// Returns the walls at a node, counter-clockwise, by their other ends.
    fn rays(&self, node: usize) -> Vec<usize> {
        let at = self.points[node];
        let ends = self.walls.iter().filter_map(|&[a, b]| match node {
            _ if node == a => Some(b),
            _ if node == b => Some(a),
            _ => None,
        });
        let mut rays: Vec<usize> = ends.collect();
        let is_late = |p: Point| (p.y, p.x) < (at.y, at.x);
        rays.sort_by(|&a, &b| {
            let [a, b] = [a, b].map(|end| self.points[end]);
            is_late(a).cmp(&is_late(b)).then_with(|| match orient2d(at, a, b) {
                CounterClockwise => std::cmp::Ordering::Less,
                Collinear => std::cmp::Ordering::Equal,
                Clockwise => std::cmp::Ordering::Greater,
            })
        });
        rays
    }

    /// Returns the sectors of a node that contain a direction: along a wall, the one on its left
    /// and the one on its right.
    fn sectors(&self, node: usize, towards: Point) -> [usize; 2] {
        let (at, rays) = (self.points[node], self.rays(node));
        let n = rays.len();
        let is_along = |&ray: &usize| {
            orient2d(at, self.points[ray], towards) == Collinear && at.lex_cmp(self.points[ray]) == at.lex_cmp(towards)
        };
        if n == 0 {
            return [0; 2];
        }
        if let Some(ray) = rays.iter().position(is_along) {
            return [ray, (ray + n - 1) % n];
        }
        let sector = (0..n).find(|&i| {
            let [a, b] = [rays[i], rays[(i + 1) % n]].map(|ray| self.points[ray]);
            let turn = |a, b| orient2d(at, a, b);
            match turn(a, b) {
                _ if n == 1 => true,
                CounterClockwise => turn(a, towards) == CounterClockwise && turn(towards, b) == CounterClockwise,
                Clockwise => turn(b, towards) != CounterClockwise || turn(towards, a) != CounterClockwise,
                Collinear => turn(a, towards) == CounterClockwise,
            }
        });
        [sector.expect("one of them"); 2]
    }

    /// Returns the straight steps from a node that pass no other node: from a sector of it to a
    /// node and a sector there.
    fn steps(&self, from: usize) -> Vec<(usize, usize, usize)> {
        let at = self.points[from];
        let mut steps = Vec::new();
        for (to, &there) in self.points.iter().enumerate() {
            let is_hit = |wall: &[usize; 2]| crosses(wall.map(|end| self.points[end]), [at, there]);
            let is_clear = to != from
                && !self.points.iter().any(|&p| is_between(at, p, there))
                && !self
                    .walls
                    .iter()
                    .any(|wall| !wall.contains(&from) && !wall.contains(&to) && is_hit(wall));
            if is_clear {
                let (leaves, [left, right]) = (self.sectors(from, there), self.sectors(to, at));
                steps.push((leaves[0], to, right));
                steps.push((leaves[1], to, left));
            }
        }
        steps
    }

    /// Returns the nodes that a node sees, on straight paths that pass nodes within one of their
    /// sectors.
    fn seen(&self, from: usize, sector: Option<usize>) -> Vec<usize> {
        let at = self.points[from];
        let mut seen = Vec::new();
        let first = self
            .steps(from)
            .into_iter()
            .filter(|step| sector.is_none_or(|sector| sector == step.0));
        let mut open: Vec<(usize, usize)> = first.map(|(_, to, sector)| (to, sector)).collect();
        while let Some((node, sector)) = open.pop() {
            seen.push(node);
            let here = self.points[node];
            let on = self.steps(node).into_iter().filter(|&(leaves, to, _)| {
                let to = self.points[to];
                leaves == sector && orient2d(at, here, to) == Collinear && at.lex_cmp(here) == here.lex_cmp(to)
            });
            open.extend(on.map(|(_, to, sector)| (to, sector)));
        }
        seen.sort_unstable();
        seen.dedup();
        seen
    }

    /// Returns the lengths of the shortest paths from a node to all nodes.
    fn lengths(&self, from: usize) -> Vec<f64> {
        let mut lengths: Vec<Vec<f64>> = (0..self.points.len())
            .map(|node| vec![f64::INFINITY; self.rays(node).len().max(1)])
            .collect();
        lengths[from].fill(0.0);
        // The Bellman-Ford algorithm.
        let all: Vec<_> = (0..self.points.len()).map(|node| self.steps(node)).collect();
        loop {
            let mut changed = false;
            for (node, steps) in all.iter().enumerate() {
                for &(sector, to, there) in steps {
                    let [a, b] = [self.points[node], self.points[to]];
                    let length = lengths[node][sector] + (a.x - b.x).hypot(a.y - b.y);
                    changed |= length < lengths[to][there];
                    lengths[to][there] = lengths[to][there].min(length);
                }
            }
            if !changed {
                let best = |lengths: Vec<f64>| lengths.into_iter().fold(f64::INFINITY, f64::min);
                return lengths.into_iter().map(best).collect();
            }
        }
    }
}

fn swept(sweep: &mut Sweep, graph: &LocalGraph, node: u32, range: Range, reach: f64, points: &[u32]) -> Vec<usize> {
    sweep.run(graph, node, range, reach, points);
    let mut seen: Vec<usize> = sweep.seen.iter().map(|seen| seen.node as usize).collect();
    seen.sort_unstable();
    seen
}

fn check(scene: &Scene) {
    let graph = scene.graph();
    let mut sweep = Sweep::default();
    let count = scene.points.len() as u32;
    let open: Vec<u32> = (0..count)
        .filter(|&node| scene.rays(node as usize).is_empty())
        .collect();
    for node in 0..count {
        let at = scene.points[node as usize];
        let found = swept(&mut sweep, &graph, node, Range::All, f64::INFINITY, &open);
        assert_eq!(
            found,
            scene.seen(node as usize, None),
            "from {at:?} in {:?} {:?}",
            scene.points,
            scene.walls
        );
        check_turns(scene, &graph, &mut sweep, node, &open);
        let expected = scene.lengths(node as usize);
        let mut search = VisibilitySearch::new(
            &graph,
            node,
            (0..count).map(|node| (node, 1)),
            usize::MAX,
            f64::INFINITY,
        );
        while !search.go(1) {}
        let found = search.found();
        assert!(found.is_sorted_by(|a, b| a.length <= b.length));
        assert_eq!(found.len(), expected.iter().filter(|length| length.is_finite()).count());
        for found in found {
            let expected = expected[found.node as usize];
            assert!(
                (found.length - expected).abs() <= 1e-12 * expected,
                "from {node} to {found:?}, not {expected}, in {:?} {:?}",
                scene.points,
                scene.walls
            );
            let way = search.way(found);
            let legs = way
                .windows(2)
                .map(|leg| (leg[1].0.x - leg[0].0.x).hypot(leg[1].0.y - leg[0].0.y));
            assert!((legs.sum::<f64>() - found.length).abs() <= 1e-12 * found.length);
        }
        // Fewer targets, or a limit.
        let Some(middle) = found.get(found.len() / 2) else {
            continue;
        };
        for (wanted, limit) in [(found.len() / 2 + 1, f64::INFINITY), (usize::MAX, middle.length)] {
            let mut search = VisibilitySearch::new(&graph, node, (0..count).map(|node| (node, 1)), wanted, limit);
            let expected = found.iter().filter(|found| found.length <= middle.length);
            assert!(search.go(u64::MAX));
            assert!(
                search
                    .found()
                    .iter()
                    .map(|found| found.length)
                    .eq(expected.map(|found| found.length))
            );
        }
    }
}

/// Checks that only nodes in the direction of tangents are seen from where a path turns.
fn check_turns(scene: &Scene, graph: &LocalGraph, sweep: &mut Sweep, node: u32, open: &[u32]) {
    let Some(bounds) = graph.turning_bounds(node) else {
        return;
    };
    let at = scene.points[node as usize];
    let ends = bounds.map(|end| scene.points[end as usize]);
    let sector = scene
        .rays(node as usize)
        .iter()
        .position(|&ray| ray as u32 == bounds[0]);
    // Round the end of a wall a path starts beside the wall: on its left to turn right, and on its
    // right to turn left.
    let is_along = |&node: &usize| {
        let there = scene.points[node];
        bounds[0] == bounds[1] && orient2d(at, ends[0], there) == Collinear && at.lex_cmp(ends[0]) == at.lex_cmp(there)
    };
    let in_sector = scene.seen(node as usize, sector);
    let mut along = Vec::new();
    for (to, hidden) in [(Side::Right, Clockwise), (Side::Left, CounterClockwise)] {
        let mut found = swept(sweep, graph, node, Range::Turn { to, bounds }, f64::INFINITY, open);
        along.extend(found.extract_if(.., |node| is_along(node)));
        let is_tangent = |&node: &usize| ends.iter().all(|&end| orient2d(at, end, scene.points[node]) != hidden);
        let expected = in_sector
            .iter()
            .copied()
            .filter(|node| is_tangent(node) && !is_along(node));
        assert!(
            found.into_iter().eq(expected),
            "from {at:?} to the {to:?} in {:?} {:?}",
            scene.points,
            scene.walls
        );
    }
    along.sort_unstable();
    along.dedup();
    assert!(along.into_iter().eq(in_sector.into_iter().filter(is_along)));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn search_agrees_with_brute_force_on_grid_walls(
        walls in prop::collection::vec((0..6, 0..6, 0..6, 0..6).prop_map(|(a, b, c, d)| [(a, b), (c, d)]), 0..12),
        open in prop::collection::vec((0..6, 0..6), 1..5),
    ) {
        check(&Scene::new(&walls, &open));
    }

    #[test]
    fn search_agrees_with_brute_force_on_short_grid_walls(
        walls in prop::collection::vec((0..5, 0..5, -1..2, -1..2).prop_map(|(a, b, c, d)| [(a, b), (a + c, b + d)]), 0..25),
        open in prop::collection::vec((0..5, 0..5), 1..4),
    ) {
        check(&Scene::new(&walls, &open));
    }

    #[test]
    fn search_agrees_with_brute_force_on_walls_anywhere(
        walls in prop::collection::vec((0..1000, 0..1000, 0..1000, 0..1000).prop_map(|(a, b, c, d)| [(a, b), (c, d)]), 0..20),
        open in prop::collection::vec((0..1000, 0..1000), 1..4),
    ) {
        check(&Scene::new(&walls, &open));
    }
}

/// Paths run round the outside of an obstacle only.
#[test]
fn an_obstacle_is_not_entered() {
    let corners = [(0, 0), (4, 0), (4, 4), (0, 4)].map(|(x, y)| Point::new(f64::from(x), f64::from(y)));
    let mut graph = LocalGraph::default();
    for (i, &corner) in corners.iter().enumerate() {
        // Counter-clockwise, with the obstacle on the left.
        graph.add_edge([(corner, None), (corners[(i + 1) % 4], None)], [false, true]);
    }
    let mut search = VisibilitySearch::new(&graph, 0, [(2, 1)], 1, f64::INFINITY);
    assert!(search.go(u64::MAX));
    let found = search.found();
    assert_eq!(found.iter().map(|found| found.length).collect::<Vec<_>>(), [8.0]);
    assert_eq!(search.way(&found[0]).len(), 3);
}
