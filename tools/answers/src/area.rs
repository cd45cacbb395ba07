//! The area within a walking distance, as polygons and as a number.

use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{AreaCover, AreaPolygon, QueryOptions};
use delaunay_tiles::store::TileReader;
use serde_json::{Value, json};

use crate::answer::{Area, Status};
use crate::values::position;

/// Maximum distance of an arc's straight edges from the arc, inside it, as a fraction of the arc's
/// radius. A sector of a disc loses 4/3 of this fraction of its area.
pub const TOLERANCE: f64 = 1e-4;

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
    let polygons = cover.polygons(TOLERANCE);
    // The sum of no numbers is -0.
    let size = 0.0 + polygons.iter().map(AreaPolygon::area).sum::<f64>();
    Ok((status, Area { polygons, size }))
}

/// Returns the GeoJSON geometry of the polygons.
pub fn geometry(polygons: &[AreaPolygon]) -> Value {
    let ring = |ring: &[Point]| {
        let closed = ring.iter().chain(ring.first());
        closed.map(|&point| position(point)).collect::<Vec<_>>()
    };
    let polygon = |polygon: &AreaPolygon| polygon.rings().map(ring).collect::<Vec<_>>();
    json!({"type": "MultiPolygon", "coordinates": polygons.iter().map(polygon).collect::<Vec<_>>()})
}
