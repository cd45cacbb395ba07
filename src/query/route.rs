//! A path as it is told.

use super::proximity::Distance;
use super::tiles::Tiles;
use super::QueryError;
use crate::geometry::Point;
use crate::store::VertexId;

/// A shortest path.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// How long it is.
    pub distance: Distance,
    /// Its points.
    pub points: Vec<Point>,
}

/// Makes a path of a way.
pub(super) async fn path(
    tiles: &mut Tiles,
    way: &[(Point, Option<VertexId>)],
    length: f64,
    certify: bool,
) -> Result<Path, QueryError> {
    let _ = (tiles, certify);
    Ok(Path {
        distance: Distance::of_legs(length, way.len()),
        points: way.iter().map(|(point, _)| *point).collect(),
    })
}
