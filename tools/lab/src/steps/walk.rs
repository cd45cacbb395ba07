//! A shortest path, the triangles that its search passes, and the tiles that it uses.

use std::path::Path;

use anyhow::bail;
use delaunay_tiles::geometry::Point;
use delaunay_tiles::query::{Explored, PathOutcome, QueryOptions, TilesUsed};
use delaunay_tiles::store::TileId;

use super::ground::Ground;
use super::stages::Constrained;
use super::triangles::Triangle;

/// Maximum number of vertices of a tile: more and smaller tiles than in the other pictures.
const TILE_VERTICES: usize = 50;
/// From one bay of Sumbawa to another.
const FROM: Point = Point::new(117.75, -8.52);
const TO: Point = Point::new(118.695, -8.4);

/// The answer of a query.
pub struct Walk {
    /// The tiles that the query used, in ascending order.
    pub used: Vec<TileId>,
    /// The triangles that the search passed.
    pub searched: Vec<Triangle>,
    pub path: Vec<Point>,
    pub ground: Constrained,
}

impl Walk {
    /// Builds a file of small tiles, and asks it for a path.
    ///
    /// # Errors
    /// Fails if the build or the query fails, or if there is no path.
    pub async fn take(ground: &Ground, scratch: &Path) -> anyhow::Result<Self> {
        let reader = ground.build(&scratch.join("walk.tiles"), TILE_VERTICES, true).await?;
        let (used, searched) = (TilesUsed::default(), Explored::default());
        let options = QueryOptions::default().tiles_used(&used).explored(&searched);
        let PathOutcome::Found(path) = reader.shortest_path(FROM, TO, options).await? else {
            bail!("the path that is drawn is not there: other islands are in its way");
        };
        let mut searched = searched.triangles();
        searched.sort_by(|a, b| a[0].lex_cmp(b[0]).then(a[1].lex_cmp(b[1])).then(a[2].lex_cmp(b[2])));
        Ok(Self {
            used: used.tiles(),
            searched,
            path: path.points,
            ground: Constrained::gather(&reader).await?,
        })
    }
}
