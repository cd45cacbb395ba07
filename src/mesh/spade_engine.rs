//! Crate `spade` as an engine: its bulk load, then flips that make the result canonical.
//!
//! spade's predicates are exact, but it takes any of the diagonals of a cocircular polygon. Lawson
//! flips with the perturbed circle test make these canonical. They change cocircular edges only.
//!
//! spade's bulk load orders points by rounded distances and angles. Where magnitudes differ by
//! dozens of orders, the hull may not be convex. Such a result is detected and replaced by that of
//! the library's own kernel.

use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation as _};

use super::divide_conquer::DivideConquer;
use super::engine::Engine;
use super::topology::Topology;
use super::triangulation::Triangulation;
use crate::geometry::{HalfEdge, Orientation, PackedHalfEdge, Point, TriangleId, VertexIndex, in_circle, orient2d};

/// The engine based on crate `spade`.
#[derive(Default)]
pub(super) struct SpadeEngine {
    stack: Vec<HalfEdge>,
    /// Replaces spade where its hull is not convex.
    native: DivideConquer,
}

/// A vertex with its index in the caller's array, because the bulk load reorders vertices.
#[derive(Clone, Copy)]
struct Indexed {
    point: Point,
    index: u32,
}

impl HasPosition for Indexed {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.point.x, self.point.y)
    }
}

impl Engine for SpadeEngine {
    fn triangulate(&mut self, points: &[Point], mesh: &mut Triangulation) {
        if are_collinear(points) {
            // spade's bulk load takes quadratic time on collinear points.
            mesh.set_collinear(points);
            return;
        }
        let vertices = points
            .iter()
            .zip(0..)
            .map(|(&point, index)| Indexed { point, index })
            .collect();
        let spade = DelaunayTriangulation::<Indexed>::bulk_load(vertices)
            .expect("valid points are within the limits of spade, which are the same");
        mesh.clear();
        for face in spade.inner_faces() {
            mesh.triangles.push(face.vertices().map(|v| v.data().index));
        }
        for face in spade.inner_faces() {
            let triangle = face.index() - 1;
            debug_assert_eq!(mesh.neighbours.len(), triangle);
            let corners = mesh.triangles[triangle];
            let mut twins = [PackedHalfEdge::NONE; 3];
            for edge in face.adjacent_edges() {
                let origin = corner_of(corners, edge.from().data().index);
                if let Some(other) = edge.rev().face().as_inner() {
                    let number = TriangleId(other.index() as u32 - 1);
                    let corner = corner_of(mesh.triangles[number.index()], edge.to().data().index);
                    twins[origin as usize] = HalfEdge::new(number, corner).into();
                }
            }
            mesh.neighbours.push(twins);
        }
        // spade lists the hull clockwise.
        mesh.hull
            .extend(spade.convex_hull().map(|edge| edge.from().data().index));
        mesh.hull.reverse();
        if is_convex(points, mesh) {
            self.canonicalise(points, mesh);
        } else {
            tracing::info!(
                points = points.len(),
                "spade's hull is not convex; triangulating again without it"
            );
            self.native.triangulate(points, mesh);
        }
    }
}

/// Returns whether all points are collinear.
fn are_collinear(points: &[Point]) -> bool {
    match *points {
        [a, b, ref others @ ..] => others.iter().all(|&p| orient2d(a, b, p) == Orientation::Collinear),
        _ => true,
    }
}

/// Returns whether the hull turns left or goes straight at every vertex and goes round once, so
/// that no point can lie outside it.
fn is_convex(points: &[Point], mesh: &Triangulation) -> bool {
    let hull: Vec<Point> = mesh.hull.iter().map(|&v| points[v as usize]).collect();
    let n = hull.len();
    let corners = |i: usize| [hull[i], hull[(i + 1) % n], hull[(i + 2) % n]];
    let turns_left = (0..n)
        .map(corners)
        .all(|[a, b, c]| orient2d(a, b, c) != Orientation::Clockwise);
    let minima = (0..n)
        .map(corners)
        .filter(|[a, b, c]| b.lex_cmp(*a).is_lt() && b.lex_cmp(*c).is_lt())
        .count();
    turns_left && minima == 1
}

impl SpadeEngine {
    /// Flips every edge whose opposite corner lies in the circle by the tie rule, until there is
    /// none.
    ///
    /// The perturbed test is a generic lifting. So the flips end, and they end in the only
    /// triangulation that is regular under it.
    fn canonicalise(&mut self, points: &[Point], mesh: &mut Triangulation) {
        let point = |v: VertexIndex| points[v.index()];
        self.stack.clear();
        self.stack.extend(mesh.half_edges());
        while let Some(edge) = self.stack.pop() {
            let Some(twin) = mesh.twin(edge).half_edge() else {
                continue;
            };
            let [a, b, c] = [edge, edge.next(), edge.prev()].map(|s| point(mesh.origin(s)));
            if in_circle(a, b, c, point(mesh.apex(twin))) {
                flip(mesh, edge, twin);
                for half_edge in [edge, twin] {
                    self.stack.extend(HalfEdge::of_triangle(half_edge.triangle()));
                }
            }
        }
    }
}

fn corner_of(corners: [u32; 3], vertex: u32) -> u32 {
    corners
        .iter()
        .zip(0..)
        .find_map(|(&v, corner)| (v == vertex).then_some(corner))
        .expect("the vertex of an edge is a corner of both its triangles")
}

/// Replaces the diagonal of the two triangles at `edge` and `twin`.
///
/// ```text
///        c                  c
///      ╱   ╲              ╱ │ ╲
///     a ─e→ b     →      a  │  b
///      ╲   ╱              ╲ │ ╱
///        d                  d
/// ```
fn flip(mesh: &mut Triangulation, edge: HalfEdge, twin: HalfEdge) {
    let [a, b, c] = [edge, edge.next(), edge.prev()].map(|s| mesh.origin(s).0);
    let d = mesh.apex(twin).0;
    let [bc, ca, ad, db] = [edge.next(), edge.prev(), twin.next(), twin.prev()].map(|s| mesh.packed_twin(s));
    let [t, u] = [edge, twin].map(HalfEdge::triangle);
    mesh.triangles[t.index()] = [c, d, b];
    mesh.triangles[u.index()] = [d, c, a];
    let [[cd, db_inner, bc_inner], [dc, ca_inner, ad_inner]] = [t, u].map(HalfEdge::of_triangle);
    mesh.neighbours[t.index()] = [dc.into(), db, bc];
    mesh.neighbours[u.index()] = [cd.into(), ca, ad];
    for (outer, inner) in [(db, db_inner), (bc, bc_inner), (ca, ca_inner), (ad, ad_inner)] {
        if let Some(outer) = outer.get() {
            mesh.set_twin(outer, inner.into());
        }
    }
}
