//! The surface at many points, as [overviews](crate::overviews) ask for it.

use std::sync::Arc;

use super::batch::{At, BulkOptions, Outcome, Question, ask};
use super::walk::Spot;
use crate::geometry::Point;
use crate::query::request::Contradiction;
use crate::store::{ReadError, Tile, TileId, TileReader};
use crate::terrain::{FileSurface, Surface, TileSurface};

/// The surface at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum OnSurface {
    /// The point is a vertex with this z, which is NaN in files without z.
    Vertex(f64),
    /// The point lies elsewhere on the surface.
    Between {
        /// NaN in files without z.
        z: f64,
        /// About twice the area of the triangle, the same whatever the tiles.
        area: f64,
    },
    /// The point is outside.
    Outside,
}

impl TileReader {
    /// Returns the surface at points, in their order. Nothing is left out of it. The file has triangles.
    ///
    /// # Errors
    /// If a tile cannot be read or is damaged.
    pub(crate) async fn on_surface(
        &self,
        points: impl Into<Arc<[Point]>>,
        options: BulkOptions,
    ) -> Result<Vec<OnSurface>, ReadError> {
        let surface = FileSurface::without_peeling(Surface::default().holes(true), self.metadata());
        ask(self, points.into(), options, Where { surface }, OnSurface::Outside).await
    }
}

struct Where {
    surface: FileSurface,
}

impl Question for Where {
    type Answer = OnSurface;
    type Errand = std::convert::Infallible;
    type InTile = TileSurface;

    fn in_tile(&self, tile: &Tile) -> TileSurface {
        self.surface.in_tile(tile)
    }

    fn answer(&self, at: &At<'_, TileSurface>, spot: Spot, _: TileId) -> Result<Outcome<Self>, Contradiction> {
        let At { tile, in_tile, point } = *at;
        Ok(Outcome::Answer(match spot {
            Spot::Outside(_) => OnSurface::Outside,
            Spot::Vertex(corner) => OnSurface::Vertex(tile.z(corner).unwrap_or(f64::NAN)),
            Spot::Triangle(triangle) => {
                let facet = in_tile.facet(tile, triangle);
                facet.map_or(OnSurface::BETWEEN, |facet| OnSurface::Between {
                    z: facet.z_inside(point),
                    area: facet.doubled_area(),
                })
            }
            Spot::Edge(half_edge) => {
                // Which of the two triangles the walk comes to depends on where it starts.
                let [a, b] = tile.ends(half_edge).map(|end| end.point);
                let (dx, dy) = (b.x - a.x, b.y - a.y);
                let facet = in_tile.facet(tile, half_edge.triangle());
                let z = facet.and_then(|facet| Some(facet.z_at(point, facet.place(point)?)));
                OnSurface::Between {
                    z: z.unwrap_or(f64::NAN),
                    area: dx * dx + dy * dy,
                }
            }
        }))
    }

    fn finish(&self, _: &At<'_, TileSurface>, errand: Self::Errand) -> Result<OnSurface, Contradiction> {
        match errand {}
    }
}

impl OnSurface {
    /// Where there is no z.
    const BETWEEN: Self = Self::Between {
        z: f64::NAN,
        area: f64::NAN,
    };
}
