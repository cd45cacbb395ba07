//! The goals of a wavefront.

use super::aims::Aims;
use crate::geometry::{Orientation, Point, TriangleId, orient2d};
use crate::query::free_space::{Position, QueryPoint};
use crate::store::TileId;

/// The targets to be found.
#[derive(Clone, Debug)]
pub(crate) enum Goal {
    /// All sites.
    Sites,
    /// All vertices.
    Vertices,
    /// Some query points.
    Points(QueryPoints),
}

/// The query points to be found.
#[derive(Clone, Debug, Default)]
pub(crate) struct QueryPoints {
    points: Vec<Point>,
    /// Whether the search is directed towards the points.
    is_aimed: bool,
    /// Free triangles that contain a query point, inside or on an edge, sorted by a hash of their
    /// corners, each with the index of the point.
    triangles: Vec<(u64, [Point; 3], u32)>,
    /// The hashes of the corners of those triangles, for quick rejection.
    corners: Filter,
    /// Query points at vertices: the hash of the point and its index, sorted.
    vertices: Vec<(u64, u32)>,
    /// Query points outside the hull or on its edge.
    pub(crate) outside: Vec<u32>,
    /// Free triangles at query points, sorted.
    around: Vec<(TileId, TriangleId)>,
}

/// A set of hashes that may report hashes it does not contain.
#[derive(Clone, Debug, Default)]
struct Filter {
    bits: Vec<u64>,
}

impl Filter {
    fn of(numbers: &[u64]) -> Self {
        let bits = (8 * numbers.len()).next_power_of_two().max(64);
        let mut this = Self {
            bits: vec![0; bits / 64],
        };
        for &number in numbers {
            let (word, bit) = this.slot(number);
            this.bits[word] |= bit;
        }
        this
    }

    #[inline]
    fn slot(&self, number: u64) -> (usize, u64) {
        let slot = (number >> 20) as usize & (64 * self.bits.len() - 1);
        (slot / 64, 1 << (slot % 64))
    }

    #[inline]
    fn may_have(&self, number: u64) -> bool {
        let (word, bit) = self.slot(number);
        self.bits[word] & bit != 0
    }
}

/// Returns a hash of a point that depends on its coordinates only.
#[inline]
fn number(p: Point) -> u64 {
    let mixed = p.x.to_bits().wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(31) ^ p.y.to_bits();
    let mixed = mixed.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed ^ (mixed >> 29)
}

fn sum(corners: [Point; 3]) -> u64 {
    corners.into_iter().map(number).fold(0, u64::wrapping_add)
}

fn same(a: [Point; 3], b: [Point; 3]) -> bool {
    a.iter().all(|p| b.contains(p))
}

/// Returns whether a closed triangle contains a point.
fn holds(corners: [Point; 3], p: Point) -> bool {
    (0..3).all(|i| orient2d(corners[i], corners[(i + 1) % 3], p) != Orientation::Clockwise)
}

impl QueryPoints {
    /// Creates goals from the free points among `points`; the others are never found.
    pub(crate) fn new<'p>(points: impl IntoIterator<Item = &'p QueryPoint>) -> Self {
        let mut this = Self::default();
        let mut corners = Vec::new();
        for (point, index) in points.into_iter().zip(0..) {
            this.points.push(point.point);
            if let (Position::Vertex(vertex), true) = (point.position, point.is_free) {
                this.vertices.push((number(vertex.point), index));
            }
            if point.is_outside {
                this.outside.push(index);
            }
            for &triangle in &point.triangles {
                corners.extend(triangle.map(number));
                this.triangles.push((sum(triangle), triangle, index));
            }
            this.around.extend_from_slice(&point.around);
            if let Position::Triangle(triangle) = point.position {
                this.around.push((triangle.tile, triangle.triangle));
            }
        }
        this.vertices.sort_unstable();
        this.triangles.sort_by_key(|triangle| triangle.0);
        this.around.sort_unstable();
        this.around.dedup();
        this.corners = Filter::of(&corners);
        this
    }

    pub(crate) fn points(&self) -> &[Point] {
        &self.points
    }

    /// Returns the free triangles of a tile that contain query points or touch them.
    pub(crate) fn triangles_in(&self, tile: TileId) -> impl Iterator<Item = TriangleId> {
        let first = self.around.partition_point(|around| around.0 < tile);
        let here = self.around[first..].iter().take_while(move |around| around.0 == tile);
        here.map(|around| around.1)
    }

    /// Directs the search towards the points. Each step then takes time for each of them, so they
    /// should be few, and near each other.
    pub(crate) fn aimed(mut self) -> Self {
        self.is_aimed = true;
        self
    }

    /// Returns the points towards which the search is directed.
    pub(super) fn aims(&self) -> Aims {
        match self.is_aimed || self.points.len() == 1 {
            true => Aims::new(&self.points),
            false => Aims::default(),
        }
    }

    /// Calls `take` with each query point in a closed triangle.
    #[inline]
    pub(crate) fn in_triangle(&self, corners: [Point; 3], mut take: impl FnMut(u32, Point)) {
        if !self.corners.may_have(number(corners[0])) {
            return;
        }
        let sum = sum(corners);
        let first = self.triangles.partition_point(|triangle| triangle.0 < sum);
        for &(_, triangle, index) in self.triangles[first..].iter().take_while(|triangle| triangle.0 == sum) {
            let point = self.points[index as usize];
            if same(triangle, corners) && holds(corners, point) {
                take(index, point);
            }
        }
    }

    /// Returns the query points on a vertex.
    #[inline]
    pub(crate) fn on_vertex(&self, vertex: Point) -> impl Iterator<Item = u32> {
        let number = if self.vertices.is_empty() { 0 } else { number(vertex) };
        let first = self.vertices.partition_point(|vertex| vertex.0 < number);
        let points = self.vertices[first..]
            .iter()
            .take_while(move |vertex| vertex.0 == number);
        let points = points.map(|vertex| vertex.1);
        points.filter(move |&index| self.points[index as usize] == vertex)
    }

    /// Returns the query points outside the hull that lie in a closed window.
    pub(crate) fn outside_within(&self, root: Point, right: Point, left: Point) -> impl Iterator<Item = u32> {
        self.outside.iter().copied().filter(move |&index| {
            let point = self.points[index as usize];
            orient2d(root, right, point) != Orientation::Clockwise
                && orient2d(root, left, point) != Orientation::CounterClockwise
        })
    }
}
