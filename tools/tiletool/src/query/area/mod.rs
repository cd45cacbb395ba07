//! The area within a walking distance, as polygons and as a number.
//!
//! Crate i_overlay unites the parts that the library returns. It rounds coordinates to a grid of
//! 2^-30 of the area's size or finer, far below the tolerance with which arcs become lines. The
//! number is the area of the polygons. Holes without any part of the area in them, which most
//! buildings are, stay as they are.

mod holes;
mod shape;

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{AreaCover, QueryOptions};
use delaunay_tiles::store::TileReader;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::solver::{Precision, Solver, Strategy};
use i_overlay::float::overlay::OverlayOptions;
use i_overlay::float::simplify::SimplifyShape;
use serde_json::{Value, json};

use self::shape::{Shape, ShapeRing, signed_area, straightened};
use super::answer::{Area, Polygon, Status};
use super::values::position;

/// Maximum distance of an arc's straight edges from the arc, inside it, as a fraction of the arc's
/// radius. A sector of a disc loses 4/3 of this fraction of its area.
pub const TOLERANCE: f64 = 1e-4;

/// Points that are at most this fraction of the radius away from a straight line are removed.
const STRAIGHT: f64 = 1e-8;

/// Crossings are rounded, which makes new ones, the fewer the greater the distance at which ends are
/// snapped to edges. It begins with 2^4 units of the grid, and grows by a factor of eight. With the
/// default solver, a union took seconds for a thousand pieces. With strategy `Frag`, one did not
/// end for a rectangle and a wall, and one lost a building among 36 000.
const SOLVER: Solver = Solver {
    strategy: Strategy::Tree,
    precision: Precision {
        start: 8,
        progression: 6,
    },
    multithreading: None,
};

/// Returns the area within `radius` of `at`. If a limit ended the query, it is the area of what was
/// found until then.
///
/// # Errors
/// As the library's `area_within`, unless a [`Status`] says it.
pub async fn within(
    reader: &TileReader,
    at: Point,
    radius: f64,
    options: QueryOptions,
) -> anyhow::Result<(Status, Area)> {
    let mut cover = AreaCover::default();
    let status = match reader.cover_area(at, radius, options, &mut cover).await {
        Ok(()) => Status::Ok,
        Err(error) => Status::of(error)?,
    };
    let rings = cover.rings();
    let pieces = cover.pieces();
    let outlines = rings
        .outlines
        .iter()
        .map(|ring| shape_ring(ring))
        .chain(pieces.iter().map(|piece| shape_ring(&piece.outline(TOLERANCE))));
    // The union leaves rounded points on straight lines. Removing them could make lines touch, so
    // the result is united once more.
    let unions = united(&outlines.collect::<Shape>());
    let straight = unions
        .iter()
        .flatten()
        .map(|ring| straightened(ring, STRAIGHT * radius));
    let mut shapes = united(&straight.collect::<Shape>());
    holes::cut_out(&mut shapes, rings.holes.iter().map(|ring| shape_ring(ring)));
    let sizes = shapes.iter().flatten().map(|ring| signed_area(ring, at));
    // The sum of no numbers is -0.
    let size = 0.0 + sizes.sum::<f64>();
    let point = |[x, y]: [f64; 2]| Point::new(x, y);
    let ring = |ring: ShapeRing| ring.into_iter().map(point).collect();
    let polygon = |shape: Shape| shape.into_iter().map(ring).collect();
    let polygons = shapes.into_iter().map(polygon).collect();
    Ok((status, Area { polygons, size }))
}

fn shape_ring(ring: &[Point]) -> ShapeRing {
    ring.iter().map(|p| [p.x, p.y]).collect()
}

/// Returns the union of outlines, counter-clockwise except around holes.
fn united(outlines: &[ShapeRing]) -> Vec<Shape> {
    let options = OverlayOptions {
        ogc: true,
        ..OverlayOptions::default()
    };
    SimplifyShape::simplify_shape_custom(&outlines, FillRule::NonZero, options, SOLVER)
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
