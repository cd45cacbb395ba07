//! Random free places.

use anyhow::bail;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Footing, QueryOptions};
use delaunay_tiles::store::TileReader;
use distributions::Kind;

/// Random places that are tried for each one that is wanted, at most.
const TRIES: u64 = 1000;

/// The first of a seed's random places in the file's rectangle that are free.
pub async fn free(reader: &TileReader, count: usize, seed: u64) -> anyhow::Result<Vec<Point>> {
    let bounds = reader.directory().metadata.bounds;
    let (width, height) = bounds.size();
    let mut places = Vec::new();
    for [x, y] in distributions::points(Kind::Uniform, TRIES * count as u64, seed) {
        if places.len() == count {
            return Ok(places);
        }
        let place = Point::new(bounds.min_x + x * width, bounds.min_y + y * height);
        if reader.footing(place, QueryOptions::default()).await? == Footing::Free {
            places.push(place);
        }
    }
    if places.len() < count {
        bail!(
            "only {} of {} random places are free",
            places.len(),
            TRIES * count as u64
        );
    }
    Ok(places)
}
