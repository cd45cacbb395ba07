//! The area within a walking distance, as polygons.
//!
//! Crate i_overlay unites the parts that the library returns. It rounds coordinates to a grid of
//! 2^-30 of the area's size or finer, far below the tolerance with which arcs become lines.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::QueryOptions;
use delaunay_tiles::store::TileReader;
use futures::TryStreamExt;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::solver::Solver;
use i_overlay::float::overlay::OverlayOptions;
use i_overlay::float::simplify::SimplifyShape;
use serde_json::{Value, json};

use super::answer::{Polygon, Status};
use super::values::position;

/// Maximum distance of an arc's straight edges from the arc, inside it, as a fraction of the arc's
/// radius.
pub const TOLERANCE: f64 = 1e-4;

/// Points that are at most this fraction of the radius away from a straight line are removed.
const STRAIGHT: f64 = 1e-8;

/// Returns the polygons of the area within `radius` of `at`. If a limit ended the query, they cover
/// what was found until then.
pub async fn within(
    reader: &TileReader,
    at: Point,
    radius: f64,
    options: QueryOptions,
) -> anyhow::Result<(Status, Vec<Polygon>)> {
    let mut parts = reader.area_within(at, radius, options);
    let mut outlines: Vec<Vec<[f64; 2]>> = Vec::new();
    let status = loop {
        match parts.try_next().await {
            Ok(Some(part)) => outlines.push(part.outline(TOLERANCE).iter().map(|p| [p.x, p.y]).collect()),
            Ok(None) => break Status::Ok,
            Err(error) => break Status::of(error)?,
        }
    };
    let options = OverlayOptions {
        ogc: true,
        ..OverlayOptions::default()
    };
    let union = outlines.simplify_shape_custom(FillRule::NonZero, options, Solver::default());
    // The union leaves rounded points on straight lines. Removing them could make lines touch, so
    // the result is united once more.
    let rings = union.into_iter().flatten();
    let straight: Vec<Vec<[f64; 2]>> = rings.map(|ring| straightened(&ring, STRAIGHT * radius)).collect();
    let shapes = straight.simplify_shape_custom(FillRule::NonZero, options, Solver::default());
    let point = |[x, y]: [f64; 2]| Point::new(x, y);
    let ring = |ring: Vec<[f64; 2]>| ring.into_iter().map(point).collect();
    let polygon = |shape: Vec<Vec<[f64; 2]>>| shape.into_iter().map(ring).collect();
    Ok((status, shapes.into_iter().map(polygon).collect()))
}

/// Returns a ring without the points that are at most `slack` away from the line between their
/// neighbours.
fn straightened(ring: &[[f64; 2]], slack: f64) -> Vec<[f64; 2]> {
    let is_straight = |[ax, ay]: [f64; 2], [bx, by]: [f64; 2], [cx, cy]: [f64; 2]| {
        let (dx, dy) = (cx - ax, cy - ay);
        let off = (dx * (by - ay) - dy * (bx - ax)).abs();
        let along = dx * (bx - ax) + dy * (by - ay);
        let square = dx * dx + dy * dy;
        off <= slack * square.sqrt() && (0.0..=square).contains(&along)
    };
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for &point in ring {
        while let [.., before, last] = kept[..]
            && is_straight(before, last, point)
        {
            kept.pop();
        }
        kept.push(point);
    }
    kept
}

/// Returns the GeoJSON geometry of the polygons.
pub fn geometry(polygons: &[Polygon]) -> Value {
    let ring = |ring: &Vec<Point>| {
        let closed = ring.iter().chain(ring.first());
        closed.map(|&point| position(point)).collect::<Vec<_>>()
    };
    let polygon = |rings: &Polygon| rings.iter().map(ring).collect::<Vec<_>>();
    json!({"type": "MultiPolygon", "coordinates": polygons.iter().map(polygon).collect::<Vec<_>>()})
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_straight_lines_are_removed() {
        let ring = [
            [0.0, 0.0],
            [1.0, 1e-10],
            [2.0, 0.0],
            [3.0, 0.0],
            [3.0, 1.0],
            [3.0, 0.5],
            [0.0, 0.5],
        ];
        let kept = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [3.0, 0.5], [0.0, 0.5]];
        assert_eq!(straightened(&ring, 1e-8), kept);
        assert_eq!(straightened(&ring[..2], 1e-8), ring[..2]);
    }
}
