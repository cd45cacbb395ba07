//! The surface at many points, as [overviews](crate::overviews) ask for it.

use std::sync::Arc;

use foldhash::{HashMap, HashMapExt};

use super::batch::{At, BulkOptions, Outcome, Question, ask};
use super::walk::{Locate, Spot, SpotStep};
use crate::geometry::{HalfEdge, Point, Rect};
use crate::mesh::{Walk, WalkEnd};
use crate::query::request::Contradiction;
use crate::store::{PassReader, ReadError, Tile, TileId, TileReader, spawn};
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

/// The part of a surface around a tile of a finer one: the tiles of it that are there.
pub(crate) struct SurfacePart {
    reader: PassReader,
    tiles: HashMap<TileId, Arc<Tile>>,
    surface: FileSurface,
}

/// The triangle in which a walk ended.
#[derive(Clone, Copy)]
struct Near<'a> {
    tile: &'a Tile,
    half_edge: HalfEdge,
}

impl TileReader {
    /// Returns the surface at points, in their order. Nothing is left out of it. The file has triangles.
    ///
    /// # Errors
    /// If a tile cannot be read or is damaged.
    async fn on_surface(&self, points: Vec<Point>) -> Result<Vec<OnSurface>, ReadError> {
        let surface = surface_of(self);
        let options = BulkOptions::default().threads(1);
        ask(self, points.into(), options, Where { surface }, OnSurface::Outside).await
    }
}

impl SurfacePart {
    /// Reads the part of a surface within bounds.
    ///
    /// # Errors
    /// If a tile cannot be read or is damaged.
    pub(crate) async fn within(reader: &PassReader, bounds: Rect) -> Result<Self, ReadError> {
        let mut tiles = HashMap::new();
        for id in reader.tiles_where(|tile| tile.intersects(bounds)).await? {
            tiles.insert(id, reader.tile(id).await?);
        }
        Ok(Self {
            reader: reader.clone(),
            tiles,
            surface: surface_of(reader),
        })
    }

    /// Returns the surface at points, in their order, each of which should be near the one before it.
    /// What other tiles are needed for is found last. Must be awaited within a tokio runtime.
    ///
    /// # Errors
    /// If a tile cannot be read or is damaged.
    pub(crate) async fn at(self, points: Vec<Point>) -> Result<Vec<OnSurface>, ReadError> {
        let reader = self.reader.clone();
        let (points, found) = spawn(move || {
            let found = self.find(&points);
            (points, found)
        })
        .await?;
        let (mut found, open) = found?;
        if !open.is_empty() {
            let rest = open.iter().map(|&place| points[place]).collect();
            for (place, at) in open.into_iter().zip(reader.on_surface(rest).await?) {
                found[place] = at;
            }
        }
        Ok(found)
    }

    /// Returns the surface at points, and which of them need other tiles.
    fn find(&self, points: &[Point]) -> Result<(Vec<OnSurface>, Vec<usize>), ReadError> {
        let question = Where {
            surface: self.surface.clone(),
        };
        let (mut found, mut open) = (Vec::with_capacity(points.len()), Vec::new());
        let mut near = None;
        for (place, &point) in points.iter().enumerate() {
            match self.walk(point, &mut near)? {
                Some((tile, spot)) => found.push(question.at(tile, &question.surface.in_tile(tile), point, spot)),
                None => {
                    open.push(place);
                    found.push(OnSurface::Outside);
                }
            }
        }
        Ok((found, open))
    }

    /// Walks to a point, from where the walk before ended. Returns `None` if it needs a tile that is not
    /// there.
    fn walk<'a>(&'a self, point: Point, near: &mut Option<Near<'a>>) -> Result<Option<(&'a Tile, Spot)>, ReadError> {
        let triangles = self.reader.metadata().triangles;
        if let Some(Near { tile, half_edge }) = *near {
            let end = Walk::new(point, triangles).run(tile, half_edge);
            let (half_edge, spot) = match end.map_err(|error| self.reader.damaged(tile.id(), error.to_string()))? {
                WalkEnd::Triangle(triangle) => (HalfEdge::new(triangle, 0), Some(Spot::Triangle(triangle))),
                WalkEnd::Edge(half_edge) => (half_edge, Some(Spot::Edge(half_edge))),
                WalkEnd::Vertex(half_edge) => (half_edge, Some(Spot::Vertex(tile.origin(half_edge)))),
                WalkEnd::Hull(exit) => (exit, Some(Spot::Outside(None))),
                WalkEnd::Elsewhere(exit) => (exit, None),
            };
            if let Some(spot) = spot {
                *near = Some(Near { tile, half_edge });
                return Ok(Some((tile, spot)));
            }
        }
        let mut walk = Locate::new(point, triangles);
        let mut id = self.reader.directory().tree.tile_at(point);
        while let Some(tile) = id.and_then(|id| self.tiles.get(&id)) {
            let step = walk.step_to_spot(tile);
            match step.map_err(|error| self.reader.damaged(tile.id(), error.to_string()))? {
                SpotStep::Need(other) => id = Some(other),
                SpotStep::There(spot) => {
                    let half_edge = match spot {
                        Spot::Triangle(triangle) => Some(HalfEdge::new(triangle, 0)),
                        Spot::Edge(half_edge) => Some(half_edge),
                        Spot::Vertex(corner) if tile.has_vertex(corner) => tile.leaving(corner),
                        Spot::Vertex(_) | Spot::Outside(_) => None,
                    };
                    if let Some(half_edge) = half_edge {
                        *near = Some(Near { tile, half_edge });
                    }
                    return Ok(Some((tile, spot)));
                }
            }
        }
        Ok(None)
    }
}

fn surface_of(reader: &TileReader) -> FileSurface {
    FileSurface::without_peeling(Surface::default().holes(true), reader.metadata())
}

struct Where {
    surface: FileSurface,
}

impl Where {
    /// Returns the surface at a point whose walk ended in a tile.
    fn at(&self, tile: &Tile, in_tile: &TileSurface, point: Point, spot: Spot) -> OnSurface {
        match spot {
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
        }
    }
}

impl Question for Where {
    type Answer = OnSurface;
    type Errand = std::convert::Infallible;
    type InTile = TileSurface;

    fn in_tile(&self, tile: &Tile) -> TileSurface {
        self.surface.in_tile(tile)
    }

    fn answer(&self, at: &At<'_, TileSurface>, spot: Spot, _: TileId) -> Result<Outcome<Self>, Contradiction> {
        Ok(Outcome::Answer(self.at(at.tile, at.in_tile, at.point, spot)))
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
