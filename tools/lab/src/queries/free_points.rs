//! Random free points.

use anyhow::bail;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Footing, QueryOptions};
use delaunay_tiles::store::TileReader;
use distributions::Kind;

/// The maximum number of random points that are tried for each requested point.
const TRIES: u64 = 1000;

/// Returns the first `count` random points of a seed, in the file's rectangle, that are free.
pub async fn draw(reader: &TileReader, count: usize, seed: u64) -> anyhow::Result<Vec<Point>> {
    let bounds = reader.metadata().bounds;
    let (width, height) = bounds.size();
    let mut points = Vec::new();
    for [x, y] in distributions::points(Kind::Uniform, TRIES * count as u64, seed) {
        if points.len() == count {
            return Ok(points);
        }
        let point = Point::new(bounds.min_x + x * width, bounds.min_y + y * height);
        if reader.footing(point, QueryOptions::default()).await? == Footing::Free {
            points.push(point);
        }
    }
    if points.len() < count {
        bail!(
            "only {} of {} random points are free",
            points.len(),
            TRIES * count as u64
        );
    }
    Ok(points)
}
