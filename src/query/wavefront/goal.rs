//! What the wave looks for.

use crate::geometry::{Orientation, Point, TriangleId, orient2d};
use crate::query::free_space::{Place, Spot};
use crate::store::TileId;

/// What is to be found.
#[derive(Clone, Debug)]
pub(crate) enum Goal {
    /// Sites.
    Sites,
    /// Vertices.
    Vertices,
    /// Places.
    Places(Places),
}

/// Places to be found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Places {
    points: Vec<Point>,
    /// Free triangles that a place lies in or on, in order of a number made of their corners.
    triangles: Vec<(u64, [Point; 3], u32)>,
    /// Corners of those triangles, for a quick no.
    corners: Filter,
    /// Vertices that are places, in order of their points' numbers.
    vertices: Vec<(u64, u32)>,
    /// Places outside the hull or on its edge.
    pub(crate) outside: Vec<u32>,
    /// Free triangles round places, in order.
    around: Vec<(TileId, TriangleId)>,
}

/// Numbers that may be in a set.
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
            let (word, bit) = this.place(number);
            this.bits[word] |= bit;
        }
        this
    }

    #[inline]
    fn place(&self, number: u64) -> (usize, u64) {
        let place = (number >> 20) as usize & (64 * self.bits.len() - 1);
        (place / 64, 1 << (place % 64))
    }

    #[inline]
    fn may_have(&self, number: u64) -> bool {
        let (word, bit) = self.place(number);
        self.bits[word] & bit != 0
    }
}

/// A number for a point, the same wherever it is met.
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

/// Whether a point lies in a closed triangle.
fn holds(corners: [Point; 3], p: Point) -> bool {
    (0..3).all(|i| orient2d(corners[i], corners[(i + 1) % 3], p) != Orientation::Clockwise)
}

impl Places {
    /// All free ones of these; the others are never found.
    pub(crate) fn new<'p>(places: impl IntoIterator<Item = &'p Place>) -> Self {
        let mut this = Self::default();
        let mut corners = Vec::new();
        for (place, index) in places.into_iter().zip(0..) {
            this.points.push(place.point);
            if let (Spot::Vertex(vertex), true) = (place.spot, place.is_free) {
                this.vertices.push((number(vertex.point), index));
            }
            if place.is_outside {
                this.outside.push(index);
            }
            for &triangle in &place.triangles {
                corners.extend(triangle.map(number));
                this.triangles.push((sum(triangle), triangle, index));
            }
            this.around.extend_from_slice(&place.around);
            if let Spot::Triangle(triangle) = place.spot {
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

    /// The free triangles of a tile in or at which places lie.
    pub(crate) fn triangles_in(&self, tile: TileId) -> impl Iterator<Item = TriangleId> {
        let first = self.around.partition_point(|around| around.0 < tile);
        let here = self.around[first..].iter().take_while(move |around| around.0 == tile);
        here.map(|around| around.1)
    }

    /// The only one there is.
    pub(crate) fn single(&self) -> Option<Point> {
        match self.points[..] {
            [point] => Some(point),
            _ => None,
        }
    }

    /// Takes the places in a closed triangle.
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

    /// The places on a vertex.
    #[inline]
    pub(crate) fn on_vertex(&self, vertex: Point) -> impl Iterator<Item = u32> {
        let number = if self.vertices.is_empty() { 0 } else { number(vertex) };
        let first = self.vertices.partition_point(|vertex| vertex.0 < number);
        let places = self.vertices[first..]
            .iter()
            .take_while(move |vertex| vertex.0 == number);
        let places = places.map(|vertex| vertex.1);
        places.filter(move |&index| self.points[index as usize] == vertex)
    }

    /// The places outside the hull that lie in a closed cone.
    pub(crate) fn outside_within(&self, root: Point, right: Point, left: Point) -> impl Iterator<Item = u32> {
        self.outside.iter().copied().filter(move |&index| {
            let point = self.points[index as usize];
            orient2d(root, right, point) != Orientation::Clockwise
                && orient2d(root, left, point) != Orientation::CounterClockwise
        })
    }
}
