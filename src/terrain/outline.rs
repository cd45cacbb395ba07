//! The outline of a surface: what is known of it outside.
//!
//! In: the tiles of a file whose vertices have z, in any order. Out: the z of the nearest point of
//! the hull. Where the vertices are on a line, and there are no triangles, the outline is the chain
//! of all vertices.

use crate::geometry::{HalfEdge, Point, Rect};
use crate::mesh::Twin;
use crate::store::Tile;
use crate::terrain::facet::{Corner, z_on_edge};

/// Number of adjacent edges that a search passes over at once if their box is too far away.
const RUN: usize = 64;

/// The edges of the hull, in an order that does not depend on the tiles.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    edges: Vec<[Corner; 2]>,
    /// The boxes around each [`RUN`] edges.
    boxes: Vec<Rect>,
}

/// An outline to which tiles are still added.
#[derive(Default)]
pub(crate) struct OutlineParts {
    edges: Vec<[Corner; 2]>,
    /// All vertices, if there are no triangles.
    vertices: Vec<Corner>,
}

impl OutlineParts {
    /// Adds a tile. Each tile of a file must be added once. A file without z has no outline.
    pub(crate) fn add(&mut self, tile: &Tile, has_triangles: bool) {
        let corner = |vertex| {
            let (point, z) = (tile.point(vertex), tile.z(vertex)?);
            Some(Corner { point, z })
        };
        if !has_triangles {
            self.vertices.extend(tile.vertex_indices().filter_map(corner));
            return;
        }
        // A tile knows which edges at its own vertices are on the hull, and not of all that its own
        // triangles have.
        for triangle in tile.triangle_ids() {
            let sides = (0..3).map(|side| HalfEdge::new(triangle, side));
            let is_its = |side: &HalfEdge| tile.twin(*side) == Twin::Hull && tile.has_vertex(tile.origin(*side));
            for side in sides.filter(is_its) {
                let ends = [tile.origin(side), tile.origin(side.next())];
                if let [Some(from), Some(to)] = ends.map(corner) {
                    self.edges.push([from, to]);
                }
            }
        }
    }

    /// Returns the outline of the tiles.
    pub(crate) fn finish(self) -> Outline {
        let Self {
            mut edges,
            mut vertices,
        } = self;
        vertices.sort_unstable_by(|a, b| a.point.lex_cmp(b.point));
        match vertices[..] {
            [only] => edges.push([only; 2]),
            _ => edges.extend(vertices.windows(2).map(|pair| [pair[0], pair[1]])),
        }
        // The lower half of the hull, then the upper one: neighbours come one after another.
        let is_upper = |[from, to]: &[Corner; 2]| to.point.lex_cmp(from.point).is_lt();
        edges.sort_unstable_by(|a, b| {
            let halves = is_upper(a).cmp(&is_upper(b));
            halves.then_with(|| a[0].point.lex_cmp(b[0].point))
        });
        Outline::of_edges(edges)
    }
}

impl Outline {
    /// Returns the outline that has these [edges](Self::edges).
    pub(crate) fn of_edges(edges: Vec<[Corner; 2]>) -> Self {
        let around = |run: &[[Corner; 2]]| Rect::around(run.as_flattened().iter().map(|corner| corner.point));
        Self {
            boxes: edges.chunks(RUN).map(around).collect(),
            edges,
        }
    }

    /// Returns the edges.
    pub(crate) fn edges(&self) -> &[[Corner; 2]] {
        &self.edges
    }

    /// Returns the z of the point of the outline that is nearest to `p`; of several, or of several
    /// that are equally near but for rounding, the one on the first edge. `None` if there are no vertices.
    pub(crate) fn z_near(&self, p: Point) -> Option<f64> {
        let mut best: Option<(f64, f64)> = None;
        for (bounds, run) in self.boxes.iter().zip(self.edges.chunks(RUN)) {
            if best.is_some_and(|(distance, _)| squared_distance_to_box(*bounds, p) > distance) {
                continue;
            }
            for &edge in run {
                let (distance, z) = nearest_on(edge, p);
                if best.is_none_or(|(least, _)| distance < least) {
                    best = Some((distance, z));
                }
            }
        }
        best.map(|(_, z)| z)
    }
}

/// Returns the squared distance from `p` to the nearest point of an edge, and the z there.
fn nearest_on([a, b]: [Corner; 2], p: Point) -> (f64, f64) {
    let along = (b.point.x - a.point.x, b.point.y - a.point.y);
    let to_p = (p.x - a.point.x, p.y - a.point.y);
    let squared = along.0 * along.0 + along.1 * along.1;
    let share = (to_p.0 * along.0 + to_p.1 * along.1) / squared;
    // A single vertex is an edge of no length, whose share is not a number.
    if share.is_nan() || share <= 0.0 {
        return (squared_length(to_p), a.z);
    }
    if share >= 1.0 {
        return (squared_length((p.x - b.point.x, p.y - b.point.y)), b.z);
    }
    let nearest = Point::new(a.point.x + share * along.0, a.point.y + share * along.1);
    let z = z_on_edge([a, b], nearest);
    (squared_length((p.x - nearest.x, p.y - nearest.y)), z)
}

fn squared_distance_to_box(bounds: Rect, p: Point) -> f64 {
    let x = (bounds.min_x - p.x).max(p.x - bounds.max_x).max(0.0);
    let y = (bounds.min_y - p.y).max(p.y - bounds.max_y).max(0.0);
    squared_length((x, y))
}

fn squared_length((x, y): (f64, f64)) -> f64 {
    x * x + y * y
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: f64, y: f64, z: f64) -> Corner {
        let point = Point::new(x, y);
        Corner { point, z }
    }

    /// The outline of a square of 200 by 200 with an edge of length 1 between neighbours, whose z is
    /// x + 1000 y.
    fn square() -> Outline {
        let at = |x: i32, y: i32| corner(x.into(), y.into(), f64::from(x + 1000 * y));
        let sides = (0..200).flat_map(|i| {
            [
                [at(i, 0), at(i + 1, 0)],
                [at(200, i), at(200, i + 1)],
                [at(i + 1, 200), at(i, 200)],
                [at(0, i + 1), at(0, i)],
            ]
        });
        let edges = sides.collect();
        let parts = OutlineParts {
            edges,
            ..OutlineParts::default()
        };
        parts.finish()
    }

    #[test]
    fn a_point_outside_gets_the_z_of_its_projection_or_of_the_nearest_corner() {
        let outline = square();
        for (p, z) in [
            (Point::new(50.25, -3.0), 50.25),
            (Point::new(199.5, 300.0), 200_199.5),
            (Point::new(-7.0, 120.5), 120_500.0),
            (Point::new(260.0, 33.0), 33_200.0),
            (Point::new(-1.0, -9.0), 0.0),
            (Point::new(900.0, 201.0), 200_200.0),
        ] {
            assert_eq!(outline.z_near(p), Some(z), "{p:?}");
        }
    }

    #[test]
    fn points_on_a_line_and_a_single_point_have_an_outline() {
        let vertices = vec![corner(4.0, 0.0, 8.0), corner(0.0, 0.0, 4.0), corner(1.0, 0.0, 6.0)];
        let chain = |vertices| {
            OutlineParts {
                vertices,
                ..OutlineParts::default()
            }
            .finish()
        };
        let line = chain(vertices.clone());
        assert_eq!(line.z_near(Point::new(0.5, 9.0)), Some(5.0));
        assert_eq!(line.z_near(Point::new(2.5, -9.0)), Some(7.0));
        assert_eq!(line.z_near(Point::new(-2.5, -9.0)), Some(4.0));
        assert_eq!(chain(vertices[..1].to_vec()).z_near(Point::new(7.0, 7.0)), Some(8.0));
        assert_eq!(chain(Vec::new()).z_near(Point::new(7.0, 7.0)), None);
    }
}
