//! Nodes and obstacle edges, and the rays that leave a node along them.

use foldhash::HashMap;

use crate::geometry::{Orientation, Point, orient2d};
use crate::query::answer::{WayPoint, distance};

/// No node, or no ray.
pub(super) const NONE: u32 = u32::MAX;

/// A subsegment of an obstacle's boundary, or of a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    pub(super) nodes: [u32; 2],
    pub(super) points: [Point; 2],
    /// Whether the left side is free, and whether the right side is.
    pub(super) free: [bool; 2],
}

/// A node: its point, its vertex if it is one, and the first of the rays that leave it along edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    way_point: WayPoint,
    first_ray: u32,
}

/// Nodes and obstacle edges.
///
/// Edges must not cross, and no node may be inside an edge: an edge with a point on it is two
/// edges.
#[derive(Debug, Default)]
pub(crate) struct LocalGraph {
    pub(super) nodes: Vec<Node>,
    pub(super) edges: Vec<Edge>,
    /// The next ray of the same node. Ray 2e leaves the first end of edge e, ray 2e + 1 the second.
    next_rays: Vec<u32>,
    numbers: HashMap<[u64; 2], u32>,
}

impl LocalGraph {
    /// Returns the node at a point, and adds it if there is none.
    pub(crate) fn node(&mut self, way_point: WayPoint) -> u32 {
        let point = way_point.0;
        let number = self.nodes.len() as u32;
        let node = *self
            .numbers
            .entry([point.x.to_bits(), point.y.to_bits()])
            .or_insert(number);
        if node == number {
            self.nodes.push(Node {
                way_point,
                first_ray: NONE,
            });
        }
        node
    }

    /// Adds an edge. `free` tells whether its left side and its right side are free.
    pub(crate) fn add_edge(&mut self, ends: [WayPoint; 2], free: [bool; 2]) {
        let nodes = ends.map(|end| self.node(end));
        let ray = self.next_rays.len() as u32;
        for (node, ray) in nodes.into_iter().zip(ray..) {
            let first = &mut self.nodes[node as usize].first_ray;
            self.next_rays.push(std::mem::replace(first, ray));
        }
        self.edges.push(Edge {
            nodes,
            points: ends.map(|end| end.0),
            free,
        });
    }

    pub(crate) fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Returns a node's point, and its vertex.
    pub(crate) fn way_point(&self, node: u32) -> WayPoint {
        self.nodes[node as usize].way_point
    }

    pub(super) fn point(&self, node: u32) -> Point {
        self.nodes[node as usize].way_point.0
    }

    /// Returns the rays that leave a node along edges: their edges, and the nodes where they end.
    pub(super) fn rays(&self, node: u32) -> impl Iterator<Item = Ray> {
        let next = |&ray: &u32| Some(self.next_rays[ray as usize]).filter(|&ray| ray != NONE);
        let first = Some(self.nodes[node as usize].first_ray).filter(|&ray| ray != NONE);
        std::iter::successors(first, next).map(|ray| {
            let edge = ray / 2;
            let to = self.edges[edge as usize].nodes[1 - ray as usize % 2];
            Ray { ray, edge, to }
        })
    }

    /// Returns whether the left side of a ray is free.
    pub(super) fn is_left_free(&self, ray: Ray) -> bool {
        self.edges[ray.edge as usize].free[ray.ray as usize % 2]
    }

    /// Returns the nodes at the right and left end of the sector in which paths turn round a node:
    /// the sector that is wider than a half-turn.
    pub(super) fn turning_bounds(&self, node: u32) -> Option<[u32; 2]> {
        let at = self.point(node);
        // The sector is on the left of the ray that has all others on its right.
        let bound = |side: Orientation| {
            let has_others = |ray: &Ray| {
                let to = self.point(ray.to);
                let mut others = self.rays(node).filter(|other| other.to != ray.to);
                others.all(|other| orient2d(at, to, self.point(other.to)) == side)
            };
            self.rays(node).find(has_others).map(|ray| ray.to)
        };
        Some([bound(Orientation::Clockwise)?, bound(Orientation::CounterClockwise)?])
    }

    pub(super) fn length(&self, from: u32, to: u32) -> f64 {
        distance(self.point(from), self.point(to))
    }
}

/// An edge seen from one of its ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub(super) ray: u32,
    pub(super) edge: u32,
    /// The node at the other end.
    pub(super) to: u32,
}

/// Returns whether, of three collinear points, `at` is between the others, that is, `to` is beyond
/// `at`.
pub(super) fn is_ahead(from: Point, at: Point, to: Point) -> bool {
    from.lex_cmp(at) == at.lex_cmp(to)
}

/// Returns whether, of three collinear points, `a` and `b` are in the same direction from `from`.
pub(super) fn same_direction(from: Point, a: Point, b: Point) -> bool {
    from.lex_cmp(a) == from.lex_cmp(b)
}
