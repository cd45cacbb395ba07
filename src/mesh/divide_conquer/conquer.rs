//! Cuts the points into parts, triangulates and merges them, and converts the result.

use super::arrays::Arrays;
use super::half_edges::BitHalfEdge;
use super::hull::{Axis, Hull, xy_less, yx_less};
use crate::geometry::{MortonSquare, Point, Rect};
use crate::mesh::engine::Engine;
use crate::mesh::triangulation::Triangulation;

/// The divide-and-conquer engine, with the memory that it keeps between calls.
#[derive(Default)]
pub(in crate::mesh) struct DivideConquer {
    /// For each vertex, the index of its point in the caller's array, in the bits of `index_mask`.
    /// The bits above hold as much of the point's [Morton key](MortonSquare::key) as fits.
    keyed: Vec<u64>,
    index_mask: u64,
    arrays: Arrays,
    /// The ghosts of the result.
    ghosts: Vec<BitHalfEdge>,
}

impl Engine for DivideConquer {
    fn triangulate(&mut self, points: &[Point], mesh: &mut Triangulation) {
        assert!(points.len() < 1 << 29, "the kernel takes fewer than 2^29 points");
        if points.len() < 2 {
            mesh.set_collinear(points);
            return;
        }
        self.index_mask = (points.len() as u64).next_power_of_two() - 1;
        self.keyed.clear();
        self.keyed.extend(0..points.len() as u64);
        self.arrays.points.clear();
        self.arrays.points.extend_from_slice(points);
        mesh.clear();
        // The kernel works in the memory of the result.
        std::mem::swap(&mut self.arrays.corners, &mut mesh.triangles);
        let twins = std::mem::take(&mut mesh.neighbours).into_iter();
        self.arrays.twins = twins.map(|_| [BitHalfEdge::UNSET; 3]).collect();
        self.arrays.corners.reserve(2 * points.len());
        self.arrays.twins.reserve(2 * points.len());
        let hull = self.conquer(points, 0, points.len());
        self.finish(hull, mesh);
        std::mem::swap(&mut self.arrays.corners, &mut mesh.triangles);
        if mesh.triangles.is_empty() {
            mesh.set_collinear(points);
        }
    }
}

impl DivideConquer {
    /// Triangulates the points `from..to`, at least two of them: cuts them, conquers both parts,
    /// and merges these. The points are sorted by key, or their keys are equal.
    fn conquer(&mut self, points: &[Point], from: usize, to: usize) -> Hull {
        let few = match to - from {
            2 => return self.arrays.two(from),
            3 => return self.arrays.three(from).unwrap_or_else(|| self.conquer_line(from)),
            4 => self.arrays.four(from),
            _ => None,
        };
        if let Some(hull) = few {
            return hull;
        }
        if self.keyed[from] ^ self.keyed[to - 1] <= self.index_mask {
            self.sort(points, from, to);
        }
        // The highest bit in which the keys differ says where the smallest cell around the points
        // is halved.
        let bit = (self.keyed[from] ^ self.keyed[to - 1]).ilog2();
        let axis = if bit % 2 == 1 { Axis::X } else { Axis::Y };
        let mut cut = from + self.keyed[from..to].partition_point(|key| key >> bit & 1 == 0);
        // A part has at least two points: a single point gets the one next to the cut from the
        // other part.
        if cut - from == 1 {
            let next = (cut..to).reduce(|a, b| if self.comes_before(axis, b, a) { b } else { a });
            let next = next.expect("three points are left");
            self.keyed[cut..=next].rotate_right(1);
            self.arrays.points[cut..=next].rotate_right(1);
            cut += 1;
        } else if to - cut == 1 {
            let next = (from..cut).reduce(|a, b| if self.comes_before(axis, a, b) { b } else { a });
            let next = next.expect("three points are left");
            self.keyed[next..cut].rotate_left(1);
            self.arrays.points[next..cut].rotate_left(1);
            cut -= 1;
        }
        let left = self.conquer(points, from, cut);
        let right = self.conquer(points, cut, to);
        self.arrays.merge(left, right, axis)
    }

    /// Sorts the points `from..to` along the Morton curve over a square around them.
    ///
    /// Afterwards, the first key differs from the last one. As there is room for 35 bits of the
    /// key, and the square shrinks to 2⁻¹⁷ at each call for the points of one cell, calls nest
    /// only a few levels deep, whatever the distribution.
    fn sort(&mut self, points: &[Point], from: usize, to: usize) {
        let (keyed, ordered) = (&mut self.keyed[from..to], &mut self.arrays.points[from..to]);
        let square = MortonSquare::around(Rect::around(ordered.iter().copied()));
        let mask = self.index_mask;
        for (key, p) in keyed.iter_mut().zip(&*ordered) {
            *key = square.key(*p) & !mask | *key & mask;
        }
        keyed.sort_unstable();
        for (p, key) in ordered.iter_mut().zip(keyed) {
            *p = points[(*key & mask) as usize];
        }
    }

    fn comes_before(&self, axis: Axis, a: usize, b: usize) -> bool {
        let (a, b) = (self.arrays.points[a], self.arrays.points[b]);
        match axis {
            Axis::X => xy_less(a, b),
            Axis::Y => yx_less(a, b),
        }
    }

    /// Joins three points on a line to a chain.
    #[cold]
    fn conquer_line(&mut self, from: usize) -> Hull {
        for i in [from, from + 1, from] {
            if self.comes_before(Axis::X, i + 1, i) {
                self.arrays.points.swap(i, i + 1);
                self.keyed.swap(i, i + 1);
            }
        }
        self.arrays.chain(from)
    }

    /// Removes the ghosts, and converts the result to the caller's indices.
    fn finish(&mut self, hull: Hull, mesh: &mut Triangulation) {
        self.ghosts.clear();
        let (keyed, mask) = (&self.keyed, self.index_mask);
        let index = |vertex: u32| (keyed[vertex as usize] & mask) as u32;
        let half_edges = self.arrays.half_edges();
        let mut ghost = hull.left.leaves;
        loop {
            self.ghosts.push(ghost);
            mesh.hull.push(index(half_edges.dest(ghost)));
            ghost = half_edges.hull_next(ghost);
            if ghost == hull.left.leaves {
                break;
            }
        }
        let count = self.arrays.corners.len() - self.ghosts.len();
        self.arrays.move_behind(&self.ghosts, count);
        self.arrays.corners.truncate(count);
        self.arrays.twins.truncate(count);
        for corner in self.arrays.corners.as_flattened_mut() {
            *corner = index(*corner);
        }
        // Collecting reuses the same memory.
        let twins = std::mem::take(&mut self.arrays.twins).into_iter();
        mesh.neighbours = twins.map(|of_triangle| of_triangle.map(BitHalfEdge::packed)).collect();
    }
}
