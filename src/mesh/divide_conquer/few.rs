//! The smallest parts: two, three or four points.
//!
//! The signs of a few tests determine the triangles of three or four points: one test and a
//! selection for three, five tests and a table for four. So no branch depends on the points, of
//! which a processor would guess half wrong. Only points with a test that rounding leaves open, or
//! with a tie, take another way.

use std::hint::select_unpredictable;
use std::sync::LazyLock;

use super::arrays::Arrays;
use super::half_edges::{BitHalfEdge, GHOST};
use super::hull::{End, Extremes, Hull};
use crate::geometry::{BoxFilter, Chord, Orientation, Point, Rect, orient2d};

/// The triangles and ghosts of four points. Vertices and faces are numbered from 0.
#[derive(Clone, Copy)]
struct Faces {
    corners: [[u32; 3]; 6],
    twins: [[BitHalfEdge; 3]; 6],
    /// For each vertex on the hull, the ghost of the hull edge that leaves it.
    leaving: [BitHalfEdge; 4],
}

impl Faces {
    /// The value for signs that no points have.
    const NONE: Self = Self {
        corners: [[GHOST; 3]; 6],
        twins: [[BitHalfEdge::UNSET; 3]; 6],
        leaving: [BitHalfEdge::UNSET; 4],
    };

    /// Creates the faces of these triangles. `hull` has the vertices of the hull in
    /// counter-clockwise order.
    fn new(triangles: &[[u32; 3]], hull: &[u32]) -> Self {
        let mut faces = Self::NONE;
        let next_on_hull = |i: usize| (i + 1) % hull.len();
        let ghosts = (0..hull.len()).map(|i| [hull[next_on_hull(i)], hull[i], GHOST]);
        for (face, corners) in triangles.iter().copied().chain(ghosts).enumerate() {
            faces.corners[face] = corners;
        }
        let ghost = |i: usize, corner| BitHalfEdge::new((triangles.len() + i) as u32, corner);
        for (i, &vertex) in hull.iter().enumerate() {
            faces.leaving[vertex as usize] = ghost(i, 0);
            faces.link(ghost(i, 2), ghost(next_on_hull(i), 1));
        }
        let edges: Vec<_> = (0..6)
            .flat_map(|face| [0, 1, 2].map(|corner| BitHalfEdge::new(face, corner)))
            .filter(|&edge| !faces.ends(edge).contains(&GHOST))
            .collect();
        for &edge in &edges {
            let [from, to] = faces.ends(edge);
            let twin = edges.iter().find(|&&twin| faces.ends(twin) == [to, from]);
            faces.link(edge, *twin.expect("ghosts close the hull"));
        }
        faces
    }

    /// Returns the origin and the destination.
    fn ends(&self, edge: BitHalfEdge) -> [u32; 2] {
        [edge, edge.next()].map(|edge| self.corners[edge.triangle()][edge.corner()])
    }

    fn link(&mut self, a: BitHalfEdge, b: BitHalfEdge) {
        self.twins[a.triangle()][a.corner()] = b;
        self.twins[b.triangle()][b.corner()] = a;
    }
}

/// The faces of four points by the signs of [`Arrays::four`], a bit for each.
static FOUR: LazyLock<[Faces; 32]> = LazyLock::new(|| std::array::from_fn(four));

/// Returns the faces of four points with these signs: for each of bits 0 to 3, whether the other
/// three points are in counter-clockwise order; bit 4, whether point 3 lies inside the circle
/// through the others, if these are in counter-clockwise order, and outside it otherwise.
fn four(signs: usize) -> Faces {
    let is_set = |bit: usize| signs >> bit & 1 == 1;
    let mut triangles = Vec::new();
    for (without, [a, b, c]) in [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]].into_iter().enumerate() {
        // An exchange of two points reverses the sign of a determinant.
        let determinant_is_positive = is_set(4) ^ (without % 2 == 0);
        let contains_the_other = determinant_is_positive == is_set(without);
        if !contains_the_other {
            triangles.push(if is_set(without) { [a, b, c] } else { [a, c, b] });
        }
    }
    // Four points have two or three triangles.
    if !matches!(triangles.len(), 2 | 3) {
        return Faces::NONE;
    }
    let edges: Vec<_> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .collect();
    let from = |vertex: u32| edges.iter().find(|&&(u, v)| u == vertex && !edges.contains(&(v, u)));
    let mut hull: Vec<u32> = (0..4).find(|&vertex| from(vertex).is_some()).into_iter().collect();
    while let Some(&(_, next)) = hull.last().and_then(|&last| from(last))
        && next != hull[0]
    {
        hull.push(next);
    }
    Faces::new(&triangles, &hull)
}

impl Arrays {
    /// Adds the edge between two points with a ghost on either side.
    #[inline]
    pub(super) fn two(&mut self, first: usize) -> Hull {
        let (a, ghosts) = (first as u32, self.next_face());
        let [ab, ba] = [0, 1].map(|ghost| BitHalfEdge::new(ghosts + ghost, 0));
        self.add_ring([a, a + 1], [ba, ab]);
        self.hull_of::<2>(first, |vertex| BitHalfEdge::new(ghosts + vertex, 0))
    }

    /// Adds three points on a line, in lexicographic order, with a ghost on either side of each
    /// edge.
    pub(super) fn chain(&mut self, first: usize) -> Hull {
        let (a, ghosts) = (first as u32, self.next_face());
        let [ab, bc, cb, ba] = [0, 1, 2, 3].map(|ghost| BitHalfEdge::new(ghosts + ghost, 0));
        self.add_ring([a, a + 1, a + 2, a + 1], [ba, cb, bc, ab]);
        self.hull_of::<3>(first, |vertex| if vertex == 0 { ab } else { cb })
    }

    /// Triangulates three points, unless they are collinear.
    #[inline]
    pub(super) fn three(&mut self, first: usize) -> Option<Hull> {
        let points @ [a, b, c] = self.points_from(first);
        let sign = BoxFilter::new(Rect::around(points)).side(&Chord { l: a, r: b }.view(c));
        let is_counter_clockwise = if sign.is_certain {
            sign.is_positive
        } else {
            match orient2d(a, b, c) {
                Orientation::Collinear => return None,
                orientation => orientation == Orientation::CounterClockwise,
            }
        };
        let (second, third) = select_unpredictable(is_counter_clockwise, (1, 2), (2, 1));
        let corners = [0, second, third].map(|number| first as u32 + number);
        let inner = self.next_face();
        let half_edges = [0, 1, 2].map(|corner| BitHalfEdge::new(inner, corner));
        let [ab, bc, ca] = [1, 2, 3].map(|ghost| BitHalfEdge::new(inner + ghost, 0));
        self.corners.push(corners);
        self.twins.push([ab, bc, ca]);
        self.add_ring(corners, half_edges);
        let behind = |number| select_unpredictable(number == second, bc, ca);
        Some(self.hull_of::<3>(first, |number| select_unpredictable(number == 0, ab, behind(number))))
    }

    /// Triangulates four points, unless three of them may be collinear, or all of them cocircular.
    #[inline]
    pub(super) fn four(&mut self, first: usize) -> Option<Hull> {
        let points @ [a, b, c, d] = self.points_from(first);
        let filter = BoxFilter::new(Rect::around(points));
        let (ab, cd) = (Chord { l: a, r: b }, Chord { l: c, r: d });
        let (c_sees_ab, d_sees_ab) = (ab.view(c), ab.view(d));
        let signs = [
            filter.side(&cd.view(b)),
            filter.side(&cd.view(a)),
            filter.side(&d_sees_ab),
            filter.side(&c_sees_ab),
            filter.circle(&c_sees_ab, &d_sees_ab),
        ];
        let are_certain = signs.iter().fold(true, |certain, sign| certain & sign.is_certain);
        let bits = (0..)
            .zip(signs)
            .fold(0, |bits, (i, sign)| bits | usize::from(sign.is_positive) << i);
        are_certain.then(|| self.add_four(&FOUR[bits], first))
    }

    /// Adds the faces of the four vertices from `first` on.
    #[inline(always)]
    fn add_four(&mut self, faces: &Faces, first: usize) -> Hull {
        let (first_face, first_vertex) = (self.next_face(), first as u32);
        let vertex = |corner: u32| {
            if corner == GHOST {
                GHOST
            } else {
                first_vertex.wrapping_add(corner)
            }
        };
        self.corners.extend(faces.corners.map(|corners| corners.map(vertex)));
        self.twins
            .extend(faces.twins.map(|twins| twins.map(|twin| twin.plus(first_face))));
        self.hull_of::<4>(first, |number| faces.leaving[number as usize].plus(first_face))
    }

    /// Adds a ring of ghosts around vertices in counter-clockwise order. `inside` has the twins of
    /// their real half-edges.
    #[inline(always)]
    fn add_ring<const N: usize>(&mut self, hull: [u32; N], inside: [BitHalfEdge; N]) {
        let first = self.next_face();
        let half_edge = |i: usize, corner| BitHalfEdge::new(first + (i % N) as u32, corner);
        self.corners
            .extend(std::array::from_fn::<_, N, _>(|i| [hull[(i + 1) % N], hull[i], GHOST]));
        self.twins.extend(std::array::from_fn::<_, N, _>(|i| {
            [inside[i], half_edge(i + N - 1, 2), half_edge(i + 1, 1)]
        }));
    }

    /// Returns the hull of the `N` vertices from `first` on. `leaving` returns the ghost of the hull
    /// edge that leaves the vertex of a number, from 0.
    #[inline(always)]
    fn hull_of<const N: usize>(&self, first: usize, leaving: impl Fn(u32) -> BitHalfEdge) -> Hull {
        Extremes::of(self.points_from::<N>(first)).map(|number| End {
            vertex: first as u32 + number,
            leaves: leaving(number),
        })
    }

    #[inline(always)]
    fn points_from<const N: usize>(&self, first: usize) -> [Point; N] {
        *self.points[first..]
            .first_chunk()
            .expect("a part has this number of points")
    }

    #[inline]
    fn next_face(&self) -> u32 {
        self.corners.len() as u32
    }
}
