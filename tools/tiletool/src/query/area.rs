//! The area within a walking distance, as polygons.
//!
//! The library's pieces are united by crate i_overlay, which rounds to a grid of 2^-30 of the area's size, or finer: far below
//! the tolerance with which arcs become lines.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::QueryOptions;
use delaunay_tiles::store::TileReader;
use futures::TryStreamExt;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::solver::Solver;
use i_overlay::float::overlay::OverlayOptions;
use i_overlay::float::simplify::SimplifyShape;
use serde_json::{Value, json};

use super::answer::Status;
use super::print::position;

/// An arc's line is this part of its radius inside the arc at most.
pub const TOLERANCE: f64 = 1e-4;

/// Rings, the outer one first, counter-clockwise, the others clockwise; first points are not repeated.
pub type Polygon = Vec<Vec<Point>>;

/// The polygons of the area; of what was found in time if a budget ended it.
pub async fn within(
    reader: &TileReader,
    at: Point,
    radius: f64,
    options: QueryOptions,
) -> anyhow::Result<(Status, Vec<Polygon>)> {
    let mut pieces = reader.area_within(at, radius, options);
    let mut outlines: Vec<Vec<[f64; 2]>> = Vec::new();
    let status = loop {
        match pieces.try_next().await {
            Ok(Some(piece)) => outlines.push(piece.outline(TOLERANCE).iter().map(|p| [p.x, p.y]).collect()),
            Ok(None) => break Status::Ok,
            Err(error) => break Status::of(error)?,
        }
    };
    let options = OverlayOptions {
        ogc: true,
        ..OverlayOptions::default()
    };
    let shapes = outlines.simplify_shape_custom(FillRule::NonZero, options, Solver::default());
    let point = |[x, y]: [f64; 2]| Point::new(x, y);
    let ring = |ring: Vec<[f64; 2]>| ring.into_iter().map(point).collect();
    let polygon = |shape: Vec<Vec<[f64; 2]>>| shape.into_iter().map(ring).collect();
    Ok((status, shapes.into_iter().map(polygon).collect()))
}

/// Where it is, for GeoJSON.
pub fn geometry(polygons: &[Polygon]) -> Value {
    let ring = |ring: &Vec<Point>| {
        let closed = ring.iter().chain(ring.first());
        closed.map(|&point| position(point)).collect::<Vec<_>>()
    };
    let polygon = |rings: &Polygon| rings.iter().map(ring).collect::<Vec<_>>();
    json!({"type": "MultiPolygon", "coordinates": polygons.iter().map(polygon).collect::<Vec<_>>()})
}
